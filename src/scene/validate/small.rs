//! The small systems: one table of a scene file each.

use std::f64::consts::TAU;

use super::joint;
use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys;
use crate::scene::subject::SmallSystem;
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// Reads a system from its table.
type Reader = fn(&Document<'_>) -> Result<SmallSystem, SceneError>;

/// The tables, and what reads each.
const TABLES: [(&str, Reader); 4] = [
    ("impact_oscillator", impact_oscillator),
    ("mass_on_belt", mass_on_belt),
    ("two_modes_on_belt", two_modes_on_belt),
    ("damped_contact", damped_contact),
];

/// The small system of a scene; `None` where it has no table of one.
pub(super) fn small(document: &Document<'_>) -> Result<Option<SmallSystem>, SceneError> {
    let mut given = TABLES.iter().filter(|(table, _)| document.has(table));
    let Some((table, reader)) = given.next() else {
        return Ok(None);
    };
    let mut others = given.map(|(table, _)| *table).chain(
        joint::TABLES
            .into_iter()
            .filter(|table| document.has(table)),
    );
    if let Some(other) = others.next() {
        return Err(document.inconsistent(
            other,
            &[],
            format!("a scene runs one thing, and [{table}] says already what"),
            format!("keep [{table}] or [{other}]"),
        ));
    }
    reader(document).map(Some)
}

fn impact_oscillator(document: &Document<'_>) -> Result<SmallSystem, SceneError> {
    let wall = document.get(&keys::WALL)?;
    let start = document.get(&keys::START_POSITION)?;
    if start < wall {
        return Err(document.inconsistent(
            keys::START_POSITION.path,
            &[keys::WALL.path],
            format!(
                "the mass starts at {} um, behind the wall at {} um",
                start * 1e6,
                wall * 1e6
            ),
            "start it at or above impact_oscillator.wall_um",
        ));
    }
    Ok(SmallSystem::ImpactOscillator(ImpactOscillator {
        omega: TAU * document.get(&keys::IMPACT_FREQUENCY)?,
        damping: document.get(&keys::IMPACT_DAMPING)?,
        drive: document.get(&keys::IMPACT_DRIVE)?,
        drive_omega: TAU * document.get(&keys::IMPACT_DRIVE_FREQUENCY)?,
        wall,
        restitution: document.get(&keys::RESTITUTION)?,
    }))
}

fn mass_on_belt(document: &Document<'_>) -> Result<SmallSystem, SceneError> {
    let mu_s = document.get(&keys::BELT_MU_S)?;
    let mu_d = document.get(&keys::BELT_MU_D)?;
    if mu_d > mu_s {
        return Err(document.inconsistent(
            keys::BELT_MU_D.path,
            &[keys::BELT_MU_S.path],
            format!(
                "it exceeds the static coefficient, {mu_s}: the mass could neither stick nor slide"
            ),
            "make it at most mass_on_belt.mu_s",
        ));
    }
    Ok(SmallSystem::MassOnBelt(MassOnBelt {
        omega: TAU * document.get(&keys::BELT_FREQUENCY)?,
        damping: document.get(&keys::BELT_DAMPING)?,
        load: document.get(&keys::BELT_LOAD)?,
        mu_s,
        mu_d,
        belt: document.get(&keys::BELT_SPEED)?,
        stribeck: document.find(&keys::BELT_STRIBECK)?,
    }))
}

fn two_modes_on_belt(document: &Document<'_>) -> Result<SmallSystem, SceneError> {
    /// The rise at rest must be over at the belt's speed: what is left of it would damp.
    const RISEN: f64 = 20.0;

    let (creep, belt) = (
        document.get(&keys::COUPLED_CREEP)?,
        document.get(&keys::COUPLED_SPEED)?,
    );
    if creep * belt < RISEN {
        return Err(document.inconsistent(
            keys::COUPLED_CREEP.path,
            &[keys::COUPLED_SPEED.path],
            "the coefficient still rises at the belt's speed, and mode coupling needs a constant one",
            format!("make it at least {:.0}", RISEN / belt),
        ));
    }
    let contact = TAU * document.get(&keys::COUPLED_CONTACT)?;
    Ok(SmallSystem::TwoModesOnBelt(TwoModesOnBelt {
        omega: [
            TAU * document.get(&keys::COUPLED_FIRST)?,
            TAU * document.get(&keys::COUPLED_SECOND)?,
        ],
        angle: document.get(&keys::COUPLED_ANGLE)?,
        contact_stiffness: contact * contact,
        load: document.get(&keys::COUPLED_LOAD)?,
        mu: document.get(&keys::COUPLED_MU)?,
        creep,
        belt,
    }))
}

fn damped_contact(document: &Document<'_>) -> Result<SmallSystem, SceneError> {
    // An undamped mass on the spring of the contact alone would vibrate with this.
    let contact = TAU * document.get(&keys::CONTACT_FREQUENCY)?;
    Ok(SmallSystem::DampedContact(DampedContact {
        omega: TAU * document.get(&keys::DAMPED_FREQUENCY)?,
        damping: document.get(&keys::DAMPED_DAMPING)?,
        drive: document.get(&keys::DAMPED_DRIVE)?,
        drive_omega: TAU * document.get(&keys::DAMPED_DRIVE_FREQUENCY)?,
        contact_stiffness: contact * contact,
        contact_damping: 2.0 * document.get(&keys::CONTACT_DAMPING)? * contact,
    }))
}
