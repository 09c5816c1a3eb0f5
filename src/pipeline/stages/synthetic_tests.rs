//! Scenes, headers and frames for tests: signals known in closed form, split into frames.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use crate::analysis::{
    chaos::DivergenceMethod,
    poincare::Direction,
    recurrence::{Norm, Threshold},
};
use crate::pipeline::message::{Frame, Header, JointInfo, Subject, SurfaceMesh};
use crate::scene::{
    AnalysisSpec, ChaosSpec, DelaySpec, EmbeddingSpec, QuantificationSpec, RecurrenceSpec,
    RegimeSpec, SectionSpec, SectionSurface, SpectrogramSpec, SpectrumSpec, ThresholdSpec,
};
use crate::test_signals::sines;

/// Sample rate of all synthetic runs, Hz.
pub const RATE: f64 = 200_000.0;

/// Slip speed in steady sliding, m/s, close to that of the paper.
pub const SLIDING_SPEED: f64 = 15.9e-3;

/// The default analyses.
pub fn analyses() -> AnalysisSpec {
    AnalysisSpec {
        spectrum: Some(SpectrumSpec {
            window: 20e-3,
            every: 5e-3,
            rest: None,
        }),
        spectrogram: Some(SpectrogramSpec {
            window: 5e-3,
            every: 0.5e-3,
            max_frequency: 20e3,
        }),
        recurrence: Some(RecurrenceSpec {
            window: 5e-3,
            every: 2.5e-3,
            size: 400,
            embedding: EMBEDDING,
            criterion: criterion(Threshold::Rate(0.05)),
        }),
        ..AnalysisSpec::default()
    }
}

/// All analyses; delay and dimension are chosen from the signal where possible.
pub fn all_analyses() -> AnalysisSpec {
    let embedding = EmbeddingSpec {
        lag: None,
        dimension: None,
    };
    AnalysisSpec {
        delay: Some(DelaySpec {
            window: 8e-3,
            every: 4e-3,
            largest_lag: 150e-6,
            largest_dimension: 5,
            bins: 16,
            false_share: 0.01,
        }),
        recurrence: Some(RecurrenceSpec {
            window: 2e-3,
            every: 2e-3,
            size: 100,
            embedding,
            criterion: criterion(Threshold::Rate(0.05)),
        }),
        quantification: Some(QuantificationSpec {
            // 61 states every 30.5 states.
            window: 1.22e-3,
            every: 0.61e-3,
            step: 20e-6,
            embedding,
            criterion: criterion(Threshold::Spread(0.3)),
            theiler: 60e-6,
            least_diagonal: 5,
            least_vertical: 2,
        }),
        section: Some(SectionSpec {
            every: 0.7525e-3,
            surface: SectionSurface::Delay {
                lag: None,
                level: 0.0,
            },
            direction: Direction::Rising,
        }),
        chaos: Some(ChaosSpec {
            window: 8e-3,
            every: 5e-3,
            embedding,
            theiler: 0.25e-3,
            horizon: 1e-3,
            method: DivergenceMethod::Rosenstein,
        }),
        regime: Some(RegimeSpec {
            window: 10e-3,
            every: 5e-3,
            silence: 1e-12,
        }),
        ..analyses()
    }
}

/// Delay and dimension that unfold tones near 4 kHz.
pub const EMBEDDING: EmbeddingSpec = EmbeddingSpec {
    lag: Some(60e-6),
    dimension: Some(5),
};

/// Euclidean distances below a threshold.
pub fn criterion(threshold: Threshold) -> ThresholdSpec {
    ThresholdSpec {
        norm: Norm::Euclidean,
        threshold,
    }
}

/// Displacement (m) and velocity (m/s) of the probe.
#[derive(Clone, Default)]
pub struct Motion {
    pub displacement: Vec<f64>,
    pub velocity: Vec<f64>,
}

impl Motion {
    /// A sum of tones, each (frequency in Hz, velocity amplitude in m/s, phase in rad).
    pub fn tones(seconds: f64, tones: &[(f64, f64, f64)]) -> Self {
        let n = (seconds * RATE).round() as usize;
        let integral: Vec<_> = tones
            .iter()
            .map(|(f, a, phase)| (*f, a / (TAU * f), phase - FRAC_PI_2))
            .collect();
        Self {
            displacement: sines(RATE, n, &integral),
            velocity: sines(RATE, n, tones),
        }
    }

    /// The same motion with an exponential envelope that is 1 at the end.
    pub fn with_growth(mut self, rate: f64) -> Self {
        let n = self.velocity.len();
        for x in [&mut self.displacement, &mut self.velocity] {
            for (i, x) in x.iter_mut().enumerate() {
                *x *= (rate * (i as f64 - n as f64) / RATE).exp();
            }
        }
        self
    }

    /// This motion followed by another one.
    pub fn then(mut self, next: &Self) -> Self {
        self.displacement.extend(&next.displacement);
        self.velocity.extend(&next.velocity);
        self
    }

    /// This motion followed by another one, with a cross-fade of 10 ms: a real motion has no discontinuity.
    pub fn fading_into(mut self, next: &Self) -> Self {
        let fade = (10e-3 * RATE) as usize;
        let pairs = [
            (&mut self.displacement, &next.displacement),
            (&mut self.velocity, &next.velocity),
        ];
        for (old, new) in pairs {
            let start = old.len() - fade;
            for (i, (x, y)) in old[start..].iter_mut().zip(new).enumerate() {
                let share = 0.5 - 0.5 * (PI * i as f64 / fade as f64).cos();
                *x += share * (y - *x);
            }
            old.extend(&new[fade..]);
        }
        self
    }

    /// Splits the motion into frames of `size` samples, starting at time `t0`.
    pub fn frames(&self, t0: f64, tilt: f64, size: usize) -> Vec<Arc<Frame>> {
        let parts = self
            .displacement
            .chunks(size)
            .zip(self.velocity.chunks(size));
        let frame = |(index, (displacement, velocity)): (usize, (&[f64], &[f64]))| {
            Arc::new(Frame {
                index: index as u64,
                t0: t0 + (index * size) as f64 / RATE,
                dt: 1.0 / RATE,
                displacement: displacement.to_vec(),
                velocity: velocity.to_vec(),
                tilt,
                load: 150.0,
                rotation_factor: 1.0,
                transitions: 2,
                ..Frame::default()
            })
        };
        parts.enumerate().map(frame).collect()
    }
}

pub fn header() -> Header {
    Header {
        scene: "synthetic".into(),
        title: String::new(),
        about: String::new(),
        scene_text: String::new(),
        command: String::new(),
        sample_rate: RATE,
        duration: 0.1,
        endless: false,
        controls: Vec::new(),
        analysis: AnalysisSpec::default(),
        rest_speed: 0.0,
        subject: Subject::Joint(JointInfo {
            body: String::new(),
            modes: Vec::new(),
            min_tilt: 0.0,
            max_tilt: 0.0,
            tilt_range: None,
            azimuth: 0.0,
            outline: SurfaceMesh::default(),
            rotation: [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0],
            rotation_span: [1.0; 2],
            load_span: [150.0; 2],
            ball_radius: 15.875e-3,
            patch_radius: 1.697e-3,
            sliding_speed: SLIDING_SPEED,
        }),
        computed: None,
    }
}
