use super::*;
use crate::analysis::test_signals::*;
use std::f64::consts::TAU;

fn add(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

fn ar1(seed: u64, n: usize, phi: f64) -> Vec<f64> {
    let mut x = 0.0;
    noise(seed, n + 2000, 1.0)
        .into_iter()
        .map(|e| {
            x = phi * x + e;
            x
        })
        .skip(2000)
        .collect()
}

/// Resonance at `f` cycles a sample with radius r.
fn ar2(seed: u64, n: usize, f: f64, r: f64) -> Vec<f64> {
    let (mut x, mut y) = (0.0, 0.0);
    noise(seed, n + 2000, 1.0)
        .into_iter()
        .map(|e| {
            let z = 2.0 * r * (TAU * f).cos() * x - r * r * y + e;
            y = x;
            x = z;
            z
        })
        .skip(2000)
        .collect()
}

#[test]
fn probe() {
    let mut cat: Vec<(String, &str, Vec<f64>)> = Vec::new();
    let n = std::env::var("N")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(8000);
    let mut put = |name: String, kind: &'static str, x: Vec<f64>| cat.push((name, kind, x));
    for e in [0.0, 1e-3, 1e-2, 5e-2] {
        put(
            format!("sine {e}"),
            "P",
            add(&sines(50., n, &[(1.03, 1., 0.2)]), &noise(1, n, e)),
        );
        put(
            format!("harm {e}"),
            "P",
            add(
                &sines(50., n, &[(1.03, 1., 0.2), (2.06, 0.3, 0.), (3.09, 0.2, 1.)]),
                &noise(2, n, e),
            ),
        );
        put(
            format!("two {e}"),
            "Q",
            add(
                &sines(50., n, &[(1., 1., 0.2), (0.618034, 0.4, 0.)]),
                &noise(3, n, e),
            ),
        );
        put(
            format!("two far {e}"),
            "Q",
            add(
                &sines(50., n, &[(1., 1., 0.2), (std::f64::consts::PI, 0.4, 0.)]),
                &noise(3, n, e),
            ),
        );
        put(
            format!("two close {e}"),
            "Q",
            add(
                &sines(50., n, &[(1., 1., 0.2), (1.0718, 0.4, 0.)]),
                &noise(3, n, e),
            ),
        );
        put(
            format!("two faint {e}"),
            "Q",
            add(
                &sines(50., n, &[(1., 1., 0.2), (0.618034, 0.05, 0.)]),
                &noise(3, n, e),
            ),
        );
        put(
            format!("two nonl {e}"),
            "Q",
            add(
                &sines(50., n, &[(1., 1., 0.2), (0.618034, 0.6, 0.)])
                    .iter()
                    .map(|x| x + 0.4 * x * x - 0.2 * x * x * x)
                    .collect::<Vec<_>>(),
                &noise(3, n, e),
            ),
        );
        put(
            format!("am {e}"),
            "Q",
            add(
                &(0..n)
                    .map(|i| {
                        let t = i as f64 / 50.0;
                        (1.0 + 0.3 * (TAU * 0.0618 * t).sin()) * (TAU * t).sin()
                            + 0.2 * (2.0 * TAU * t + 0.4).sin()
                    })
                    .collect::<Vec<_>>(),
                &noise(3, n, e),
            ),
        );
    }
    put(
        "three tones".into(),
        "Q",
        sines(
            50.,
            n,
            &[(1., 1., 0.2), (0.618034, 0.4, 0.), (0.2723, 0.3, 0.)],
        ),
    );
    for c in [2.5, 3.5, 4.0, 4.15] {
        put(
            format!("roes {c}"),
            "P",
            coordinate(&roessler(n, 0.1, [0.2, 0.2, c], [1., 1., 0.]), 0),
        );
    }
    for c in [4.3, 4.5, 5.0, 5.7, 9.0] {
        put(
            format!("roes {c}"),
            "C",
            coordinate(&roessler(n, 0.1, [0.2, 0.2, c], [1., 1., 0.]), 0),
        );
    }
    put(
        "roes .05 4".into(),
        "P",
        coordinate(&roessler(n, 0.05, [0.2, 0.2, 4.0], [1., 1., 0.]), 0),
    );
    put(
        "roes .05 5.7".into(),
        "C",
        coordinate(&roessler(n, 0.05, [0.2, 0.2, 5.7], [1., 1., 0.]), 0),
    );
    put(
        "roes .2 5.7".into(),
        "C",
        coordinate(&roessler(n, 0.2, [0.2, 0.2, 5.7], [1., 1., 0.]), 0),
    );
    put(
        "roes noisy 5.7".into(),
        "C",
        add(
            &coordinate(&roessler(n, 0.1, [0.2, 0.2, 5.7], [1., 1., 0.]), 0),
            &noise(7, n, 0.1),
        ),
    );
    put(
        "roes noisy 4".into(),
        "P",
        add(
            &coordinate(&roessler(n, 0.1, [0.2, 0.2, 4.0], [1., 1., 0.]), 0),
            &noise(7, n, 0.05),
        ),
    );
    for dt in [0.01, 0.02, 0.04, 0.1] {
        put(
            format!("lor {dt}"),
            "C",
            coordinate(&lorenz(n, dt, [1., 1., 1.]), 0),
        );
    }
    put(
        "lor z".into(),
        "C",
        coordinate(&lorenz(n, 0.02, [1., 1., 1.]), 2),
    );
    put(
        "lor noisy".into(),
        "C",
        add(
            &coordinate(&lorenz(n, 0.02, [1., 1., 1.]), 0),
            &noise(7, n, 0.2),
        ),
    );
    for s in 1..4 {
        put(format!("white {s}"), "N", noise(s, n, 1.0));
    }
    for phi in [0.3, 0.5, 0.8, 0.9, 0.95, 0.99] {
        for s in 1..3 {
            put(format!("ar1 {phi} {s}"), "N", ar1(s, n, phi));
        }
    }
    for (f, r) in [(0.02, 0.9), (0.02, 0.99), (0.02, 0.997), (0.1, 0.95)] {
        put(format!("ar2 {f} {r}"), "N", ar2(5, n, f, r));
    }
    let t = |i: usize| i as f64 / n as f64;
    for g in [-3.0, -1.0, -0.3, 1.0, 4.0, 12.0] {
        put(
            format!("expo {g}"),
            "T",
            (0..n)
                .map(|i| (g * t(i)).exp() * (TAU * 0.02 * i as f64).sin())
                .collect(),
        );
    }
    put(
        "linear fade".into(),
        "T",
        (0..n)
            .map(|i| (1.0 - t(i)) * (TAU * 0.02 * i as f64).sin())
            .collect(),
    );
    put(
        "onset".into(),
        "T",
        (0..n)
            .map(|i| (TAU * 0.02 * i as f64).sin() * (12.0 * (t(i) - 0.5)).exp().min(1.0))
            .collect(),
    );
    for w in [0.05, 0.2, 1.0] {
        put(
            format!("chirp {w}"),
            "T",
            (0..n)
                .map(|i| (TAU * 0.02 * (1.0 + 0.5 * w * t(i)) * i as f64).sin())
                .collect(),
        );
    }
    let kind_filter = std::env::var("K").unwrap_or_default();
    for (name, kind, x) in &cat {
        if !kind_filter.is_empty() && !kind_filter.contains(kind) {
            continue;
        }
        let seen = &x[x.len().saturating_sub(8192)..];
        let (lo, hi) = seen
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| {
                (l.min(x), h.max(x))
            });
        let scaled: Vec<f64> = seen
            .iter()
            .map(|x| (x - lo) / (0.5 * (hi - lo)) - 1.0)
            .collect();
        let s = Signs::of(&scaled, 1.0).unwrap();
        let clock = std::time::Instant::now();
        let v = classify(
            x,
            &RegimeSearch {
                sample_rate: 1.0,
                silence: 0.0,
            },
        )
        .unwrap();
        let ms = clock.elapsed().as_micros() as f64 * 1e-3;
        let short = match v.regime {
            Regime::Periodic => "P",
            Regime::QuasiPeriodic => "Q",
            Regime::Chaotic => "C",
            Regime::Noise => "N",
            Regime::Transient => "T",
            Regime::Unsure => "?",
            Regime::Silent => "S",
        };
        println!(
            "M {} {kind} -> {short} {:.2} {name:16} {ms:.1} ms | {} || env {:+.3}/{:.1} tempo {:?} floor {:.1e} F {:.1} {:?} {:?}/{} near {:.3} lin {:.3} far {:.3} K {:?} lyap {:?} turns {:.0}",
            if short == *kind {
                "ok "
            } else if short == "?" {
                "???"
            } else {
                "BAD"
            },
            v.confidence,
            v.evidence
                .iter()
                .map(|e| format!("{} {:?} {:.2}", e.what, e.says, e.weight))
                .collect::<Vec<_>>()
                .join(", "),
            s.envelope.change,
            s.envelope.clarity.min(999.),
            s.tempo.map(|t| (t.change as f32, t.clarity as f32)),
            s.floor,
            s.lawful_floor(),
            s.tones,
            s.section,
            s.passages,
            s.near,
            s.linear,
            s.far,
            s.drift,
            s.exponent,
            s.turns
        );
    }
}
