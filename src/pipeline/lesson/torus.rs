//! Attractors: torus and chaos.

use std::f64::consts::{LN_2, LN_10};

use super::Facts;
use crate::analysis::tones::Bases;
use crate::dynamics::Attractor;
use crate::pipeline::message::Regime;
use crate::report::Measured;

/// Name of the fact of which the lesson is contradicted by another type of motion.
pub const MOTION: &str = "type of motion, by the last classification";

/// Number of combination frequencies that are listed.
const COMBINATIONS: usize = 3;

impl Facts<'_> {
    /// Adds the type of motion, which the lesson may explain. One that is not clear contradicts nothing.
    pub fn motion(&mut self, explained: Option<Regime>) {
        let regime = self.measured.regime;
        let unclear = [Regime::Transient, Regime::Noise, Regime::Undetermined];
        let clear = regime.filter(|regime| !unclear.contains(regime));
        let text = regime.map(|regime| regime.to_string());
        let fact = self.found(MOTION, text.as_deref(), "");
        fact.predicted = explained.map(|explained| explained.to_string().as_str().into());
        let both = explained.zip(clear);
        fact.agrees = both.map(|(explained, regime)| regime == explained);
    }

    /// Adds the largest exponents, and whether the attractor that they indicate is the claimed one.
    fn exponents(&mut self, names: &[&str], claimed: &str, fits: fn(Attractor) -> bool) {
        let exponents = self.measured.exponents.as_deref();
        for (k, name) in names.iter().enumerate() {
            let found = exponents.and_then(|found| found.spectrum.exponents.get(k));
            self.estimate(name, found.map(Measured::from), "1/s");
        }
        let attractor = exponents.map(|found| found.attractor());
        let text = attractor.map(|attractor| attractor.to_string());
        let fact = self.found("attractor by the exponents", text.as_deref(), "");
        let decided = attractor.filter(|attractor| attractor.is_decided());
        fact.predicted = Some(claimed.into());
        fact.agrees = decided.map(fits);
    }
}

/// Two base frequencies and their combinations.
pub fn torus(facts: &mut Facts<'_>) {
    let lines = &facts.measured.lines;
    let frequency = |name: &str| {
        let line = lines.iter().find(|line| line.label == name)?;
        Some(line.frequency)
    };
    let [f1, f2] = ["f1", "f2"].map(frequency);
    let beat = Bases::of_names(frequency).beat();
    let has_second = f1.map(|_| beat.is_some());
    facts.claim("second tone", ["present", "none"], true, has_second);
    facts.found("first tone f1", f1, "Hz");
    facts.found("second tone f2", f2, "Hz");
    facts.found("difference frequency", beat, "Hz");
    facts.found("period of the beat", beat.map(|beat| 1.0 / beat), "s");
    let mixed = lines.iter().filter(|line| line.is_mixed());
    let half = lines.iter().find(|line| line.is_half());
    for line in mixed.take(COMBINATIONS).chain(half) {
        facts.found(&line.label, Some(line.frequency), "Hz");
    }
    if half.is_some() {
        facts.found("torus", Some("doubled, with lines half-way between"), "");
    }
    let names = ["largest Lyapunov exponent", "second Lyapunov exponent"];
    let is_torus = |attractor| matches!(attractor, Attractor::Torus(_));
    facts.exponents(&names, "torus", is_torus);
    facts.motion(Some(Regime::QuasiPeriodic));
}

/// The distance of a perturbed trajectory.
pub fn chaos(facts: &mut Facts<'_>) {
    let [first, last] = [0, 1].map(|k| facts.measured.separation.map(|ends| ends[k]));
    let line = last.and_then(|last| last.line);
    let clear = line.filter(|line| line.grows() || line.shrinks());
    let shrinks = clear.map(|line| line.shrinks());
    facts.claim("trajectories", ["converging", "separating"], false, shrinks);
    let [first, now] = [first, last].map(|at| at.map(|at| at.distance));
    facts.found("initial distance, relative to the motion", first, "");
    facts.found("current distance, relative to the motion", now, "");
    let rate = line.map(|line| Measured::new(line.rate_per_s, line.half_width_per_s));
    facts.estimate("growth rate of the distance", rate, "1/s");
    let growing = line.filter(|line| line.grows()).map(|line| line.rate_per_s);
    let after = last.and_then(|last| Some(last.saturated_s? - last.start_s));
    let gain = growing.filter(|_| after.is_some()).map(|rate| LN_10 / rate);
    facts.found("doubling time", growing.map(|rate| LN_2 / rate), "s");
    facts.found("time until it is a tenth of the motion", after, "s");
    facts.found("time gained by tenfold accuracy", gain, "s");
    let names = ["largest Lyapunov exponent"];
    facts.exponents(&names, "chaos", Attractor::is_chaotic);
    facts.motion(Some(Regime::Chaotic));
}
