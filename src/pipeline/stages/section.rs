//! Passages through a Poincare section.

use super::choices::{Choices, Unfolding};
use super::{Context, Emit, Stage};
use crate::analysis::{AnalysisError, Direction, SectionFinder, SlidingWindow};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record, SectionPoint};
use crate::scene::{
    DelaySpec, EmbeddingSpec, SectionSpec, SectionSurface, Setting, StateCoordinate,
};

/// Coordinates of the delay trajectory of Fig. 10.
const DIMENSION: usize = 3;

/// Emits [`Record::Section`] at its instants, if passages have become known since the last one.
///
/// A passage is known some samples after it, see [`SectionFinder`]. Where the delay is chosen
/// automatically another choice starts another section; passages at the border are left out.
pub struct SectionStage {
    surface: Surface,
    direction: Direction,
}

enum Surface {
    Delay {
        passages: Passages<1>,
        unfolding: Unfolding,
        level: f64,
    },
    State {
        passages: Passages<3>,
        plane: Plane,
    },
}

impl SectionStage {
    /// For samples at `rate` (Hz); `delay` is the scene's choice of delays.
    pub fn new(spec: &SectionSpec, delay: Option<&DelaySpec>, rate: f64) -> Self {
        let hop = spec.every * rate;
        let surface = match &spec.surface {
            SectionSurface::Delay { lag, level } => {
                let embedding = EmbeddingSpec {
                    lag: *lag,
                    dimension: Setting::Given(DIMENSION),
                };
                Surface::Delay {
                    passages: Passages::new(hop),
                    unfolding: Unfolding::new(&embedding, delay, rate),
                    level: *level,
                }
            }
            SectionSurface::State {
                normal_q,
                normal_qdot,
                offset,
                shown,
            } => Surface::State {
                passages: Passages::new(hop),
                plane: Plane {
                    normal_q: normal_q.clone(),
                    normal_qdot: normal_qdot.clone(),
                    offset: *offset,
                    shown: *shown,
                },
            },
        };
        Self {
            surface,
            direction: spec.direction,
        }
    }
}

impl Stage for SectionStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let direction = self.direction;
        match &mut self.surface {
            Surface::Delay {
                passages,
                unfolding,
                level,
            } => {
                let find = Find {
                    lag_at: |seen, choices: &Choices| Some(unfolding.at(seen, choices)?.lag),
                    finder: |lag| SectionFinder::delay(lag, DIMENSION, *level, direction),
                    shown: [0, 2],
                };
                passages.push([&frame.displacement], find, context, emit)
            }
            Surface::State { passages, plane } => {
                if frame.modes == 0 {
                    return Ok(());
                }
                let [height, across, up] = plane.channels(frame);
                let find = Find {
                    lag_at: |_, _: &Choices| Some(0),
                    finder: |_| SectionFinder::plane(&[1.0, 0.0, 0.0], plane.offset, direction),
                    shown: [1, 2],
                };
                passages.push([&height, &across, &up], find, context, emit)
            }
        }
    }
}

/// A plane of the modal state.
struct Plane {
    normal_q: Vec<f64>,
    normal_qdot: Vec<f64>,
    offset: f64,
    shown: [StateCoordinate; 2],
}

impl Plane {
    /// For each sample: normal times state, and the two coordinates that are shown.
    fn channels(&self, frame: &Frame) -> [Vec<f64>; 3] {
        let dot = |normal: &[f64], x: &[f64]| normal.iter().zip(x).map(|(n, x)| n * x).sum::<f64>();
        let mut channels = [const { Vec::new() }; 3];
        let states = frame.q.chunks_exact(frame.modes);
        for (q, qdot) in states.zip(frame.qdot.chunks_exact(frame.modes)) {
            let [first, second] = self.shown.map(|coordinate| match coordinate {
                StateCoordinate::Q(k) => q[k],
                StateCoordinate::Qdot(k) => qdot[k],
            });
            let height = dot(&self.normal_q, q) + dot(&self.normal_qdot, qdot);
            for (channel, x) in channels.iter_mut().zip([height, first, second]) {
                channel.push(x);
            }
        }
        channels
    }
}

/// How passages are found, and which two coordinates of each are shown.
struct Find<L, F> {
    /// The delay (samples) that holds when so many samples have been seen; 0 if there is none.
    lag_at: L,
    /// A finder for that delay.
    finder: F,
    shown: [usize; 2],
}

/// The passages of a stream of `C` channels, told at fixed instants.
struct Passages<const C: usize> {
    sliding: SlidingWindow<C>,
    /// Samples that have been looked at.
    taken: u64,
    running: Option<Running>,
}

/// A finder, the delay it was made for, and the sample it began with.
struct Running {
    finder: SectionFinder,
    lag: usize,
    origin: u64,
}

impl<const C: usize> Passages<C> {
    /// Told every `hop` samples.
    fn new(hop: f64) -> Self {
        // Long enough for what is new at each instant.
        let length = hop.max(1.0).ceil() as usize;
        Self {
            sliding: SlidingWindow::new(length, hop).starting_with(1),
            taken: 0,
            running: None,
        }
    }

    fn push<L, F>(
        &mut self,
        samples: [&[f64]; C],
        find: Find<L, F>,
        context: &Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError>
    where
        L: Fn(u64, &Choices) -> Option<usize>,
        F: Fn(usize) -> Result<SectionFinder, AnalysisError>,
    {
        let Self {
            sliding,
            taken,
            running,
        } = self;
        sliding.push(samples, |view| {
            let first = std::mem::replace(taken, view.seen);
            let Some(lag) = (find.lag_at)(view.seen, &context.choices) else {
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
            let fresh = (view.seen - first) as usize;
            let pieces = view.channels.map(|x| &x[x.len() - fresh..]);
            let mut points = Vec::new();
            finder.push(&pieces, |crossing| {
                points.push(SectionPoint {
                    time: context.time(*origin as f64 + crossing.sample),
                    at: find.shown.map(|k| crossing.point[k]),
                });
            })?;
            if points.is_empty() {
                return Ok(());
            }
            emit(Record::Section {
                time: context.newest(view.seen),
                points,
            })
        })
    }
}
