//! Order and size of the finite elements, by the natural frequencies.

use super::baseline::{Baseline, timed};
use super::{CostError, CostSetting, WorkPrecisionPoint, WorkPrecisionSet};
use crate::fem::{BodyMode, BodyModes, Elements};
use crate::study::OnProgress;

/// Finite elements of one order.
struct Family {
    name: &'static str,
    order: usize,
    /// Element sizes, m, down to where a mesh takes a few tenths of a second.
    sizes: &'static [f64],
}

const FAMILIES: [Family; 4] = [
    Family {
        name: "linear elements",
        order: 1,
        sizes: &[16e-3, 12e-3, 8e-3, 6e-3, 4e-3, 3e-3, 2e-3, 1e-3],
    },
    Family {
        name: "quadratic elements",
        order: 2,
        sizes: &[40e-3, 24e-3, 16e-3, 12e-3, 8e-3, 6e-3, 4e-3, 2e-3],
    },
    Family {
        name: "cubic elements",
        order: 3,
        sizes: &[40e-3, 24e-3, 16e-3, 12e-3, 8e-3, 6e-3, 4e-3],
    },
    Family {
        name: "quartic elements",
        order: 4,
        sizes: &[40e-3, 24e-3, 16e-3, 12e-3, 8e-3, 6e-3, 4e-3],
    },
];

/// The reference, and a second mesh that gives its error. At this order the error is dominated by the corner
/// between beam and ball and is about proportional to the element size; with half the size, the difference of
/// the two is about the error of the finer.
const REFERENCES: [Elements; 2] = [
    Elements {
        size: 8e-3,
        order: *Elements::ORDERS.end(),
    },
    Elements {
        size: 16e-3,
        order: *Elements::ORDERS.end(),
    },
];

/// Orders and sizes of the elements. The frequencies are those of the model, even if the scene prescribes
/// others.
pub(super) fn element_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    let body = baseline.plan.scene.ball_on_beam()?;
    let modes = |elements: &Elements| {
        let modes = BodyModes::solve(&body.geometry, &body.material, elements, &body.families)?;
        Ok::<_, CostError>(modes.modes().to_vec())
    };
    let best = modes(&REFERENCES[0])?;
    let floor = largest_error(&modes(&REFERENCES[1])?, &best);
    let all: usize = FAMILIES.iter().map(|family| family.sizes.len()).sum();
    let mut done = 0;
    let mut sets = Vec::new();
    for &Family { name, order, sizes } in &FAMILIES {
        let mut points = Vec::new();
        for &size in sizes {
            if !should_continue(done as f64 / all as f64) {
                return Ok(None);
            }
            done += 1;
            let (found, seconds) =
                timed(baseline.plan.repeats, || modes(&Elements { size, order }));
            points.push(WorkPrecisionPoint {
                value: 1e3 * size,
                seconds,
                rhs_evals: 0,
                error: found
                    .map(|found| largest_error(&found, &best))
                    .map_err(|error| error.to_string()),
                detail: String::new(),
            });
        }
        sets.push(WorkPrecisionSet {
            setting: CostSetting::Elements,
            family: name.to_owned(),
            parameter: "element size, mm".into(),
            floor: Some(floor),
            points,
        });
    }
    Ok(Some(sets))
}

/// Largest relative error of a natural frequency. Modes are matched by kind, because coarse meshes change
/// their order.
fn largest_error(found: &[BodyMode], best: &[BodyMode]) -> f64 {
    let errors = best.iter().filter_map(|best| {
        let same = |mode: &&BodyMode| (mode.kind, mode.order) == (best.kind, best.order);
        let found = found.iter().find(same)?;
        Some((found.frequency_hz / best.frequency_hz - 1.0).abs())
    });
    errors.fold(0.0, f64::max)
}
