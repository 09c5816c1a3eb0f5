//! Coexisting attractors, and the share of random initial kicks that leads to each.

use schemars::JsonSchema;
use serde::Serialize;

use super::lyapunov::title;
use super::response::SettledResponse;
use super::sweep::SweepPoint;
use crate::analysis::regime::Regime;
use crate::number::{counted, fixed};
use crate::report::{Block, Report, Table};

/// Two motions belong to the same attractor if the frequencies of their strongest lines differ by no more
/// than this fraction.
const SAME_FREQUENCY: f64 = 0.005;

/// And if their amplitudes differ by no more than this fraction.
const SAME_AMPLITUDE: f64 = 0.05;

/// And if their mean displacements differ by no more than this fraction of the amplitude: a symmetric system has two of
/// each that is not symmetric.
const SAME_PLACE: f64 = 0.25;

/// Standard normal quantile of a 95 % interval.
const Z: f64 = 1.96;

/// An attractor, characterised by its regime, frequency, amplitude and place.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Attractor {
    /// Regime: the type of motion.
    pub regime: Regime,
    /// Frequency of the strongest line, Hz; `None` at rest.
    pub frequency_hz: Option<f64>,
    /// Displacement amplitude at the probe, m.
    pub amplitude_m: f64,
    /// Mean displacement of the probe, m.
    pub mean_m: f64,
    /// Seeds of the kicks that led to this attractor.
    // The motion of the first one represents it.
    pub seeds: Vec<u64>,
    /// Share of all kicks that led to this attractor, 0 to 1 (an estimate of its basin stability).
    pub share: f64,
    /// The share's 95 % interval (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209–212).
    pub share_interval: [f64; 2],
}

/// Basins of attraction: the attractors that random kicks of a scene reach.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Basins {
    /// Tilt of the load, rad; `None` for a scene without a load.
    #[serde(rename = "tilt_rad")]
    pub tilt: Option<f64>,
    /// Number of kicks planned.
    pub kicks: usize,
    /// Number of kicks simulated.
    pub simulated: usize,
    /// Number of undecided kicks, without a settled response: the motion still changed, or the simulation
    /// failed.
    pub undecided: usize,
    /// Whether the study was stopped early.
    pub interrupted: bool,
    /// The attractors in descending order of share.
    pub attractors: Vec<Attractor>,
}

impl Basins {
    /// Collects the attractors from the points so far. `kicks` is the number of kicks planned, `tilt` the tilt of the
    /// load, rad.
    pub fn new(tilt: Option<f64>, kicks: usize, points: &[SweepPoint]) -> Self {
        let attractors = attractors(points);
        let decided: usize = attractors.iter().map(|a| a.seeds.len()).sum();
        Self {
            tilt,
            kicks,
            simulated: points.len(),
            undecided: points.len() - decided,
            interrupted: points.len() < kicks,
            attractors,
        }
    }
}

/// Number of seeds of an attractor that are printed. JSON has all of them.
const MAX_SEEDS: usize = 8;

impl Report for Basins {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let attractors = counted(self.attractors.len(), "attractor");
        let rest = format!(": {attractors} from {}", counted(self.simulated, "kick"));
        let mut blocks = vec![Block::heading(title(scene, self.tilt), rest)];
        if self.simulated < self.kicks {
            let (done, all) = (self.simulated, self.kicks);
            let missing = format!("{done} of {all} kicks computed; --resume computes the rest");
            blocks.push(Block::Warning(missing));
        }
        let table = Table::of(&self.attractors)
            .right("share", |it| format!("{:.0} %", 100.0 * it.share))
            .right("95 % interval", |it| {
                let [low, high] = it.share_interval.map(|share| 100.0 * share);
                format!("{low:.0} to {high:.0}")
            })
            .left("type of motion", |it| it.regime.to_string())
            .right("line, Hz", |it| fixed(it.frequency_hz, 1))
            .right("amplitude, µm", |it| fixed(1e6 * it.amplitude_m, 4))
            .left("seeds", |it| {
                let seeds = it.seeds.iter().take(MAX_SEEDS).map(u64::to_string);
                let more = (it.seeds.len() > MAX_SEEDS).then(|| "...".to_owned());
                seeds.chain(more).collect::<Vec<_>>().join(", ")
            });
        blocks.push(table.into());
        if self.undecided > 0 {
            blocks.push(Block::text(format!(
                "{} undecided: the motion had not settled, or the simulation failed; raise --max-transient",
                counted(self.undecided, "kick")
            )));
        }
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.interrupted
    }
}

/// Groups the points of a sweep at constant parameters by attractor, in descending order of share. Points
/// without a settled response belong to no attractor but count in the total.
pub fn attractors(points: &[SweepPoint]) -> Vec<Attractor> {
    let mut found: Vec<Attractor> = Vec::new();
    for point in points {
        let Some(response) = point.found().filter(|response| response.settled) else {
            continue;
        };
        let known = found.iter().position(|known| known.is_that_of(response));
        let known = known.unwrap_or_else(|| {
            found.push(Attractor {
                regime: response.regime,
                frequency_hz: response.lines.first().map(|line| line.frequency),
                amplitude_m: response.amplitude_m,
                mean_m: response.mean_m,
                seeds: Vec::new(),
                share: 0.0,
                share_interval: [0.0, 1.0],
            });
            found.len() - 1
        });
        found[known].seeds.push(point.place.values[0] as u64);
    }
    for attractor in &mut found {
        (attractor.share, attractor.share_interval) = share(attractor.seeds.len(), points.len());
    }
    found.sort_by_key(|attractor| std::cmp::Reverse(attractor.seeds.len()));
    found
}

impl Attractor {
    fn is_that_of(&self, response: &SettledResponse) -> bool {
        let frequency = response.lines.first().map(|line| line.frequency);
        let same_frequency = match (self.frequency_hz, frequency) {
            (Some(one), Some(other)) => (one - other).abs() <= SAME_FREQUENCY * one,
            (one, other) => one.is_none() && other.is_none(),
        };
        let distance = (self.mean_m - response.mean_m).abs();
        // At rest, the amplitude is the residue of the decay.
        let same_motion = if self.regime == Regime::Silent {
            let residue = self.amplitude_m.max(response.amplitude_m);
            distance <= residue + SAME_PLACE * self.mean_m.abs()
        } else {
            (self.amplitude_m - response.amplitude_m).abs() <= SAME_AMPLITUDE * self.amplitude_m
                && distance <= SAME_PLACE * self.amplitude_m
        };
        self.regime == response.regime && same_frequency && same_motion
    }
}

/// A share and its Wilson interval.
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
    use crate::study::sweep::{Axis, Shard, Start, SweepPlan};

    #[test]
    fn shares_have_the_wilson_interval() {
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
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        let values = [
            (Parameter::named("nodes").unwrap(), 28.0),
            (Parameter::named("time.tolerance").unwrap(), 1e-4),
        ];
        let plan = SweepPlan {
            subject: scene.with_values(&values).unwrap(),
            axes: vec![Axis::new(
                Parameter::named("start.seed").unwrap(),
                (1..=6).map(f64::from),
            )],
            starts: vec![Start::Fresh],
            response: ResponsePlan {
                min_transient_s: 0.05,
                max_transient_s: 0.4,
                measurement_s: 0.06,
                exponents: 0,
                orbits: true,
                portrait: false,
                max_rhs_evals: None,
            },
        };
        let mut points = run(&plan, Shard::WHOLE, Vec::new(), 2);
        let found = attractors(&points);
        // 95 % intervals.
        let basins = Basins::new(plan.subject.start_tilt(), plan.size(), &points);
        crate::report::agreement::check(&basins, &[95.0]);
        assert!(found.len() >= 2, "{found:?}");
        let members: usize = found.iter().map(|attractor| attractor.seeds.len()).sum();
        assert!(members <= 6 && found[0].seeds.len() >= found[1].seeds.len());
        let shares: f64 = found.iter().map(|attractor| attractor.share).sum();
        assert!((shares - members as f64 / 6.0).abs() < 1e-12);
        // The order of the points only selects the representative.
        points.reverse();
        let mut backwards: Vec<usize> = attractors(&points).iter().map(|a| a.seeds.len()).collect();
        backwards.sort_unstable();
        let mut forwards: Vec<usize> = found.iter().map(|a| a.seeds.len()).collect();
        forwards.sort_unstable();
        assert_eq!(forwards, backwards);
    }
}
