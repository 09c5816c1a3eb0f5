//! Table of the friction law of a joint.

use std::sync::Arc;

use strum::{EnumString, IntoStaticStr, VariantArray};

use super::knots::{Curve, MAX_POINTS};
use crate::joint::{DynamicFriction, Friction, FrictionTable, LuGre, RateAndState, Stribeck};
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schema::kind::Range::{Closed, Positive};
use crate::scene::schema::kind::{Kind, choice, flag, number, tables, text};
use crate::scene::schema::unit::*;
use crate::scene::schema::{IfAbsent, Key, Schema, keys};

/// Range of coefficients of friction.
pub const COEFFICIENT: Kind<f64> = number(ONE, Closed(0.0, 10.0));

/// Range of the slope factor of the creep region.
pub const CREEP: Kind<f64> = number(SECOND_PER_METRE, Positive(1e8));

pub fn declare(schema: &mut Schema) {
    Friction::declare(schema, "friction");
    CURVE.declare(schema);
    schema.add(CURVE.table, &CURVE_FILE);
}

/// Names of the friction laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray, IntoStaticStr, EnumString)]
#[strum(serialize_all = "kebab-case")]
enum Law {
    /// Eq. (5).
    Stribeck,
    /// A constant coefficient, smoothed at rest.
    Constant,
    /// A measured curve.
    Table,
    /// Elastic bristles.
    Lugre,
    /// Friction that depends on the age of the contact.
    RateAndState,
    /// No friction.
    None,
}

keys! {
    Friction |table| {
        /// Friction law: Eq. (5), a constant coefficient, a measured curve, LuGre friction (elastic bristles), rate-and-state friction (age of the contact), or none, which is equivalent to omitting the table.
        law = "law": choice::<Law>(), default "stribeck";
        /// Coefficient of friction.
        mu = "mu": COEFFICIENT, with ["constant"];
        /// Static coefficient of friction.
        mu_s = "mu_s": COEFFICIENT, with ["stribeck", "lugre"];
        /// Kinetic coefficient of friction; usually at most the static one.
        mu_d = "mu_d": COEFFICIENT, with ["stribeck", "lugre"];
        /// Slope factor of the creep region, `d` of Eq. (5); a larger value gives a steeper increase near zero slip.
        creep = "creep_slope_s_per_m": CREEP, default 1000, with ["stribeck", "constant", "table"];
        /// Slope factor of the sliding region, `f` of Eq. (5); a larger value gives a steeper decrease.
        stribeck = "stribeck_slope_s_per_m": number(SECOND_PER_METRE, Closed(0.0, 1e6)), default 10, with ["stribeck", "lugre"];
        /// Stiffness of the bristles divided by the normal force, `sigma_0`.
        stiffness = "bristle_stiffness_per_m": number(PER_METRE, Positive(1e9)), with ["lugre"];
        /// Damping of the bristles divided by the normal force, `sigma_1`.
        damping = "bristle_damping_s_per_m": number(SECOND_PER_METRE, Closed(0.0, 1e4)), else "0, with `lugre`", with ["lugre"];
        /// Viscous friction divided by the normal force, `sigma_2`.
        viscous = "viscous_s_per_m": number(SECOND_PER_METRE, Closed(0.0, 1e4)), else "0, with `lugre`", with ["lugre"];
        /// Coefficient of friction of steady sliding at the reference speed.
        mu_0 = "mu_0": COEFFICIENT, with ["rate-and-state"];
        /// Direct effect `a`: change of the coefficient at once per factor e of the slip speed.
        direct = "direct_effect": number(ONE, Positive(1.0)), with ["rate-and-state"];
        /// Evolution effect `b`: opposite change after the slip distance; larger than the direct effect for a coefficient that falls with the speed.
        evolution = "evolution_effect": number(ONE, Closed(0.0, 1.0)), with ["rate-and-state"];
        /// Reference speed `V_0`.
        reference_speed = "reference_speed_m_per_s": number(METRE_PER_SECOND, Closed(1e-9, 1e3)), with ["rate-and-state"];
        /// Slip distance `D_c` over which the contact renews its age.
        distance = "slip_distance_um": number(MICROMETRE, Closed(1e-3, 1e5)), with ["rate-and-state"];
        /// Whether the radial component of the friction force in Eq. (8) is included.
        radial = "radial": flag(), default true;
    } => {
        table.reject_unused("law", law.into())?;
        match law {
            Law::Stribeck => {
                let (mu_s, mu_d) = (table.needed("mu_s", mu_s)?, table.needed("mu_d", mu_d)?);
                Friction::Stribeck { law: Stribeck { mu_s, mu_d, creep, stribeck }, radial }
            }
            Law::Constant => {
                Friction::Stribeck { law: Stribeck::constant(table.needed("mu", mu)?, creep), radial }
            }
            Law::Table => {
                let law = FrictionTable::new(friction_points(table.document)?, creep);
                // In range and in order, they can still be too close together.
                let law = law.ok_or_else(|| {
                    let problem = "two speeds are so close that the slope between them is not finite";
                    table.inconsistent(CURVE.list.name, &[], problem, "remove one of the two points")
                })?;
                Friction::Table { law: Arc::new(law), radial }
            }
            Law::Lugre => {
                let law = LuGre {
                    mu_s: positive(table, "mu_s", mu_s)?,
                    mu_d: positive(table, "mu_d", mu_d)?,
                    stribeck,
                    stiffness: table.needed("bristle_stiffness_per_m", stiffness)?,
                    damping: damping.unwrap_or(0.0),
                    viscous: viscous.unwrap_or(0.0),
                };
                Friction::Dynamic { law: DynamicFriction::LuGre(law), radial }
            }
            Law::RateAndState => {
                let law = RateAndState {
                    mu_0: positive(table, "mu_0", mu_0)?,
                    direct: table.needed("direct_effect", direct)?,
                    evolution: table.needed("evolution_effect", evolution)?,
                    reference_speed: table.needed("reference_speed_m_per_s", reference_speed)?,
                    distance: table.needed("slip_distance_um", distance)?,
                };
                ensure!(table, law.mu_0 <= MOST_DIRECT * law.direct => "direct_effect", &["mu_0"];
                    "the coefficient is more than {MOST_DIRECT} times the direct effect";
                    "increase the direct effect");
                Friction::Dynamic { law: DynamicFriction::RateAndState(law), radial }
            }
            Law::None => Friction::None,
        }
    };
}

/// Largest ratio of the coefficient to the direct effect; beyond it numbers would overflow.
const MOST_DIRECT: f64 = 300.0;

/// A required coefficient that must not be zero.
fn positive(table: Table<'_>, name: &'static str, given: Option<f64>) -> Result<f64, SceneError> {
    let number = table.needed(name, given)?;
    ensure!(table, number > 0.0 => name, &["law"];
        "the selected law needs a positive coefficient";
        "increase it");
    Ok(number)
}

keys! {
    /// Measured friction curve: a smooth curve through these points, monotone between them and constant before the first and after the last. It is multiplied by the creep factor of Eq. (5), so that the friction vanishes at zero speed.
    static CURVE_POINTS: usize = "points": tables(MAX_POINTS), else ONE_CURVE, with ["table"];
    /// Slip speed of the point; higher than that of the previous point.
    static SPEED: f64 = "speed_m_per_s": number(METRE_PER_SECOND, Closed(0.0, 1e3));
    /// Coefficient of friction at this speed.
    static MU: f64 = "mu": COEFFICIENT;
    /// Measured friction curve as points from a CSV file, relative to the folder of the scene file: the line `speed_m_per_s,mu`, then one point on each line.
    static CURVE_FILE: String = "points_csv": text(), else ONE_CURVE, with ["table"];
}

/// The measured friction curve.
pub static CURVE: Curve = Curve {
    table: "friction",
    list: &CURVE_POINTS,
    point: [&SPEED, &MU],
    order: ["speed", "higher"],
};

const ONE_CURVE: &str = "exactly one of `points` and `points_csv` with `table`";

/// Reads the points of the measured friction curve: slip speed (m/s) and coefficient.
fn friction_points(document: &Document<'_>) -> Result<Vec<[f64; 2]>, SceneError> {
    let table = document.table(CURVE.table);
    let [list, file] = [CURVE.list.name, CURVE_FILE.name];
    ensure!(table, !(table.has(list) && table.has(file)) => file, &[list];
        "the scene gives the friction curve more than once";
        "keep one of friction.{list} and friction.{file}");
    // A file has been replaced by its points.
    table.needed(list, table.has(list).then_some(()))?;
    CURVE.points(document)
}
