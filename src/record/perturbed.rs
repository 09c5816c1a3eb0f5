//! The reference trajectory and a perturbed trajectory that starts close to it, and their distance.

use std::collections::VecDeque;
use std::f64::consts::LN_10;

use super::panel_view::PanelView;
use super::paths::{self, Root};
use super::stream::RecordingStream;
use super::{style, text};
use crate::number::with_error;
use crate::pipeline::message::{DivergenceFit, Frame, Header, TrajectoryDivergence};
use crate::plot::response::{SMALLEST, phase_portrait};
use crate::plot::{Color, FullScale, Layer, RedrawTimer, Unit};

/// Length of the trails, s: about sixteen periods of a 4 kHz squeak.
const TRAIL: f64 = 4e-3;
/// Width of the trails, points on paper.
const TRAIL_WIDTH: f64 = 0.9;
/// Both trajectories: entity and colour.
const TRAJECTORIES: [(&str, Color); 2] =
    [("reference", Color::Run), ("perturbed", Color::Compared)];

/// Draws both trajectories and their distance.
#[derive(Debug)]
pub struct PerturbedTrajectory {
    /// Displacement (m) and velocity (m/s) of both trajectories at the last samples, oldest first.
    trail: VecDeque<[[f64; 2]; 2]>,
    scales: [FullScale; 2],
    portraits: PanelView,
    redraw: RedrawTimer,
    last: Option<TrajectoryDivergence>,
}

impl PerturbedTrajectory {
    /// Names the series and starts empty.
    pub fn new(rec: &RecordingStream) -> Self {
        let name = "perturbed trajectory, µm";
        rec.name(paths::PERTURBED_DISPLACEMENT, [(name, Color::Compared)]);
        rec.name(paths::DIVERGENCE_DISTANCE, [("distance", Color::Run)]);
        Self {
            trail: VecDeque::new(),
            scales: SMALLEST.map(FullScale::new),
            portraits: PanelView::of("both-portraits", &Root::of_run()),
            redraw: RedrawTimer::default(),
            last: None,
        }
    }

    /// Adds a frame; the trails are redrawn once per frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) {
        let perturbed = frame.perturbed.as_ref();
        let Some(perturbed) = perturbed.filter(|perturbed| !perturbed.distance.is_empty()) else {
            return;
        };
        let every = frame.shown.map_or(1, |shown| shown.every);
        let second = perturbed.displacement.iter().zip(&perturbed.velocity);
        let first = frame.len() - perturbed.distance.len();
        for (k, (&u, &v)) in (first..).zip(second) {
            if k % every == 0 {
                rec.row(paths::PERTURBED_DISPLACEMENT, frame.time(k), [1e6 * u]);
            }
            let first = [frame.displacement[k], frame.velocity[k]];
            self.trail.push_back([first, [u, v]]);
        }
        let keep = (TRAIL / frame.dt).round() as usize;
        self.trail.drain(..self.trail.len().saturating_sub(keep));
        if !self.redraw.is_due(frame.end(), frame.shown) {
            return;
        }
        for (c, scale) in self.scales.iter_mut().enumerate() {
            let values = self.trail.iter().flatten().map(|point| point[c].abs());
            scale.update(values.fold(0.0, f64::max), SMALLEST[c]);
        }
        self.draw_portraits(rec, frame.end() - frame.dt);
    }

    fn draw_portraits(&mut self, rec: &RecordingStream, time: f64) {
        let reach = Some(self.scales.map(FullScale::get));
        let both = phase_portrait(&[], reach, Color::Ink).square();
        let mut both = both.with_title("phase portraits, last 4 ms");
        let layers = (0..).zip(TRAJECTORIES).flat_map(|(copy, (name, color))| {
            let points: Vec<[f64; 2]> = self.trail.iter().map(|point| point[copy]).collect();
            let last = Vec::from_iter(points.last().copied());
            let trail = Layer::line(points, color).with_size(TRAIL_WIDTH);
            let now = Layer::points(last, 4.2, color).with_id(format!("{name}_now"));
            [trail.with_id(name).with_label(name), now]
        });
        both.layers = layers.collect();
        self.portraits.draw(rec, time.into(), &both);
    }

    /// Adds a distance of the trajectories.
    pub fn push_distance(
        &mut self,
        rec: &RecordingStream,
        header: &Header,
        separation: &TrajectoryDivergence,
    ) {
        // A gap where the distance is zero.
        let level = separation.distance.log10();
        let level = if level.is_finite() { level } else { f64::NAN };
        rec.row(paths::DIVERGENCE_DISTANCE, separation.time_s, [level]);
        let before = self.last.replace(*separation);
        let was_open = before.is_none_or(|before| before.saturated_s.is_none());
        if was_open && separation.saturated_s.is_some() {
            self.draw_fit(rec);
        }
        let words = text::document(document(header, separation));
        rec.log("divergence/text", separation.time_s, &words);
    }

    /// Draws the fitted line of the logarithmic distance once it is final.
    fn draw_fit(&self, rec: &RecordingStream) {
        let Some((separation, line)) = self.last.and_then(|last| Some((last, last.line?))) else {
            return;
        };
        let name = format!("slope λ = {} per s", rate(line));
        let curve = vec![(name, Color::Compared, 2.4)];
        rec.start(paths::DIVERGENCE_FIT, curve, true);
        for time in [
            line.since_s,
            separation.saturated_s.unwrap_or(separation.time_s),
        ] {
            let level = line.intercept + line.rate_per_s * (time - separation.start_s);
            rec.row(paths::DIVERGENCE_FIT, time, [level / LN_10]);
        }
    }

    /// Draws the fitted line of distances that are not saturated.
    pub fn finish(&self, rec: &RecordingStream) {
        if self.last.is_some_and(|last| last.saturated_s.is_none()) {
            self.draw_fit(rec);
        }
    }
}

/// The rate of the fitted line with its error.
fn rate(line: DivergenceFit) -> String {
    with_error(line.rate_per_s, line.half_width_per_s)
}

/// The divergence of the trajectories as text.
fn document(header: &Header, separation: &TrajectoryDivergence) -> String {
    let age = Unit::write(separation.time_s - separation.start_s, "s");
    let heading = match separation.saturated_s {
        Some(_) => "The trajectories have separated",
        None if separation.line.is_some_and(|line| line.grows()) => {
            "The trajectories are separating"
        }
        None => "The trajectories are close",
    };
    let line = match separation.line {
        Some(line) => {
            let slope = format!("**λ = {} per s**", rate(line));
            format!("Slope of ln(distance): {slope}, an estimate of the largest Lyapunov exponent.")
        }
        None => "No slope yet: too few distances, or all below the integration error.".to_owned(),
    };
    let saturated = match separation.saturated_s {
        Some(time) => {
            let time = Unit::write(time - separation.start_s, "s");
            format!(
                "The distance reached a tenth of the motion after **{time}**; then it saturated."
            )
        }
        None => "The distance is still small compared with the motion.".to_owned(),
    };
    format!(
        "## {heading}\n\nBlue: reference trajectory; orange: perturbed trajectory, started from a slightly \
         perturbed state at {start}. After {age} their distance is **{distance:.1e}** of the motion.\n\n\
         {line}\n\n{saturated}",
        start = style::format_time(header, separation.start_s),
        distance = separation.distance,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::demo;

    #[test]
    fn the_divergence_is_described() {
        let mut separation = TrajectoryDivergence {
            time_s: 0.15,
            start_s: 0.05,
            distance: 2.5e-4,
            line: None,
            saturated_s: None,
        };
        let header = demo::header(0.3);
        let text = document(&header, &separation);
        assert!(text.starts_with("## The trajectories are close"), "{text}");
        assert!(text.contains("slightly perturbed state at 50 ms. After 100 ms"));
        assert!(text.contains("**2.5e-4** of the motion"), "{text}");
        separation.line = Some(DivergenceFit {
            rate_per_s: 71.2,
            half_width_per_s: 4.0,
            since_s: 0.06,
            intercept: -20.0,
        });
        assert!(document(&header, &separation).contains("λ = 71.2 ± 4.0 per s"));
        separation.saturated_s = Some(0.14);
        let text = document(&header, &separation);
        assert!(
            text.starts_with("## The trajectories have separated")
                && text.contains("after **90 ms**")
        );
    }
}
