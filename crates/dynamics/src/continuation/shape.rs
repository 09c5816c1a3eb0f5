//! Samples of an orbit: its range, and its distance from the guards.

use nalgebra::DVector;

use super::ContinuationError;
use super::flow::{Flow, SegmentEnds, slope_in};
use super::shooting::{Scale, ShootingPoint};
use crate::{Switching, System};

/// Samples per period from which ranges and minima are computed.
pub(super) const SAMPLES: usize = 128;

/// A state of an orbit.
#[derive(Clone, Debug)]
pub(super) struct OrbitSample {
    /// Time from phase zero, s.
    time_s: f64,
    /// The state.
    pub z: Vec<f64>,
    /// Status of a system whose events are located; otherwise empty.
    status: Vec<u8>,
    /// Guards crossed before, from any origin.
    crossings: u64,
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

impl GuardDistances {
    /// The distances over the samples of an orbit.
    pub fn of(sys: &dyn System, samples: &[OrbitSample]) -> Self {
        match sys.switching() {
            Some(switching) if switching.guards() > 0 && sys.jumps() => {
                Self::ClosestDip(closest_dip(switching, samples))
            }
            Some(switching) => Self::Minima(minima(switching, samples)),
            None => Self::Minima(Vec::new()),
        }
    }

    /// Number of guards of a continuous system that change their sign.
    pub fn open(&self) -> usize {
        match self {
            Self::Minima(minima) => minima.iter().filter(|&&least| least < 0.0).count(),
            Self::ClosestDip(_) => 0,
        }
    }
}

impl Flow<'_> {
    /// Samples of an orbit at equal intervals, the first one at phase zero, and the ends of its segments.
    pub fn samples(
        &mut self,
        sys: &dyn System,
        shot: &ShootingPoint,
        with_maps: bool,
    ) -> Result<(Vec<OrbitSample>, SegmentEnds), ContinuationError> {
        let period = self.period(shot);
        let parameter = shot.parameter;
        let mut samples: Vec<OrbitSample> = Vec::with_capacity(SAMPLES);
        let ends = self.observed_segments(sys, shot, with_maps, &mut |integrator, k| {
            let end = shot.span(k)[1];
            let phase = |sample: usize| sample as f64 / SAMPLES as f64;
            while samples.len() < SAMPLES && phase(samples.len()) < end {
                let time_s = phase(samples.len()) * period;
                let mut z = vec![0.0; sys.dim()];
                integrator
                    .sample(time_s, &mut z)
                    .map_err(|source| ContinuationError::Integration { parameter, source })?;
                samples.push(OrbitSample {
                    time_s,
                    z,
                    status: integrator.status().to_vec(),
                    crossings: integrator.stats().crossings,
                });
            }
            Ok(())
        })?;
        Ok((samples, ends))
    }

    /// The scale for an orbit or a guess.
    pub fn scale(&mut self, shot: &ShootingPoint) -> Result<Scale, ContinuationError> {
        let sys = self.system(shot.parameter)?;
        let (samples, _) = self.samples(sys.as_ref(), shot, false)?;
        let sizes = sizes(sys.as_ref(), &samples);
        let (period, width) = (self.period(shot), self.width());
        Ok(Scale::new(sys.as_ref(), sizes, period, width))
    }
}

/// The observable of these factors and its rate at the samples of an orbit, the first one again at the end.
pub(super) fn portrait(
    sys: &dyn System,
    factors: &[f64],
    samples: &[OrbitSample],
) -> Vec<[f64; 2]> {
    let observe = |z: &[f64]| factors.iter().zip(z).map(|(a, z)| a * z).sum::<f64>();
    let points = samples.iter().chain(samples.first()).map(|sample| {
        let slope = slope_in(sys, &sample.status, sample.time_s, &sample.z);
        [observe(&sample.z), observe(slope.as_slice())]
    });
    points.collect()
}

/// The largest distances of the vibration and of the first-order components from their means.
pub(super) fn sizes(sys: &dyn System, samples: &[OrbitSample]) -> [f64; 2] {
    let n = sys.tangent_dim();
    let states = || {
        samples
            .iter()
            .map(|s| DVector::from_column_slice(&s.z[..n]))
    };
    let mean = states().sum::<DVector<f64>>() / samples.len() as f64;
    let unit = Scale::new(sys, [1.0; 2], 1.0, 1.0);
    states()
        .map(|state| unit.norms(&(state - &mean)))
        .fold([0.0; 2], |largest: [f64; 2], norms| {
            [0, 1].map(|part| largest[part].max(norms[part]))
        })
}

/// The values of the guards at a sample, for a status.
fn guard_values(switching: &dyn Switching, status: &[u8], sample: &OrbitSample) -> Vec<f64> {
    let mut values = vec![0.0; switching.guards()];
    switching.guard_values(status, sample.time_s, &sample.z, &mut values);
    values
}

/// The rate of a guard along the flow at a sample, for a status.
fn guard_rate(switching: &dyn Switching, status: &[u8], sample: &OrbitSample, guard: usize) -> f64 {
    let mut gradient = vec![0.0; switching.dim()];
    let (t, z) = (sample.time_s, &sample.z);
    let rate = switching.guard_gradient(status, guard, t, z, &mut gradient);
    let slope = slope_in(switching, &sample.status, t, z);
    let along = gradient.iter().zip(slope.iter()).map(|(g, f)| g * f);
    rate + along.sum::<f64>()
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
fn minima(switching: &dyn Switching, samples: &[OrbitSample]) -> Vec<f64> {
    let status = vec![0; switching.status_len()];
    let values: Vec<Vec<f64>> = samples
        .iter()
        .map(|sample| guard_values(switching, &status, sample))
        .collect();
    let h = samples[1].time_s - samples[0].time_s;
    let minimum = |guard: usize| {
        let sum: f64 = values.iter().map(|values| values[guard]).sum();
        let sign = sum.signum();
        let value = |k: &usize| sign * values[*k][guard];
        let lowest = (0..SAMPLES).min_by(|a, b| value(a).total_cmp(&value(b)));
        let near = [SAMPLES - 1, 0, 1].map(|offset| {
            let k = (lowest.unwrap_or(0) + offset) % SAMPLES;
            let rate = sign * guard_rate(switching, &status, &samples[k], guard);
            [value(&k), rate]
        });
        cubic_minimum([near[0], near[1]], h).min(cubic_minimum([near[1], near[2]], h))
    };
    (0..switching.guards()).map(minimum).collect()
}

/// The guard with the lowest minimum that is not a crossing, relative to its largest value.
fn closest_dip(switching: &dyn Switching, samples: &[OrbitSample]) -> Option<(usize, f64)> {
    let values: Vec<Vec<f64>> = samples
        .iter()
        .map(|sample| guard_values(switching, &sample.status, sample))
        .collect();
    let dips = (0..switching.guards()).flat_map(|guard| {
        let known = samples.iter().zip(&values).map(move |(sample, values)| {
            let rate = guard_rate(switching, &sample.status, sample, guard);
            [values[guard], rate]
        });
        let known: Vec<_> = known.collect();
        let largest = known.iter().fold(0.0_f64, |max, v| max.max(v[0].abs()));
        let dip = move |(pair, samples): (&[[f64; 2]], &[OrbitSample])| {
            let is_dip = pair[0][1] < 0.0 && pair[1][1] > 0.0;
            let h = samples[1].time_s - samples[0].time_s;
            (is_dip && largest > 0.0 && samples[0].crossings == samples[1].crossings)
                .then(|| (guard, cubic_minimum([pair[0], pair[1]], h) / largest))
        };
        let pairs = known.windows(2).zip(samples.windows(2));
        pairs.filter_map(dip).collect::<Vec<_>>()
    });
    dips.min_by(|a, b| a.1.total_cmp(&b.1))
}
