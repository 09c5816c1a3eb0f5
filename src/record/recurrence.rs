//! The recurrence plot, Eq. (26): bright where the state comes back to where it was, shaded by
//! distance elsewhere.

use rerun::{Image, Points2D, Radius, RecordingStream, Transform3D};

use super::{
    error::RecordError,
    paths,
    plot::{Axis, Bounds, Plot},
    stream,
    style::{self, ColorMap, short},
};

/// Side of the field, pixels of the picture's plane.
const SIDE: f32 = 400.0;
/// Shades of distance; few, because noise in the last bits only swells the file.
const SHADES: u8 = 16;
/// Brightest shade of a pair that is not recurrent, as a share of the colour map.
const BRIGHTEST: f32 = 0.5;

/// One recurrence plot, borrowed from its record.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// End of the window, s.
    pub time: f64,
    /// Length of the window, s.
    pub window: f64,
    /// Points along a side.
    pub size: usize,
    /// Distance of each pair, 0 to 255, `size x size`, oldest first.
    pub distance: &'a [u8],
    /// 255 where recurrent, else 0.
    pub recurrent: &'a [u8],
    /// Threshold, m.
    pub threshold: f64,
    /// Recurrence rate, 0 to 1.
    pub rate: f64,
    /// Delay, s.
    pub lag: f64,
    /// Embedding dimension.
    pub dimension: usize,
}

/// Draws recurrence plots.
#[derive(Debug)]
pub struct Recurrence {
    /// Colour of each distance, and of recurrence.
    shades: [[u8; 3]; 256],
    recurrent: [u8; 3],
    /// Window (s) and size for which axes and scale are drawn.
    drawn: Option<(f64, usize)>,
}

impl Recurrence {
    /// Starts empty; axes come with the first picture.
    pub fn new() -> Self {
        let map = ColorMap::inferno();
        let step = 256 / u16::from(SHADES);
        Self {
            shades: std::array::from_fn(|distance| {
                let shade = distance as u16 / step;
                let near = 1.0 - f32::from(shade) / f32::from(SHADES - 1);
                map.at(BRIGHTEST * near)
            }),
            recurrent: map.at(1.0),
            drawn: None,
        }
    }

    fn plot(window: f64) -> Plot {
        let axis = |name: &str| Axis::linear(name, -1e3 * window, 0.0, 4);
        Plot {
            width: SIDE,
            height: SIDE,
            x: axis("time before now, ms"),
            y: axis("time before now, ms"),
            grid: false,
        }
    }

    /// What the view must show, whatever the window.
    pub fn bounds() -> Bounds {
        let Bounds { x, y: [top, low] } = Self::plot(1.0).bounds();
        // One more line of words, the caption.
        Bounds {
            x,
            y: [top - 16.0, low],
        }
    }

    /// Draws a plot.
    pub fn draw(&mut self, rec: &RecordingStream, picture: Picture) -> Result<(), RecordError> {
        let now = (picture.window, picture.size);
        if self.drawn != Some(now) {
            self.drawn = Some(now);
            Self::plot(picture.window).draw(rec, paths::RECURRENCE_AXES, Some(picture.time))?;
            let scale = SIDE / picture.size as f32;
            let scale = Transform3D::from_scale([scale, scale, 1.0]);
            stream::log_at(rec, paths::RECURRENCE_IMAGE, picture.time, &scale)?;
        }
        let image = Image::from_rgb24(self.pixels(&picture), [picture.size as u32; 2])
            .with_draw_order(-2.0);
        stream::log_at(rec, paths::RECURRENCE_IMAGE, picture.time, &image)?;

        let words = format!(
            "{:.1} % recurrent, ε = {} µm, m = {}, τ = {} µs",
            1e2 * picture.rate,
            short(1e6 * picture.threshold),
            picture.dimension,
            short(1e6 * picture.lag),
        );
        let caption = Points2D::new([[0.5 * SIDE, -32.0]])
            .with_labels([words])
            .with_colors([style::AXIS])
            .with_radii([Radius::new_ui_points(0.0)]);
        stream::log_at(rec, paths::RECURRENCE_CAPTION, picture.time, &caption)
    }

    /// RGB pixels, the newest row on top.
    fn pixels(&self, picture: &Picture) -> Vec<u8> {
        let rows = picture.distance.chunks_exact(picture.size).rev();
        let marks = picture.recurrent.chunks_exact(picture.size).rev();
        let mut pixels = Vec::with_capacity(3 * picture.distance.len());
        for (row, marks) in rows.zip(marks) {
            for (&distance, &mark) in row.iter().zip(marks) {
                pixels.extend(if mark == 0 {
                    self.shades[usize::from(distance)]
                } else {
                    self.recurrent
                });
            }
        }
        pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn newest_row_is_on_top_and_recurrence_shines() {
        let recurrence = Recurrence::new();
        let picture = Picture {
            time: 0.0,
            window: 1e-3,
            size: 2,
            distance: &[0, 255, 255, 0],
            recurrent: &[0, 0, 0, 255],
            threshold: 1e-7,
            rate: 0.25,
            lag: 1e-5,
            dimension: 3,
        };
        let far = recurrence.shades[255];
        let expected = [far, recurrence.recurrent, recurrence.shades[0], far].concat();
        assert_eq!(recurrence.pixels(&picture), expected);
        assert_eq!(far, ColorMap::inferno().at(0.0));
    }
}
