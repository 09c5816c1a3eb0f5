//! The range of tilts that a session offers.

use crate::scene::Scene;

/// Range of tilts, degrees, if the scene itself does not exceed it. It is smaller if the patch would leave
/// the ball.
const TILT_RANGE_DEG: [f64; 2] = [0.0, 10.0];

/// Range of tilts, degrees: the union of the range of the scene and [`TILT_RANGE_DEG`], as far as the patch
/// stays on the ball.
pub(super) fn tilt_range_deg(scene: &Scene) -> Option<[f64; 2]> {
    let tilt = &scene.joint().ok()?.tilt;
    let own = [tilt.min(), tilt.max()].map(f64::to_degrees);
    let fits = |deg: f64| scene.clone().with_tilt(deg).is_ok();
    // In steps of 0.5 degrees from the range of the scene, which is valid.
    let extend = |own: f64, end: f64| {
        let steps = ((end - own).abs() / 0.5).ceil() as u32;
        let at = |k: u32| match k == steps {
            true => end,
            false => own + 0.5 * f64::from(k) * (end - own).signum(),
        };
        (0..=steps)
            .map(at)
            .take_while(|deg| fits(*deg))
            .last()
            .unwrap_or(own)
    };
    Some([
        extend(own[0], own[0].min(TILT_RANGE_DEG[0])),
        extend(own[1], own[1].max(TILT_RANGE_DEG[1])),
    ])
}
