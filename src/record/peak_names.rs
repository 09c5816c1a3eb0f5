//! Labels of the peaks of a curve above its plot area.

use rerun::{Color, LineStrips2D, Points2D, Radius};

use super::style;
use crate::plot::shown;

/// Rows of peak labels above the plot area, and their height, pixels.
const NAME_LINES: usize = 3;
const NAME_HEIGHT: f32 = 24.0;
/// Height of all rows of peak labels, pixels.
pub const NAMES_HEIGHT: f32 = NAME_LINES as f32 * NAME_HEIGHT - 4.0;
/// Width of a character of a label and space around a label, pixels. They are upper limits, because the
/// viewer uses a fixed font size.
const LETTER: f32 = 8.0;
const NAME_PADDING: f32 = 16.0;

/// Labels of peaks above the plot area, and lines from them to the peaks.
pub fn names_and_stems(
    width: f32,
    named: impl Iterator<Item = Named>,
    color: Color,
) -> (Points2D, LineStrips2D) {
    let placed = place_names(width, named);
    let names = Points2D::new(placed.iter().map(|name| name.at))
        .with_labels(placed.iter().map(|name| shown(&name.named.name)))
        .with_show_labels(true)
        .with_colors(vec![color; placed.len()])
        .with_radii([Radius::new_ui_points(0.0)]);
    // The lines start below the label, which the viewer draws below its position.
    let stems = placed.iter().map(|name| {
        let [x, tip] = name.named.tip;
        [[x, name.at[1] + NAME_HEIGHT], [x, tip]]
    });
    let stems = LineStrips2D::new(stems)
        .with_colors([style::faded(color, 0.5)])
        .with_radii([Radius::new_ui_points(0.5)]);
    (names, stems)
}

/// Position and label of a peak.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// Position of the peak.
    pub tip: [f32; 2],
    /// Label of the peak.
    pub name: String,
}

/// A label and its position.
#[derive(Clone, Debug, PartialEq)]
struct Placed {
    named: Named,
    at: [f32; 2],
}

/// Places labels above the plot area, centred over their peaks if possible, in the given order. Each label
/// takes the lowest row in which it overlaps no other; a label without space is omitted, its peak keeps its
/// mark.
fn place_names(width: f32, names: impl Iterator<Item = Named>) -> Vec<Placed> {
    let mut placed: Vec<Placed> = Vec::new();
    let mut taken: [Vec<[f32; 2]>; NAME_LINES] = Default::default();
    for named in names {
        let half = 0.5 * (LETTER * named.name.chars().count() as f32 + NAME_PADDING);
        let middle = named.tip[0].clamp(half - NAME_PADDING, width + NAME_PADDING - half);
        let [left, right] = [middle - half, middle + half];
        let is_free = |line: &Vec<[f32; 2]>| line.iter().all(|[a, b]| right <= *a || *b <= left);
        if let Some(line) = taken.iter().position(is_free) {
            taken[line].push([left, right]);
            let at = [middle, -(line as f32 + 1.0) * NAME_HEIGHT - 4.0];
            placed.push(Placed { named, at });
        }
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_overlap() {
        let named = |x: f32, name: &str| Named {
            tip: [x, 50.0],
            name: name.to_owned(),
        };
        let crowd = [
            (100.0, "f1: 4.12"),
            (103.0, "f2: 3.88"),
            (390.0, "3 f1: 12.36"),
            (97.0, "f3: 4"),
        ];
        let placed = place_names(400.0, crowd.map(|(x, name)| named(x, name)).into_iter());
        let line = |k: usize| (-placed[k].at[1] / NAME_HEIGHT) as usize;
        assert_eq!([line(0), line(1), line(2), line(3)], [1, 2, 1, 3]);
        assert_eq!(placed[0].at[0], 100.0, "over its peak");
        assert!(placed[2].at[0] < 390.0, "within the view");
        // There is no space for a fourth label at the same place.
        let five = [100.0, 101.0, 102.0, 103.0, 300.0].map(|x| named(x, "f1: 4.12"));
        let kept: Vec<_> = place_names(400.0, five.into_iter())
            .iter()
            .map(|p| p.named.tip[0])
            .collect();
        assert_eq!(kept, [100.0, 101.0, 102.0, 300.0]);
    }
}
