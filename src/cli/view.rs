//! `squeakscope view`: a recording in the browser.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args as Arguments;

use super::browser::BrowserArgs;
use super::error::CliError;
use super::live::{POLL_PERIOD, bound};
use super::{console, interrupt};
use crate::live::Page;
use crate::record::check_recording;

/// Arguments of `squeakscope view`.
#[derive(Debug, Arguments)]
pub struct ViewArgs {
    /// Recording to show.
    #[arg(value_name = "FILE.rrd")]
    pub recording: PathBuf,
    /// Port on this machine; 0 takes a free port.
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    pub port: u16,
    #[command(flatten)]
    pub browser: BrowserArgs,
}

/// Runs the command until Ctrl-C.
///
/// # Errors
/// If the file is not a recording, or cannot be served.
pub(super) fn execute(args: &ViewArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    check_recording(&args.recording)?;
    let failed = CliError::during::<std::io::Error>("server");
    let listener = bound(IpAddr::V4(Ipv4Addr::LOCALHOST), args.port)?;
    let page = Page::of_recording(listener, &args.recording).map_err(failed)?;
    interrupt::start_work();
    console::print(&format!(
        "recording: {} (Ctrl-C ends the server)\n",
        page.url()
    ))?;
    args.browser.open(page.url());
    while !stop.load(Ordering::Relaxed) && !page.is_finished() {
        std::thread::sleep(POLL_PERIOD);
    }
    page.close().map_err(failed)
}
