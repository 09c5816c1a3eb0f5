//! The strongest line over a tilt that rises and falls.

use super::Facts;
use crate::number::{quantity, short};
use crate::pipeline::message::ToneChange;

/// Number of jumps that are listed, the last ones.
const JUMPS: usize = 3;

impl Facts<'_> {
    /// Adds the last changes of the line, and the tilts at which it depends on the direction.
    pub fn jumps(&mut self) {
        let Some(tilts) = &self.measured.tilts else {
            return;
        };
        let up = tilts.tilt.map(|_| list(&tilts.up));
        let down = tilts.has_decreased.then(|| list(&tilts.down));
        self.found("jumps with rising tilt", up.as_deref(), "");
        self.found("jumps with falling tilt", down.as_deref(), "");
        if let Some([smallest, largest]) = tilts.differing {
            self.found("lines differ from", Some(smallest), "rad");
            self.found("lines differ up to", Some(largest), "rad");
        }
    }
}

/// The last changes of a line, such as `at 9.1° from 4.14 kHz to 2.05 kHz`.
fn list(changes: &[ToneChange]) -> String {
    let jump = |jump: &ToneChange| {
        let [from, to] = [jump.from, jump.to.frequency].map(|hz| quantity(hz, 3, "Hz"));
        let tilt = short(jump.to.tilt.to_degrees());
        format!("at {tilt}° from {from} to {to}")
    };
    let last = &changes[changes.len().saturating_sub(JUMPS)..];
    match last.iter().map(jump).collect::<Vec<_>>().join("; ") {
        none if none.is_empty() => "none so far".to_owned(),
        jumps => jumps,
    }
}

/// The hysteresis loop.
pub fn facts(facts: &mut Facts<'_>) {
    let Some(tilts) = &facts.measured.tilts else {
        return;
    };
    let differs = tilts.has_decreased.then_some(tilts.differing.is_some());
    let cases = ["different by direction", "equal in both directions"];
    facts.claim("line at the same tilt", cases, true, differs);
    facts.found("current tilt", tilts.tilt, "rad");
    facts.strongest_line();
    facts.jumps();
    facts.found("last jump with rising tilt", tilts.last_up, "rad");
    facts.found("jump back, at a smaller tilt", tilts.back, "rad");
    let both = tilts.last_up.zip(tilts.back);
    facts.found("width of the loop", both.map(|(up, back)| up - back), "rad");
}
