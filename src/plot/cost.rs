//! Work-precision sets: error over CPU time, and over evaluations of the right-hand side.

use super::axis::{Axis, decades};
use super::color::Color;
use super::figure::{Figure, Layer, Marker, Panel};
use crate::number::{error, setting, short};
use crate::study::cost::{Advice, CostPoint, CostSet, CostStudy, Knob};

/// Errors below this are drawn at the lower end.
const LEAST: f64 = 1e-16;
/// Height of the row of a family that failed, as a share of the field.
const ROW: f64 = 0.05;

/// What errors are set against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// CPU time.
    Time,
    /// Evaluations of the right-hand side.
    Calls,
}

impl Work {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Time, Self::Calls];

    /// That of a point, in the unit of the axis; `None` where there is none.
    fn of(self, point: &CostPoint) -> Option<f64> {
        let work = match self {
            Self::Time => 1e3 * point.seconds,
            Self::Calls => point.calls as f64,
        };
        (work > 0.0).then_some(work)
    }

    /// Its name and unit.
    fn name(self) -> &'static str {
        match self {
            Self::Time => "CPU time, ms",
            Self::Calls => "calls of the right-hand side",
        }
    }
}

/// A figure for each knob that was turned, `cost-KNOB`.
pub fn cost_figures(study: &CostStudy) -> Vec<Figure> {
    let knobs = Knob::ALL.into_iter().filter_map(|knob| {
        let row: Vec<Panel> = error_panels(study, knob)
            .into_iter()
            .map(|(_, panel)| panel)
            .collect();
        let title = match knob {
            Knob::Integrator | Knob::Events | Knob::Nodes => format!(
                "{}: {}, over {:.3} ms",
                study.scene,
                knob.name(),
                1e3 * study.horizon
            ),
            _ => format!("{}: {}", study.scene, knob.name()),
        };
        let name = format!("cost-{}", knob.name());
        (!row.is_empty()).then(|| Figure::new(name, title, 88.0, vec![row]))
    });
    knobs.collect()
}

/// The sets of a knob: error over CPU time, and over calls if there are any; both have the same axis of
/// errors.
pub fn error_panels(study: &CostStudy, knob: Knob) -> Vec<(Work, Panel)> {
    let sets: Vec<&CostSet> = study.sets.iter().filter(|set| set.knob == knob).collect();
    let points = || sets.iter().flat_map(|set| &set.points);
    let works = Work::ALL.into_iter();
    let works = works.filter(|work| points().any(|point| work.of(point).is_some()));
    works
        .map(|work| (work, panel(study, knob, &sets, work)))
        .collect()
}

fn panel(study: &CostStudy, knob: Knob, sets: &[&CostSet], work: Work) -> Panel {
    let points = || sets.iter().flat_map(|set| &set.points);
    let x = Axis::closely(work.name(), points().filter_map(|point| work.of(point)));
    let y = errors(knob, sets);
    let mut layers = floors(sets, &x);
    let drawn = |set: &&CostSet| -> Vec<([f64; 2], String)> {
        let points = set.points.iter();
        let points = points.filter_map(|point| {
            let error = point.error.as_ref().ok()?.max(y.range[0]);
            Some(([work.of(point)?, error], hover(set, point)))
        });
        points.collect()
    };
    let advised: &[Advice] = match knob {
        Knob::Integrator => &study.advice,
        _ => &[],
    };
    let best = sets.iter().flat_map(|set| {
        let best = advised.iter().filter(|advice| advice.method == set.family);
        let best = best.filter_map(|advice| set.points.iter().find(|p| p.value == advice.value));
        best.filter_map(|point| Some([work.of(point)?, *point.error.as_ref().ok()?]))
    });
    let best: Vec<[f64; 2]> = best.collect();
    if !best.is_empty() {
        let best = Layer::points(best, 5.0, Color::Ink).marked(Marker::Ring);
        layers.push(best.at("advised").named("cheapest for its error"));
    }
    layers.extend(sets.iter().enumerate().map(|(k, set)| {
        let places = drawn(set).into_iter().map(|(place, _)| place).collect();
        // A line that another may cover is wider, so that it is still seen.
        let width = 1.0 + 0.25 * 6usize.saturating_sub(k) as f64;
        let line = Layer::line(places, Color::Series(k)).wide(width);
        line.named(&set.family).at(entity("curves", set))
    }));
    layers.extend(sets.iter().enumerate().map(|(k, set)| {
        let (places, hover) = drawn(set).into_iter().unzip();
        let points = Layer::points(places, 2.4, Color::Series(k));
        points.hovered(hover).at(entity("points", set))
    }));
    layers.extend(failures(sets, &x, &y, work));
    Panel::new("", x, y, layers)
}

/// The axis of errors, with room above for what failed.
fn errors(knob: Knob, sets: &[&CostSet]) -> Axis {
    let points = sets.iter().flat_map(|set| &set.points);
    let errors = points.filter_map(|point| point.error.as_ref().ok().copied());
    let floors = sets.iter().filter_map(|set| set.floor);
    let [low, mut high] = decades(errors.chain(floors).filter(|error| *error > LEAST));
    let (top, rows) = (high, sets.iter().filter(|set| has_failed(set)).count());
    while f64::from(high - top) < ROW * rows as f64 * f64::from(high - low) {
        high += 1;
    }
    Axis::decades(knob.error(), [low, high])
}

fn has_failed(set: &CostSet) -> bool {
    set.points.iter().any(|point| point.error.is_err())
}

/// The errors of the references, below which nothing is known: one line if all families have the same.
fn floors(sets: &[&CostSet], x: &Axis) -> Vec<Layer> {
    let floors = sets.iter().enumerate();
    let floors = floors.filter_map(|(k, set)| Some((k, set.floor.filter(|floor| *floor > 0.0)?)));
    let floors: Vec<(usize, f64)> = floors.collect();
    let Some(&(_, first)) = floors.first() else {
        return Vec::new();
    };
    let line = |floor: f64, color| {
        let ends = x.range.map(|x| [x, floor.max(LEAST)]);
        Layer::line(ends.to_vec(), color).dashed().at("floor")
    };
    if floors.iter().all(|(_, floor)| *floor == first) {
        let name = format!("the reference's own error, {first:.1e}");
        return vec![line(first, Color::Faint).named(name)];
    }
    let lines = floors
        .iter()
        .map(|(k, floor)| line(*floor, Color::Series(*k)));
    let key = line(f64::NAN, Color::Faint).named("the references' own errors");
    [key].into_iter().chain(lines).collect()
}

/// Crosses in a row of their own above all errors, one row a family that failed.
fn failures(sets: &[&CostSet], x: &Axis, y: &Axis, work: Work) -> Vec<Layer> {
    let failed = sets.iter().enumerate().filter(|(_, set)| has_failed(set));
    let layers = failed.zip(0..).flat_map(|((k, set), row)| {
        let share = 1.0 - ROW * (f64::from(row) + 0.6);
        let height = y.range[0] * (y.range[1] / y.range[0]).powf(share);
        let points = set.points.iter().filter(|point| point.error.is_err());
        let places = points
            .clone()
            .filter_map(|point| Some([work.of(point)?, height]));
        let places: Vec<[f64; 2]> = places.collect();
        let values = points.clone().map(|point| format!("{:e}", point.value));
        let values: Vec<String> = values.collect();
        let words = format!("× {} failed at {}", set.family, values.join(", "));
        // Beside the crosses, on the side where there is more room.
        let ends = places.iter().map(|place| x.share(place[0]));
        let (first, last) = ends.fold((1.0, 0.0), |(a, b), x| (x.min(a), x.max(b)));
        let left = if 1.0 - last > first {
            last + 0.02
        } else {
            0.01
        };
        let left = x.range[0] * (x.range[1] / x.range[0]).powf(f64::min(left, 0.7));
        let hover = points.map(|point| hover(set, point)).collect();
        let crosses = Layer::points(places, 2.6, Color::Series(k)).marked(Marker::Cross);
        [
            crosses.hovered(hover).at(entity("failed", set)),
            Layer {
                color: Color::Series(k),
                ..Layer::text([left, height], words).at(format!("{}/words", entity("failed", set)))
            },
        ]
    });
    layers.collect()
}

/// The entity of a family of settings.
fn entity(folder: &str, set: &CostSet) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
    format!("{folder}/{}", set.family.replace(|c| !plain(c), "_"))
}

/// A setting, its error and what it costs, in one line: what is asked for first comes first, since a
/// narrow tooltip cuts the end off. The family stands above it there.
pub fn hover(set: &CostSet, point: &CostPoint) -> String {
    let error = match &point.error {
        Ok(found) => format!("error {}", error(*found)),
        Err(_) => "failed".to_owned(),
    };
    let mut text = format!(
        "{}: {error}, {} ms of CPU",
        setting(set.turned, point.value),
        short(1e3 * point.seconds)
    );
    if point.calls > 0 {
        text += &format!(", {} calls", point.calls);
    }
    let reason = point.error.as_ref().err().into_iter();
    let detail = Some(&point.detail).filter(|detail| !detail.is_empty());
    for more in reason.chain(detail) {
        text += &format!("; {more}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Look, Shape};

    fn point(value: f64, seconds: f64, error: Result<f64, &str>) -> CostPoint {
        CostPoint {
            value,
            seconds,
            calls: (1e6 * seconds) as u64,
            error: error.map_err(str::to_owned),
            detail: String::new(),
        }
    }

    fn study(points: Vec<CostPoint>) -> CostStudy {
        let sets = vec![CostSet {
            knob: Knob::Integrator,
            family: "lawson54".to_owned(),
            turned: "tolerance",
            floor: Some(1e-9),
            points,
        }];
        CostStudy {
            scene: "test".to_owned(),
            held: Default::default(),
            horizon: 4e-3,
            exponent: None,
            stopped: false,
            advice: crate::study::cost::advice(&sets),
            sets,
        }
    }

    #[test]
    fn every_point_is_drawn_and_failures_are_marked() {
        let study = study(vec![
            point(1e-3, 1e-3, Ok(1e-3)),
            point(1e-3, 2e-3, Ok(1e-7)),
            point(1e-3, 5e-4, Err("it blew up")),
        ]);
        let figures = cost_figures(&study);
        assert_eq!(figures.len(), 1);
        assert_eq!(figures[0].name, "cost-integrator");
        let svg = figures[0].svg(&Look::default());
        assert!(svg.contains("lawson54") && svg.contains("× lawson54 failed at 1e-3"));
        assert!(svg.contains("own error") && svg.contains("10⁻⁹"), "{svg}");
        for panel in &figures[0].rows[0] {
            let points = panel
                .layers
                .iter()
                .find(|layer| layer.id == "points/lawson54");
            let Some(Layer {
                shape: Shape::Points { points, .. },
                ..
            }) = points
            else {
                panic!("no points: {panel:?}");
            };
            assert_eq!(points.len(), 2);
        }
    }

    #[test]
    fn axes_hold_all_points_and_leave_room_for_failures() {
        let study = study(vec![
            point(1e-2, 2e-3, Ok(1e-2)),
            point(1e-4, 4e-3, Ok(0.0)),
            point(1e-6, 10e-3, Err("no")),
        ]);
        let panels = error_panels(&study, Knob::Integrator);
        let [(Work::Time, time), (Work::Calls, calls)] = &panels[..] else {
            panic!("two panels");
        };
        assert_eq!(time.y, calls.y, "so that they can be compared");
        assert_eq!(calls.x.range, [2e3, 1e4]);
        // An error of nothing does not stretch the axis; a decade above is for what failed.
        assert_eq!(time.y.range, [1e-9, 1e-1]);
        let exact = time
            .layers
            .iter()
            .find(|layer| layer.id == "points/lawson54");
        let Some(Layer {
            shape: Shape::Points { points, hover, .. },
            ..
        }) = exact
        else {
            panic!("no points");
        };
        assert_eq!((points[1][1], hover.len()), (1e-9, 2));
    }

    #[test]
    fn a_setting_is_one_line() {
        let study = study(vec![point(1e-4, 4e-3, Ok(2e-5))]);
        let of = |turned, point: &CostPoint| {
            let set = CostSet {
                turned,
                ..study.sets[0].clone()
            };
            hover(&set, point)
        };
        assert_eq!(
            of("tolerance", &study.sets[0].points[0]),
            "tolerance 1e-4: error 2.0e-5, 4 ms of CPU, 4000 calls"
        );
        assert_eq!(
            of("step, s", &point(6.4e-6, 2.5e-3, Err("it blew up"))),
            "step 6.4e-6 s: failed, 2.5 ms of CPU, 2500 calls; it blew up"
        );
    }
}
