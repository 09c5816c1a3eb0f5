//! Recurrence quantification of the probe's displacement.

use super::choices::Unfolding;
use super::thinning::EveryStep;
use super::{Context, Emit, Stage, samples};
use crate::analysis::{DelayVectors, RateBase, RecurrenceRule, SlidingWindow, quantify};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::{DelaySpec, QuantificationSpec};

/// Emits [`Record::Quantification`]. A window of which nothing can be said is passed over.
///
/// States are taken every step, counted from the first sample of the run; step and delay are
/// rounded, to whole samples and to whole steps, one at least. Measures of lines are in states.
///
/// Each window is counted anew: 1.3 ms for 2000 states of `torus-3deg` or `periodic-2deg` under a
/// fixed distance, where [`RecurrenceWindow`](crate::analysis::RecurrenceWindow) takes 1.5 and
/// 7 ms for the 500 that enter from one window of the scenes to the next.
pub struct QuantificationStage {
    every_step: EveryStep,
    sliding: SlidingWindow<1>,
    unfolding: Unfolding,
    /// States in the window.
    states: usize,
    rule: RecurrenceRule,
    least_diagonal: usize,
    least_vertical: usize,
    /// Spacing of the states, s.
    dt: f64,
}

impl QuantificationStage {
    /// For samples at `rate` (Hz); `delay` is the scene's choice of delays.
    pub fn new(spec: &QuantificationSpec, delay: Option<&DelaySpec>, rate: f64) -> Self {
        let every_step = EveryStep::new(samples(spec.step, rate, 1));
        let steps_a_second = rate / every_step.step() as f64;
        let states = samples(spec.sliding.window, steps_a_second, 1);
        let unfolding = Unfolding::new(&spec.embedding, delay, rate);
        let most = unfolding.most();
        let reach =
            DelayVectors::samples_for(states, steps(most.lag, every_step.step()), most.dimension);
        Self {
            sliding: SlidingWindow::new(reach, spec.sliding.every * steps_a_second)
                .starting_with(states),
            every_step,
            unfolding,
            states,
            rule: RecurrenceRule {
                norm: spec.nearness.norm,
                threshold: spec.nearness.threshold,
                theiler: samples(spec.theiler, steps_a_second, 1),
            },
            least_diagonal: spec.least_diagonal,
            least_vertical: spec.least_vertical,
            dt: 1.0 / steps_a_second,
        }
    }
}

impl Stage for QuantificationStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self {
            every_step,
            sliding,
            unfolding,
            states,
            rule,
            least_diagonal,
            least_vertical,
            dt,
        } = self;
        let step = every_step.step();
        sliding.space_out(frame.apart() / step as u64);
        sliding.push([every_step.of(&frame.displacement)], |view| {
            let seen = (view.seen - 1) * step as u64 + 1;
            let Some(embedding) = unfolding.at(seen, &context.choices) else {
                return Ok(());
            };
            let lag = steps(embedding.lag, step);
            let need = DelayVectors::samples_for(*states, lag, embedding.dimension);
            let Some(from) = view.channels[0].len().checked_sub(need) else {
                return Ok(());
            };
            let vectors = DelayVectors::new(&view.channels[0][from..], lag, embedding.dimension)?;
            // The distance first, because it is told, too.
            let Ok(rule) = rule.fixed(&vectors) else {
                return Ok(());
            };
            let Ok(counts) = quantify(&vectors, &rule) else {
                return Ok(());
            };
            emit(Record::Quantification {
                time: context.newest(seen),
                window: *states as f64 * *dt,
                dt: *dt,
                threshold: rule.threshold.distance(),
                measures: counts.measures(*least_diagonal, *least_vertical, RateBase::Counted),
                period: counts.period().map(|states| states * *dt),
            })
        })
    }
}

/// A delay (samples) in whole steps, one at least.
fn steps(lag: usize, step: usize) -> usize {
    ((lag + step / 2) / step).max(1)
}
