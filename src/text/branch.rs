//! Text of branches of periodic orbits, next to the plots of a recording.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::number::{fixed, quantity, short};
use crate::report::Table;
use crate::scene::Parameter;
use crate::study::branch::{Branch, OrbitPoint};
use crate::text::capitalize;

/// Largest number of multipliers listed.
const MULTIPLIERS: usize = 8;

/// Name of the parameter without its unit, such as `tilt`, as in a sweep.
pub fn parameter(branch: &Branch) -> String {
    let parameter = Parameter::named(&branch.parameter);
    parameter.map_or_else(|_| branch.name().to_owned(), Parameter::label)
}

/// The description of an orbit (Markdown).
pub fn orbit(branch: &Branch, point: &OrbitPoint) -> String {
    let orbit = &point.orbit;
    let mut text = format!(
        "# {} {} {}\n\n{} orbit at **{}**, amplitude {}.\n\n",
        capitalize(&parameter(branch)),
        short(point.at.value),
        branch.unit,
        if orbit.stable {
            "Attracting"
        } else {
            "Repelling"
        },
        quantity(orbit.frequency_hz(), 5, "Hz"),
        quantity(orbit.amplitude, 4, "m"),
    );
    if !orbit.stable {
        let _ = writeln!(
            text,
            "{} multipliers are outside the unit circle.\n",
            orbit.unstable_multipliers
        );
    }
    if let Some([_, second]) = orbit.torus_frequencies_hz() {
        let _ = writeln!(
            text,
            "The motion beside the orbit turns around it at {}: a second tone grows.\n",
            quantity(second, 4, "Hz")
        );
    }
    let table = Table::of(orbit.multipliers.iter().take(MULTIPLIERS))
        .right("magnitude", |it| fixed(it.magnitude(), 6))
        .right("turns per period", |it| fixed(it.angle.abs() / TAU, 5))
        .right("growth, 1/s", |it| {
            fixed(it.growth_per_s(orbit.period_s), 2)
        });
    text += &table.markdown();
    if let Some(error) = orbit.trivial_multiplier_error {
        let _ = writeln!(text, "\nError of the multipliers: {error:.0e}.");
    }
    text
}

/// The description of the recording (Markdown).
pub fn about(branch: &Branch) -> String {
    let mut text = format!(
        "# Branches of periodic orbits over {}\n\nFrom {} to {} {}. An orbit attracts if all its multipliers, except the one \
         at 1, are inside the unit circle. Where one leaves, the motion changes: through 1 at a fold, through -1 at a \
         period doubling, as a complex pair at a Neimark-Sacker point, where a torus is born.\n\n",
        parameter(branch),
        branch.interval[0],
        branch.interval[1],
        branch.unit
    );
    for reason in &branch.ended {
        let _ = writeln!(text, "* {reason}");
    }
    text.push('\n');
    text
}
