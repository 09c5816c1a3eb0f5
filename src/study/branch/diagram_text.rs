//! What happens at a bifurcation over the tilt, in one sentence.

use super::hopf::{SteadyBifurcation, SteadyBifurcationKind};
use crate::dynamics::continuation::{Bifurcation, BifurcationKind, Criticality};
use crate::number::{quantity, significant};
use crate::text::capitalize;

/// What happens to a periodic motion.
pub(super) fn orbit_sentence(found: &Bifurcation) -> String {
    let tone = format!("the tone of {}", quantity(found.frequency_hz, 4, "Hz"));
    let tilt = degrees(found.parameter);
    if !found.has_stable_side() {
        let point = match found.kind {
            BifurcationKind::NeimarkSacker => " point",
            _ => "",
        };
        return format!(
            "At {tilt}, {tone}, which repels on both sides, has a {}{point}: the settled motion does not change.",
            found.kind
        );
    }
    let jumps = found
        .birth
        .is_some_and(|birth| birth.criticality == Criticality::Subcritical);
    match found.kind {
        BifurcationKind::Fold => {
            let side = match found.fold_curvature {
                Some(curvature) if curvature > 0.0 => "above",
                _ => "below",
            };
            format!(
                "{} exists only {side} {tilt} (fold): beyond, the motion jumps to another one.",
                capitalize(&tone)
            )
        }
        BifurcationKind::PeriodDoubling | BifurcationKind::NeimarkSacker if jumps => format!(
            "When the tilt {}, {tone} becomes unstable and the motion jumps to another one (subcritical {}).",
            passes(found.crossing_rate, &tilt),
            match found.kind {
                BifurcationKind::PeriodDoubling => "period doubling",
                _ => "Neimark-Sacker point",
            },
        ),
        BifurcationKind::PeriodDoubling => format!(
            "When the tilt {}, {tone} becomes unstable and the motion repeats only every second period: a line appears \
             at {} (period doubling).",
            passes(found.crossing_rate, &tilt),
            quantity(0.5 * found.frequency_hz, 4, "Hz"),
        ),
        BifurcationKind::NeimarkSacker => format!(
            "When the tilt {}, {tone} becomes unstable and a second tone grows {} beside it: the motion becomes a torus \
             (Neimark-Sacker point).",
            passes(found.crossing_rate, &tilt),
            quantity(found.torus_frequency_hz.unwrap_or(f64::NAN), 4, "Hz"),
        ),
        BifurcationKind::BranchPoint | BifurcationKind::SymmetryBreaking => {
            format!(
                "At {tilt}, another periodic motion crosses {tone} and may take over its stability."
            )
        }
        BifurcationKind::Grazing => format!(
            "At {tilt}, a contact node of {tone} just touches zero pressure: its sequence of separations changes."
        ),
    }
}

/// What happens to steady sliding.
pub(super) fn steady_sentence(found: &SteadyBifurcation) -> String {
    let tilt = degrees(found.at.value);
    if found.kind == SteadyBifurcationKind::ZeroEigenvalue {
        return format!("At {tilt}, steady sliding loses its balance without vibration.");
    }
    let criticality = found.cycle.as_ref().map(|cycle| cycle.criticality);
    let birth = match criticality {
        Some(Criticality::Supercritical) => ": its squeak starts softly",
        Some(Criticality::Subcritical) => ": its squeak starts with a jump",
        Some(Criticality::Undetermined) | None => "",
    };
    format!(
        "When the tilt {}, steady sliding becomes unstable in the mode {} at {} ({}){birth}.",
        passes(found.crossing_speed, &tilt),
        found.label,
        quantity(found.frequency_hz, 4, "Hz"),
        found.kind,
    )
}

/// How the tilt passes a bifurcation beyond which a motion is unstable, by the rate of its growth with the tilt.
fn passes(rate: Option<f64>, tilt: &str) -> String {
    match rate {
        Some(rate) if rate > 0.0 => format!("rises above {tilt}"),
        Some(_) => format!("falls below {tilt}"),
        None => format!("passes {tilt}"),
    }
}

fn degrees(tilt: f64) -> String {
    format!("{} degrees", significant(tilt, 4))
}
