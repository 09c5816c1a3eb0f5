//! The recurrence plot, Eq. (26): recurrent pairs are bright, other pairs are shaded by distance.
//!
//! A pixel is a class index of one byte: a shade of distance, or recurrence. The viewer looks up the colour
//! and displays the name of the class under the cursor. Colours instead of indices would take three times the
//! space.

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

/// Side of the plot area, pixels.
const SIDE: f32 = 400.0;
/// Brightest shade of a non-recurrent pair, as a position in the colour map.
const BRIGHTEST: f32 = 0.5;

/// Draws recurrence plots.
#[derive(Debug)]
pub struct Recurrence {
    root: Root,
    quantity: Quantity,
    /// Window (s) and size of the current axes and scale.
    drawn: Option<(f64, usize)>,
}

impl Recurrence {
    /// Names the classes; the axes are drawn with the first plot.
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
        // The vertical axis is the same; the caption is drawn in place of its name.
        Plot {
            width: SIDE,
            height: SIDE,
            top_margin: 0.0,
            x: axis(&format!("time before present, {} (both axes)", unit.symbol)),
            y: axis(""),
            grid: false,
        }
    }

    /// Bounds of the view; they do not depend on the window.
    pub fn bounds() -> Bounds {
        Self::plot(1.0).bounds()
    }

    /// Draws a plot at the end of its window.
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

        let caption = caption(picture, &self.quantity);
        let path = self.root.at(paths::RECURRENCE);
        Self::plot(1.0).draw_caption(rec, &path, at, &caption)
    }
}

/// Recurrence rate, threshold (a distance in the unit of `quantity`), dimension and delay of a recurrence
/// plot.
pub fn caption(plot: &RecurrenceImage, quantity: &Quantity) -> String {
    let epsilon = match plot.threshold {
        Some(threshold) => format!("ε = {}", quantity.format(threshold)),
        None => "ε chosen for each state".to_owned(),
    };
    format!(
        "RR = {:.0} %, {epsilon}, m = {}, τ = {}",
        1e2 * plot.rate,
        plot.dimension,
        Quantity::Time.format(plot.lag),
    )
}

/// A class with its name and colour.
fn class(id: u8, name: &str, [r, g, b]: [u8; 3]) -> rerun::ClassDescription {
    let color = rerun::Rgba32::from_rgb(r, g, b);
    (u16::from(id), name, color).into()
}
