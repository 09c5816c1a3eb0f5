//! A synthetic run for the tests of recordings: a growing tone, then two tones with incommensurate
//! frequencies, then two tones with random phase. Only the structure of the records is realistic, not the
//! physics.

mod analyses;
mod body;

use std::{f64::consts::TAU, sync::Arc};

use body::{geometry, outline};

use crate::{
    analysis::{levels::LevelReference, recurrence::RecurrenceImage},
    dynamics::ErrorEstimate,
    pipeline::message::{
        Appearance, EnergySample, Frame, Header, Health, JointInfo, ModeInfo, NodeState,
        Observation, OperatingPoint, PatchGeometry, PatchSnapshot, PerturbedSamples, Record,
        SignalInfo, SpectralLine, Subject, Summary, Vibration,
    },
    scene::{RecordSpec, Scene},
};

/// Sample rate, Hz.
pub const SAMPLE_RATE: f64 = 200e3;
/// Samples per frame.
const FRAME: usize = 256;
/// Radii of the ball, the beam and the patch, m.
const BALL: f64 = 15.875e-3;
const BEAM: f64 = 10e-3;
const PATCH: f64 = 1.697e-3;
/// Number of contact rings; ring `k` has `6 k` nodes, the centre one: 91 nodes.
const RINGS: usize = 5;
/// Load, N.
const LOAD: f64 = 150.0;

const MODES: [(&str, f64); 11] = [
    ("1st bending x", 1698.0),
    ("1st bending y", 1698.0),
    ("2nd bending x", 4093.0),
    ("2nd bending y", 4093.0),
    ("1st torsion", 4501.0),
    ("3rd bending x", 7545.0),
    ("3rd bending y", 7545.0),
    ("1st axial", 9737.0),
    ("2nd torsion", 9917.0),
    ("4th bending x", 12448.0),
    ("4th bending y", 12448.0),
];

/// The recording settings of a typical scene.
pub fn spec() -> RecordSpec {
    RecordSpec {
        patch_rate: 20e3,
        patch_nodes: 100,
        body_rate: 2e3,
        energy_rate: 20e3,
        deformation_scale: 5000.0,
    }
}

/// The records of a run of `duration` s, in order.
pub fn records(duration: f64) -> Vec<Record> {
    let header = Arc::new(header(duration));
    let joint = joint();
    let signal = Signal::new(duration);
    let frames = (duration * SAMPLE_RATE / FRAME as f64).round() as usize;
    let mut records = vec![Record::Header(header)];
    let mut due = RedrawTimer::default();
    for index in 0..frames {
        let frame = signal.frame(index, &joint);
        let now = frame.end();
        records.push(Record::Samples(Arc::new(frame)));
        while due.column + 1e-3 <= now {
            records.push(signal.column(due.column));
            due.column += 0.5e-3;
        }
        if now >= due.spectrum {
            due.spectrum += 5e-3;
            records.push(signal.spectrum(now));
            records.push(signal.embedding(now));
        }
        if now >= due.recurrence {
            due.recurrence += 2.5e-3;
            records.push(signal.recurrence(now));
        }
        if now >= due.analyses {
            let last = due.analyses - 5e-3;
            due.analyses += 5e-3;
            records.push(signal.delay(now));
            records.push(signal.quantification(now));
            records.push(signal.section(last.max(0.0), due.analyses - 5e-3));
            records.push(signal.chaos(now));
            records.push(signal.verdict(now));
            records.push(signal.exponents(now));
            records.push(signal.separation(now));
        }
        if now >= due.health {
            due.health += 5e-3;
            records.push(Record::Health(Health {
                time: now,
                real_time_factor: 0.8 + 0.1 * (30.0 * now).sin(),
                error: Some(ErrorEstimate {
                    ratio: 0.9,
                    tolerance: 1e-5,
                }),
                steps_per_ms: 120.0,
                rejections_per_ms: 7.0,
                rhs_evals_per_ms: 840.0,
                events_per_ms: 300.0,
                audit: Some(1e-6),
                ..Health::default()
            }));
        }
    }
    for (share, appearance) in [
        (0.02, Appearance::Growing),
        (0.36, Appearance::TwoTones),
        (0.70, Appearance::Broad),
    ] {
        let time = share * duration;
        let observation = Observation::Vibration(Box::new(vibration(appearance)));
        records.push(Record::Narration { time, observation });
    }
    records.push(Record::Warning {
        time: 0.0,
        text: "synthetic data".to_owned(),
    });
    records.push(Record::Summary(Arc::new(Summary {
        simulated_s: duration,
        ..Summary::default()
    })));
    records
}

/// A vibration with a given appearance.
fn vibration(appearance: Appearance) -> Vibration {
    Vibration {
        appearance,
        growth_rate: 100.0,
        lines: Vec::new(),
        f1: Some(4110.0),
        f2: Some(3830.0),
        beat: Some(280.0),
        second_tone: 0.2,
        broadband_share: 0.01,
        peak_speed: 0.02,
        backward_speed: 0.02,
        half_range: 1e-6,
        now: OperatingPoint {
            tilt: 0.05,
            load: None,
            rotation_factor: None,
            sliding_speed: 0.016,
        },
    }
}

/// Number of samples in [`records`].
pub fn samples(duration: f64) -> usize {
    (duration * SAMPLE_RATE / FRAME as f64).round() as usize * FRAME
}

/// The displacement of all [`samples`], m.
pub fn displacement(duration: f64) -> Vec<f64> {
    Signal::new(duration).displacement
}

/// Time of the next record of each type, s.
#[derive(Default)]
struct RedrawTimer {
    column: f64,
    spectrum: f64,
    recurrence: f64,
    analyses: f64,
    health: f64,
}

pub fn header(duration: f64) -> Header {
    Header {
        scene: "demo".to_owned(),
        title: "From a tone to a torus to chaos".to_owned(),
        about: "The load tilts slowly from 0 to 6 degrees. Watch the portrait: a loop, then a \
                band, then a tangle."
            .to_owned(),
        scene_text: "title = \"demo\"\ntilt_deg = [[0, 0], [100, 6]]".to_owned(),
        command: "squeakscope run demo".to_owned(),
        sample_rate: SAMPLE_RATE,
        duration,
        endless: false,
        controls: Vec::new(),
        analysis: Scene::load("chaos-5deg").unwrap().analysis,
        rest_speed: 0.0,
        subject: Subject::Joint(joint()),
        computed: None,
    }
}

/// A measured voltage: the synthetic motion about 2.5 V, in frames without modes.
pub fn signal_records(duration: f64) -> Vec<Record> {
    let volts = |u: f64| 2.5 + 1e6 * u;
    let header = Header {
        scene: "bench.csv".to_owned(),
        title: "Column `ch1` of bench.csv".to_owned(),
        about: "A voltage from a bench.".to_owned(),
        scene_text: String::new(),
        command: "squeakscope analyse bench.csv".to_owned(),
        subject: Subject::Signal(SignalInfo {
            source: "bench.csv".to_owned(),
            column: "ch1".to_owned(),
            unit: "V".to_owned(),
            start: 0.0,
            span: [1.5, 3.5],
            highest_frequency: 15e3,
            events: vec![analyses::event(duration)],
            level_reference: LevelReference::LargestSample,
        }),
        ..header(duration)
    };
    let of_joint = records(duration).into_iter();
    let records = of_joint.filter_map(|record| match record {
        Record::Header(_) => Some(Record::Header(Arc::new(header.clone()))),
        Record::Samples(frame) => {
            let samples: Vec<f64> = frame.displacement.iter().map(|u| volts(*u)).collect();
            Some(Record::Samples(Arc::new(Frame {
                index: frame.index,
                t0: frame.t0,
                dt: frame.dt,
                velocity: samples.clone(),
                displacement: samples,
                ..Frame::default()
            })))
        }
        Record::Embedding { time, points } => Some(Record::Embedding {
            time,
            points: points
                .iter()
                .map(|point| point.map(|u| volts(f64::from(u)) as f32))
                .collect(),
        }),
        Record::Section { time, mut points } => {
            for point in &mut points {
                point.at = point.at.map(volts);
            }
            Some(Record::Section { time, points })
        }
        Record::Narration { .. } | Record::Exponents(_) | Record::TrajectoryDivergence(_) => None,
        other => Some(other),
    });
    records.collect()
}

/// The joint of the synthetic samples.
pub fn joint() -> JointInfo {
    JointInfo {
        body: "Ball and beam".to_owned(),
        modes: MODES
            .iter()
            .map(|&(label, frequency_hz)| ModeInfo {
                label: label.to_owned(),
                frequency_hz,
            })
            .collect(),
        min_tilt: 0.0,
        max_tilt: 6f64.to_radians(),
        tilt_range: None,
        azimuth: 0.0,
        outline: outline(),
        rotation: [0.5f64.sqrt(), 0.5f64.sqrt(), 0.0],
        rotation_span: [1.0; 2],
        load_span: [LOAD; 2],
        ball_radius: BALL,
        patch_radius: PATCH,
        sliding_speed: BALL,
    }
}

/// The synthetic motion.
struct Signal {
    duration: f64,
    /// Displacement (m) and velocity (m/s) of the probe at every sample.
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    /// Phases of the two tones at every sample.
    phases: Vec<[f64; 2]>,
}

impl Signal {
    fn new(duration: f64) -> Self {
        let mut signal = Self {
            duration,
            displacement: Vec::new(),
            velocity: Vec::new(),
            phases: Vec::new(),
        };
        let dt = 1.0 / SAMPLE_RATE;
        let mut phase = [0.0; 2];
        let mut random = 1u64;
        for k in 0..samples(duration) {
            let time = k as f64 * dt;
            let wander = if time > 0.66 * duration { 0.12 } else { 0.0 };
            for (phase, frequency) in phase.iter_mut().zip([4110.0, 3830.0]) {
                random = random
                    .wrapping_mul(6364136223846793005)
                    .wrapping_add(1442695040888963407);
                let noise = (random >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
                *phase += TAU * frequency * dt + wander * noise;
            }
            let grown = 0.65e-6 * (1.0 - (-time / (0.06 * duration)).exp()).powi(2);
            let second = if time > 0.33 * duration { 0.45 } else { 0.0 };
            let u = phase[0].sin() + second * phase[1].sin() + 0.06 * (3.0 * phase[0]).sin();
            let v = phase[0].cos() + second * phase[1].cos() + 0.18 * (3.0 * phase[0]).cos();
            signal.displacement.push(grown * u);
            signal.velocity.push(grown * TAU * 4110.0 * v);
            signal.phases.push(phase);
        }
        signal
    }

    fn frame(&self, index: usize, joint: &JointInfo) -> Frame {
        let first = index * FRAME;
        let range = first..first + FRAME;
        let dt = 1.0 / SAMPLE_RATE;
        let t0 = first as f64 * dt;
        let tilt = joint.max_tilt * t0 / self.duration;
        let geometry = Arc::new(geometry(tilt));
        let amplitude = |k: usize| 0.4e-6 * (self.displacement[k].abs() / 0.65e-6).min(1.0);
        let share = |mode: usize| 1.0 / (1.0 + (mode as f64 - 2.0).abs());
        let rows = |part: fn(f64) -> f64, rate: bool| {
            range
                .clone()
                .flat_map(|k| {
                    MODES
                        .iter()
                        .enumerate()
                        .map(move |(mode, &(_, frequency))| {
                            let unit = if rate { TAU * frequency } else { 1.0 };
                            let phase = self.phases[k][mode % 2] * frequency / 4093.0;
                            unit * amplitude(k) * share(mode) * part(phase)
                        })
                })
                .collect()
        };
        let moments = || range.clone().step_by(10);
        // A perturbed trajectory with a delay of a tenth of a period.
        let beside = |signal: &[f64]| {
            let range = range.clone();
            range.map(|k| signal[k.saturating_sub(5)]).collect()
        };
        Frame {
            index: index as u64,
            t0,
            dt,
            modes: MODES.len(),
            q: rows(f64::sin, false),
            qdot: rows(f64::cos, true),
            displacement: self.displacement[range.clone()].to_vec(),
            velocity: self.velocity[range.clone()].to_vec(),
            tilt,
            load: LOAD,
            rotation_factor: 1.0,
            patch: moments()
                .map(|k| self.snapshot(k as f64 * dt, k, &geometry))
                .collect(),
            energy: moments()
                .map(|k| EnergySample {
                    time: k as f64 * dt,
                    modal: (0..MODES.len()).map(|mode| 2e-5 * share(mode)).collect(),
                    total: 5e-5,
                    friction_work: 5e-5,
                    residual: 1e-12,
                })
                .collect(),
            geometry,
            transitions: 120,
            perturbed: Some(PerturbedSamples {
                displacement: beside(&self.displacement),
                velocity: beside(&self.velocity),
                distance: vec![1e-3; FRAME],
                floor: 1e-13,
            }),
            busy_seconds: t0,
            ..Frame::default()
        }
    }

    fn snapshot(&self, time: f64, k: usize, geometry: &PatchGeometry) -> PatchSnapshot {
        let swing = self.velocity[k] / 0.0159;
        let nodes = geometry.positions.iter().zip(&geometry.pre_stress);
        let force: Vec<f64> = nodes
            .zip(&geometry.areas)
            .map(|((p, stress), area)| {
                let across = (p[0] + p[1]) / BALL * 9.0;
                stress * area * (1.0 + 0.9 * across * swing + 0.3 * swing).max(0.0)
            })
            .collect();
        PatchSnapshot {
            time,
            states: force
                .iter()
                .map(|&force| match force {
                    f if f <= 0.0 => NodeState::Separated,
                    _ if swing < -0.92 => NodeState::Stick,
                    _ => NodeState::Slip,
                })
                .collect(),
            friction: force.iter().map(|f| [-0.36 * f, 0.36 * f, 0.0]).collect(),
            normal_force: force,
        }
    }

    /// One-sided amplitudes over the `count` samples before `end`, Hann window.
    fn amplitudes(&self, end: usize, count: usize, bins: usize) -> Vec<f64> {
        let start = end.saturating_sub(count);
        let part = &self.velocity[start..end];
        let n = part.len() as f64;
        (0..bins)
            .map(|bin| {
                let step = TAU * bin as f64 / count as f64;
                let (mut re, mut im) = (0.0, 0.0);
                for (k, v) in part.iter().enumerate() {
                    let hann = 1.0 - (TAU * k as f64 / n).cos();
                    let (sin, cos) = (step * k as f64).sin_cos();
                    re += v * hann * cos;
                    im += v * hann * sin;
                }
                2.0 / n * re.hypot(im)
            })
            .collect()
    }

    fn spectrum(&self, now: f64) -> Record {
        let count = 2000;
        let bin = SAMPLE_RATE / count as f64;
        let amplitude = self.amplitudes((now * SAMPLE_RATE) as usize, count, 150);
        let peak = |frequency: f64, label: &str| SpectralLine {
            frequency,
            amplitude: amplitude[(frequency / bin).round() as usize],
            label: label.to_owned(),
        };
        let peaks = vec![
            peak(4110.0, "f1"),
            peak(3830.0, "f2"),
            peak(12330.0, "3 f1"),
        ];
        Record::Spectrum {
            time: now,
            bin,
            amplitude,
            peaks,
        }
    }

    fn column(&self, start: f64) -> Record {
        let count = 400;
        let end = (start * SAMPLE_RATE) as usize + count;
        let amplitude = self.amplitudes(end.min(self.velocity.len()), count, 31);
        Record::SpectrogramColumn {
            time: start + 1e-3,
            bin: SAMPLE_RATE / count as f64,
            level_db: amplitude
                .iter()
                .map(|a| (20.0 * (1e3 * a + 1e-9).log10()) as f32)
                .collect(),
        }
    }

    fn embedding(&self, now: f64) -> Record {
        let end = (now * SAMPLE_RATE) as usize;
        let u = |k: usize| self.displacement[k] as f32;
        Record::Embedding {
            time: now,
            points: (end.saturating_sub(2000).max(40)..end)
                .map(|k| [u(k), u(k - 12), u(k - 24)])
                .collect(),
        }
    }

    fn recurrence(&self, now: f64) -> Record {
        let (size, stride) = (400, 4);
        let end = (now * SAMPLE_RATE) as usize;
        let point = |i: usize| {
            [0, 12, 24].map(|lag| {
                let back = (size - i) * stride + lag;
                1e6 * end.checked_sub(back).map_or(0.0, |k| self.displacement[k])
            })
        };
        let points: Vec<_> = (0..size).map(point).collect();
        let distance = |a: &[f64; 3], b: &[f64; 3]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let pairs = || {
            points
                .iter()
                .flat_map(|a| points.iter().map(move |b| (a, b)))
        };
        let largest = pairs().map(|(a, b)| distance(a, b)).fold(1e-12, f64::max);
        let threshold = 0.1 * largest;
        let pixels =
            |value: &dyn Fn(f64) -> u8| pairs().map(|(a, b)| value(distance(a, b))).collect();
        let image = RecurrenceImage {
            window: (size * stride) as f64 / SAMPLE_RATE,
            size,
            distance: pixels(&|d| (255.0 * d / largest) as u8),
            recurrent: pixels(&|d| if d < threshold { 255 } else { 0 }),
            threshold: Some(1e-6 * threshold),
            rate: 0.05,
            lag: 60e-6,
            dimension: 3,
        };
        Record::Recurrence {
            time: now,
            image: Arc::new(image),
        }
    }
}
