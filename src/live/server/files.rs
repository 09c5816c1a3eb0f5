//! The files of the page, embedded in the binary.

use axum::Router;
use axum::http::header;
use axum::routing::get;
use serde_json::json;

use crate::plot::{Color, INFERNO, NAMED_LINES, PREFIXES, Rgb, gradient};
use crate::record::TRAIL;

/// Path of a file, its type and its content.
type File = (&'static str, &'static str, &'static str);

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

macro_rules! files {
    ($($path:literal: $type:ident = $file:literal),* $(,)?) => {
        &[$(($path, $type, include_str!(concat!("../page/", $file)))),*]
    };
}

/// The files of the page.
const FILES: &[File] = files! {
    "/": HTML = "index.html",
    "/page.css": CSS = "page.css",
    "/page.js": JS = "page.js",
    "/bookmarks.js": JS = "bookmarks.js",
    "/compare.js": JS = "compare.js",
    "/qr.js": JS = "qr.js",
    "/share.js": JS = "share.js",
    "/tour.js": JS = "tour.js",
    "/colours.js": JS = "colours.js",
    "/data.js": JS = "data.js",
    "/diagram.js": JS = "diagram.js",
    "/dom.js": JS = "dom.js",
    "/keys.js": JS = "keys.js",
    "/controls.js": JS = "controls.js",
    "/listen.js": JS = "listen.js",
    "/markdown.js": JS = "markdown.js",
    "/panel.js": JS = "panel.js",
    "/plot.js": JS = "plot.js",
    "/run.js": JS = "run.js",
    "/sound.js": JS = "sound.js",
    "/stage.js": JS = "stage.js",
    "/texts.js": JS = "texts.js",
    "/theme.js": JS = "theme.js",
    "/views/body.js": JS = "views/body.js",
    "/views/lesson.js": JS = "views/lesson.js",
    "/views/patch.js": JS = "views/patch.js",
    "/views/portrait.js": JS = "views/portrait.js",
    "/views/recurrence.js": JS = "views/recurrence.js",
    "/views/scope.js": JS = "views/scope.js",
    "/views/section.js": JS = "views/section.js",
    "/views/spectrogram.js": JS = "views/spectrogram.js",
    "/views/spectrum.js": JS = "views/spectrum.js",
};

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
    let files = FILES
        .iter()
        .map(|&(path, kind, text)| (path, kind, text.to_owned()));
    files
        .chain(shared())
        .fold(router, |router, (path, kind, text)| {
            router.route(
                path,
                get(move || async move { ([(header::CONTENT_TYPE, kind)], text) }),
            )
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
        for (path, _, text) in FILES {
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
        for (path, _, _) in FILES.iter().filter(|(path, ..)| *path != "/") {
            let used = FILES.iter().any(|(_, _, text)| imported(text, path));
            assert!(used, "{path} is not used");
        }
        for (file, _, text) in FILES {
            for line in text.lines().filter(|line| line.starts_with("import ")) {
                let path = line.rsplit('"').nth(1).unwrap_or_default();
                let served = FILES.iter().any(|(served, ..)| *served == path);
                let served = served || shared().iter().any(|(served, ..)| *served == path);
                assert!(served, "{file} imports {path}");
            }
        }
    }
}
