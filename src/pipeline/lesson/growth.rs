//! Growth of a small vibration: negative slope, and two coupled modes.

use super::Facts;

impl Facts<'_> {
    /// Adds whether a small vibration grows, and how fast.
    pub fn growth(&mut self) {
        let is_unstable = !self.computed.unstable().is_empty();
        let grows = self.measured.grows();
        self.claim("vibration", ["growth", "no growth"], is_unstable, grows);
        self.growth_rate("growth rate, while small", self.computed.fastest());
    }

    /// Adds the growth rate of the velocity level, and compares it with a computed one (1/s) if the vibration grows.
    pub fn growth_rate(&mut self, name: &str, predicted: Option<f64>) {
        let measured = self.measured;
        let rate = self.estimate(name, measured.growth, "1/s");
        rate.against(predicted);
        rate.agrees = rate.agrees.filter(|_| measured.grows() == Some(true));
        if measured.growth.is_none() && measured.growth_ended {
            rate.measured = Some("too short to measure".into());
        }
    }
}

/// Friction that falls with the speed of one mass.
pub fn negative_slope(facts: &mut Facts<'_>) {
    facts.growth();
    if let Some(mode) = facts.computed.modes.first() {
        facts.predicted("frequency", mode.frequency_hz, "Hz");
    }
    facts.strongest_line();
    let held = facts.measured.statuses.map(|shares| shares.held);
    facts.found("share of time sticking", held, "share");
}

/// Two modes that friction couples.
pub fn mode_coupling(facts: &mut Facts<'_>) {
    if let Some(coupling) = facts.computed.coupling {
        facts.given("coefficient of friction", coupling.mu, "");
        match coupling.critical {
            Some(critical) => facts.predicted("critical coefficient", critical, ""),
            None => facts.predicted("critical coefficient", "none, no coupling", ""),
        }
    }
    facts.growth();
    for mode in &facts.computed.modes {
        let name = format!("frequency of the {}", mode.label);
        facts.predicted(&name, mode.frequency_hz, "Hz");
    }
    facts.strongest_line();
    let free = facts.measured.statuses.map(|shares| 1.0 - shares.held);
    facts.found("share of time separated", free, "share");
}
