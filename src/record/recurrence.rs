//! The recurrence plot, Eq. (26): bright where the state comes back to where it was, shaded by
//! distance elsewhere.
//!
//! A pixel is a class, one byte: a shade of distance, or recurrence. The viewer looks the
//! colour up and names the class under the cursor; colours in the picture would take three
//! times the room.

use rerun::{
    AnnotationContext, SegmentationImage, Transform3D, components::ImageFormat,
    datatypes::ChannelDatatype,
};

use super::{
    error::RecordError,
    paths::{self, Root},
    plot::{Bounds, Plot},
    stream::{self, Moment, RecordingStream},
    style::{ColorMap, Quantity},
};
use crate::analysis::RecurrenceImage;
use crate::plot::Axis;
use crate::plot::response::{SHADES, classes};

/// Side of the field, pixels of the picture's plane.
const SIDE: f32 = 400.0;
/// Brightest shade of a pair that is not recurrent, as a share of the colour map.
const BRIGHTEST: f32 = 0.5;

/// Draws recurrence plots.
#[derive(Debug)]
pub struct Recurrence {
    root: Root,
    quantity: Quantity,
    /// Window (s) and size for which axes and scale are drawn.
    drawn: Option<(f64, usize)>,
}

impl Recurrence {
    /// Says what the classes mean; axes come with the first picture.
    pub fn new(rec: &RecordingStream, root: Root, quantity: Quantity) -> Result<Self, RecordError> {
        let map = ColorMap::inferno();
        let shades = (0..SHADES).map(|shade| {
            let percent = 100 * (u32::from(shade) + 1) / u32::from(SHADES);
            let near = 1.0 - f32::from(shade) / f32::from(SHADES - 1);
            let name = format!("distance up to {percent} % of the largest");
            class(shade, &name, map.at(BRIGHTEST * near))
        });
        let recurrent = class(SHADES, "recurrent", map.at(1.0));
        let classes = AnnotationContext::new(shades.chain([recurrent]).collect::<Vec<_>>());
        rec.log_static(root.at(paths::RECURRENCE_IMAGE), &classes)?;
        Ok(Self {
            root,
            quantity,
            drawn: None,
        })
    }

    fn plot(window: f64) -> Plot {
        let unit = Quantity::Time.unit(window);
        let axis = |name: &str| Axis::linear(name, [-unit.per_si * window, 0.0]);
        // The upright axis means the same; the caption takes the place of its name.
        Plot {
            width: SIDE,
            height: SIDE,
            head: 0.0,
            x: axis(&format!("time before now, {}, on both axes", unit.symbol)),
            y: axis(""),
            grid: false,
        }
    }

    /// What the view must show, whatever the window.
    pub fn bounds() -> Bounds {
        Self::plot(1.0).bounds()
    }

    /// Draws a plot; it stands at the end of its window.
    pub fn draw(
        &mut self,
        rec: &RecordingStream,
        at: impl Into<Moment>,
        picture: &RecurrenceImage,
    ) -> Result<(), RecordError> {
        let at = at.into();
        let now = (picture.window, picture.size);
        let image_path = self.root.at(paths::RECURRENCE_IMAGE);
        if self.drawn != Some(now) {
            self.drawn = Some(now);
            let axes = self.root.at(paths::RECURRENCE);
            Self::plot(picture.window).draw(rec, &axes, Some(at))?;
            let scale = SIDE / picture.size as f32;
            let scale = Transform3D::from_scale([scale, scale, 1.0]);
            stream::log_at(rec, &*image_path, at, &scale)?;
        }
        let format = ImageFormat::segmentation([picture.size as u32; 2], ChannelDatatype::U8);
        let image = SegmentationImage::new(classes(picture, true), format)
            .with_opacity(1.0)
            .with_draw_order(-2.0);
        stream::log_at(rec, image_path, at, &image)?;

        let epsilon = match picture.threshold {
            Some(threshold) => format!("ε = {}", self.quantity.words(threshold)),
            None => "ε of each state its own".to_owned(),
        };
        let words = format!(
            "{:.0} % recurrent, {epsilon}, m = {}, τ = {}",
            1e2 * picture.rate,
            picture.dimension,
            Quantity::Time.words(picture.lag),
        );
        self.caption(rec, at, &words)
    }

    fn caption(&self, rec: &RecordingStream, at: Moment, words: &str) -> Result<(), RecordError> {
        let path = self.root.at(paths::RECURRENCE);
        Self::plot(1.0).draw_caption(rec, &path, at, words)
    }
}

/// A class with its name and colour.
fn class(id: u8, name: &str, [r, g, b]: [u8; 3]) -> rerun::ClassDescription {
    let color = rerun::Rgba32::from_rgb(r, g, b);
    (u16::from(id), name, color).into()
}
