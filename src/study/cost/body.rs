//! The knob of the finite elements: their size, by the natural frequencies.

use super::{CostError, CostPoint, CostSet, Ground, Knob, timed};
use crate::joint::{BallJoint, Frequencies};

/// Sizes tried, m, and of the reference and the other one that tells its own error.
const SIZES: [f64; 7] = [40e-3, 24e-3, 16e-3, 12e-3, 8e-3, 6e-3, 4e-3];
const REFERENCES: [f64; 2] = [2e-3, 2.5e-3];

/// Sizes of the elements. Their order is two, always.
pub(super) fn element_sets(
    ground: &mut Ground<'_>,
    goes_on: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let mut spec = ground.plan.scene.joint()?.spec.clone();
    spec.body.frequencies = Frequencies::FiniteElement;
    let mut frequencies = |size: f64| {
        spec.body.element_size = size;
        Ok::<_, CostError>(BallJoint::new(&spec)?.frequencies_hz().to_vec())
    };
    let off = |found: &[f64], best: &[f64]| {
        let pairs = found.iter().zip(best);
        pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
    };
    let best = frequencies(REFERENCES[0])?;
    let floor = off(&frequencies(REFERENCES[1])?, &best);
    let mut points = Vec::new();
    for (k, size) in SIZES.into_iter().enumerate() {
        if !goes_on(k as f64 / SIZES.len() as f64) {
            return Ok(None);
        }
        let (found, seconds) = timed(ground.plan.repeats, || frequencies(size));
        points.push(CostPoint {
            value: 1e3 * size,
            seconds,
            calls: 0,
            error: found
                .map(|found| off(&found, &best))
                .map_err(|error| error.to_string()),
        });
    }
    Ok(Some(vec![CostSet {
        knob: Knob::Elements,
        family: "quadratic elements".to_owned(),
        turned: "size, mm",
        floor: Some(floor),
        points,
    }]))
}
