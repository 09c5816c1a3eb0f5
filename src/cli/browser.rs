//! Opens an address in the user's browser.

use clap::Args as Arguments;

use super::console;

/// Whether to open a browser.
#[derive(Clone, Copy, Debug, Default, Arguments)]
pub struct BrowserArgs {
    /// Print the address, but do not open a browser.
    #[arg(long)]
    pub no_browser: bool,
}

impl BrowserArgs {
    /// Opens an address, unless nobody would see the browser: over ssh, or without a display.
    pub fn open(self, url: &str) {
        if self.no_browser || !has_display(|name| std::env::var_os(name).is_some()) {
            return;
        }
        // Its own session: Ctrl-C ends this program and not the browser. Waits for 0.25 s at most.
        if open::that_detached(url).is_err() {
            console::print_notice("no browser could be opened; open the address yourself");
        }
    }
}

/// Whether a browser would appear before the user.
fn has_display(is_set: impl Fn(&str) -> bool) -> bool {
    let is_remote = ["SSH_CONNECTION", "SSH_TTY"].into_iter().any(&is_set);
    let shows =
        !cfg!(target_os = "linux") || ["DISPLAY", "WAYLAND_DISPLAY"].into_iter().any(is_set);
    shows && !is_remote
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_browser_needs_a_display_of_this_machine() {
        let opens = |set: &[&str]| has_display(|name| set.contains(&name));
        let bare = !cfg!(target_os = "linux");
        assert_eq!(opens(&[]), bare);
        assert!(opens(&["DISPLAY"]) && opens(&["WAYLAND_DISPLAY"]));
        for remote in ["SSH_CONNECTION", "SSH_TTY"] {
            assert!(!opens(&[remote]) && !opens(&[remote, "DISPLAY"]));
        }
    }
}
