//! Synthetic analysis results, consistent with the synthetic motion.

use std::sync::Arc;

use super::{SAMPLE_RATE, Signal};
use crate::{
    analysis::{
        chaos::{Divergence, ScalingRegion, ZeroOne},
        delay::{DelayChoice, FalseNeighbours, LagReason, MutualInformation},
        events::{RidgePoint, TonalEvent},
        recurrence::{Measures, RecurrenceKind, RecurrencePeriod, RecurrencePeriods},
        regime::{Evidence, Regime, Verdict},
    },
    dynamics::{Exponent, LyapunovSpectrum, Motion},
    pipeline::message::{DivergenceFit, Exponents, Record, SectionPoint, TrajectoryDivergence},
};

/// Delay, samples.
const LAG: usize = 12;
/// Length of the windows, s.
const WINDOW: f64 = 20e-3;

/// A tonal event in the second half, with its second harmonic.
pub fn event(duration: f64) -> TonalEvent {
    let ridge = (0..=20).map(|k| RidgePoint {
        time_s: duration * (0.5 + 0.025 * f64::from(k)),
        frequency_hz: 4093.0 + 5.0 * f64::from(k),
        level_db: -6.0,
    });
    TonalEvent {
        kind: crate::analysis::events::EventKind::Tone,
        probability: 0.99,
        start_s: 0.5 * duration,
        end_s: duration,
        frequency_hz: 4143.0,
        frequency_low_hz: 4093.0,
        frequency_high_hz: 4193.0,
        harmonics: 2,
        level_db: -6.0,
        snr_db: 30.0,
        modulation: None,
        vibrato: None,
        ridge: ridge.collect(),
    }
}

impl Signal {
    /// Type of motion at a time (s).
    fn regime(&self, now: f64) -> Regime {
        match now / self.duration {
            share if share < 0.15 => Regime::Transient,
            share if share < 0.36 => Regime::Periodic,
            share if share < 0.68 => Regime::QuasiPeriodic,
            _ => Regime::Chaotic,
        }
    }

    /// Irregularity of the motion at a time (s), 0 to 1, with small fluctuations.
    fn disorder(&self, now: f64) -> f64 {
        let scatter = 0.04 * (1.0 + (900.0 * now).sin());
        match self.regime(now) {
            Regime::Chaotic => 0.9 + scatter,
            Regime::QuasiPeriodic => 0.25 + scatter,
            _ => scatter,
        }
    }

    pub fn delay(&self, now: f64) -> Record {
        let bits = (0..=60).map(|lag| {
            let x = f64::from(lag) / LAG as f64;
            let ripple = (std::f64::consts::FRAC_PI_2 * x).cos().powi(2);
            0.4 + 4.2 * (-3.0 * x).exp() + 1.6 * ripple * (-0.1 * x).exp()
        });
        let left = 0.02 + 0.1 * self.disorder(now);
        let share = [0.96, 0.41, 0.4 * left, 0.01 * left, 0.0, 0.0].to_vec();
        Record::Delay {
            time: now,
            dt: 1.0 / SAMPLE_RATE,
            choice: Arc::new(DelayChoice {
                lag: LAG,
                reason: LagReason::FirstMinimum,
                dimension: 4,
                unfolded: true,
                theiler: 24,
                mutual: MutualInformation {
                    bins: 32,
                    bits: bits.collect(),
                },
                neighbours: FalseNeighbours {
                    lag: LAG,
                    evaluated: vec![4000; share.len()],
                    share,
                },
            }),
        }
    }

    /// Three exponents whose intervals decrease with the averaging time.
    pub fn exponents(&self, now: f64) -> Record {
        let half_width = 30.0 / (now / self.duration).sqrt();
        let exponents =
            [70.0 * self.disorder(now), 0.3, -240.0].map(|value| Exponent { value, half_width });
        Record::Exponents(Arc::new(Exponents {
            time: now,
            spectrum: LyapunovSpectrum {
                exponents: exponents.to_vec(),
                time: now,
                dimension: 22,
                resolution: 1.0 / now,
                kaplan_yorke: Some(Exponent {
                    value: 2.3,
                    half_width: 0.1,
                }),
            },
            motion: Motion::Free,
            omega_1: 10_668.8,
            segments: Vec::new(),
            chaotic_transient: None,
        }))
    }

    /// A distance that grows tenfold in each tenth of the run.
    pub fn separation(&self, now: f64) -> Record {
        let rate = 10.0 * std::f64::consts::LN_10 / self.duration;
        let intercept = (1e-8_f64).ln();
        let saturated = 0.7 * self.duration;
        Record::TrajectoryDivergence(TrajectoryDivergence {
            time_s: now,
            start_s: 0.0,
            distance: (intercept + rate * now.min(saturated)).exp(),
            line: Some(DivergenceFit {
                rate_per_s: rate,
                half_width_per_s: 0.1 * rate,
                since_s: 0.0,
                intercept,
            }),
            saturated_s: (now >= saturated).then_some(saturated),
        })
    }

    pub fn quantification(&self, now: f64) -> Record {
        let disorder = self.disorder(now);
        let longest = 4000.0 * (1.0 - 0.95 * disorder);
        // A pure tone has no vertical lines.
        let laminar = disorder > 0.2;
        Record::Quantification {
            time: now,
            dt: 1.0 / SAMPLE_RATE,
            threshold: Some(5e-8),
            measures: Measures {
                recurrence_rate: 0.05,
                determinism: Some(1.0 - 0.4 * disorder),
                mean_diagonal: Some(0.3 * longest),
                longest_diagonal: longest.floor(),
                divergence: Some(longest.recip()),
                entropy: Some(1.0 + 2.5 * disorder),
                trend: Some(-0.002 - 0.02 * disorder),
                laminarity: laminar.then_some(0.3 * disorder),
                trapping_time: laminar.then_some(2.0 + 2.0 * disorder),
                longest_vertical: 9.0,
                recurrence_time_1: Some(19.0 + 5.0 * disorder),
                recurrence_time_2: Some(47.0 - 8.0 * disorder),
            },
            periods: RecurrencePeriods(vec![RecurrencePeriod {
                kind: RecurrenceKind::Finest,
                period: 1.0 / 4110.0,
                uncertainty: 1e-7,
                share: 0.8,
            }]),
        }
    }

    /// Upward zero crossings of `y(t + lag)` in a time interval (s).
    pub fn section(&self, from: f64, now: f64) -> Record {
        let [first, last] = [from, now].map(|time| (time * SAMPLE_RATE).round() as usize);
        let y = &self.displacement;
        let passages = (first..last).filter(|k| k + 1 + 2 * LAG < y.len());
        let points = passages.filter_map(|k| {
            let [before, after] = [y[k + LAG], y[k + LAG + 1]];
            let part = before / (before - after);
            let at = |k: usize| y[k] + part * (y[k + 1] - y[k]);
            (before < 0.0 && after >= 0.0).then(|| SectionPoint {
                time_s: (k as f64 + part) / SAMPLE_RATE,
                at: [at(k), at(k + 2 * LAG)],
            })
        });
        Record::Section {
            time: now,
            points: points.collect(),
        }
    }

    pub fn chaos(&self, now: f64) -> Record {
        let chaotic = self.regime(now) == Regime::Chaotic;
        let slope = 0.012 * self.disorder(now);
        let curve = (0..400).map(|k| {
            let k = f64::from(k);
            let apart = if chaotic {
                -3.4 * (-slope * k / 3.4).exp()
            } else {
                -3.4
            };
            -14.0 + apart + 0.05 * (0.27 * k).sin()
        });
        let disorder = self.disorder(now).min(1.0);
        let (mut p, mut q) = (0.0, 0.0);
        let path = (0..1500).map(|k| {
            let k = f64::from(k);
            let angle = 0.7 * k + disorder * 30.0 * (0.013 * k).sin() * (0.0031 * k * k).cos();
            p += angle.cos();
            q += angle.sin();
            [p, q]
        });
        Record::Chaos {
            time: now,
            dt: 1.0 / SAMPLE_RATE,
            divergence: Arc::new(Divergence {
                step: 1.0,
                curve: curve.collect(),
                counted: vec![3000; 400],
                region: chaotic.then_some(ScalingRegion {
                    from: 10.0,
                    to: 150.0,
                    slope: 0.8 * slope,
                    error: 0.05 * slope,
                    intercept: -17.35,
                }),
            }),
            zero_one: Arc::new(ZeroOne {
                k: disorder,
                by_frequency: Vec::new(),
                path: path.collect(),
                stride: 1,
                samples: 1500,
            }),
        }
    }

    pub fn verdict(&self, now: f64) -> Record {
        let regime = self.regime(now);
        let disorder = self.disorder(now);
        let evidence = |criterion: &str, contribution, description: &str| Evidence {
            criterion: criterion.to_owned(),
            supports: regime,
            contribution,
            description: description.to_owned(),
        };
        Record::Regime {
            time: now,
            window: WINDOW,
            verdict: Arc::new(Verdict {
                regime,
                confidence: 0.93 - 0.3 * (40.0 * now).sin().powi(2),
                likeliest: vec![regime],
                limitation: None,
                evidence: vec![
                    evidence(
                        "lines of the spectrum",
                        2.0,
                        "Two lines, 4.11 kHz and 3.83 kHz, explain all the others.",
                    ),
                    evidence(
                        "0-1 test",
                        disorder,
                        "The path of the 0-1 test shows how regular the motion is.",
                    ),
                    evidence(
                        "repetition",
                        1.0 - 0.4 * disorder,
                        "Most recurrences lie on diagonals.",
                    ),
                ],
                intervals: Vec::new(),
            }),
        }
    }
}
