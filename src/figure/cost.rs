//! Work-precision sets: error over CPU time, and over calls of the right-hand side.

use super::panel::{Axis, Mark, Panel};
use super::style::{BLUE, GREEN, INK, ORANGE, PURPLE, Rgb, SKY, VERMILION};
use super::{Figure, FigureError};
use crate::analysis::range;
use crate::study::cost::{CostPoint, CostSet, CostStudy, Knob};

/// Colours of the families, in turn.
const FAMILIES: [Rgb; 7] = [BLUE, VERMILION, GREEN, PURPLE, SKY, ORANGE, INK];

/// Errors below this are drawn as this.
const LEAST: f64 = 1e-16;

/// What is drawn of a point: its work and its error.
type Work = fn(&CostPoint) -> f64;

/// A figure for each knob that was turned, `cost-KNOB`.
///
/// # Errors
/// [`FigureError`].
pub fn cost_figures(study: &CostStudy) -> Result<Vec<Figure>, FigureError> {
    let knobs = Knob::ALL.into_iter().filter_map(|knob| {
        let sets: Vec<&CostSet> = study.sets.iter().filter(|set| set.knob == knob).collect();
        (!sets.is_empty()).then(|| figure(study, knob, &sets))
    });
    knobs.collect()
}

fn figure(study: &CostStudy, knob: Knob, sets: &[&CostSet]) -> Result<Figure, FigureError> {
    let milliseconds: Work = |point| 1e3 * point.seconds;
    let mut row = vec![panel("CPU time, ms", knob, sets, milliseconds)];
    if sets.iter().flat_map(|set| &set.points).any(|p| p.calls > 0) {
        let calls: Work = |point| point.calls as f64;
        row.push(panel("calls of the right-hand side", knob, sets, calls));
    }
    let title = match knob {
        Knob::Integrator | Knob::Events | Knob::Nodes => format!(
            "{} — {}, over {:.3} ms",
            study.scene,
            knob.name(),
            1e3 * study.horizon
        ),
        _ => format!("{} — {}", study.scene, knob.name()),
    };
    Figure::new(format!("cost-{}", knob.name()), &title, [1200, 520], &[row])
}

fn panel(work_name: &str, knob: Knob, sets: &[&CostSet], work: Work) -> Panel {
    let points = || sets.iter().flat_map(|set| &set.points);
    let errors = points().filter_map(|point| point.error.as_ref().ok().map(|e| e.max(LEAST)));
    let floors = || sets.iter().filter_map(|set| set.floor);
    let drawn = floors().filter(|floor| *floor > LEAST);
    let y = decades(errors.chain(drawn), 1.0);
    let done = points().filter(|point| point.error.is_ok()).map(work);
    let x = decades(done.filter(|work| *work > 0.0), 0.0);
    let [left, right] = x.map(|decade| 10f64.powi(decade));
    let mut marks = Vec::new();
    // The error of the reference, of each family where they differ: below it nothing is told.
    let one_floor = floors().all(|floor| Some(floor) == sets[0].floor);
    if let (true, Some(floor)) = (one_floor, sets[0].floor) {
        marks.push(Mark::Level {
            y: floor.max(LEAST),
        });
        marks.push(Mark::Words {
            // Clear of the axis.
            at: [left * (right / left).powf(0.01), 4.0 * floor.max(LEAST)],
            words: "the reference's own error".to_owned(),
        });
    }
    let mut dots = Vec::new();
    for (set, color) in sets.iter().zip(FAMILIES.into_iter().cycle()) {
        if let (false, Some(floor)) = (one_floor, set.floor) {
            marks.push(Mark::Wire {
                points: [left, right].map(|x| [x, floor.max(LEAST)]).to_vec(),
                color,
            });
        }
        let place = |point: &CostPoint| {
            let error = point.error.as_ref().ok()?;
            Some([work(point), error.max(LEAST)])
        };
        let curve: Vec<[f64; 2]> = set.points.iter().filter_map(place).collect();
        marks.push(Mark::Line {
            points: curve.clone(),
            color,
            label: set.family.clone(),
        });
        dots.push(Mark::Dots {
            points: curve,
            // Where families agree (`auto` and what it chooses), each still shows as a ring.
            radius: 3.0 + 0.4 * dots.len() as f64,
            color,
            label: String::new(),
        });
    }
    marks.extend(dots.into_iter().rev());
    // Failures have a work, but it is that of failing: they stand at the edge, a row a family.
    let failures = sets.iter().filter_map(|set| {
        let failed = |point: &&CostPoint| point.error.is_err();
        let values: Vec<String> = set
            .points
            .iter()
            .filter(failed)
            .map(|point| format!("{:e}", point.value))
            .collect();
        (!values.is_empty()).then(|| format!("× {} at {}", set.family, values.join(", ")))
    });
    let rows = f64::from(y[1] - y[0]) * 0.05;
    for (row, words) in failures.enumerate() {
        marks.push(Mark::Words {
            at: [
                left * (right / left).powf(0.01),
                10f64.powf(f64::from(y[1]) - rows * (row as f64 + 0.7)),
            ],
            words,
        });
    }
    Panel {
        title: String::new(),
        x: Axis::decades(work_name, x),
        y: Axis::decades(knob.error(), y),
        marks,
    }
}

/// Whole decades round some positive values, at least one; `above` more at the top.
pub(super) fn decades(values: impl Iterator<Item = f64>, above: f64) -> [i32; 2] {
    let [low, high] = range(values.map(f64::log10));
    if low > high {
        return [-1, 0];
    }
    let ends = [low.floor() as i32, (high + 0.3 * above).ceil() as i32];
    [ends[0], ends[1].max(ends[0] + 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_drawn_and_failures_are_marked() {
        let point = |seconds: f64, error: Result<f64, String>| CostPoint {
            value: 1e-3,
            seconds,
            calls: (1e6 * seconds) as u64,
            error,
            detail: String::new(),
        };
        let study = CostStudy {
            scene: "test".to_owned(),
            held: Default::default(),
            horizon: 4e-3,
            exponent: None,
            stopped: false,
            sets: vec![CostSet {
                knob: Knob::Integrator,
                family: "lawson54".to_owned(),
                turned: "tolerance",
                floor: Some(1e-9),
                points: vec![
                    point(1e-3, Ok(1e-3)),
                    point(2e-3, Ok(1e-7)),
                    point(5e-4, Err("it blew up".to_owned())),
                ],
            }],
        };
        let figures = cost_figures(&study).unwrap();
        assert_eq!(figures.len(), 1);
        assert_eq!(figures[0].name, "cost-integrator");
        let svg = &figures[0].svg;
        assert!(svg.contains("lawson54") && svg.contains("× lawson54 at 1e-3"));
        assert!(svg.contains("own error") && svg.contains("10⁻⁹"), "{svg}");
        // Two dots in each of two panels.
        assert_eq!(svg.matches("<circle").count(), 4);
    }

    #[test]
    fn decades_hold_all_values() {
        assert_eq!(decades([0.02, 3.0].into_iter(), 0.0), [-2, 1]);
        assert_eq!(decades([1.0].into_iter(), 0.0), [0, 1]);
        assert_eq!(decades([].into_iter(), 0.0), [-1, 0]);
    }
}
