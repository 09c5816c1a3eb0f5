//! A bar on the standard error while a run goes on; nothing where that is no terminal.

use std::sync::Arc;

use indicatif::{ProgressBar, ProgressStyle};

use super::report::print_warning;

/// Prints a line beside a bar, from any thread.
pub(super) type Teller = Arc<dyn Fn(&str) + Send + Sync>;

/// Progress in simulated time, or in shares of the work.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar for a run of the given simulated time (s).
    pub fn new(duration: f64) -> Self {
        let template = "{elapsed} [{bar:40}] {percent:>3} % of the simulated time, {eta} to go";
        Self::with(template, duration)
    }

    fn with(template: &str, length: f64) -> Self {
        let style = ProgressStyle::with_template(template)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        Self {
            bar: ProgressBar::new(microseconds(length)).with_style(style),
        }
    }

    /// A bar for work in named steps.
    pub fn of_steps() -> Self {
        let template = "{elapsed} [{bar:40}] {percent:>3} % {msg}";
        Self::with(template, 1.0)
    }

    /// A bar for work whose end is only estimated.
    pub fn of_estimate() -> Self {
        let template = "{elapsed} [{bar:30}] {percent:>3} %, about {eta} to go: {msg}";
        Self::with(template, 1.0)
    }

    /// The share done, 0 to 1, and what is known so far.
    pub fn tell(&self, share: f64, words: String) {
        self.bar.set_message(words);
        self.reach(share);
    }

    /// The share done, 0 to 1, and the step that comes.
    pub fn step(&self, share: f64, name: &'static str) {
        self.bar.set_message(name);
        self.reach(share);
    }

    /// Prints warnings above the bar.
    pub fn teller(&self) -> Teller {
        let bar = self.bar.clone();
        Arc::new(move |words| bar.suspend(|| print_warning(words)))
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

/// The bar counts whole numbers: millionths.
fn microseconds(time: f64) -> u64 {
    (time * 1e6).round() as u64
}
