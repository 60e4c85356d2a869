//! How long work tells that it goes on, without printing.

/// Receives the progress of a stage; the command line draws bars from it.
pub trait Progress: Sync {
    /// A new part of the work begins, `total` units long.
    fn begin(&self, what: &str, total: u64);
    /// `units` more are done. Called from any thread.
    fn advance(&self, units: u64);
}

/// Ignores progress.
pub struct Quiet;

impl Progress for Quiet {
    fn begin(&self, _what: &str, _total: u64) {}
    fn advance(&self, _units: u64) {}
}
