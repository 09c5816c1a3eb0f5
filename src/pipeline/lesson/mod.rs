//! Lessons: each mechanism is declared once, with its explanation, its prediction and its facts. The stage of the lesson
//! measures what the facts compare.

mod articulation;
mod contact;
mod fact;
mod friction;
mod growth;
mod hysteresis;
mod level;
mod modes;
mod prediction;
mod second_tone;
mod stage;
mod tilt_history;
mod torus;
mod torus_birth;
mod turning;

pub use fact::{Fact, FactValue};
pub(super) use prediction::{for_joint, for_small, sliding_speed};
pub(super) use stage::LessonStage;
pub(crate) use torus::MOTION;

use self::fact::Facts;
use self::prediction::Predict;
use crate::pipeline::message::Lesson;
use crate::scene::Mechanism;

/// Velocity level over the sliding speed below which the vibration counts as inaudible.
const SILENT: f64 = 1e-3;

/// Declaration of a mechanism.
struct Declaration {
    /// Explanation: Markdown that starts with a heading of level 2.
    explanation: &'static str,
    /// Adds the facts.
    facts: fn(&mut Facts<'_>),
    /// Adds to the linear modes of a joint what else is predicted.
    predict: Option<Predict>,
}

impl Declaration {
    fn of(mechanism: Mechanism) -> Self {
        use Mechanism as M;
        match mechanism {
            M::NegativeSlope => Self::new(include_str!("negative.md"), growth::negative_slope),
            M::ModeCoupling => Self::new(include_str!("mode_coupling.md"), growth::mode_coupling),
            M::StickSlip => Self::new(include_str!("stick_slip.md"), contact::stick_slip),
            M::LiftOff => Self::new(include_str!("lift_off.md"), contact::lift_off),
            M::WhichModeWins => Self::new(include_str!("which_mode_wins.md"), modes::which_wins),
            M::Prediction => Self::new(include_str!("prediction.md"), modes::prediction),
            M::Hysteresis => Self::new(include_str!("hysteresis.md"), hysteresis::facts),
            M::Torus => Self::new(include_str!("torus.md"), torus::torus),
            M::Chaos => Self::new(include_str!("chaos.md"), torus::chaos),
            M::TorusBirth => Self::new(include_str!("torus_birth.md"), torus_birth::facts)
                .predicting(torus_birth::predict),
            M::Articulation => Self::new(include_str!("articulation.md"), articulation::facts)
                .predicting(articulation::predict),
            M::ExchangedFriction => Self::new(include_str!("exchanged.md"), friction::exchanged)
                .predicting(friction::predict_exchanged),
            M::Bristles => Self::new(include_str!("bristles.md"), friction::bristles)
                .predicting(friction::predict_memory),
            M::ContactAge => Self::new(include_str!("contact_age.md"), friction::contact_age)
                .predicting(friction::predict_memory),
            M::MeasuredFriction => Self::new(include_str!("measured.md"), friction::measured)
                .predicting(friction::predict_measured),
        }
    }

    fn new(explanation: &'static str, facts: fn(&mut Facts<'_>)) -> Self {
        Self {
            explanation,
            facts,
            predict: None,
        }
    }

    fn predicting(self, predict: Predict) -> Self {
        let predict = Some(predict);
        Self { predict, ..self }
    }
}

impl Lesson {
    /// Explanation of the mechanism: Markdown that starts with a heading of level 2.
    pub fn explanation(&self) -> &'static str {
        Declaration::of(self.computed.mechanism).explanation
    }

    /// What is predicted, what is measured so far, and whether the two agree.
    pub fn facts(&self) -> Vec<Fact> {
        let mut facts = Facts {
            computed: &self.computed,
            measured: &self.measured,
            list: Vec::new(),
        };
        (Declaration::of(self.computed.mechanism).facts)(&mut facts);
        facts.list
    }
}

impl Facts<'_> {
    /// Adds the strongest spectral line. A weak vibration has none that is heard.
    fn strongest_line(&mut self) -> &mut Fact {
        let measured = self.measured;
        let line = measured.lines.first();
        let is_silent = measured.level < SILENT * self.computed.sliding_speed;
        let value = match line {
            _ if measured.at_rest => Some("none, at rest".into()),
            Some(_) if is_silent => Some("none, silent".into()),
            line => line.map(|line| FactValue::from(line.frequency)),
        };
        self.found("strongest line", value, "Hz")
    }
}
