//! The small systems: one table of a scene file each.

use super::joint;
use super::run::{PLACE, Start};
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schema::kind::Range::{Closed, HalfOpen, Positive};
use crate::scene::schema::kind::{Number, number};
use crate::scene::schema::unit::{
    DEGREE, METRE_PER_SECOND_SQUARED, MILLIMETRE_PER_SECOND, NEWTON_PER_KILOGRAM, ONE,
    SECOND_PER_METRE, TURNS_PER_SECOND,
};
use crate::scene::schema::{Key, Otherwise, Schema, keys};
use crate::scene::subject::SmallSystem;
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// What a natural frequency must be.
const FREQUENCY: Number = number(TURNS_PER_SECOND, Positive(1e5));

/// What a damping ratio must be.
const RATIO: Number = number(ONE, HalfOpen(0.0, 1.0));

/// What the drive must be.
const DRIVE: Number = number(METRE_PER_SECOND_SQUARED, Closed(0.0, 1e6));

/// What the frequency of the drive must be.
const DRIVE_FREQUENCY: Number = number(TURNS_PER_SECOND, Closed(0.0, 1e5));

/// What the load of a mass must be.
const LOAD: Number = number(NEWTON_PER_KILOGRAM, Positive(1e6));

/// What the speed of a belt must be.
const BELT: Number = number(MILLIMETRE_PER_SECOND, Positive(1e5));

/// Reads a system from its table.
type Reader = fn(Table<'_>) -> Result<SmallSystem, SceneError>;

/// The tables, and what reads each.
const TABLES: [(&str, Reader); 4] = [
    ("impact_oscillator", |table| {
        ImpactOscillator::read(table).map(SmallSystem::ImpactOscillator)
    }),
    ("mass_on_belt", |table| {
        MassOnBelt::read(table).map(SmallSystem::MassOnBelt)
    }),
    ("two_modes_on_belt", |table| {
        TwoModesOnBelt::read(table).map(SmallSystem::TwoModesOnBelt)
    }),
    ("damped_contact", |table| {
        DampedContact::read(table).map(SmallSystem::DampedContact)
    }),
];

pub fn declare(schema: &mut Schema) {
    ImpactOscillator::declare(schema, "impact_oscillator");
    MassOnBelt::declare(schema, "mass_on_belt");
    TwoModesOnBelt::declare(schema, "two_modes_on_belt");
    DampedContact::declare(schema, "damped_contact");
}

keys! {
    ImpactOscillator {
        /// Natural frequency.
        omega = "frequency_hz": FREQUENCY;
        /// Damping ratio.
        damping = "damping_ratio": RATIO, default 0;
        /// Amplitude of the drive, as the acceleration that it gives the mass.
        drive = "drive_m_per_s2": DRIVE;
        /// Frequency of the drive, a cosine; 0 is a constant push.
        drive_omega = "drive_frequency_hz": DRIVE_FREQUENCY;
        /// Where the wall is: the mass moves at or above it.
        wall = "wall_um": PLACE, default 0;
        /// Coefficient of restitution: speed after an impact over that before it.
        restitution = "restitution": number(ONE, Closed(0.0, 1.0));
    }

    MassOnBelt {
        /// Natural frequency.
        omega = "frequency_hz": FREQUENCY;
        /// Damping ratio.
        damping = "damping_ratio": RATIO, default 0;
        /// Force that presses the mass onto the belt, by the mass.
        load = "load_n_per_kg": LOAD;
        /// Static coefficient of friction: holds while sticking.
        mu_s = "mu_s": joint::FRICTION;
        /// Kinetic coefficient of friction: holds while sliding; at most the static one.
        mu_d = "mu_d": joint::FRICTION;
        /// Speed of the belt.
        belt = "belt_mm_per_s": BELT;
        /// Slope factor of the fall from the static to the kinetic coefficient with the sliding speed; the larger, the steeper.
        stribeck = "stribeck_slope_s_per_m": number(SECOND_PER_METRE, Positive(1e6)),
            else "the coefficient falls at once";
    }

    TwoModesOnBelt |table| {
        /// Natural frequency of the first mode out of contact.
        first = "first_frequency_hz": FREQUENCY;
        /// Natural frequency of the second mode out of contact; it moves across the first one.
        second = "second_frequency_hz": FREQUENCY;
        /// Direction in which the first mode moves: from along the belt towards into it.
        angle = "angle_deg": number(DEGREE, Closed(-90.0, 90.0));
        /// Stiffness of the contact, as the frequency of the mass on it alone.
        contact = "contact_frequency_hz": FREQUENCY;
        /// Force that presses the mass onto the belt, by the mass.
        load = "load_n_per_kg": LOAD;
        /// Coefficient of friction, the same at all speeds but next to rest.
        mu = "mu": joint::FRICTION;
        /// Slope factor by which it rises from zero at rest; at least 20 over the speed of the belt.
        creep = "creep_slope_s_per_m": joint::CREEP, default 1000;
        /// Speed of the belt.
        belt = "belt_mm_per_s": BELT;
    } => TwoModesOnBelt { omega: [first, second], angle, contact_stiffness: contact * contact, load, mu, creep, belt };

    DampedContact |table| {
        /// Natural frequency out of contact.
        omega = "frequency_hz": FREQUENCY;
        /// Damping ratio out of contact.
        damping = "damping_ratio": RATIO, default 0;
        /// Amplitude of the drive, as the acceleration that it gives the mass.
        drive = "drive_m_per_s2": DRIVE;
        /// Frequency of the drive, a cosine; 0 is a constant push.
        drive_omega = "drive_frequency_hz": DRIVE_FREQUENCY;
        /// Stiffness of the contact below 0: the natural frequency of the mass on its spring alone.
        contact = "contact_frequency_hz": FREQUENCY;
        /// Damping of the contact: the damping ratio of the mass on it alone.
        ratio = "contact_damping_ratio": number(ONE, Closed(0.0, 10.0));
    } => {
        // An undamped mass on the spring of the contact alone would vibrate with `contact`.
        let (contact_stiffness, contact_damping) = (contact * contact, 2.0 * ratio * contact);
        DampedContact { omega, damping, drive, drive_omega, contact_stiffness, contact_damping }
    };
}

/// The small system of a scene; `None` where it has no table of one.
pub fn small(document: &Document<'_>) -> Result<Option<SmallSystem>, SceneError> {
    let mut given = TABLES.iter().filter(|(table, _)| document.has(table));
    let Some((table, read)) = given.next() else {
        return Ok(None);
    };
    let others = given.map(|(table, _)| *table).chain(joint::TABLES);
    for other in others {
        ensure!(document, !document.has(other) => other, &[];
            "a scene runs one thing, and [{table}] says already what";
            "keep [{table}] or [{other}]");
    }
    let system = read(document.table(table))?;
    check(document, &system)?;
    Ok(Some(system))
}

/// Whether the numbers of a system fit together, and with where it starts.
fn check(document: &Document<'_>, system: &SmallSystem) -> Result<(), SceneError> {
    /// The rise at rest must be over at the belt's speed: what is left of it would damp.
    const RISEN: f64 = 20.0;

    match *system {
        SmallSystem::ImpactOscillator(ImpactOscillator { wall, .. }) => {
            let start = Start::read(document.table("start"))?.position;
            let [start_um, wall_um] = [start, wall].map(|metres| metres * 1e6);
            ensure!(document, start >= wall => "start.position_um", &["impact_oscillator.wall_um"];
                "the mass starts at {start_um} um, behind the wall at {wall_um} um";
                "start it at or above impact_oscillator.wall_um");
        }
        SmallSystem::MassOnBelt(MassOnBelt { mu_s, mu_d, .. }) => {
            ensure!(document, mu_d <= mu_s => "mass_on_belt.mu_d", &["mass_on_belt.mu_s"];
            "it exceeds the static coefficient, {mu_s}: the mass could neither stick nor slide";
            "make it at most mass_on_belt.mu_s")
        }
        SmallSystem::TwoModesOnBelt(TwoModesOnBelt { creep, belt, .. }) => ensure!(document,
            creep * belt >= RISEN => "two_modes_on_belt.creep_slope_s_per_m", &["two_modes_on_belt.belt_mm_per_s"];
            "the coefficient still rises at the belt's speed, and mode coupling needs a constant one";
            "make it at least {:.0}", RISEN / belt),
        SmallSystem::DampedContact(_) => {}
    }
    Ok(())
}
