//! Samples of an orbit: its range, and its distance from the guards.

use nalgebra::{DMatrix, DVector};

use super::ContinuationError;
use super::flow::{Flow, SegmentEnds, slope_in};
use super::newton::residuals;
use super::shooting::{Scale, ShootingPoint, sizes_of};
use crate::{Switching, System};

/// Samples per period from which ranges and minima are computed.
const SAMPLES: usize = 128;

/// A state of an orbit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OrbitSample {
    /// Time from phase zero, s.
    pub time_s: f64,
    /// State, without quadratures.
    pub state: Vec<f64>,
    /// Status of a system whose events are located; otherwise empty.
    pub status: Vec<u8>,
}

/// Distances from the guards.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum GuardDistances {
    /// The minimum of each guard of a continuous system over the orbit, with the sign that makes its mean positive.
    Minima(Vec<f64>),
    /// The guard of a system with jumps that comes closest to zero without being crossed, and its minimum relative to its
    /// largest value.
    ClosestDip(Option<(usize, f64)>),
}

/// Properties of an orbit by samples.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    /// Half the range of the observable.
    pub amplitude: f64,
    /// Half the range of each component.
    pub component_amplitudes: Vec<f64>,
    /// Largest distance of the vibration, and of the first-order components, from their means.
    pub sizes: [f64; 2],
    /// Largest distance between the end of a segment and the start of the next one.
    pub residual: f64,
    /// The change of the state over the first half of the period.
    pub half: DVector<f64>,
    /// Guards crossed.
    pub crossings: u64,
    pub guards: GuardDistances,
    /// Derivatives of the segment maps.
    pub maps: Vec<DMatrix<f64>>,
}

impl Shape {
    /// Number of guards of a continuous system that change their sign.
    pub fn open_guards(&self) -> usize {
        match &self.guards {
            GuardDistances::Minima(minima) => minima.iter().filter(|&&least| least < 0.0).count(),
            GuardDistances::ClosestDip(_) => 0,
        }
    }
}

/// Samples of an orbit.
pub(super) struct Samples {
    pub states: Vec<OrbitSample>,
    /// Guards crossed before each sample, from any origin.
    crossings: Vec<u64>,
    /// The ends of the segments.
    ends: SegmentEnds,
}

impl Flow<'_> {
    /// Samples `count` states of an orbit at equal intervals, the first one at phase zero, and returns the ends of
    /// its segments.
    pub fn samples(
        &mut self,
        sys: &dyn System,
        shot: &ShootingPoint,
        count: usize,
        with_maps: bool,
    ) -> Result<Samples, ContinuationError> {
        let period = self.period(shot);
        let parameter = shot.parameter;
        let mut samples: Vec<OrbitSample> = Vec::with_capacity(count);
        let mut crossings = Vec::with_capacity(count);
        let mut z = vec![0.0; sys.dim()];
        let n = sys.tangent_dim();
        let ends = self.observed_segments(sys, shot, with_maps, &mut |integrator, k| {
            let end = shot.span(k)[1];
            while samples.len() < count {
                let phase = samples.len() as f64 / count as f64;
                if phase >= end {
                    break;
                }
                let time_s = phase * period;
                integrator
                    .sample(time_s, &mut z)
                    .map_err(|source| ContinuationError::Integration { parameter, source })?;
                samples.push(OrbitSample {
                    time_s,
                    state: z[..n].to_vec(),
                    status: integrator.status().to_vec(),
                });
                crossings.push(integrator.stats().crossings);
            }
            Ok(())
        })?;
        Ok(Samples {
            states: samples,
            crossings,
            ends,
        })
    }

    /// Measures an orbit.
    pub fn shape(
        &mut self,
        shot: &ShootingPoint,
        scale: &Scale,
    ) -> Result<Shape, ContinuationError> {
        let sys = self.system(shot.parameter)?;
        let sys = sys.as_ref();
        let mut all = self.samples(sys, shot, SAMPLES, true)?;
        let maps = std::mem::take(&mut all.ends.maps);
        let (samples, ends) = (&all.states, &all.ends);
        let residual = residuals(shot, ends)
            .iter()
            .fold(0.0, |max: f64, r| max.max(scale.norm_state(r)));
        let n = sys.tangent_dim();
        let half_range = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            0.5 * (high - low)
        };
        let observe = |sample: &OrbitSample| self.family.observable(shot.parameter, &sample.state);
        let guards = match sys.switching() {
            Some(switching) if switching.guards() > 0 => {
                if switching.is_continuous() {
                    GuardDistances::Minima(minima(sys, switching, samples))
                } else {
                    GuardDistances::ClosestDip(closest_dip(sys, switching, &all))
                }
            }
            _ => GuardDistances::Minima(Vec::new()),
        };
        let [start, half] = [0, SAMPLES / 2].map(|k| DVector::from_column_slice(&samples[k].state));
        Ok(Shape {
            half: half - start,
            amplitude: half_range(&mut samples.iter().map(observe)),
            component_amplitudes: (0..n)
                .map(|i| half_range(&mut samples.iter().map(|sample| sample.state[i])))
                .collect(),
            sizes: sizes(sys, samples),
            residual,
            crossings: ends.crossings,
            guards,
            maps,
        })
    }

    /// The largest distances of the vibration and of the first-order components from their means, over a guess.
    pub fn sizes(
        &mut self,
        sys: &dyn System,
        shot: &ShootingPoint,
    ) -> Result<[f64; 2], ContinuationError> {
        Ok(sizes(sys, &self.samples(sys, shot, SAMPLES, false)?.states))
    }
}

/// The largest distances of the vibration and of the first-order components from their means.
fn sizes(sys: &dyn System, samples: &[OrbitSample]) -> [f64; 2] {
    let n = sys.tangent_dim();
    let mean = samples
        .iter()
        .map(|sample| DVector::from_column_slice(&sample.state))
        .sum::<DVector<f64>>()
        / samples.len() as f64;
    let mut largest = [0.0_f64; 2];
    let mut difference = vec![0.0; n];
    for sample in samples {
        for (i, difference) in difference.iter_mut().enumerate() {
            *difference = sample.state[i] - mean[i];
        }
        let sizes = sizes_of(sys, &difference);
        largest = [0, 1].map(|part| largest[part].max(sizes[part]));
    }
    largest
}

/// Guard values and their rates along the flow at a sample.
fn guard_with_rate(
    sys: &dyn System,
    switching: &dyn Switching,
    status: &[u8],
    sample: &OrbitSample,
    guard: usize,
) -> [f64; 2] {
    let mut z = sample.state.clone();
    z.resize(sys.dim(), 0.0);
    let mut values = vec![0.0; switching.guards()];
    switching.guard_values(status, sample.time_s, &z, &mut values);
    let mut gradient = vec![0.0; sys.dim()];
    let rate = switching.guard_gradient(status, guard, sample.time_s, &z, &mut gradient);
    let slope = slope_in(sys, &sample.status, sample.time_s, &z);
    let along: f64 = gradient.iter().zip(slope.iter()).map(|(g, f)| g * f).sum();
    [values[guard], rate + along]
}

/// The minimum of the cubic with given values and slopes at the ends of an interval of length `h`.
fn cubic_minimum([from, to]: [[f64; 2]; 2], h: f64) -> f64 {
    let (a, b) = (from[0], to[0]);
    let (da, db) = (from[1] * h, to[1] * h);
    let value = |s: f64| {
        let r = 1.0 - s;
        r * r * (1.0 + 2.0 * s) * a + s * s * (3.0 - 2.0 * s) * b + s * r * (r * da - s * db)
    };
    // Derivative: da + 2 s c2 + 3 s^2 c3.
    let c2 = 3.0 * (b - a) - 2.0 * da - db;
    let c3 = 2.0 * (a - b) + da + db;
    let discriminant = c2 * c2 - 3.0 * c3 * da;
    let mut least = a.min(b);
    if discriminant >= 0.0 {
        let root = discriminant.sqrt();
        // Both roots without cancellation.
        let q = -(c2 + c2.signum() * root);
        for s in [q / (3.0 * c3), da / q] {
            if s > 0.0 && s < 1.0 {
                least = least.min(value(s));
            }
        }
    }
    least
}

/// The minimum of each guard of a continuous system over the orbit, with the sign that makes its mean positive. It is
/// negative if the orbit crosses the guard. The status of a phase would give a sign that depends on this phase.
fn minima(sys: &dyn System, switching: &dyn Switching, samples: &[OrbitSample]) -> Vec<f64> {
    let status = vec![0; switching.status_len()];
    let count = switching.guards();
    let values: Vec<Vec<f64>> = samples
        .iter()
        .map(|sample| {
            let mut z = sample.state.clone();
            z.resize(sys.dim(), 0.0);
            let mut values = vec![0.0; count];
            switching.guard_values(&status, sample.time_s, &z, &mut values);
            values
        })
        .collect();
    let h = match samples {
        [first, second, ..] => second.time_s - first.time_s,
        _ => 0.0,
    };
    let length = samples.len();
    (0..count)
        .map(|guard| {
            let sum: f64 = values.iter().map(|values| values[guard]).sum();
            let sign = sum.signum();
            let value = |k: &usize| sign * values[*k][guard];
            let lowest = (0..length).min_by(|a, b| value(a).total_cmp(&value(b)));
            let at = lowest.unwrap_or(0);
            let near = [length - 1, 0, 1].map(|offset| {
                let sample = &samples[(at + offset) % length];
                guard_with_rate(sys, switching, &status, sample, guard).map(|value| sign * value)
            });
            cubic_minimum([near[0], near[1]], h).min(cubic_minimum([near[1], near[2]], h))
        })
        .collect()
}

/// The guard with the lowest minimum that is not a crossing, relative to its largest value.
fn closest_dip(sys: &dyn System, switching: &dyn Switching, all: &Samples) -> Option<(usize, f64)> {
    let samples = &all.states;
    let count = switching.guards();
    let mut closest: Option<(usize, f64)> = None;
    for guard in 0..count {
        let values: Vec<_> = samples
            .iter()
            .map(|sample| guard_with_rate(sys, switching, &sample.status, sample, guard))
            .collect();
        let largest = values.iter().fold(0.0_f64, |max, v| max.max(v[0].abs()));
        for k in 0..samples.len() {
            let next = (k + 1) % samples.len();
            let [from, to] = [values[k], values[next]];
            let is_dip = from[1] < 0.0 && to[1] > 0.0;
            let same = next > 0 && all.crossings[k] == all.crossings[next];
            if !(is_dip && same) || largest == 0.0 {
                continue;
            }
            let h = samples[next].time_s - samples[k].time_s;
            let low = cubic_minimum([from, to], h) / largest;
            if closest.is_none_or(|(_, least)| low < least) {
                closest = Some((guard, low));
            }
        }
    }
    closest
}
