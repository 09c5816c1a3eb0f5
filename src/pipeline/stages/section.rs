//! Passages through a Poincare section.

use std::borrow::Cow;

use super::choices::{Choices, Unfolding};
use super::stage::Stage;
use super::windowed::{Channels, Windowed, displacement, input};
use crate::analysis::{AnalysisError, SectionFinder, SlidingWindow};
use crate::pipeline::message::{Frame, Record, SectionPoint};
use crate::scene::{
    DelaySpec, EmbeddingSpec, SectionSpec, SectionSurface, Setting, StateCoordinate,
};

/// Coordinates of the delay trajectory of Fig. 10.
const DIMENSION: usize = 3;

/// Emits [`Record::Section`] at its instants, if passages have become known since the last one, of
/// samples at `rate` (Hz); `delay` is the scene's choice of delays.
///
/// A passage is known some samples after it, see [`SectionFinder`]. Where the delay is chosen
/// automatically another choice starts another section; passages at the border are left out.
pub fn section(spec: &SectionSpec, delay: Option<&DelaySpec>, rate: f64) -> Box<dyn Stage> {
    let hop = spec.every * rate;
    let direction = spec.direction;
    match spec.surface.clone() {
        SectionSurface::Delay { lag, level } => {
            let embedding = EmbeddingSpec {
                lag,
                dimension: Setting::Given(DIMENSION),
            };
            let unfolding = Unfolding::new(&embedding, delay, rate);
            let find = Find {
                lag_at: move |seen, choices: &Choices| Some(unfolding.at(seen, choices)?.lag),
                finder: move |lag| SectionFinder::delay(lag, DIMENSION, level, direction),
                shown: [0, 2],
            };
            Box::new(passages(hop, displacement, find))
        }
        SectionSurface::State {
            normal_q,
            normal_qdot,
            offset,
            shown,
        } => {
            let coordinates =
                input(move |frame| plane_coordinates(frame, [&normal_q, &normal_qdot], shown));
            let find = Find {
                lag_at: |_, _: &Choices| Some(0),
                finder: move |_| SectionFinder::plane(&[1.0, 0.0, 0.0], offset, direction),
                shown: [1, 2],
            };
            Box::new(passages(hop, coordinates, find))
        }
    }
}

/// For each sample: normal (of `q` and of `dq/dt`) times state, and the two coordinates that are shown.
/// Nothing of a frame without modes.
fn plane_coordinates(
    frame: &Frame,
    [normal_q, normal_qdot]: [&[f64]; 2],
    shown: [StateCoordinate; 2],
) -> Channels<'static, 3> {
    let dot = |normal: &[f64], x: &[f64]| normal.iter().zip(x).map(|(n, x)| n * x).sum::<f64>();
    let mut channels = [const { Vec::new() }; 3];
    let modes = frame.modes.max(1);
    let states = frame.q.chunks_exact(modes);
    for (q, qdot) in states.zip(frame.qdot.chunks_exact(modes)) {
        let [first, second] = shown.map(|coordinate| match coordinate {
            StateCoordinate::Q(k) => q[k],
            StateCoordinate::Qdot(k) => qdot[k],
        });
        let height = dot(normal_q, q) + dot(normal_qdot, qdot);
        for (channel, x) in channels.iter_mut().zip([height, first, second]) {
            channel.push(x);
        }
    }
    channels.map(Cow::Owned)
}

/// How passages are found, and which two coordinates of each are shown.
struct Find<L, F> {
    /// The delay (samples) that holds when so many samples have been seen; 0 if there is none.
    lag_at: L,
    /// A finder for that delay.
    finder: F,
    shown: [usize; 2],
}

/// A finder, the delay it was made for, and the sample it began with.
struct Running {
    finder: SectionFinder,
    lag: usize,
    origin: u64,
}

/// The passages of a stream of `C` channels, sent every `hop` samples.
fn passages<const C: usize, I, L, F>(hop: f64, input: I, find: Find<L, F>) -> impl Stage
where
    I: for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
    L: Fn(u64, &Choices) -> Option<usize> + Send,
    F: Fn(usize) -> Result<SectionFinder, AnalysisError> + Send,
{
    // Long enough for what is new at each instant.
    let length = hop.max(1.0).ceil() as usize;
    let sliding = SlidingWindow::new(length, hop).starting_with(1);
    // Samples that have been searched.
    let mut taken = 0;
    let mut running: Option<Running> = None;
    let passages = Windowed::new(sliding, input, move |window, context, emit| {
        let first = std::mem::replace(&mut taken, window.seen);
        let Some(lag) = (find.lag_at)(window.seen, &context.choices) else {
            return Ok(());
        };
        let current = match running.take() {
            Some(current) if current.lag == lag => current,
            _ => Running {
                finder: (find.finder)(lag)?,
                lag,
                origin: first,
            },
        };
        let Running { finder, origin, .. } = running.insert(current);
        let fresh = (window.seen - first) as usize;
        let pieces = window.channels.map(|x| &x[x.len() - fresh..]);
        let mut points = Vec::new();
        finder.push(&pieces, |crossing| {
            points.push(SectionPoint {
                time: context.clock.time(*origin as f64 + crossing.sample),
                at: find.shown.map(|k| crossing.point[k]),
            });
        })?;
        if points.is_empty() {
            return Ok(());
        }
        let time = window.time;
        emit(Record::Section { time, points })
    });
    passages.complete()
}
