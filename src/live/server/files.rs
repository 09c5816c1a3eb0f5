//! The files of the page, embedded in the binary.

use std::collections::BTreeMap;

use axum::Router;
use axum::body::Bytes;
use axum::http::header;
use axum::routing::get;
use include_dir::{Dir, include_dir};
use serde_json::json;
use strum::VariantArray as _;

use crate::analysis::regime::Regime;
use crate::number::PREFIXES;
use crate::pipeline::message::NodeState;
use crate::plot::response::phase_portrait;
use crate::plot::{Color, FULL_SCALES, INFERNO, NAMED_LINES, Rgb, TICK_STEPS, gradient, readable};
use crate::record::{TRAIL, node_color};

pub(super) const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
pub(super) const JS: &str = "text/javascript; charset=utf-8";

/// A file: path, type and content.
type PageFile = (String, &'static str, Bytes);

/// The folder of the page; its folder `viewer` belongs to the page of a recording.
static PAGE: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/src/live/page");

/// The files of the page.
pub(super) fn page() -> impl Iterator<Item = PageFile> {
    let views = PAGE.get_dir("views").into_iter().flat_map(Dir::files);
    let embedded = PAGE.files().chain(views).filter_map(|file| {
        let name = file.path().to_string_lossy().replace('\\', "/");
        let (path, kind) = match name.rsplit_once('.')? {
            (_, "html") => ("/".to_owned(), HTML),
            (_, "css") => (format!("/{name}"), CSS),
            (_, "js") => (format!("/{name}"), JS),
            _ => return None,
        };
        Some((path, kind, Bytes::from_static(file.contents())))
    });
    embedded.chain(shared())
}

/// What the page shares with figures and recordings: colours as a style sheet, and a module with the prefixes of units,
/// first digits of ticks and full scales, names of axes, colours on light and dark ground, a colour map, the length of the
/// trail of the phase portrait and the number of named lines.
fn shared() -> [PageFile; 2] {
    let rule = |on: fn(Color) -> Rgb| {
        let rules = [
            ("signal", Color::Run),
            ("mark", Color::Compared),
            ("stick", node_color(NodeState::Stick)),
            ("slip", node_color(NodeState::Slip)),
            ("separated", node_color(NodeState::Separated)),
            ("friction", Color::Series(4)),
        ];
        let rules = rules.map(|(name, color)| {
            let [r, g, b] = on(color);
            format!("--{name}: rgb({r}, {g}, {b});")
        });
        format!("{{ {} }}", rules.join(" "))
    };
    let [dark, light] = [Color::on_dark, Color::on_light].map(rule);
    let colours = format!(":root {dark}\n:root[data-theme=\"light\"] {light}\n");
    let regimes = Regime::VARIANTS.iter();
    let regimes = regimes.map(|&regime| (regime.to_string(), Color::Regime(regime)));
    let portrait = phase_portrait(&[], None, Color::Run);
    let values = json!({
        "tick_steps": TICK_STEPS,
        "full_scales": FULL_SCALES,
        "displacement": portrait.x.name,
        "velocity": portrait.y.name,
        "tilt": readable("load.tilt_deg", "deg"),
        "prefixes": PREFIXES,
        "signal": Color::Run,
        "regimes": regimes.collect::<BTreeMap<_, _>>(),
        "spectrogram": &gradient(&INFERNO)[..],
        "trail_s": TRAIL,
        "named_lines": NAMED_LINES,
    });
    let values = format!("export default {values};\n");
    [("/shared.css", CSS, colours), ("/shared.js", JS, values)]
        .map(|(path, kind, text)| (path.to_owned(), kind, text.into()))
}

/// Serves files.
pub(super) fn routes<S: Clone + Send + Sync + 'static>(
    router: Router<S>,
    files: impl IntoIterator<Item = PageFile>,
) -> Router<S> {
    files
        .into_iter()
        .fold(router, |router, (path, kind, content)| {
            router.route(&path, get(([(header::CONTENT_TYPE, kind)], content)))
        })
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use super::*;

    fn texts() -> Vec<(String, String)> {
        let text = |content: Bytes| String::from_utf8(content.to_vec()).unwrap();
        page()
            .map(|(path, _, content)| (path, text(content)))
            .collect()
    }

    /// The page loads fast on a slow network: at most 300 kB, compressed.
    #[test]
    fn the_page_is_small() {
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (path, text) in texts() {
            let name = path.trim_start_matches('/');
            archive
                .start_file(name, zip::write::SimpleFileOptions::default())
                .unwrap();
            archive.write_all(text.as_bytes()).unwrap();
        }
        let size = archive.finish().unwrap().into_inner().len();
        assert!((10_000..300_000).contains(&size), "{size}");
    }

    /// Every module that another one imports is served, and every file that is served is used.
    #[test]
    fn imports_are_served() {
        let files = texts();
        for (path, _) in files.iter().filter(|(path, _)| path != "/") {
            let name = format!("\"{path}\"");
            let used = files.iter().any(|(_, text)| text.contains(&name));
            assert!(used, "{path} is not used");
        }
        for (file, text) in &files {
            for line in text.lines().filter(|line| line.starts_with("import ")) {
                let path = line.rsplit('"').nth(1).unwrap_or_default();
                let served = files.iter().any(|(served, _)| served == path);
                assert!(served, "{file} imports {path}");
            }
        }
    }
}
