//! The butterfly: two copies that start almost alike, one upon the other, and their distance.

use std::collections::VecDeque;

use rerun::{Color, LineStrips2D, Points2D, Radius, SeriesLines};

use super::{
    due::Due,
    error::RecordError,
    paths,
    plot::{Axes, Bounds},
    portrait::Field,
    samples::{Rows, name_series},
    stream::{self, RecordingStream},
    style::{self, FullScale, Quantity, short},
    text,
};
use crate::pipeline::message::{Frame, Header, Parting, PartingLine};

/// Length of the trails, s: about sixteen periods of a 4 kHz squeak.
const TRAIL: f64 = 4e-3;
/// Smallest full scales: displacement in m and velocity in m/s.
const SMALLEST: [f64; 2] = [1e-12, 1e-8];
/// Colours of the two copies.
const COLORS: [Color; 2] = [style::SIGNAL, style::ACCENT];
/// Their trails, and where they are now.
const COPIES: [[&str; 2]; 2] = [
    [paths::BUTTERFLY_FIRST, paths::BUTTERFLY_FIRST_NOW],
    [paths::BUTTERFLY_SECOND, paths::BUTTERFLY_SECOND_NOW],
];

/// Draws two copies and how they part.
#[derive(Debug)]
pub struct Butterfly {
    displacement: Rows,
    distance: Rows,
    /// Displacement (m) and velocity (m/s) of both copies at the last samples, oldest first.
    trail: VecDeque<[[f64; 2]; 2]>,
    scales: [FullScale; 2],
    axes: Axes,
    due: Due,
    last: Option<Parting>,
}

impl Butterfly {
    /// Names the series and starts empty.
    pub fn new(rec: &RecordingStream) -> Result<Self, RecordError> {
        let one = |path, name: &str, color| name_series(rec, path, [name.to_owned()], [color]);
        one(paths::BUTTERFLY_DISPLACEMENT, "second copy, µm", COLORS[1])?;
        one(paths::BUTTERFLY_DISTANCE, "distance", style::SIGNAL)?;
        Ok(Self {
            displacement: Rows::new(paths::BUTTERFLY_DISPLACEMENT, 1),
            distance: Rows::new(paths::BUTTERFLY_DISTANCE, 1),
            trail: VecDeque::new(),
            scales: SMALLEST.map(FullScale::new),
            axes: Axes::default(),
            due: Due::default(),
            last: None,
        })
    }

    /// What the view of the portraits must show.
    pub fn bounds() -> Bounds {
        Field::new([1.0, 1.0]).plot.bounds()
    }

    /// Takes a frame: the trails are drawn anew once a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        let Some(twin) = frame.twin.as_ref().filter(|twin| !twin.distance.is_empty()) else {
            return Ok(());
        };
        let every = frame.shown.map_or(1, |shown| shown.every);
        let second = twin.displacement.iter().zip(&twin.velocity);
        for (k, (&u, &v)) in (twin.first..).zip(second) {
            if k % every == 0 {
                self.displacement.push(frame.time(k), [1e6 * u]);
            }
            let first = [frame.displacement[k], frame.velocity[k]];
            self.trail.push_back([first, [u, v]]);
        }
        self.displacement.send_full(rec)?;
        let keep = (TRAIL / frame.dt).round() as usize;
        self.trail.drain(..self.trail.len().saturating_sub(keep));
        self.due.follow(frame);
        if !self.due.is_due(frame.end()) {
            return Ok(());
        }
        for (c, scale) in self.scales.iter_mut().enumerate() {
            let values = self.trail.iter().flatten().map(|point| point[c].abs());
            scale.update(values.fold(0.0, f64::max), SMALLEST[c]);
        }
        self.draw_portraits(rec, frame.end() - frame.dt)
    }

    fn draw_portraits(&mut self, rec: &RecordingStream, time: f64) -> Result<(), RecordError> {
        let Field {
            plot,
            units: [length, speed],
        } = Field::new(self.scales.map(FullScale::get));
        self.axes
            .draw(rec, paths::BUTTERFLY_PORTRAIT, time, &plot)?;
        for (copy, [path, now]) in COPIES.into_iter().enumerate() {
            let points = self.trail.iter().map(|point| {
                let [u, v] = point[copy];
                plot.at(length.per_si * u, speed.per_si * v)
            });
            let points: Vec<[f32; 2]> = points.collect();
            let last = points.last().copied();
            let trail = LineStrips2D::new([points])
                .with_colors([style::faded(COLORS[copy], 0.8)])
                .with_radii([Radius::new_ui_points(0.7)]);
            stream::log_at(rec, path, time, &trail)?;
            let point = Points2D::new(last)
                .with_colors([COLORS[copy]])
                .with_radii([Radius::new_ui_points(5.0)])
                .with_draw_order(1.0);
            stream::log_at(rec, now, time, &point)?;
        }
        Ok(())
    }

    /// Takes how far the two have parted.
    pub fn part(
        &mut self,
        rec: &RecordingStream,
        header: &Header,
        parting: &Parting,
    ) -> Result<(), RecordError> {
        // A gap where they are not apart at all.
        let level = parting.distance.log10();
        let level = if level.is_finite() { level } else { f64::NAN };
        self.distance.push(parting.time, [level]);
        self.distance.send(rec)?;
        let before = self.last.replace(*parting);
        if before.is_none_or(|before| before.saturated.is_none()) && parting.saturated.is_some() {
            self.draw_line(rec)?;
        }
        let words = text::document(document(header, parting));
        stream::log_at(rec, paths::BUTTERFLY_WORDS, parting.time, &words)
    }

    /// Draws the straight line through the logarithm of the distance, once it is known for good.
    fn draw_line(&self, rec: &RecordingStream) -> Result<(), RecordError> {
        let Some((parting, line)) = self.last.and_then(|last| Some((last, last.line?))) else {
            return Ok(());
        };
        let name = format!("slope λ = {} per s", rate(line));
        name_series(rec, paths::BUTTERFLY_LINE, [name], [style::ACCENT])?;
        let width = SeriesLines::update_fields().with_widths([2.4]);
        rec.log_static(paths::BUTTERFLY_LINE, &width)?;
        let mut rows = Rows::new(paths::BUTTERFLY_LINE, 1);
        for time in [line.since, parting.saturated.unwrap_or(parting.time)] {
            let level = line.intercept + line.rate * (time - parting.start);
            rows.push(time, [level / std::f64::consts::LN_10]);
        }
        rows.send(rec)
    }

    /// Sends what is left.
    pub fn finish(&mut self, rec: &RecordingStream) -> Result<(), RecordError> {
        self.displacement.send(rec)?;
        match self.last {
            Some(last) if last.saturated.is_none() => self.draw_line(rec),
            _ => Ok(()),
        }
    }
}

/// The rate of a line with its error.
fn rate(line: PartingLine) -> String {
    format!("{} ± {}", short(line.rate), short(line.half_width))
}

/// How far they have parted, in words.
fn document(header: &Header, parting: &Parting) -> String {
    let age = Quantity::Time.words(parting.time - parting.start);
    let heading = match parting.saturated {
        Some(_) => "Parted for good",
        None if parting.line.is_some_and(|line| line.grows()) => "Parting",
        None => "Still together",
    };
    let line = match parting.line {
        Some(line) => format!(
            "Slope of ln(distance): **λ = {} per s**, an estimate of the largest exponent.",
            rate(line)
        ),
        None => {
            "No slope yet: too few distances, or none above the errors of the steps.".to_owned()
        }
    };
    let saturated = match parting.saturated {
        Some(time) => format!(
            "It took **{}** to become a tenth of the motion; since then it can hardly grow.",
            Quantity::Time.words(time - parting.start)
        ),
        None => "It is still small against the motion, and free to grow.".to_owned(),
    };
    format!(
        "## {heading}\n\nThe first copy is blue; the second, orange, started almost in its state at \
         {start}. After {age} their distance is **{distance:.1e}** of the motion.\n\n{line}\n\n\
         {saturated}",
        start = style::moment(header, parting.start),
        distance = parting.distance,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::demo;

    #[test]
    fn parting_reads_well() {
        let mut parting = Parting {
            time: 0.15,
            start: 0.05,
            distance: 2.5e-4,
            line: None,
            saturated: None,
        };
        let header = demo::header(0.3);
        let text = document(&header, &parting);
        assert!(text.starts_with("## Still together"), "{text}");
        assert!(text.contains("started almost in its state at 50 ms. After 100 ms"));
        assert!(text.contains("**2.5e-4** of the motion"), "{text}");
        parting.line = Some(PartingLine {
            rate: 71.2,
            half_width: 4.0,
            since: 0.06,
            intercept: -20.0,
        });
        assert!(document(&header, &parting).contains("λ = 71.2 ± 4 per s"));
        parting.saturated = Some(0.14);
        let text = document(&header, &parting);
        assert!(text.starts_with("## Parted for good") && text.contains("took **90 ms**"));
    }
}
