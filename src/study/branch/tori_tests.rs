use std::f64::consts::TAU;

use super::*;
use crate::dynamics::continuation::FamilyError;
use crate::dynamics::{Differentiable, System};

/// Angular frequency of the drive, rad/s.
const DRIVE: f64 = 3.0;

/// `z' = (1 + i w) z - |z|^2 z + e conj(z)^2 exp(3 i t)`. In the frame that turns with a third of the drive it is
/// autonomous. Its equilibria obey `(1 - s)^2 + (w - 1)^2 = e^2 s` with `s = |z|^2`, and exist up to
/// `|w - 1| = e sqrt(1 + e^2 / 4)`: the borders of the tongue 1:3. Without the drive the rotation number is `w / 3`.
struct Driven {
    omega: f64,
    drive: f64,
}

impl System for Driven {
    fn omega(&self) -> &[f64] {
        &[]
    }

    fn first_order(&self) -> usize {
        2
    }

    fn force(&self, t: f64, w: &[f64], out: &mut [f64]) {
        let [x, y] = [w[0], w[1]];
        let (sin, cos) = (DRIVE * t).sin_cos();
        let growth = 1.0 - x * x - y * y;
        let [a, b] = [x * x - y * y, -2.0 * x * y];
        out[0] = growth * x - self.omega * y + self.drive * (a * cos - b * sin);
        out[1] = growth * y + self.omega * x + self.drive * (a * sin + b * cos);
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        false
    }
}

impl Differentiable for Driven {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let [t, x, y] = *record else {
            unreachable!("the record is the time and the state")
        };
        let (sin, cos) = (DRIVE * t).sin_cos();
        let growth = 1.0 - x * x - y * y;
        for l in 0..width {
            let [dx, dy] = [vectors[l], vectors[width + l]];
            let change = -2.0 * (x * dx + y * dy);
            let [da, db] = [2.0 * (x * dx - y * dy), -2.0 * (x * dy + y * dx)];
            out[l] =
                growth * dx + change * x - self.omega * dy + self.drive * (da * cos - db * sin);
            out[width + l] =
                growth * dy + change * y + self.omega * dx + self.drive * (da * sin + db * cos);
        }
    }
}

/// The systems over their frequency.
struct OverFrequency {
    drive: f64,
}

impl Family for OverFrequency {
    fn member(&self, omega: f64) -> Result<FamilyMember, FamilyError> {
        let drive = self.drive;
        Ok(FamilyMember {
            system: Box::new(Driven { omega, drive }),
            drive_period: Some(TAU / DRIVE),
            observable: vec![1.0],
        })
    }
}

/// The torus of a drive over some frequencies.
fn torus(drive: f64, values: &[f64]) -> Torus {
    let method = MethodName::Dop853.with(Accuracy::relative(1e-10), 0.5);
    let options = ContinuationOptions {
        method,
        ..ContinuationOptions::new([0.5, 1.5], 0.5)
    };
    let family = OverFrequency { drive };
    let study = TorusStudy {
        family: &family,
        name: "omega",
        options: &options,
        method,
        state: vec![0.9, 0.1],
        frequencies_hz: [DRIVE / TAU, values[0] / TAU],
    };
    let mut torus = Torus {
        branch: 0,
        born: 0.0,
        points: Vec::new(),
        tongues: Vec::new(),
        ended: None,
    };
    torus.ended = study.follow(values, &mut torus, &mut |_, _| Ok(())).err();
    torus
}

/// At 0.9 the rotation number is 3/10, but nothing attracts to a phase: the motion is not locked.
#[test]
fn a_torus_without_coupling_has_its_exact_rotation_number_and_is_never_locked() {
    let torus = torus(0.0, &[0.87, 0.9, 0.9321, 0.97]);
    assert_eq!((torus.points.len(), &torus.ended), (4, &None));
    for point in &torus.points {
        assert_eq!(point.kind, TorusKind::Torus, "{point:?}");
        let exact = point.at.value / DRIVE;
        let off = (point.rotation_number.unwrap() - exact).abs();
        assert!(off < 1e-7, "{point:?} {exact}");
        assert!(point.rotation_number_error.unwrap() < 1e-6, "{point:?}");
    }
    assert!(torus.tongues.is_empty());
}

#[test]
fn the_tongue_of_a_third_of_the_drive_has_the_borders_of_its_closed_form() {
    let drive = 0.2_f64;
    let border = drive * (1.0 + 0.25 * drive * drive).sqrt();
    let torus = torus(drive, &[0.76, 0.78, 0.81, 0.9, 1.0, 1.15, 1.22, 1.25]);
    assert_eq!(torus.points.len(), 8, "{torus:?}");
    for point in &torus.points {
        let is_inside = (point.at.value - 1.0).abs() < border;
        let expected = if is_inside {
            (TorusKind::Locked, Some([1, 3]))
        } else {
            (TorusKind::Torus, None)
        };
        assert_eq!((point.kind, point.locking), expected, "{point:?}");
    }
    let rotations: Vec<f64> = torus
        .points
        .iter()
        .filter_map(|p| p.rotation_number)
        .collect();
    assert!(rotations.is_sorted());
    let [tongue] = &torus.tongues[..] else {
        panic!("{:?}", torus.tongues);
    };
    let [low, high] = tongue.borders.map(Option::unwrap);
    assert!((low - (1.0 - border)).abs() < 1e-8, "{low} {border}");
    assert!((high - (1.0 + border)).abs() < 1e-8, "{high} {border}");
}

#[test]
fn lines_at_halves_of_the_combinations_double_a_torus() {
    let rate = 40.0 * 4111.3;
    let signal = |half: f64| -> Vec<f64> {
        let tone = |f: f64, t: f64| (TAU * f * t + 0.3 * f).sin();
        let [f1, f2] = [4111.3, 243.17];
        (0..60_000)
            .map(|k| f64::from(k) / rate)
            .map(|t| {
                let torus = tone(f1, t)
                    + 0.2 * (tone(f1 - f2, t) + tone(f1 + f2, t))
                    + 0.05 * (tone(2.0 * f1, t) + tone(f1 - 2.0 * f2, t));
                let halves = [f1 - 0.5 * f2, f1 + 0.5 * f2, f1 - 1.5 * f2, f1 + 1.5 * f2];
                torus + half * halves.map(|f| tone(f, t)).iter().sum::<f64>()
            })
            .collect()
    };
    for (half, expected) in [(0.0, false), (0.01, true)] {
        let tones = tones_in(&signal(half), rate, [4110.0, 244.0], false).unwrap();
        let [second, _] = tones.second.unwrap();
        assert!((second - 243.17).abs() < 1e-3, "{second}");
        assert_eq!(tones.doubled, expected, "{half}");
    }
}
