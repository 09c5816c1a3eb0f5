//! Work-precision diagrams: error over CPU time and over right-hand-side evaluations.

use super::axis::{Axis, decades};
use super::color::Color;
use super::figure::{Figure, Layer, Marker, Panel};
use crate::number::{error, setting, short};
use crate::study::cost::{Advice, CostSetting, CostStudy, WorkPrecisionPoint, WorkPrecisionSet};

/// Smaller errors are drawn at the lower end of the axis.
const SMALLEST_ERROR: f64 = 1e-16;
/// Height of the row of a family with failed runs, as a fraction of the axis.
const FAILED_ROW: f64 = 0.05;

/// The measure of work on the horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkMeasure {
    /// CPU time.
    CpuTime,
    /// Number of right-hand-side evaluations.
    RhsEvals,
}

impl WorkMeasure {
    /// Both measures.
    pub const ALL: [Self; 2] = [Self::CpuTime, Self::RhsEvals];

    /// Work of a point in the unit of the axis; `None` if it was not measured.
    fn of(self, point: &WorkPrecisionPoint) -> Option<f64> {
        let work = match self {
            Self::CpuTime => 1e3 * point.seconds,
            Self::RhsEvals => point.rhs_evals as f64,
        };
        (work > 0.0).then_some(work)
    }

    /// Axis label with unit.
    fn name(self) -> &'static str {
        match self {
            Self::CpuTime => "CPU time, ms",
            Self::RhsEvals => "right-hand-side evaluations",
        }
    }
}

/// One figure for each setting that was varied, named `cost-SETTING`.
pub fn cost_figures(study: &CostStudy) -> Vec<Figure> {
    let settings = CostSetting::ALL.into_iter().filter_map(|setting| {
        let row: Vec<Panel> = error_panels(study, setting)
            .into_iter()
            .map(|(_, panel)| panel)
            .collect();
        let title = match setting {
            CostSetting::Integrator | CostSetting::Events | CostSetting::Nodes => format!(
                "{}: {}, over {:.3} ms",
                study.scene,
                setting.name(),
                1e3 * study.horizon
            ),
            CostSetting::Budget => format!("{}: error budget of all settings", study.scene),
            _ => format!("{}: {}", study.scene, setting.name()),
        };
        let name = format!("cost-{}", setting.name());
        (!row.is_empty()).then(|| Figure::new(name, title, 88.0, vec![row]))
    });
    settings.collect()
}

/// The panels of a setting: error over CPU time, and over right-hand-side evaluations if they were counted.
/// Both have the same error axis.
pub fn error_panels(study: &CostStudy, setting: CostSetting) -> Vec<(WorkMeasure, Panel)> {
    let sets: Vec<&WorkPrecisionSet> = study
        .sets
        .iter()
        .filter(|set| set.setting == setting)
        .collect();
    let points = || sets.iter().flat_map(|set| &set.points);
    let works = WorkMeasure::ALL.into_iter();
    let works = works.filter(|work| points().any(|point| work.of(point).is_some()));
    works
        .map(|work| (work, panel(study, setting, &sets, work)))
        .collect()
}

fn panel(
    study: &CostStudy,
    setting: CostSetting,
    sets: &[&WorkPrecisionSet],
    work: WorkMeasure,
) -> Panel {
    let points = || sets.iter().flat_map(|set| &set.points);
    let trade_off = trade_off(study, setting, work);
    let works = points().filter_map(|point| work.of(point));
    let x = Axis::rounded_logarithmic(
        work.name(),
        works.chain(trade_off.iter().map(|point| point[0])),
    );
    let y = errors(setting, sets);
    let mut layers = floors(sets, &x);
    if !trade_off.is_empty() {
        let model = Layer::line(trade_off, Color::Faint).with_line_width(1.5);
        layers.push(
            model
                .with_id("trade_off")
                .with_label("model: cheapest combinations"),
        );
    }
    let drawn = |set: &&WorkPrecisionSet| -> Vec<([f64; 2], String)> {
        let points = set.points.iter();
        let points = points.filter_map(|point| {
            let error = point.error.as_ref().ok()?.max(y.range[0]);
            Some(([work.of(point)?, error], hover(set, point)))
        });
        points.collect()
    };
    let advised: &[Advice] = match setting {
        CostSetting::Integrator => &study.advice,
        _ => &[],
    };
    let best = sets.iter().flat_map(|set| {
        let best = advised.iter().filter(|advice| advice.method == set.family);
        let best = best.filter_map(|advice| set.points.iter().find(|p| p.value == advice.value));
        best.filter_map(|point| Some([work.of(point)?, *point.error.as_ref().ok()?]))
    });
    let best: Vec<[f64; 2]> = best.collect();
    if !best.is_empty() {
        let best = Layer::points(best, 5.0, Color::Ink).with_marker(Marker::Ring);
        layers.push(
            best.with_id("recommended")
                .with_label("cheapest for its error"),
        );
    }
    layers.extend(sets.iter().enumerate().map(|(k, set)| {
        let places = drawn(set).into_iter().map(|(place, _)| place).collect();
        // Earlier lines are wider, so that they remain visible below later ones.
        let width = 1.0 + 0.25 * 6usize.saturating_sub(k) as f64;
        let line = Layer::line(places, Color::Series(k)).with_line_width(width);
        line.with_label(&set.family).with_id(entity("curves", set))
    }));
    layers.extend(sets.iter().enumerate().map(|(k, set)| {
        let (places, hover) = drawn(set).into_iter().unzip();
        let points = Layer::points(places, 2.4, Color::Series(k));
        points.with_hover(hover).with_id(entity("points", set))
    }));
    layers.extend(failures(sets, &x, &y, work));
    Panel::new("", x, y, layers)
}

/// Cheapest combinations of all settings in the model of the error budget, on the range of the choices.
fn trade_off(study: &CostStudy, setting: CostSetting, work: WorkMeasure) -> Vec<[f64; 2]> {
    let budget = study.budget.as_ref();
    let budget = budget.filter(|_| (setting, work) == (CostSetting::Budget, WorkMeasure::CpuTime));
    let longest = budget.and_then(|budget| {
        let times = budget.choices.iter().map(|choice| choice.seconds);
        times.reduce(f64::max)
    });
    let points = budget.into_iter().flat_map(|budget| &budget.trade_off);
    let points =
        points.take_while(|point| longest.is_some_and(|longest| point[0] <= 2.0 * longest));
    points
        .map(|[seconds, error]| [1e3 * seconds, *error])
        .collect()
}

/// The error axis, with space above for failed runs.
fn errors(setting: CostSetting, sets: &[&WorkPrecisionSet]) -> Axis {
    let points = sets.iter().flat_map(|set| &set.points);
    let errors = points.filter_map(|point| point.error.as_ref().ok().copied());
    let floors = sets.iter().filter_map(|set| set.floor);
    let [low, mut high] = decades(errors.chain(floors).filter(|error| *error > SMALLEST_ERROR));
    let (top, rows) = (high, sets.iter().filter(|set| has_failed(set)).count());
    while f64::from(high - top) < FAILED_ROW * rows as f64 * f64::from(high - low) {
        high += 1;
    }
    Axis::decades(setting.error(), [low, high])
}

fn has_failed(set: &WorkPrecisionSet) -> bool {
    set.points.iter().any(|point| point.error.is_err())
}

/// The errors of the references, below which errors are not resolved: one line if all families have the same.
fn floors(sets: &[&WorkPrecisionSet], x: &Axis) -> Vec<Layer> {
    let floors = sets.iter().enumerate();
    let floors = floors.filter_map(|(k, set)| Some((k, set.floor.filter(|floor| *floor > 0.0)?)));
    let floors: Vec<(usize, f64)> = floors.collect();
    let Some(&(_, first)) = floors.first() else {
        return Vec::new();
    };
    let line = |floor: f64, color| {
        let ends = x.range.map(|x| [x, floor.max(SMALLEST_ERROR)]);
        Layer::line(ends.to_vec(), color)
            .dashed()
            .with_id("reference_error")
    };
    if floors.iter().all(|(_, floor)| *floor == first) {
        let name = format!("error of the reference, {first:.1e}");
        return vec![line(first, Color::Faint).with_label(name)];
    }
    let lines = floors
        .iter()
        .map(|(k, floor)| line(*floor, Color::Series(*k)));
    let key = line(f64::NAN, Color::Faint).with_label("errors of the references");
    [key].into_iter().chain(lines).collect()
}

/// Crosses above all errors, one row per family with failed runs.
fn failures(sets: &[&WorkPrecisionSet], x: &Axis, y: &Axis, work: WorkMeasure) -> Vec<Layer> {
    let failed = sets.iter().enumerate().filter(|(_, set)| has_failed(set));
    let layers = failed.zip(0..).flat_map(|((k, set), row)| {
        let share = 1.0 - FAILED_ROW * (f64::from(row) + 0.6);
        let height = y.range[0] * (y.range[1] / y.range[0]).powf(share);
        let points = set.points.iter().filter(|point| point.error.is_err());
        let places = points
            .clone()
            .filter_map(|point| Some([work.of(point)?, height]));
        let places: Vec<[f64; 2]> = places.collect();
        let values = points.clone().map(|point| format!("{:e}", point.value));
        let values: Vec<String> = values.collect();
        let words = format!("× {} failed at {}", set.family, values.join(", "));
        // The label is placed on the side of the crosses with more space.
        let ends = places.iter().map(|place| x.fraction(place[0]));
        let (first, last) = ends.fold((1.0, 0.0), |(a, b), x| (x.min(a), x.max(b)));
        let left = if 1.0 - last > first {
            last + 0.02
        } else {
            0.01
        };
        let left = x.range[0] * (x.range[1] / x.range[0]).powf(f64::min(left, 0.7));
        let hover = points.map(|point| hover(set, point)).collect();
        let crosses = Layer::points(places, 2.6, Color::Series(k)).with_marker(Marker::Cross);
        [
            crosses.with_hover(hover).with_id(entity("failed", set)),
            Layer {
                color: Color::Series(k),
                ..Layer::text([left, height], words)
                    .with_id(format!("{}/label", entity("failed", set)))
            },
        ]
    });
    layers.collect()
}

/// Entity of a family of settings.
fn entity(folder: &str, set: &WorkPrecisionSet) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
    format!("{folder}/{}", set.family.replace(|c| !plain(c), "_"))
}

/// The value, its error and its cost in one line. The value comes first, because a narrow tooltip cuts off
/// the end. The tooltip shows the family above it.
pub fn hover(set: &WorkPrecisionSet, point: &WorkPrecisionPoint) -> String {
    let error = match &point.error {
        Ok(found) => format!("error {}", error(*found)),
        Err(_) => "failed".to_owned(),
    };
    let mut text = format!(
        "{}: {error}, {} ms CPU time",
        setting(&set.parameter, point.value),
        short(1e3 * point.seconds)
    );
    if point.rhs_evals > 0 {
        text += &format!(", {} RHS evals", point.rhs_evals);
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
    use crate::plot::{FigureOptions, Shape};
    use crate::scene::AccuracyBudget;
    use crate::study::cost::{BudgetChoice, ErrorBudget};

    fn point(value: f64, seconds: f64, error: Result<f64, &str>) -> WorkPrecisionPoint {
        WorkPrecisionPoint {
            value,
            seconds,
            rhs_evals: (1e6 * seconds) as u64,
            error: error.map_err(str::to_owned),
            detail: String::new(),
        }
    }

    fn study(points: Vec<WorkPrecisionPoint>) -> CostStudy {
        let sets = vec![WorkPrecisionSet {
            setting: CostSetting::Integrator,
            family: "lawson54".to_owned(),
            parameter: "tolerance".into(),
            floor: Some(1e-9),
            points,
        }];
        CostStudy {
            scene: "test".to_owned(),
            fixed_at: Default::default(),
            horizon: 4e-3,
            exponent: None,
            stopped: false,
            budget: None,
            advice: crate::study::cost::advice(&sets),
            sets,
        }
    }

    #[test]
    fn every_point_is_drawn_and_failures_are_marked() {
        let study = study(vec![
            point(1e-3, 1e-3, Ok(1e-3)),
            point(1e-3, 2e-3, Ok(1e-7)),
            point(1e-3, 5e-4, Err("the solution diverged")),
        ]);
        let figures = cost_figures(&study);
        assert_eq!(figures.len(), 1);
        assert_eq!(figures[0].name, "cost-integrator");
        let svg = figures[0].svg(&FigureOptions::default());
        assert!(svg.contains("lawson54") && svg.contains("× lawson54 failed at 1e-3"));
        assert!(
            svg.contains("error of the reference") && svg.contains("10⁻⁹"),
            "{svg}"
        );
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
    fn the_budget_is_drawn_over_the_cheapest_combinations_of_the_model() {
        let mut study = study(vec![
            point(1e-2, 1e-3, Ok(5e-3)),
            point(1e-3, 3e-3, Ok(4e-4)),
        ]);
        study.sets[0].setting = CostSetting::Budget;
        study.budget = Some(ErrorBudget {
            choices: vec![BudgetChoice {
                budget: AccuracyBudget {
                    target: 1e-3,
                    settings: Vec::new(),
                    averaging_time: 0.1,
                    errors: Default::default(),
                    fingerprint: String::new(),
                },
                verified: true,
                tries: 1,
                predicted: Vec::new(),
                shares: Vec::new(),
                next: None,
                seconds: 3e-3,
                rhs_evals: 3000,
            }],
            trade_off: vec![[1e-3, 6e-3], [3e-3, 5e-4], [1.0, 1e-5]],
            ..ErrorBudget::default()
        });
        let figures = cost_figures(&study);
        assert_eq!(figures[0].name, "cost-budget");
        let panels = error_panels(&study, CostSetting::Budget);
        let model = panels[0]
            .1
            .layers
            .iter()
            .find(|layer| layer.id == "trade_off");
        let Some(Layer {
            shape: Shape::Lines { strips, .. },
            ..
        }) = model
        else {
            panic!("no trade-off: {model:?}");
        };
        // Combinations that cost much more than every choice are not drawn.
        assert_eq!(strips[0], [[1.0, 6e-3], [3.0, 5e-4]]);
        assert!(
            panels[1]
                .1
                .layers
                .iter()
                .all(|layer| layer.id != "trade_off")
        );
    }

    #[test]
    fn axes_contain_all_points_and_a_row_for_failures() {
        let study = study(vec![
            point(1e-2, 2e-3, Ok(1e-2)),
            point(1e-4, 4e-3, Ok(0.0)),
            point(1e-6, 10e-3, Err("no")),
        ]);
        let panels = error_panels(&study, CostSetting::Integrator);
        let [
            (WorkMeasure::CpuTime, time),
            (WorkMeasure::RhsEvals, rhs_evals),
        ] = &panels[..]
        else {
            panic!("two panels");
        };
        assert_eq!(time.y, rhs_evals.y, "both panels have the same error axis");
        assert_eq!(rhs_evals.x.range, [2e3, 1e4]);
        // A zero error does not extend the axis; the decade above is for failed runs.
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
    fn the_tooltip_is_one_line() {
        let study = study(vec![point(1e-4, 4e-3, Ok(2e-5))]);
        let of = |parameter: &'static str, point: &WorkPrecisionPoint| {
            let set = WorkPrecisionSet {
                parameter: parameter.into(),
                ..study.sets[0].clone()
            };
            hover(&set, point)
        };
        assert_eq!(
            of("tolerance", &study.sets[0].points[0]),
            "tolerance 1e-4: error 2.0e-5, 4 ms CPU time, 4000 RHS evals"
        );
        assert_eq!(
            of(
                "step, s",
                &point(6.4e-6, 2.5e-3, Err("the solution diverged"))
            ),
            "step 6.4e-6 s: failed, 2.5 ms CPU time, 2500 RHS evals; the solution diverged"
        );
    }
}
