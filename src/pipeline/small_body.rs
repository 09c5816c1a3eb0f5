//! The small system of a simulation.

use std::f64::consts::TAU;

use super::PipelineError;
use super::message::{SmallInfo, StatusInfo, StatusKind};
use super::prepare::{boxed, small_probe};
use super::simulate::Motion;
use crate::scene::SmallSystem;

/// Upper limit of frequency axes as a multiple of the largest natural or driving frequency: discontinuities
/// have many harmonics.
const HARMONICS: f64 = 8.0;

/// Continues with other numbers from a time (s) on. The angle of the drive goes on.
pub(super) fn set(
    before: &mut SmallSystem,
    small: &mut SmallSystem,
    time: f64,
    motion: &mut Motion,
) -> Result<(), PipelineError> {
    if let (Some((old, phase)), Some((new, shifted))) = (before.drive(), small.drive()) {
        *shifted = (*phase + (old - new) * time).rem_euclid(TAU);
    }
    let integrator = &mut motion.integrator;
    integrator.integrate_to(time)?;
    if let SmallSystem::ImpactOscillator(oscillator) = small {
        // A wall that moves takes a mass that it reaches along.
        let position = integrator.state()[0];
        integrator.translate(&[(oscillator.wall - position).max(0.0)])?;
    }
    integrator.restart(boxed(small).into())?;
    motion.probe = small_probe(small);
    motion.sensitivity.parameters_changed(time);
    Ok(())
}

/// Description of a small system sampled at `rate` (Hz).
pub(super) fn info(small: &SmallSystem, rate: f64) -> SmallInfo {
    use StatusKind::{Free, Held, Other};
    // The statuses in the order of their numbers.
    let (omegas, statuses, transition) = match small {
        SmallSystem::ImpactOscillator(system) => (
            vec![system.omega, system.drive_omega],
            vec![("flying", Free), ("resting on the wall", Held)],
            "impacts",
        ),
        SmallSystem::MassOnBelt(system) => (
            vec![system.omega],
            vec![
                ("slower than the belt", Free),
                ("sticks", Held),
                ("faster than the belt", Other),
            ],
            "changes between sticking and sliding",
        ),
        SmallSystem::TwoModesOnBelt(system) => (
            system.omega.to_vec(),
            vec![("in contact", Held), ("separated", Free)],
            "contacts and separations",
        ),
        SmallSystem::DampedContact(system) => (
            vec![
                system.omega,
                system.drive_omega,
                system.contact_stiffness.sqrt(),
            ],
            vec![("separated", Free), ("in contact", Held)],
            "contacts and separations",
        ),
    };
    let highest = omegas.iter().copied().fold(0.0, f64::max) / TAU;
    SmallInfo {
        words: small.description(),
        frequency_hz: omegas[0] / TAU,
        highest_frequency: (HARMONICS * highest).min(0.5 * rate),
        statuses: statuses
            .into_iter()
            .map(|(label, kind)| StatusInfo { label, kind })
            .collect(),
        transition,
    }
}
