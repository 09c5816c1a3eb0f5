//! Taking steps: try, judge, accept or shorten.

use super::control::{Control, Size};
use super::stepper::{Step, Stepper};
use super::{DynamicsError, System, Tally};

/// A step may be stretched by this much to end where it must, rather than leave a sliver.
const STRETCH: f64 = 1.0 + 1e-6;

/// The progress is looked at every so many steps: some seconds of work. Where these steps crawl
/// ([`Controller::crawl`](super::control::Controller::crawl)) on the average, the integration ends. On the
/// average, since single longer steps among them, as implicit ones among explicit ones, get nowhere either.
const STRETCH_OF_STEPS: u64 = 500_000;

/// What decides on the steps of an integration, and what is counted and known of its state.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// The choice of the step.
    pub control: Control,
    /// Natural circular frequencies of the system, rad/s.
    pub omega: Vec<f64>,
    /// Size of the present state; of its first-order components, the largest since the start.
    pub size: Size,
    /// Whether the method takes implicit steps.
    pub implicit: bool,
    /// Steps since the progress was last looked at.
    pub progress: Progress,
    /// Work done.
    pub tally: Tally,
    /// The largest error over the one allowed among the steps accepted since it was last asked for;
    /// `None` without steps, or where steps are fixed and have no estimate.
    pub largest_ratio: Option<f64>,
}

/// What some steps have come to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress {
    steps: u64,
    /// The time that they have covered, s.
    covered: f64,
}

impl Pace {
    /// Evaluates the system afresh at the stepper's present state, where the next step starts.
    pub fn refresh<Y, M>(
        &mut self,
        stepper: &mut M,
        sys: &Y,
        status: Option<&[u8]>,
    ) -> Result<(), DynamicsError>
    where
        Y: System + ?Sized,
        M: Stepper,
    {
        stepper.refresh(sys, status, &mut self.tally);
        let size = Size::of(&stepper.step().end, &self.omega);
        if !(size.is_finite() && self.rate(stepper).is_finite()) {
            return Err(non_finite(stepper, sys, stepper.step().end_time));
        }
        self.remember(size);
        Ok(())
    }

    /// The size of the slope at the stepper's present state.
    pub fn rate<M: Stepper>(&self, stepper: &M) -> Size {
        Size::of(&stepper.step().end_slope, &self.omega)
    }

    /// Takes one step from the stepper's present state, which ends at `limit` (s) if it would go
    /// past it. A status given is held.
    pub fn step<Y, M>(
        &mut self,
        stepper: &mut M,
        sys: &Y,
        status: Option<&[u8]>,
        limit: f64,
    ) -> Result<(), DynamicsError>
    where
        Y: System + ?Sized,
        M: Stepper,
    {
        stepper.follow(sys, status, &mut self.tally);
        let (start, gain) = (stepper.step().start_time, stepper.rule().gain);
        let start_size = self.size;
        loop {
            let wanted = self.control.step();
            let landing = limit - start <= wanted * STRETCH;
            let end = if landing { limit } else { start + wanted };
            if end <= start {
                // Only a fixed step can be that short: a controller's stays above `shortest`.
                let allowed = "long enough to make a difference to the time";
                return Err(DynamicsError::Parameter {
                    name: "the step",
                    value: wanted,
                    allowed,
                });
            }
            if !landing {
                self.control.realise(end - start);
            }
            stepper.attempt(sys, status, end, &mut self.tally);

            let size = Size::of(&stepper.step().end, &self.omega);
            let error = stepper.error(&self.omega);
            let finite = size.is_finite() && error.is_finite() && self.rate(stepper).is_finite();
            let ratio = match &self.control {
                _ if !finite => f64::INFINITY,
                Control::Fixed(_) => 0.0,
                Control::Adaptive(controller) => controller.ratio(error, start_size.max(size)),
            };
            if ratio <= 1.0 {
                if let Control::Adaptive(controller) = &mut self.control {
                    if !landing {
                        controller.accept(ratio, gain);
                    }
                    let before = self.largest_ratio.unwrap_or(0.0);
                    self.largest_ratio = Some(before.max(ratio));
                }
                self.tally.steps += 1;
                self.remember(size);
                return self.check_progress(end, end - start);
            }

            self.tally.rejections += 1;
            let shorter = match &mut self.control {
                Control::Fixed(_) => None,
                Control::Adaptive(controller) => {
                    controller.reject(end - start, ratio, gain);
                    Some(controller.step).filter(|&step| step >= controller.shortest(start))
                }
            };
            if shorter.is_none() {
                let failure = if finite {
                    DynamicsError::StepUnderflow {
                        time: start,
                        step: end - start,
                        error_ratio: ratio,
                        implicit: self.implicit,
                    }
                } else {
                    non_finite(stepper, sys, start)
                };
                stepper.rewind();
                return Err(failure);
            }
        }
    }

    /// Looks now and then whether steps get anywhere, and gives up where they do not: the last one, of
    /// length `h` (s), ended at time `t` (s).
    fn check_progress(&mut self, t: f64, h: f64) -> Result<(), DynamicsError> {
        let Control::Adaptive(controller) = &self.control else {
            return Ok(());
        };
        self.progress.steps += 1;
        self.progress.covered += h;
        if self.progress.steps < STRETCH_OF_STEPS {
            return Ok(());
        }
        let Progress { steps, covered } = std::mem::take(&mut self.progress);
        let mean = covered / steps as f64;
        if mean >= controller.crawl() {
            return Ok(());
        }
        Err(DynamicsError::Stalled {
            time: t,
            step: mean,
            steps,
            implicit: self.implicit,
        })
    }

    /// Takes the stepper's last step back.
    pub fn rewind<M: Stepper>(&mut self, stepper: &mut M) {
        stepper.rewind();
        self.resize(stepper);
    }

    /// Takes note of the size of the stepper's present state, which is no longer that of the step.
    pub fn resize<M: Stepper>(&mut self, stepper: &M) {
        self.remember(Size::of(&stepper.step().end, &self.omega));
    }

    /// Takes note of the size of an accepted state.
    fn remember(&mut self, size: Size) {
        self.size = Size {
            first_order: self.size.first_order.max(size.first_order),
            ..size
        };
    }
}

/// The error for a step that failed on a number that is not finite.
fn non_finite<Y, M>(stepper: &M, sys: &Y, last_good_time: f64) -> DynamicsError
where
    Y: System + ?Sized,
    M: Stepper,
{
    let step = stepper.step();
    let worst = |values: &[f64]| values.iter().position(|x| !x.is_finite());
    let component = worst(&step.end)
        .or_else(|| worst(&step.end_slope))
        .or_else(|| worst(&step.error))
        // All finite, but too large to be added up.
        .or_else(|| step.end.iter().position(|x| x.abs() > 1e-4 * f64::MAX))
        .unwrap_or(0);
    let known = worst(&step.start).is_none();
    DynamicsError::NonFinite {
        time: step.end_time,
        last_good_time,
        component,
        modes: sys.modes(),
        part: known.then(|| part_at_fault(step, sys)).flatten(),
        last_good_state: if known {
            step.start.clone()
        } else {
            Vec::new()
        },
    }
}

/// The part of the system that is at fault where a step from a good state failed. The stages of the
/// step are spoilt by then: it is looked for along the slope of the good state, at which the step was
/// aimed.
fn part_at_fault<Y: System + ?Sized>(step: &Step, sys: &Y) -> Option<String> {
    let (t, h) = (step.start_time, step.length());
    let mut slope = vec![0.0; sys.dim()];
    sys.rhs(t, &step.start, &mut slope);
    // Where the force at the good state itself is no number, its slope leads nowhere.
    let here = sys.part_at_fault(t, &step.start);
    here.or_else(|| {
        // A fixed step may have gone wrong well behind where the slope leads.
        [0.5, 1.0, 2.0].into_iter().find_map(|share| {
            let ahead = step.start.iter().zip(&slope);
            let ahead: Vec<f64> = ahead.map(|(z, slope)| z + share * h * slope).collect();
            let known = ahead.iter().all(|z| z.is_finite());
            known.then(|| sys.part_at_fault(t + share * h, &ahead))?
        })
    })
}
