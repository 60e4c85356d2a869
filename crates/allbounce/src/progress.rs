//! Progress bars on a terminal, silence elsewhere.

use std::{io::IsTerminal, sync::Mutex};

use indicatif::{ProgressBar, ProgressStyle};
use radfile::Progress;

/// Draws one bar for the part of the work that goes on.
pub struct Bars {
    shown: bool,
    bar: Mutex<ProgressBar>,
}

impl Bars {
    pub fn new(quiet: bool) -> Bars {
        Bars { shown: !quiet && std::io::stderr().is_terminal(), bar: Mutex::new(ProgressBar::hidden()) }
    }

    fn swap(&self, next: ProgressBar) {
        let mut bar = self.bar.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        bar.finish_and_clear();
        *bar = next;
    }
}

impl Progress for Bars {
    fn begin(&self, what: &str, total: u64) {
        if self.shown {
            let style = ProgressStyle::with_template("{msg:28} {bar:40} {percent:>3}% {eta:>5}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            self.swap(ProgressBar::new(total).with_style(style).with_message(what.to_owned()));
        }
    }

    fn advance(&self, units: u64) {
        if self.shown {
            self.bar.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).inc(units);
        }
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.swap(ProgressBar::hidden());
    }
}
