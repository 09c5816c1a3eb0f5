//! Systems from closures.

use crate::continuation::{Family, FamilyError, FamilyMember};
use crate::system::difference_of_change;
use crate::{Differentiable, Switching, System};

/// Writes numbers from a status, a time (s), the coordinates and the velocities.
type Formula = Box<dyn Fn(u8, f64, &[f64], &[f64], &mut [f64]) + Send + Sync>;

/// The status of a time (s), the coordinates and the velocities.
type StatusOf = Box<dyn Fn(f64, &[f64], &[f64]) -> u8 + Send + Sync>;

/// Changes coordinates and velocities at a guard of a status, and returns the next status.
type Crossing = Box<dyn Fn(u8, usize, &mut [f64], &mut [f64]) -> u8 + Send + Sync>;

/// Restores what a status fixes in coordinates and velocities.
type Hold = Box<dyn Fn(u8, &mut [f64], &mut [f64]) + Send + Sync>;

/// Oscillators whose force is a closure: [`system`], or, with statuses, [`piecewise_system`]. Derivatives are central
/// differences.
pub struct OwnSystem {
    omega: Vec<f64>,
    damping: Vec<f64>,
    /// Period of the drive, s; `None` for an autonomous system.
    drive_period: Option<f64>,
    force: Formula,
    status_of: StatusOf,
    /// Number of guards; zero for a smooth system.
    guards: usize,
    guard_values: Formula,
    cross: Crossing,
    hold: Hold,
}

/// Oscillators `q_i'' + omega_i^2 q_i = f_i(t, q, v)` with natural circular frequencies (rad/s) and a closure
/// `force(t, q, v, out)`. Without more ([`OwnSystem::driven`]) it must not depend on the time.
pub fn system(
    omega: impl Into<Vec<f64>>,
    force: impl Fn(f64, &[f64], &[f64], &mut [f64]) + Send + Sync + 'static,
) -> OwnSystem {
    OwnSystem {
        omega: omega.into(),
        damping: Vec::new(),
        drive_period: None,
        force: Box::new(move |_, t, q, v, out| force(t, q, v, out)),
        status_of: Box::new(|_, _, _| 0),
        guards: 0,
        guard_values: Box::new(|_, _, _, _, _| ()),
        cross: Box::new(|status, _, _, _| status),
        hold: Box::new(|_, _, _| ()),
    }
}

/// As [`system`], with a force that depends on a status, too: `status_of(t, q, v)` is that of a state, and
/// `force(status, t, q, v, out)` its smooth law. A status ends where one of the `guards`, which
/// `guard_values(status, t, q, v, out)` writes, falls through zero. `cross(status, guard, q, v)` then returns the next
/// status, and may change the state ([`Switching`]). Without guards the system counts as smooth, with the status of each
/// moment.
pub fn piecewise_system(
    omega: impl Into<Vec<f64>>,
    status_of: impl Fn(f64, &[f64], &[f64]) -> u8 + Send + Sync + 'static,
    force: impl Fn(u8, f64, &[f64], &[f64], &mut [f64]) + Send + Sync + 'static,
    guards: usize,
    guard_values: impl Fn(u8, f64, &[f64], &[f64], &mut [f64]) + Send + Sync + 'static,
    cross: impl Fn(u8, usize, &mut [f64], &mut [f64]) -> u8 + Send + Sync + 'static,
) -> OwnSystem {
    OwnSystem {
        force: Box::new(force),
        status_of: Box::new(status_of),
        guards,
        guard_values: Box::new(guard_values),
        cross: Box::new(cross),
        ..system(omega, |_, _, _, _| ())
    }
}

impl OwnSystem {
    /// Adds `2 zeta_i omega_i q_i'` to the left side, with damping ratios `zeta_i`.
    pub fn damped(mut self, damping: impl Into<Vec<f64>>) -> Self {
        self.damping = damping.into();
        self
    }

    /// The force depends on the time, with this period (s).
    pub fn driven(mut self, period: f64) -> Self {
        self.drive_period = Some(period);
        self
    }

    /// Moves states onto the constraint of their status by `hold(status, q, v)`, for example to the velocity of what a mass
    /// sticks to. It has no effect without statuses.
    pub fn held(
        mut self,
        hold: impl Fn(u8, &mut [f64], &mut [f64]) + Send + Sync + 'static,
    ) -> Self {
        self.hold = Box::new(hold);
        self
    }

    /// Coordinates and velocities of a state.
    fn parts<'z>(&self, z: &'z [f64]) -> (&'z [f64], &'z [f64]) {
        z.split_at(self.omega.len())
    }
}

impl System for OwnSystem {
    fn omega(&self) -> &[f64] {
        &self.omega
    }

    fn damping(&self) -> &[f64] {
        &self.damping
    }

    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        let (q, v) = self.parts(z);
        (self.force)((self.status_of)(t, q, v), t, q, v, out);
    }

    fn switching(&self) -> Option<&dyn Switching> {
        (self.guards > 0).then_some(self as &dyn Switching)
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        self.drive_period.is_none()
    }
}

impl Differentiable for OwnSystem {}

impl Switching for OwnSystem {
    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        let (q, v) = self.parts(z);
        status[0] = (self.status_of)(t, q, v);
    }

    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        let (q, v) = self.parts(z);
        (self.force)(status[0], t, q, v, out);
    }

    fn guards(&self) -> usize {
        self.guards
    }

    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]) {
        let (q, v) = self.parts(z);
        (self.guard_values)(status[0], t, q, v, values);
    }

    fn cross(&self, guard: usize, _t: f64, z: &mut [f64], status: &mut [u8]) {
        let (q, v) = z.split_at_mut(self.omega.len());
        status[0] = (self.cross)(status[0], guard, q, v);
    }

    fn settle(&self, status: &[u8], t: f64, z: &mut [f64], (vectors, width): (&mut [f64], usize)) {
        let hold = |z: &mut [f64]| {
            let (q, v) = z.split_at_mut(self.omega.len());
            (self.hold)(status[0], q, v);
        };
        difference_of_change((t, z), (vectors, width, 0.0), |_, z| hold(z));
        hold(z);
    }
}

/// The systems that a closure returns for values of the parameter; the observable is the first component of the state.
impl<F: Fn(f64) -> OwnSystem> Family for F {
    fn member(&self, parameter: f64) -> Result<FamilyMember, FamilyError> {
        let system = self(parameter);
        Ok(FamilyMember {
            drive_period: system.drive_period,
            observable: vec![1.0],
            system: Box::new(system),
        })
    }
}
