//! Work-precision picture: error against CPU time, a panel for each setting.

use super::{Axis, Color, Figure, Layer, Panel};
use crate::study::cost::{Cost, Setting, WorkPrecision, WorkPrecisionPoint};

/// Smaller errors are drawn at the lower end of the axis.
const SMALLEST_ERROR: f64 = 1e-12;

/// The error of each setting against time.
pub fn cost_figure(scene: &str, study: &Cost) -> Figure {
    let panels = Setting::ALL.into_iter().filter_map(|setting| {
        let sets = study.settings.iter().filter(|set| set.setting == setting);
        let sets: Vec<&WorkPrecision> = sets.collect();
        (!sets.is_empty()).then(|| panel(setting, &sets, study.scatter))
    });
    let title = format!("{scene}: error of the settled motion against time");
    Figure::new("cost", &title, 88.0, vec![panels.collect()])
}

fn panel(setting: Setting, sets: &[&WorkPrecision], scatter: Option<f64>) -> Panel {
    let points = || sets.iter().flat_map(|set| &set.points);
    let found = |point: &WorkPrecisionPoint| Some([point.cpu_s, point.error?.max(SMALLEST_ERROR)]);
    let times = points().filter(|point| point.error.is_some());
    let x = Axis::rounded_logarithmic(setting.time(), times.map(|point| point.cpu_s));
    let errors = points().filter_map(found).map(|place| place[1]);
    let y = Axis::rounded_logarithmic("relative error", errors.chain(scatter));
    let mut layers = Vec::new();
    if let Some(scatter) = scatter {
        let ends = x.range.map(|x| [x, scatter]);
        let line = Layer::line(ends.to_vec(), Color::Faint).dashed();
        layers.push(line.with_label("scatter of the motion"));
    }
    for (k, set) in sets.iter().enumerate() {
        let places: Vec<_> = set.points.iter().filter_map(found).collect();
        layers.push(Layer::line(places.clone(), Color::Series(k)).with_label(set.method));
        layers.push(Layer::points(places, 2.4, Color::Series(k)));
    }
    Panel::new(setting.name(), x, y, layers)
}
