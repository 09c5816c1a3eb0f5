//! What the handlers of all requests share.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use re_web_viewer_server::WebViewerData;
use tokio::sync::watch;

use crate::live::bands::Bands;
use crate::live::session::Session;

/// How often the panel is sent, if it has changed.
pub const PANEL_EVERY: Duration = Duration::from_millis(50);

pub struct Shared {
    pub session: Arc<Session>,
    pub viewer: &'static WebViewerData,
    pub address: SocketAddr,
    pub bands: watch::Receiver<Bands>,
}
