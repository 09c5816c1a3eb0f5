//! Where the contact patch is looked at from: square onto the ball, at the middle of all the
//! places that the patch visits during the run.

use crate::pipeline::message::JointInfo;

/// The tilts that are kept in view where the load is tilted by hand, rad.
const STEERED: f64 = 0.09;

/// The view's middle and the directions of its screen, in the frame of the ball's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vantage {
    /// Point of the ball in the middle of what the patch visits, mm.
    pub middle: [f64; 3],
    /// Half the width of what the patch visits, mm.
    pub reach: f64,
    /// Unit vectors to the right, upwards and towards the onlooker.
    axes: [[f64; 3]; 3],
}

impl Vantage {
    /// For the tilts that a run plans.
    ///
    /// The beam's axis (tilt zero) is kept in sight unless the patch is always far from it.
    pub fn new(joint: &JointInfo) -> Self {
        let half = patch_angle(joint);
        let (mut low, mut high) = (joint.min_tilt - half, joint.max_tilt + half);
        if let Some([least, most]) = joint.reach {
            // Where it may be tilted by hand, most of that: all of it would be seen from too far.
            low = low.min(least.max(-STEERED));
            high = high.max(most.min(STEERED));
        }
        // A little more than the pole itself, for its mark.
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

    /// The point that lies `right`, `up` and `near` of the middle, in units of the reach, mm.
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

/// Half the angle under which the patch is seen from the ball's centre, rad.
pub fn patch_angle(joint: &JointInfo) -> f64 {
    (joint.patch_radius / joint.ball_radius).min(1.0).asin()
}

/// `v` turned by `angle` from the pole towards `azimuth` (rad), about the axis square to both:
/// the formula of Rodrigues. Right and upwards keep their sense for every azimuth.
fn turned(v: [f64; 3], angle: f64, azimuth: f64) -> [f64; 3] {
    let axis = [-azimuth.sin(), azimuth.cos(), 0.0];
    let along: f64 = (0..3).map(|i| axis[i] * v[i]).sum();
    let (sin, cos) = angle.sin_cos();
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let cross = axis[j] * v[k] - axis[k] * v[j];
        cos * v[i] + sin * cross + (1.0 - cos) * along * axis[i]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::demo;

    fn vantage(tilts: [f64; 2], azimuth: f64) -> Vantage {
        let [min_tilt, max_tilt] = tilts.map(f64::to_radians);
        Vantage::new(&JointInfo {
            min_tilt,
            max_tilt,
            azimuth,
            ..demo::joint()
        })
    }

    #[test]
    fn the_middle_lies_between_the_ends_of_the_patchs_way() {
        let joint = demo::joint();
        let (half, radius) = (patch_angle(&joint), 1e3 * joint.ball_radius);
        for azimuth in [0.0, 2.0, -1.3] {
            let seen = vantage([0.0, 8.0], azimuth);
            let tilt = 4f64.to_radians();
            let expected = [
                tilt.sin() * azimuth.cos(),
                tilt.sin() * azimuth.sin(),
                tilt.cos(),
            ];
            for (found, expected) in seen.middle.iter().zip(expected) {
                assert!((found - radius * expected).abs() < 1e-12 * radius);
            }
            assert!((seen.reach - radius * (tilt + half).sin()).abs() < 1e-12 * radius);
        }
    }

    #[test]
    fn the_pole_is_in_sight_unless_far_away() {
        for (tilts, near) in [
            ([0.0, 6.0], true),
            ([12.0; 2], true),
            ([-12.0; 2], true),
            ([40.0; 2], false),
        ] {
            let seen = vantage(tilts, 0.7);
            let pole = [0.0, 0.0, 1e3 * demo::joint().ball_radius];
            let from_middle = (0..3)
                .map(|i| (pole[i] - seen.middle[i]).powi(2))
                .sum::<f64>();
            assert_eq!(from_middle.sqrt() < seen.reach, near, "{tilts:?}");
        }
    }

    #[test]
    fn screen_axes_are_orthonormal_and_upright_at_the_pole() {
        let seen = vantage([0.0, 0.0], 1.0);
        assert_eq!(
            seen.axes,
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        );
        let axes = vantage([5.0, 30.0], 2.5).axes;
        for i in 0..3 {
            for j in 0..3 {
                let dot: f64 = (0..3).map(|k| axes[i][k] * axes[j][k]).sum();
                assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
    }
}
