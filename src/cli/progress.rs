//! A progress bar on the standard error, if that is a terminal.

use std::sync::Arc;

use indicatif::{ProgressBar, ProgressStyle};

use super::console::print_warning;

/// Prints a warning above the progress bar, from any thread.
pub(super) type Notifier = Arc<dyn Fn(&str) + Send + Sync>;

/// Progress of a computation.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar with an estimate of the remaining time.
    pub fn new() -> Self {
        let template = "{elapsed} [{bar:30}] {percent:>3} %, about {eta} left: {msg}";
        let style = ProgressStyle::with_template(template)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        Self {
            bar: ProgressBar::new(1_000_000).with_style(style),
        }
    }

    /// Sets the completed share, 0 to 1, and the task.
    pub fn update(&self, share: f64, task: &str) {
        self.bar.set_message(task.to_owned());
        // The bar counts in integers.
        self.bar.set_position((share * 1e6).round() as u64);
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
