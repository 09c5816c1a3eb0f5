//! Rendering of SVG as PNG and PDF.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use svg2pdf::{ConversionOptions, PageOptions};

use super::figure::FigureError;
use super::text;

/// Dots per inch of an SVG.
const DOTS: f32 = 96.0;

pub fn tree(svg: &str) -> Result<Tree, FigureError> {
    let options = Options {
        fontdb: Arc::clone(&FONTS),
        font_family: text::FAMILY.to_owned(),
        ..Options::default()
    };
    Tree::from_str(svg, &options).map_err(failure)
}

fn failure(error: impl ToString) -> FigureError {
    FigureError(error.to_string())
}

/// Renders an SVG at a resolution in pixels per inch.
pub fn png(svg: &str, resolution: f32) -> Result<Vec<u8>, FigureError> {
    let tree = tree(svg)?;
    let scale = resolution / DOTS;
    let [width, height] = [tree.size().width(), tree.size().height()];
    let [width, height] = [width, height].map(|side| (side * scale).round() as u32);
    let size = "its size is zero or too large";
    let mut pixels = Pixmap::new(width, height).ok_or_else(|| failure(size))?;
    let enlarged = Transform::from_scale(scale, scale);
    resvg::render(&tree, enlarged, &mut pixels.as_mut());
    pixels.encode_png().map_err(failure)
}

/// Converts an SVG to a single-page PDF.
pub fn pdf(svg: &str) -> Result<Vec<u8>, FigureError> {
    let page = PageOptions { dpi: DOTS };
    svg2pdf::to_pdf(&tree(svg)?, ConversionOptions::default(), page).map_err(failure)
}

/// The font, parsed once.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    for face in text::FACES {
        fonts.load_font_data(face.to_vec());
    }
    Arc::new(fonts)
});
