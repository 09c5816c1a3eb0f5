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
use std::path::Path;
use std::sync::Arc;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use tokio::fs::File;
use tokio_util::io::ReaderStream;

use super::files::{HTML, JS, routes};
use super::viewer;

/// The paths of a recording and of the viewer.
pub(super) fn router(recording: &Path) -> io::Result<Router> {
    let viewer = viewer()?;
    let file: Arc<Path> = recording.into();
    let page = include_bytes!("../page/viewer/index.html");
    let start = include_bytes!("../page/viewer/start.js");
    let files: [(&str, &str, &'static [u8]); 5] = [
        ("/", HTML, page),
        ("/start.js", JS, start),
        ("/viewer.js", JS, viewer.viewer_js()),
        ("/viewer.wasm", "application/wasm", viewer.viewer_wasm()),
        ("/favicon.ico", "image/x-icon", viewer.favicon()),
    ];
    let files = files.map(|(path, kind, bytes)| (path.to_owned(), kind, Bytes::from_static(bytes)));
    let file = get(move || async move { streamed(&file).await });
    Ok(routes(Router::new(), files).route("/recording.rrd", file))
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
