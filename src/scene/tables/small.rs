//! Tables of the small systems.

use super::run::{PLACE, Start};
use super::{friction, joint};
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schema::kind::Range::{Closed, HalfOpen, Positive};
use crate::scene::schema::kind::{Kind, number};
use crate::scene::schema::unit::*;
use crate::scene::schema::{IfAbsent, Key, Schema, keys};
use crate::scene::subject::SmallSystem;
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// Range of natural frequencies.
const FREQUENCY: Kind<f64> = number(TURNS_PER_SECOND, Positive(1e5));

/// Range of damping ratios.
const RATIO: Kind<f64> = number(ONE, HalfOpen(0.0, 1.0));

/// Range of drive amplitudes.
const DRIVE: Kind<f64> = number(METRE_PER_SECOND_SQUARED, Closed(0.0, 1e6));

/// Range of drive frequencies.
const DRIVE_FREQUENCY: Kind<f64> = number(TURNS_PER_SECOND, Closed(0.0, 1e5));

/// Range of specific normal loads.
const LOAD: Kind<f64> = number(NEWTON_PER_KILOGRAM, Positive(1e6));

/// Range of belt speeds.
const BELT: Kind<f64> = number(MILLIMETRE_PER_SECOND, Positive(1e5));

/// Names of the tables.
pub const NAMES: [&str; 4] = [
    "impact_oscillator",
    "mass_on_belt",
    "two_modes_on_belt",
    "damped_contact",
];

pub fn declare(schema: &mut Schema) {
    let [impact, belt, two_modes, contact] = NAMES;
    ImpactOscillator::declare(schema, impact);
    MassOnBelt::declare(schema, belt);
    TwoModesOnBelt::declare(schema, two_modes);
    DampedContact::declare(schema, contact);
}

keys! {
    ImpactOscillator |table| {
        /// Natural frequency.
        omega = "natural_frequency_hz": FREQUENCY;
        /// Damping ratio.
        damping = "damping_ratio": RATIO, default 0;
        /// Amplitude of the drive, as the acceleration of the mass.
        drive = "drive_amplitude_m_per_s2": DRIVE;
        /// Frequency of the drive, a cosine; 0 is a constant force.
        drive_omega = "drive_frequency_hz": DRIVE_FREQUENCY;
        /// Position of the wall; the mass moves above it.
        wall = "wall_position_um": PLACE, default 0;
        /// Coefficient of restitution: speed after an impact divided by the speed before it.
        restitution = "restitution": number(ONE, Closed(0.0, 1.0));
    } => ImpactOscillator { omega, damping, drive, drive_omega, drive_phase: 0.0, wall, restitution };

    MassOnBelt {
        /// Natural frequency.
        omega = "natural_frequency_hz": FREQUENCY;
        /// Damping ratio.
        damping = "damping_ratio": RATIO, default 0;
        /// Normal force on the belt, divided by the mass.
        load = "load_n_per_kg": LOAD;
        /// Static coefficient of friction, which applies while the mass sticks.
        mu_s = "mu_s": friction::COEFFICIENT;
        /// Kinetic coefficient of friction, which applies while the mass slides; at most the static one.
        mu_d = "mu_d": friction::COEFFICIENT;
        /// Speed of the belt.
        belt = "belt_speed_mm_per_s": BELT;
        /// Slope factor of the decrease from the static to the kinetic coefficient with sliding speed; a larger value gives a steeper decrease.
        stribeck = "stribeck_slope_s_per_m": number(SECOND_PER_METRE, Positive(1e6)),
            else "a jump to the kinetic coefficient";
    }

    TwoModesOnBelt |table| {
        /// Natural frequency of the first mode out of contact.
        first = "first_frequency_hz": FREQUENCY;
        /// Natural frequency of the second mode out of contact; its direction is perpendicular to that of the first.
        second = "second_frequency_hz": FREQUENCY;
        /// Direction of the first mode: angle from the belt direction towards the belt normal.
        angle = "mode_angle_deg": number(DEGREE, Closed(-90.0, 90.0));
        /// Contact stiffness, as the natural frequency of the mass on this spring alone.
        contact = "contact_frequency_hz": FREQUENCY;
        /// Normal force on the belt, divided by the mass.
        load = "load_n_per_kg": LOAD;
        /// Coefficient of friction, constant except near zero sliding speed.
        mu = "mu": friction::COEFFICIENT;
        /// Slope factor of the increase from zero at rest; at least 20 divided by the belt speed.
        creep = "creep_slope_s_per_m": friction::CREEP, default 1000;
        /// Speed of the belt.
        belt = "belt_speed_mm_per_s": BELT;
    } => TwoModesOnBelt { omega: [first, second], angle, contact_stiffness: contact * contact, load, mu, creep, belt };

    DampedContact |table| {
        /// Natural frequency out of contact.
        omega = "natural_frequency_hz": FREQUENCY;
        /// Damping ratio out of contact.
        damping = "damping_ratio": RATIO, default 0;
        /// Amplitude of the drive, as the acceleration of the mass.
        drive = "drive_amplitude_m_per_s2": DRIVE;
        /// Frequency of the drive, a cosine; 0 is a constant force.
        drive_omega = "drive_frequency_hz": DRIVE_FREQUENCY;
        /// Contact stiffness below 0, as the natural frequency of the mass on this spring alone.
        contact = "contact_frequency_hz": FREQUENCY;
        /// Contact damping, as the damping ratio of the mass on the contact alone.
        ratio = "contact_damping_ratio": number(ONE, Closed(0.0, 10.0));
    } => {
        // `contact` is the natural frequency of the undamped mass on the contact spring alone.
        let (contact_stiffness, contact_damping) = (contact * contact, 2.0 * ratio * contact);
        DampedContact { omega, damping, drive, drive_omega, drive_phase: 0.0, contact_stiffness, contact_damping }
    };
}

/// Reads the small system of a scene; `None` if no table defines one.
pub fn small(document: &Document<'_>) -> Result<Option<SmallSystem>, SceneError> {
    let mut given = NAMES.into_iter().filter(|table| document.has(table));
    let Some(table) = given.next() else {
        return Ok(None);
    };
    for other in given.chain(joint::TABLES) {
        ensure!(document, !document.has(other) => other, &[];
            "a scene defines one system, and [{table}] already defines one";
            "keep [{table}] or [{other}]");
    }
    ensure!(document, !document.has("time.carry") => "time.carry", &[];
        "a small system has no load, tilt or rotation that changes";
        "remove it");
    let given = document.table(table);
    let system = match table {
        "impact_oscillator" => SmallSystem::ImpactOscillator(FromTable::read(given)?),
        "mass_on_belt" => SmallSystem::MassOnBelt(FromTable::read(given)?),
        "two_modes_on_belt" => SmallSystem::TwoModesOnBelt(FromTable::read(given)?),
        "damped_contact" => SmallSystem::DampedContact(FromTable::read(given)?),
        table => unreachable!("no system is defined by [{table}]"),
    };
    check(document, &system)?;
    Ok(Some(system))
}

/// Checks the parameters of a system, and its initial position.
fn check(document: &Document<'_>, system: &SmallSystem) -> Result<(), SceneError> {
    /// Minimum of slope factor times belt speed; a coefficient that still increases at the belt speed would
    /// damp.
    const RISEN: f64 = 20.0;

    match *system {
        SmallSystem::ImpactOscillator(ImpactOscillator { wall, .. }) => {
            let start = Start::read(document.table("start"))?.position;
            let [start_um, wall_um] = [start, wall].map(|metres| metres * 1e6);
            ensure!(document, start >= wall => "start.position_um", &["impact_oscillator.wall_position_um"];
                "the initial position {start_um} µm is below the wall at {wall_um} µm";
                "increase it to at least impact_oscillator.wall_position_um");
        }
        SmallSystem::MassOnBelt(MassOnBelt { mu_s, mu_d, .. }) => {
            ensure!(document, mu_d <= mu_s => "mass_on_belt.mu_d", &["mass_on_belt.mu_s"];
            "it exceeds the static coefficient {mu_s}, for which the mass can neither stick nor slide";
            "reduce it to at most mass_on_belt.mu_s")
        }
        SmallSystem::TwoModesOnBelt(TwoModesOnBelt { creep, belt, .. }) => ensure!(document,
            creep * belt >= RISEN => "two_modes_on_belt.creep_slope_s_per_m", &["two_modes_on_belt.belt_speed_mm_per_s"];
            "the coefficient still increases at the belt speed, and mode coupling requires a constant one";
            "increase it to at least {:.0}", RISEN / belt),
        SmallSystem::DampedContact(_) => {}
    }
    Ok(())
}
