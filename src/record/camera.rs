//! The camera of the contact patch: perpendicular to the ball, at the centre of the region that the patch
//! covers during the run.

use nalgebra::{Rotation3, Unit, Vector3};

use crate::pipeline::message::JointInfo;

/// Largest tilt that is kept in view if the tilt is set interactively, rad.
const INTERACTIVE_TILT: f64 = 0.09;

/// Centre of the view and directions of the screen, in the frame of the ball centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Camera {
    /// Point of the ball at the centre of the view, mm.
    pub middle: [f64; 3],
    /// Half-width of the region that the patch covers, mm.
    pub reach: f64,
    /// Unit vectors to the right, upwards and towards the camera.
    axes: [[f64; 3]; 3],
}

impl Camera {
    /// A camera for the tilts of a run.
    ///
    /// The beam axis (tilt zero) is kept in view unless the patch is always far from it.
    pub fn new(joint: &JointInfo) -> Self {
        // Half the angle subtended by the patch at the ball centre, rad.
        let half = (joint.patch_radius / joint.ball_radius).min(1.0).asin();
        let (mut low, mut high) = (joint.min_tilt - half, joint.max_tilt + half);
        if let Some([least, most]) = joint.tilt_range {
            // The whole interactive range would need too large a distance.
            low = low.min(least.max(-INTERACTIVE_TILT));
            high = high.max(most.min(INTERACTIVE_TILT));
        }
        // A margin for the mark of the beam axis.
        if low < 2.0 * half {
            low = low.min(-0.2 * half);
        }
        if high > -2.0 * half {
            high = high.max(0.2 * half);
        }
        let turn = |v| turned(v, 0.5 * (low + high), joint.azimuth);
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(turn);
        let radius = 1e3 * joint.ball_radius;
        let quarter = std::f64::consts::FRAC_PI_2;
        Self {
            middle: axes[2].map(|c| radius * c),
            reach: radius * (0.5 * (high - low)).min(quarter).sin(),
            axes,
        }
    }

    /// The point at `right`, `up` and `near` relative to the centre, in units of the half-width, mm.
    pub fn point(&self, [right, up, near]: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| {
            let [x, y, z] = self.axes.map(|axis| axis[i]);
            self.middle[i] + self.reach * (right * x + up * y + near * z)
        })
    }

    /// The unit vector upwards on the screen.
    pub fn up(&self) -> [f64; 3] {
        self.axes[1]
    }
}

/// `v` rotated by `angle` from the beam axis towards `azimuth` (rad), about the axis perpendicular to both. The directions
/// right and up have the same sense for every azimuth.
fn turned(v: [f64; 3], angle: f64, azimuth: f64) -> [f64; 3] {
    let axis = Unit::new_unchecked(Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0));
    (Rotation3::from_axis_angle(&axis, angle) * Vector3::from(v)).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::demo;

    fn camera(tilts: [f64; 2], azimuth: f64) -> Camera {
        let [min_tilt, max_tilt] = tilts.map(f64::to_radians);
        Camera::new(&JointInfo {
            min_tilt,
            max_tilt,
            azimuth,
            ..demo::joint()
        })
    }

    #[test]
    fn the_centre_is_the_middle_of_the_covered_region() {
        let joint = demo::joint();
        let (half, radius) = (
            (joint.patch_radius / joint.ball_radius).asin(),
            1e3 * joint.ball_radius,
        );
        for azimuth in [0.0, 2.0, -1.3] {
            let view = camera([0.0, 8.0], azimuth);
            let tilt = 4f64.to_radians();
            let expected = [
                tilt.sin() * azimuth.cos(),
                tilt.sin() * azimuth.sin(),
                tilt.cos(),
            ];
            for (found, expected) in view.middle.iter().zip(expected) {
                assert!((found - radius * expected).abs() < 1e-12 * radius);
            }
            assert!((view.reach - radius * (tilt + half).sin()).abs() < 1e-12 * radius);
        }
    }

    #[test]
    fn the_beam_axis_is_in_view_unless_far_away() {
        for (tilts, near) in [
            ([0.0, 6.0], true),
            ([12.0; 2], true),
            ([-12.0; 2], true),
            ([40.0; 2], false),
        ] {
            let view = camera(tilts, 0.7);
            let pole = [0.0, 0.0, 1e3 * demo::joint().ball_radius];
            let from_middle = (0..3)
                .map(|i| (pole[i] - view.middle[i]).powi(2))
                .sum::<f64>();
            assert_eq!(from_middle.sqrt() < view.reach, near, "{tilts:?}");
        }
    }

    #[test]
    fn screen_axes_are_orthonormal_and_upright_at_the_beam_axis() {
        let view = camera([0.0, 0.0], 1.0);
        assert_eq!(
            view.axes,
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        );
        let axes = camera([5.0, 30.0], 2.5).axes;
        for i in 0..3 {
            for j in 0..3 {
                let dot: f64 = (0..3).map(|k| axes[i][k] * axes[j][k]).sum();
                assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
