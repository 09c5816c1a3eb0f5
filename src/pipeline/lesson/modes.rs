//! Several unstable modes: which one dominates.

use super::Facts;

impl Facts<'_> {
    /// Adds frequency and growth rate of each unstable mode, the fastest first.
    fn unstable_modes(&mut self) {
        for mode in self.computed.unstable() {
            let name = |quantity| format!("{quantity} of the {}", mode.label);
            self.predicted(&name("frequency"), mode.frequency_hz, "Hz");
            self.predicted(&name("growth rate"), mode.growth, "1/s");
        }
    }

    /// Adds the modes with the most energy, and the strongest line.
    fn leaders(&mut self) {
        let measured = self.measured;
        let at_end = measured.leader_at_end.as_deref();
        self.found("strongest mode at the end of the growth", at_end, "");
        self.found("strongest mode, last 25 ms", measured.leader.as_deref(), "");
        self.strongest_line();
    }

    /// The unstable mode at the strongest line.
    fn mode_of_line(&self) -> Option<String> {
        let line = self.measured.lines.first()?;
        let mode = self.computed.unstable_near(line.frequency);
        Some(mode.map_or("none", |mode| &mode.label).to_owned())
    }
}

/// The mode that the kick selects.
pub fn which_wins(facts: &mut Facts<'_>) {
    facts.unstable_modes();
    let start = facts.computed.start;
    facts.given("kick at the start", start.kick, "m/s √kg");
    facts.given("seed of the first kick", &*start.seed.to_string(), "");
    facts.leaders();
    let mode = facts.mode_of_line();
    facts.found("mode of the strongest line", mode.as_deref(), "");
    if let Some(kick) = facts.measured.last_kick {
        let kicks = facts.measured.kicks as f64;
        facts.found("kicks since the start", Some(kicks), "");
        facts.found("last kick", Some(kick.size), "m/s √kg");
        facts.found("seed of the last kick", Some(&*kick.seed.to_string()), "");
        facts.found("time of the last kick", Some(kick.time_s), "s");
    }
}

/// Whether the mode that grows fastest dominates the squeak.
pub fn prediction(facts: &mut Facts<'_>) {
    facts.unstable_modes();
    facts.growth_rate("growth rate, while small", None);
    facts.leaders();
    if let Some(fastest) = facts.computed.unstable().first() {
        let mode = facts.mode_of_line();
        let agrees = mode.as_ref().map(|mode| *mode == fastest.label);
        let fact = facts.found("mode of the strongest line", mode.as_deref(), "");
        fact.predicted = Some(fastest.label.as_str().into());
        fact.agrees = agrees;
    }
}
