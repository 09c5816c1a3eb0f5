//! A progress bar on the standard error, if that is a terminal.

use std::borrow::Cow;
use std::sync::Arc;

use indicatif::{ProgressBar, ProgressStyle};

use super::report::print_warning;

/// Prints a warning above the progress bar, from any thread.
pub(super) type Notifier = Arc<dyn Fn(&str) + Send + Sync>;

/// Progress in simulated time, or as a fraction of the work.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar for a simulated time in s.
    pub fn of_simulation(duration: f64) -> Self {
        let template = "{elapsed} [{bar:40}] {percent:>3} % of the simulated time, {eta} left";
        Self::with(template, duration)
    }

    /// A bar for named phases of work.
    pub fn of_phases() -> Self {
        let template = "{elapsed} [{bar:40}] {percent:>3} % {msg}";
        Self::with(template, 1.0)
    }

    /// A bar with an estimate of the remaining time.
    pub fn with_estimate() -> Self {
        let template = "{elapsed} [{bar:30}] {percent:>3} %, about {eta} left: {msg}";
        Self::with(template, 1.0)
    }

    fn with(template: &str, length: f64) -> Self {
        let style = ProgressStyle::with_template(template)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        Self {
            bar: ProgressBar::new(millionths(length)).with_style(style),
        }
    }

    /// Sets the completed fraction, 0 to 1, and the message.
    pub fn update(&self, fraction: f64, message: impl Into<Cow<'static, str>>) {
        self.bar.set_message(message);
        self.set_position(fraction);
    }

    /// Sets the simulated time in s, or the completed fraction.
    pub fn set_position(&self, position: f64) {
        self.bar.set_position(millionths(position));
    }

    /// Returns a function that prints warnings above the bar.
    pub fn notifier(&self) -> Notifier {
        let bar = self.bar.clone();
        Arc::new(move |message| bar.suspend(|| print_warning(message)))
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// The bar counts in integers.
fn millionths(position: f64) -> u64 {
    (position * 1e6).round() as u64
}
