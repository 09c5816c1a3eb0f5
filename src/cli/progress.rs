//! A bar on the standard error while a run goes on; nothing where that is no terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// Progress in simulated time.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar for a run of the given simulated time (s).
    pub fn new(duration: f64) -> Self {
        let template = "{elapsed} [{bar:40}] {percent:>3} % of the simulated time, {eta} to go";
        let style = ProgressStyle::with_template(template)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        Self {
            bar: ProgressBar::new(microseconds(duration)).with_style(style),
        }
    }

    /// Simulated time reached, s.
    pub fn reach(&self, time: f64) {
        self.bar.set_position(microseconds(time));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// The bar counts whole numbers.
fn microseconds(time: f64) -> u64 {
    (time * 1e6).round() as u64
}
