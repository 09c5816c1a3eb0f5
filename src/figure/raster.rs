//! From SVG to pixels.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::{FigureError, style};

/// Pixels a point.
const SCALE: f32 = 2.0;

/// Draws an SVG with the program's own font.
pub fn png(svg: &str) -> Result<Vec<u8>, FigureError> {
    let failed = |reason: &dyn std::fmt::Display| FigureError::Raster(reason.to_string());
    let options = Options {
        fontdb: fonts(),
        font_family: style::FAMILY.to_owned(),
        ..Options::default()
    };
    let tree = Tree::from_str(svg, &options).map_err(|e| failed(&e))?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|s| (s * SCALE) as u32);
    let mut pixels = Pixmap::new(width, height).ok_or_else(|| failed(&"it has no size"))?;
    resvg::render(
        &tree,
        Transform::from_scale(SCALE, SCALE),
        &mut pixels.as_mut(),
    );
    pixels.encode_png().map_err(|e| failed(&e))
}

/// The font, parsed once.
fn fonts() -> Arc<fontdb::Database> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let load = || {
        let mut fonts = fontdb::Database::new();
        for face in style::FACES {
            fonts.load_font_data(face.to_vec());
        }
        Arc::new(fonts)
    };
    Arc::clone(FONTS.get_or_init(load))
}
