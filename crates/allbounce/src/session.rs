//! What every subcommand shares: threads, quietness, the memory budget, the report file.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use anyhow::Context;
use serde::Serialize;

use crate::{files, memory, progress::Bars, report};

/// Options of every subcommand.
#[derive(clap::Args)]
#[command(next_help_heading = "Common options")]
pub struct SessionArgs {
    /// Write the run's numbers as JSON
    #[arg(long, global = true, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Threads; does not change any result [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Memory that a step with whole matrices or pictures may use, such as 6GiB [default: what is free]
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory::parse)]
    memory_limit: Option<u64>,
    /// Print errors only
    #[arg(short, long, global = true)]
    quiet: bool,
}

/// One run of the program.
pub struct Session {
    report: Option<PathBuf>,
    memory_limit: Option<u64>,
    quiet: bool,
    /// Whether tables and warnings are left to somebody else.
    brief: bool,
    start: Instant,
}

impl Session {
    /// Sets up the thread pool.
    pub fn new(args: &SessionArgs) -> anyhow::Result<Session> {
        let threads = args.threads.map_or(0, usize::from);
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().context("threads could not be started")?;
        Ok(Session {
            report: args.report.clone(),
            memory_limit: args.memory_limit,
            quiet: args.quiet,
            brief: false,
            start: Instant::now(),
        })
    }

    /// The same without tables and warnings: for trials that nobody needs to read about.
    pub fn brief(&self) -> Session {
        Session { report: None, brief: true, ..*self }
    }

    /// Progress bars of a stage.
    pub fn progress(&self) -> Bars {
        Bars::new(self.quiet)
    }

    /// Refuses a step that needs more memory than there is.
    pub fn ask_memory(&self, step: &str, need: u64, remedy: &str) -> anyhow::Result<()> {
        memory::ask(step, need, self.memory_limit, remedy)
    }

    /// Prints numbers as a short table to the terminal.
    pub fn print<T: Serialize>(&self, title: &str, numbers: &T) -> anyhow::Result<()> {
        if !self.quiet && !self.brief {
            eprint!("{}", report::table(title, &serde_json::to_value(numbers)?));
        }
        Ok(())
    }

    /// Prints one line.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            eprintln!("{line}");
        }
    }

    /// The files that this run writes: its output and the report.
    pub fn outputs<'a>(&'a self, output: &'a Path) -> Vec<(&'static str, &'a Path)> {
        let report = self.report.as_deref().map(|path| ("--report", path));
        std::iter::once(("-o", output)).chain(report).collect()
    }

    /// Prints a line that people should not miss.
    pub fn warn(&self, line: &str) {
        if !self.brief {
            self.say(&format!("warning: {line}"));
        }
    }

    /// Writes the report file, if one was asked for.
    pub fn finish<T: Serialize>(&self, numbers: &T) -> anyhow::Result<()> {
        match &self.report {
            Some(path) => files::write(path, format!("{}\n", serde_json::to_string_pretty(numbers)?).as_bytes()),
            None => Ok(()),
        }
    }

    /// Seconds since the program started.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}
