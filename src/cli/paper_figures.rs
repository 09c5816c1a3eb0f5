//! The reproduced figures of the paper.

use super::error::Cause;
use crate::joint::{BallJoint, Friction};
use crate::plot::Figure;
use crate::plot::paper::{
    bifurcation, configuration, embedding, friction_curves, mode_shapes, motion, recurrence_plots,
    sections,
};
use crate::study::paper::{
    EMBEDDING_TILT_DEG, Evidence, FIGURE_TILTS_DEG, Finding, RECURRENCE_TILTS_DEG,
};
use crate::study::sweep::{SweepPlan, SweepPoint};
use crate::text::paper::caption;

/// Number of figures in the paper.
pub(super) const FIGURES: u8 = 11;

/// Draws all available figures, or only one, with their captions.
pub(super) fn figures(
    plan: &SweepPlan,
    points: &[SweepPoint],
    (evidence, findings): (&Evidence, &[Finding]),
    only: Option<u8>,
) -> Result<Vec<Figure>, Cause> {
    let ball = BallJoint::new(&plan.subject.joint()?.spec)?;
    let [first, last] = RECURRENCE_TILTS_DEG;
    // Multiples of 0.2 degrees; the sweep also has 3.5 degrees.
    let mut succession = evidence.between(first, last);
    succession.retain(|(tilt, _)| (5.0 * tilt - (5.0 * tilt).round()).abs() < 1e-6);
    let numbers = (1..=FIGURES).filter(|n| only.is_none_or(|only| only == *n));
    let mut figures = Vec::new();
    for number in numbers {
        let tilt = number
            .checked_sub(4)
            .and_then(|k| FIGURE_TILTS_DEG.get(usize::from(k)));
        let motion = tilt.and_then(|tilt| Some((*tilt, evidence.at(*tilt)?)));
        let figure = match (number, &ball.spec().friction, motion) {
            (1, ..) => {
                let tilt = FIGURE_TILTS_DEG[2].to_radians();
                Some(configuration(&ball, &ball.model(tilt)?, tilt)?)
            }
            (2, ..) => Some(mode_shapes(&ball)?),
            (3, Friction::Stribeck { law, .. }, _) if law.mu_s != law.mu_d => {
                let velocity = ball.sliding_velocity(FIGURE_TILTS_DEG[2].to_radians());
                let sliding = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
                Some(friction_curves(law, sliding))
            }
            (4..=7, _, Some((tilt, response))) => {
                let modes = ball.model(tilt.to_radians())?.explained_modes()?;
                Some(self::motion(number.into(), tilt, response, &modes))
            }
            (8, ..) => {
                let chosen = evidence.embedding.as_ref();
                chosen.map(|(choice, dt)| embedding(EMBEDDING_TILT_DEG, choice, *dt))
            }
            (9, ..) => Some(recurrence_plots(&succession)),
            (10, ..) => Some(sections(&succession)),
            (11, ..) => Some(bifurcation(plan, points)),
            _ => None,
        };
        figures.extend(figure.map(|figure| Figure {
            caption: caption(number, motion, findings),
            ..figure
        }));
    }
    Ok(figures)
}
