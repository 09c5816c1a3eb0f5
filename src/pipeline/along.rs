//! What goes along with a simulation where its scene asks: tangent vectors and a second copy.

use super::message::{Exponents, Frame};
use super::twin::Twin;
use crate::dynamics::{DynamicsError, Integrator, System};
use crate::scene::{Scene, SubjectSpec};

/// Follows a simulation from sample to sample.
#[derive(Debug)]
pub(super) struct Along {
    /// When exponents are due, if they are asked for.
    exponents: Option<Due>,
    /// The second copy, if it is asked for.
    twin: Option<Twin>,
    /// See [`TwinSamples::floor`](super::message::TwinSamples::floor).
    floor: f64,
}

/// The samples at which something is due.
#[derive(Clone, Copy, Debug)]
struct Due {
    /// Index of the sample from which on time counts.
    from: u64,
    /// Samples from one time to the next.
    every: u64,
}

/// A sample that the simulation has just reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached<'a> {
    /// Its index, from the start.
    pub index: u64,
    /// Its time, s.
    pub time: f64,
    /// The state there.
    pub z: &'a [f64],
}

impl Along {
    /// What a scene asks for.
    pub fn new(scene: &Scene) -> Self {
        let rate = scene.sample_rate;
        let seed = scene.start.seed;
        let analysis = &scene.analysis;
        Self {
            exponents: analysis.exponents.map(|spec| Due {
                from: (spec.settle * rate).ceil() as u64,
                every: (spec.every * rate).round().max(1.0) as u64,
            }),
            twin: analysis.butterfly.map(|spec| Twin::new(spec, seed)),
            floor: floor(scene),
        }
    }

    /// Follows to a sample, which is already in the frame, and adds to the frame what is due there.
    /// `probe` gives displacement (m) and velocity (m/s) of a state.
    pub fn follow<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        integrator: &mut Integrator,
        reached: Reached<'_>,
        probe: impl Fn(&[f64]) -> [f64; 2],
        frame: &mut Frame,
    ) -> Result<(), DynamicsError> {
        if let Some(due) = self.exponents {
            frame
                .exponents
                .extend(due.exponents(sys, integrator, reached));
        }
        let Some(twin) = &mut self.twin else {
            return Ok(());
        };
        let k = frame.len() - 1;
        let beside = frame.twin.get_or_insert_default();
        beside.floor = self.floor;
        if let Some(state) = twin.sample(sys, integrator, reached.time, reached.z)? {
            if beside.distance.is_empty() {
                beside.first = k;
            }
            let [displacement, velocity] = probe(state.z);
            beside.displacement.push(displacement);
            beside.velocity.push(velocity);
            beside.distance.push(state.distance);
        }
        Ok(())
    }
}

/// The distance of two copies below which the errors of their steps rule. On the same steps these
/// errors are the same, and there is the rounding alone. Where the state or the law jumps at events,
/// each copy cuts its own steps, and what the errors of the two differ by parts them at once: copies
/// 1e-12 apart are half a tolerance apart after a few impacts. Where nothing jumps, as in a joint, the
/// errors differ so little that copies 1e-12 apart part alike with and without events.
fn floor(scene: &Scene) -> f64 {
    match scene.subject {
        SubjectSpec::Small(_) => 10.0 * scene.integrator.tolerance,
        SubjectSpec::Joint(_) => 100.0 * f64::EPSILON,
    }
}

impl Due {
    /// The exponents, where they are due.
    fn exponents<Y: System + ?Sized>(
        self,
        sys: &Y,
        integrator: &mut Integrator,
        reached: Reached<'_>,
    ) -> Option<Exponents> {
        let since = reached.index.checked_sub(self.from)?;
        if since == 0 {
            integrator.forget_growth();
        }
        if since % self.every != 0 {
            return None;
        }
        let spectrum = integrator.exponents()?;
        (spectrum.time > 0.0).then(|| Exponents {
            time: reached.time,
            spectrum,
            motion: integrator.motion(sys),
            omega_1: sys.omega().iter().copied().fold(f64::NAN, f64::min),
        })
    }
}

/// Lets the tangent vectors that a scene asks for go along with its integrator.
///
/// # Errors
/// [`DynamicsError`] when the system has no derivative, or fewer dimensions than vectors.
pub(super) fn with_tangents<Y: System + ?Sized>(
    scene: &Scene,
    sys: &Y,
    integrator: Integrator,
) -> Result<Integrator, DynamicsError> {
    match scene.analysis.exponents {
        Some(spec) => integrator.with_tangents(sys, spec.count, scene.start.seed),
        None => Ok(integrator),
    }
}
