//! Which attractors coexist, and how many of many kicks lead to each.

use serde::Serialize;

use super::response::Response;
use super::sweep::{SweepPlan, SweepPoint};
use crate::analysis::Regime;

/// Motions are of one attractor if the frequencies of their strongest lines differ by no more than
/// this share.
const SAME_FREQUENCY: f64 = 0.005;

/// And if their amplitudes differ by no more than this share.
const SAME_AMPLITUDE: f64 = 0.05;

/// The standard normal deviate of a 95 % interval.
const Z: f64 = 1.96;

/// One attractor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attractor {
    /// Kind of motion.
    pub regime: Regime,
    /// Frequency of its strongest line, Hz; `None` at rest.
    #[serde(rename = "frequency_hz")]
    pub frequency: Option<f64>,
    /// Amplitude at the probe, m.
    #[serde(rename = "amplitude_m")]
    pub amplitude: f64,
    /// Places in the list of points of those that came to it; the first stands for all of them.
    #[serde(skip)]
    pub members: Vec<usize>,
    /// Seeds of the kicks that led to it: the values of the parameter that is swept.
    pub seeds: Vec<u64>,
    /// Its share of all kicks, 0 to 1.
    pub share: f64,
    /// The share's 95 % interval (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209–212).
    pub interval: [f64; 2],
}

/// What random kicks of a scene have come to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Basins {
    /// Tilt of the load, rad; `None` for a scene without a load.
    #[serde(rename = "tilt_rad")]
    pub tilt: Option<f64>,
    /// Kicks in all.
    pub kicks: usize,
    /// Kicks that have been followed.
    pub followed: usize,
    /// Kicks whose motion still changed when it was measured, or could not be followed.
    pub undecided: usize,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
    /// The attractors, the commonest first.
    pub attractors: Vec<Attractor>,
}

impl Basins {
    /// Of the points so far of a sweep over the seed of the kick.
    pub fn new(plan: &SweepPlan, points: &[SweepPoint], interrupted: bool) -> Self {
        let attractors = attractors(points);
        let decided: usize = attractors.iter().map(|a| a.members.len()).sum();
        Self {
            tilt: plan.scene.joint().ok().map(|joint| joint.tilt.at(0.0)),
            kicks: plan.len(),
            followed: points.len(),
            undecided: points.len() - decided,
            interrupted,
            attractors,
        }
    }
}

/// The attractors that points at the same parameters have come to, the commonest first. Points
/// without a response, and those that still changed when they were measured, count among all but
/// come to none.
pub fn attractors(points: &[SweepPoint]) -> Vec<Attractor> {
    let mut found: Vec<Attractor> = Vec::new();
    for (place, point) in points.iter().enumerate() {
        let Some(response) = point
            .outcome
            .as_ref()
            .ok()
            .filter(|response| response.settled)
        else {
            continue;
        };
        let seed = point.place.values[0] as u64;
        match found
            .iter_mut()
            .find(|attractor| attractor.is_that_of(response))
        {
            Some(attractor) => {
                attractor.members.push(place);
                attractor.seeds.push(seed);
            }
            None => found.push(Attractor {
                regime: response.regime,
                frequency: response.lines.first().map(|line| line.frequency),
                amplitude: response.amplitude,
                members: vec![place],
                seeds: vec![seed],
                share: 0.0,
                interval: [0.0, 1.0],
            }),
        }
    }
    for attractor in &mut found {
        (attractor.share, attractor.interval) = share(attractor.members.len(), points.len());
    }
    found.sort_by_key(|attractor| std::cmp::Reverse(attractor.members.len()));
    found
}

impl Attractor {
    fn is_that_of(&self, response: &Response) -> bool {
        let frequency = response.lines.first().map(|line| line.frequency);
        let same_frequency = match (self.frequency, frequency) {
            (Some(one), Some(other)) => (one - other).abs() <= SAME_FREQUENCY * one,
            (one, other) => one.is_none() && other.is_none(),
        };
        // At rest, amplitudes are what is left of the decay.
        let same_amplitude = self.regime == Regime::Silent
            || (self.amplitude - response.amplitude).abs() <= SAME_AMPLITUDE * self.amplitude;
        self.regime == response.regime && same_frequency && same_amplitude
    }
}

/// A share with its interval.
fn share(count: usize, all: usize) -> (f64, [f64; 2]) {
    let n = all.max(1) as f64;
    let p = count as f64 / n;
    let z2 = Z * Z / n;
    let middle = (p + 0.5 * z2) / (1.0 + z2);
    let half = Z / (1.0 + z2) * (p * (1.0 - p) / n + 0.25 * z2 / n).sqrt();
    (p, [(middle - half).max(0.0), (middle + half).min(1.0)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Parameter, Scene};
    use crate::study::response::ResponsePlan;
    use crate::study::sweep::tests::run;
    use crate::study::sweep::{Axis, Shard, Start};

    #[test]
    fn shares_have_wilsons_interval() {
        let (p, [low, high]) = share(0, 20);
        assert_eq!((p, low), (0.0, 0.0));
        // z^2 / (n + z^2)
        assert!((high - 3.8416 / 23.8416).abs() < 1e-12, "{high}");
        let (p, [low, high]) = share(10, 20);
        assert_eq!(p, 0.5);
        assert!(
            (low + high - 1.0).abs() < 1e-12 && (0.29..0.31).contains(&low),
            "{low}"
        );
    }

    #[test]
    fn a_tone_and_a_torus_coexist() {
        let scene = Scene::load("torus-3deg").unwrap();
        let values = [
            (Parameter::named("nodes").unwrap(), 28.0),
            (Parameter::named("time.tolerance").unwrap(), 1e-4),
        ];
        let plan = SweepPlan {
            scene: scene.with_values(&values).unwrap(),
            axes: vec![Axis::new(
                Parameter::named("start.seed").unwrap(),
                (1..=6).map(f64::from),
            )],
            starts: vec![Start::Cold],
            response: ResponsePlan {
                least: 0.05,
                most: 0.4,
                measure: 0.06,
                exponents: 0,
                portrait: false,
                most_calls: None,
            },
        };
        let mut points = run(&plan, Shard::WHOLE, &[], 2);
        let found = attractors(&points);
        println!("{found:?}");
        assert!(found.len() >= 2, "{found:?}");
        let members: usize = found.iter().map(|attractor| attractor.members.len()).sum();
        assert!(members <= 6 && found[0].members.len() >= found[1].members.len());
        let shares: f64 = found.iter().map(|attractor| attractor.share).sum();
        assert!((shares - members as f64 / 6.0).abs() < 1e-12);
        // The order of the points decides nothing but which of them stands for the others.
        points.reverse();
        let mut backwards: Vec<usize> = attractors(&points)
            .iter()
            .map(|a| a.members.len())
            .collect();
        backwards.sort_unstable();
        let mut forwards: Vec<usize> = found.iter().map(|a| a.members.len()).collect();
        forwards.sort_unstable();
        assert_eq!(forwards, backwards);
    }
}
