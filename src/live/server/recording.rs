//! A recording file in Rerun's web viewer.
//!
//! | path | content |
//! |---|---|
//! | `/` | the page of the viewer |
//! | `/recording.rrd` | the file |
//! | `/viewer.js`, `/viewer.wasm` | Rerun's web viewer, embedded in the binary |
//!
//! The content policy of the guard also stops the usage statistics that the viewer sends to its makers.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use tokio::fs::File;
use tokio_util::io::ReaderStream;

use super::accept::Limits;
use super::{BoundListener, Server, viewer};

/// Period of the checks for the end.
const POLL_EVERY: Duration = Duration::from_millis(25);

/// The running server of a recording.
#[derive(Debug)]
pub struct RecordingPage {
    server: Server,
    url: String,
}

impl RecordingPage {
    /// Serves a recording and the viewer.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn open(serving: BoundListener, recording: &Path) -> io::Result<Self> {
        let viewer = viewer()?;
        let file: Arc<PathBuf> = Arc::new(recording.to_owned());
        let routes: [(&str, &str, &'static [u8]); 5] = [
            (
                "/",
                "text/html; charset=utf-8",
                include_bytes!("../page/viewer/index.html"),
            ),
            (
                "/start.js",
                "text/javascript",
                include_bytes!("../page/viewer/start.js"),
            ),
            ("/viewer.js", "text/javascript", viewer.viewer_js()),
            ("/viewer.wasm", "application/wasm", viewer.viewer_wasm()),
            ("/favicon.ico", "image/x-icon", viewer.favicon()),
        ];
        let router = Router::new().route(
            "/recording.rrd",
            get(move || async move { streamed(&file).await }),
        );
        let router = routes
            .into_iter()
            .fold(router, |router, (path, kind, content)| {
                let answer = ([(header::CONTENT_TYPE, kind)], Bytes::from_static(content));
                router.route(path, get(answer))
            });
        let url = format!("http://{}/", serving.address);
        let server = Server::start(serving, None, router, Limits::default())?;
        Ok(Self { server, url })
    }

    /// Address of the page.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Serves until the flag is set, and closes open connections.
    ///
    /// # Errors
    /// The error that stopped the server earlier.
    pub fn serve_until(self, stop: &AtomicBool) -> io::Result<()> {
        while !stop.load(Ordering::Relaxed) && !self.server.serving.is_finished() {
            std::thread::sleep(POLL_EVERY);
        }
        self.server.close()
    }
}

/// A file, read while it is sent.
pub(super) async fn streamed(path: &Path) -> Response {
    let opened = async {
        let file = File::open(path).await?;
        let length = file.metadata().await?.len();
        io::Result::Ok((file, length))
    };
    match opened.await {
        Ok((file, length)) => {
            let headers = [
                (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
                (header::CONTENT_LENGTH, length.to_string()),
            ];
            let body = Body::from_stream(ReaderStream::with_capacity(file, 1 << 16));
            (headers, body).into_response()
        }
        Err(_) => StatusCode::NOT_FOUND.into_response(),
    }
}
