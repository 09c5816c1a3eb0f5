//! The files of the page, embedded in the binary.

use std::borrow::Cow;

use axum::Router;
use axum::http::header;
use axum::routing::get;
use include_dir::{Dir, include_dir};
use serde_json::json;

use crate::plot::{Color, INFERNO, NAMED_LINES, PREFIXES, Rgb, gradient};
use crate::record::TRAIL;

const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

/// The folder of the page; its folder `viewer` belongs to the page of a recording.
static PAGE: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/src/live/page");

/// The files of the page: path, type and content.
fn files() -> impl Iterator<Item = (String, &'static str, &'static str)> {
    let views = PAGE.get_dir("views").into_iter().flat_map(Dir::files);
    PAGE.files().chain(views).filter_map(|file| {
        let name = file.path().to_string_lossy().replace('\\', "/");
        let (path, kind) = match name.rsplit_once('.')? {
            (_, "html") => ("/".to_owned(), "text/html; charset=utf-8"),
            (_, "css") => (format!("/{name}"), CSS),
            (_, "js") => (format!("/{name}"), JS),
            _ => return None,
        };
        Some((path, kind, file.contents_utf8()?))
    })
}

/// What the page shares with figures and recordings: colours as a style sheet, and a module with the prefixes of units,
/// a colour on light and dark ground, a colour map, the length of the trail of the phase portrait and the number of named lines.
fn shared() -> [(&'static str, &'static str, String); 2] {
    let rule = |on: fn(Color) -> Rgb| {
        let [signal, mark] = [Color::Run, Color::Compared].map(|color| {
            let [r, g, b] = on(color);
            format!("rgb({r}, {g}, {b})")
        });
        format!("{{ --signal: {signal}; --mark: {mark}; }}")
    };
    let [dark, light] = [Color::on_dark, Color::on_light].map(rule);
    let colours = format!(":root {dark}\n:root[data-theme=\"light\"] {light}\n");
    let values = json!({
        "prefixes": PREFIXES,
        "signal": Color::Run,
        "spectrogram": &gradient(&INFERNO)[..],
        "trail_s": TRAIL,
        "named_lines": NAMED_LINES,
    });
    let values = format!("export default {values};\n");
    [("/shared.css", CSS, colours), ("/shared.js", JS, values)]
}

/// Serves the files.
pub(super) fn routes<S: Clone + Send + Sync + 'static>(router: Router<S>) -> Router<S> {
    let files = files().map(|(path, kind, text)| (path, kind, Cow::Borrowed(text)));
    let shared = shared().map(|(path, kind, text)| (path.to_owned(), kind, Cow::Owned(text)));
    files
        .chain(shared)
        .fold(router, |router, (path, kind, text)| {
            let answer = ([(header::CONTENT_TYPE, kind)], text);
            router.route(&path, get(answer))
        })
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use super::*;

    /// The page loads fast on a slow network: at most 300 kB, compressed.
    #[test]
    fn the_page_is_small() {
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (path, _, text) in files() {
            let name = path.trim_start_matches('/');
            archive
                .start_file(name, zip::write::SimpleFileOptions::default())
                .unwrap();
            archive.write_all(text.as_bytes()).unwrap();
        }
        let size = archive.finish().unwrap().into_inner().len();
        println!("{size} bytes, compressed");
        assert!((10_000..300_000).contains(&size), "{size}");
    }

    /// Every module that another one imports is served, and every file that is served is used.
    #[test]
    fn imports_are_served() {
        let imported = |text: &str, path: &str| text.contains(&format!("\"{path}\""));
        for (path, _, _) in files().filter(|(path, ..)| path != "/") {
            let used = files().any(|(_, _, text)| imported(text, &path));
            assert!(used, "{path} is not used");
        }
        for (file, _, text) in files() {
            for line in text.lines().filter(|line| line.starts_with("import ")) {
                let path = line.rsplit('"').nth(1).unwrap_or_default();
                let served = files().any(|(served, ..)| served == path)
                    || shared().iter().any(|(served, ..)| *served == path);
                assert!(served, "{file} imports {path}");
            }
        }
    }
}
