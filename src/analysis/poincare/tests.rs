use super::*;
use std::f64::consts::TAU;

#[test]
fn probe() {
    for reach_level in [0.0, 0.5, 0.9] {
        for period in [16.0, 24.0, 50.0, 200.0] {
            let n = 4000;
            let f = 1.0 / (period + 0.1234);
            let x: Vec<f64> = (0..n).map(|i| (TAU * f * i as f64 + 0.3).sin()).collect();
            let c = plane_section(&[&x], &[1.0], reach_level, Direction::Rising).unwrap();
            let mut worst: f64 = 0.0;
            let ph = (reach_level as f64).asin() - 0.3;
            for c in c
                .iter()
                .filter(|c| c.sample > 20.0 && c.sample < n as f64 - 20.0)
            {
                let k = (f * c.sample - ph / TAU).round();
                let exact = (k + ph / TAU) / f;
                worst = worst.max((c.sample - exact).abs());
            }
            println!("L {reach_level} {period} {worst:e} {}", c.len());
        }
        for dev in [1e-3, 1e-2] {
            let period = 50.1;
            let n = 400_000;
            let f = 1.0 / period;
            let e = crate::analysis::test_signals::noise(1, n, dev);
            let x: Vec<f64> = (0..n)
                .map(|i| (TAU * f * i as f64 + 0.3).sin() + e[i])
                .collect();
            let c = plane_section(&[&x], &[1.0], reach_level, Direction::Rising).unwrap();
            let (mut s, mut l) = (0.0, 0.0);
            let ph = (reach_level as f64).asin() - 0.3;
            for c in &c {
                let k = (f * c.sample - ph / TAU).round();
                let exact = (k + ph / TAU) / f;
                s += (c.sample - exact).powi(2);
                let i = c.sample as usize;
                let lin = i as f64 + (x[i] - reach_level) / (x[i] - x[i + 1]);
                l += (lin - exact).powi(2);
            }
            println!("L noise {dev} ratio {} n {}", (s / l).sqrt(), c.len());
        }
    }
}
