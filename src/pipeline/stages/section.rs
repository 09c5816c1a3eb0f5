//! Points of a Poincare section.

use std::borrow::Cow;

use super::choices::StageEmbedding;
use super::stage::Stage;
use super::windowed::{Channels, Windowed, displacement, input};
use crate::analysis::{poincare::SectionFinder, sliding::SlidingWindow};
use crate::pipeline::message::{Frame, Record, SectionPoint};
use crate::scene::{DelaySpec, EmbeddingSpec, SectionSpec, SectionSurface, StateCoordinate};

/// Dimension of the delay trajectory of Fig. 10.
const DIMENSION: usize = 3;

/// Emits [`Record::Section`] at regular intervals if there are new points, for samples at `rate` (Hz);
/// `delay` is the delay analysis of the scene.
///
/// A crossing is known a few samples after it, see [`SectionFinder`]. If the delay is chosen automatically, a
/// new choice starts a new section; crossings at the transition are lost.
pub fn section(spec: &SectionSpec, delay: Option<&DelaySpec>, rate: f64) -> Box<dyn Stage> {
    let hop = spec.every * rate;
    let direction = spec.direction;
    match spec.surface.clone() {
        SectionSurface::Delay { lag, level } => {
            let embedding = EmbeddingSpec {
                lag,
                dimension: Some(DIMENSION),
            };
            let unfolding = StageEmbedding::new(&embedding, delay, rate);
            let finder = move |lag| SectionFinder::delay(lag, DIMENSION, level, direction);
            Box::new(passages(hop, displacement, Some(unfolding), finder, [0, 2]))
        }
        SectionSurface::State {
            normal_q,
            normal_qdot,
            offset,
            shown,
        } => {
            let coordinates =
                input(move |frame| plane_coordinates(frame, [&normal_q, &normal_qdot], shown));
            let finder = move |_| SectionFinder::first_of(3, offset, direction);
            Box::new(passages(hop, coordinates, None, finder, [1, 2]))
        }
    }
}

/// For each sample: the scalar product of the normal (of `q` and of `dq/dt`) with the state, and the two
/// displayed coordinates. Empty for a frame without modes.
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

/// The section points of a stream of `C` channels, emitted every `hop` samples, with the coordinates `shown`. `unfolding` gives
/// the delay, which is 0 without it, and `finder` a finder for a delay (samples).
fn passages<const C: usize>(
    hop: f64,
    input: impl for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
    unfolding: Option<StageEmbedding>,
    finder: impl Fn(usize) -> SectionFinder + Send,
    shown: [usize; 2],
) -> impl Stage {
    // Long enough for the new samples at each instant.
    let length = hop.max(1.0).ceil() as usize;
    let sliding = SlidingWindow::new(length, hop).with_min_length(1);
    // Number of samples already searched.
    let mut taken = 0;
    // The finder with its delay, and the sample at which it started.
    let mut running: Option<(SectionFinder, usize, u64)> = None;
    let passages = Windowed::new(sliding, input, move |window, context| {
        let first = std::mem::replace(&mut taken, window.seen);
        let lag = match unfolding {
            Some(unfolding) => unfolding.at(window.seen, &context.choices).map(|at| at.lag),
            None => Some(0),
        };
        let Some(lag) = lag else {
            return Ok(None);
        };
        let current = match running.take() {
            Some(current) if current.1 == lag => current,
            _ => (finder(lag), lag, first),
        };
        let (finder, _, origin) = running.insert(current);
        let fresh = (window.seen - first) as usize;
        let pieces = window.channels.map(|x| &x[x.len() - fresh..]);
        let mut points = Vec::new();
        finder.push(&pieces, |crossing| {
            points.push(SectionPoint {
                time_s: context.clock.time(*origin as f64 + crossing.sample),
                at: shown.map(|k| crossing.point[k]),
            });
        });
        let time = window.time;
        Ok((!points.is_empty()).then_some(Record::Section { time, points }))
    });
    passages.complete()
}
