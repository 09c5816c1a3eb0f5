//! State shared by the request handlers.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use re_web_viewer_server::WebViewerData;
use tokio::sync::watch;

use super::roles::Keys;
use super::second::SecondRun;
use crate::live::bands::RegimeBands;
use crate::live::session::Session;

/// Interval at which a changed panel is sent.
pub const PANEL_EVERY: Duration = Duration::from_millis(50);

/// Data shared by all connections of the server.
pub struct Shared {
    pub session: Arc<Session>,
    pub viewer: &'static WebViewerData,
    pub address: SocketAddr,
    pub bands: watch::Receiver<RegimeBands>,
    /// Keys of the roles; `None` if only this machine can reach the page.
    pub keys: Option<Keys>,
    /// Address of the page without a key.
    pub url: String,
    /// A second run for comparison.
    pub second: Option<SecondRun>,
    /// The tour, as JSON.
    pub tour: String,
}
