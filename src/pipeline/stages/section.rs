//! Points of a Poincare section.

use super::embedding::{Embedding, StageEmbedding};
use super::stage::Stage;
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
pub fn section(spec: &SectionSpec, delay: Option<&DelaySpec>, rate: f64) -> Stage {
    let hop = spec.every * rate;
    let direction = spec.direction;
    let unfolding = |lag| {
        let dimension = Some(DIMENSION);
        StageEmbedding::new(&EmbeddingSpec { lag, dimension }, delay, rate)
    };
    match spec.surface.clone() {
        SectionSurface::Delay { lag, level } => {
            let finder = move |lag| SectionFinder::delay(lag, DIMENSION, level, direction);
            let displacement = |frame: &Frame| [frame.displacement.clone()];
            passages(hop, displacement, unfolding(lag), finder, [0, 2])
        }
        SectionSurface::State {
            normal_q,
            normal_qdot,
            offset,
            shown,
        } => {
            let coordinates =
                move |frame: &Frame| plane_coordinates(frame, [&normal_q, &normal_qdot], shown);
            // A plane has no delay; one that is given is known from the start.
            let finder = move |_| SectionFinder::first_of(3, offset, direction);
            passages(hop, coordinates, unfolding(Some(0.0)), finder, [1, 2])
        }
    }
}

/// For each sample: the scalar product of the normal (of `q` and of `dq/dt`) with the state, and the two
/// displayed coordinates. Empty for a frame without modes.
fn plane_coordinates(
    frame: &Frame,
    [normal_q, normal_qdot]: [&[f64]; 2],
    shown: [StateCoordinate; 2],
) -> [Vec<f64>; 3] {
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
    channels
}

/// The section points of a stream of `C` channels, emitted every `hop` samples, with the coordinates `shown`. `unfolding` gives
/// the delay, and `finder` a finder for a delay (samples).
fn passages<const C: usize>(
    hop: f64,
    channels: impl Fn(&Frame) -> [Vec<f64>; C] + Send + 'static,
    unfolding: StageEmbedding,
    finder: impl Fn(usize) -> SectionFinder + Send + 'static,
    shown: [usize; 2],
) -> Stage {
    // Long enough for the new samples at each instant.
    let length = hop.max(1.0).ceil() as usize;
    let mut sliding = SlidingWindow::new(length, hop).with_min_length(1);
    // Number of samples already searched.
    let mut taken = 0;
    // The finder with its delay, and the sample at which it started.
    let mut running: Option<(SectionFinder, usize, u64)> = None;
    Box::new(move |frame, context| {
        let channels = channels(frame);
        sliding.push(channels.each_ref().map(|x| &x[..]), |view| {
            let first = std::mem::replace(&mut taken, view.seen);
            let Some(Embedding { lag, .. }) = unfolding.at(view.seen, &context.choices) else {
                return Ok(());
            };
            let current = match running.take() {
                Some(current) if current.1 == lag => current,
                _ => (finder(lag), lag, first),
            };
            let (finder, _, origin) = running.insert(current);
            let fresh = (view.seen - first) as usize;
            let pieces = view.channels.map(|x| &x[x.len() - fresh..]);
            let mut points = Vec::new();
            finder.push(&pieces, |crossing| {
                points.push(SectionPoint {
                    time_s: context.clock.time(*origin as f64 + crossing.sample),
                    at: shown.map(|k| crossing.point[k]),
                });
            });
            let time = context.clock.time(view.seen as f64 - 1.0);
            let section = (!points.is_empty()).then_some(Record::Section { time, points });
            context.records.extend(section);
            Ok(())
        })
    })
}
