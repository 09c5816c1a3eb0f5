//! Facts: what is predicted before a run, what is measured in it, and whether the two agree.

use schemars::JsonSchema;
use serde::Serialize;

use crate::number::{percent, quantity, short};
use crate::pipeline::message::{Measurements, MechanismPrediction};
use crate::report::{Cell, Measured, Tone};

/// A fact of a lesson.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Fact {
    /// Quantity.
    pub name: String,
    /// Unit of its numbers. Texts show `rad` in degrees and a `share` in percent. Empty for other dimensionless numbers and
    /// for texts.
    pub unit: &'static str,
    /// Computed before the run, given by the scene, or what the lesson claims; `None` for a quantity that is only measured.
    pub predicted: Option<FactValue>,
    /// Measured so far; `None` for a quantity that is only computed, or not yet measured.
    pub measured: Option<FactValue>,
    /// Half-width of the 95 % interval of the measured number; `None` if unknown.
    pub half_width: Option<f64>,
    /// Whether the measured value is the predicted one, a number within its interval; `None` if the run does not decide.
    pub agrees: Option<bool>,
    /// Whether the predicted value is one that the scene gives.
    #[serde(skip)]
    is_given: bool,
}

/// Value of a fact.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum FactValue {
    /// A number in the unit of the fact.
    Number(f64),
    /// A type of motion, the name of a mode, or why there is no number.
    Text(String),
}

impl From<f64> for FactValue {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for FactValue {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl Fact {
    /// The fact as a line: `frequency: predicted 400 Hz, measured 399 Hz, agrees`.
    pub fn line(&self) -> Vec<Cell> {
        let name = format!("{}: ", self.name);
        let predicted = self.predicted.as_ref();
        let word = if self.is_given { "" } else { "predicted " };
        let predicted = predicted.map(|value| format!("{word}{}", self.text(value, None)));
        let Some(value) = &self.measured else {
            let value = predicted.unwrap_or_else(|| "not yet measured".to_owned());
            return vec![(name + &value).into()];
        };
        let before = predicted.map_or(name.clone(), |text| format!("{name}{text}, measured "));
        let text = self.text(value, self.half_width);
        let measured = match (self.agrees, value, &self.predicted) {
            (None, ..) => Tone::Strong.cell(text),
            (Some(true), ..) => Tone::Good.cell(format!("{text}, agrees")),
            (_, FactValue::Number(x), Some(FactValue::Number(y))) if x * y > 0.0 => {
                let off = 100.0 * (x / y - 1.0);
                Tone::Doubtful.cell(format!("{text}, differs by {off:.1} %"))
            }
            _ => Tone::Doubtful.cell(format!("{text}, differs")),
        };
        vec![before.into(), measured]
    }

    /// Compares an estimate with a computed number: they agree within the interval.
    pub fn against(&mut self, computed: Option<f64>) {
        self.predicted = computed.map(FactValue::Number);
        let width = self.half_width.filter(|width| width.is_finite());
        if let (Some(FactValue::Number(found)), Some(computed)) = (&self.measured, computed) {
            self.agrees = width.map(|width| (found - computed).abs() <= width);
        }
    }

    fn text(&self, value: &FactValue, half_width: Option<f64>) -> String {
        let number = match value {
            FactValue::Text(text) => return text.clone(),
            FactValue::Number(number) => *number,
        };
        match (self.unit, half_width) {
            (unit, Some(half_width)) => Measured::new(number, half_width).unit(unit).to_string(),
            ("rad", _) => format!("{}°", short(number.to_degrees())),
            ("share", _) => percent(number),
            (unit @ ("Hz" | "s" | "m/s" | "m/s √kg"), _) => quantity(number, 3, unit),
            (unit, _) => format!("{} {unit}", short(number)).trim_end().to_owned(),
        }
    }
}

/// The facts of a lesson under construction, with what they are about.
pub struct Facts<'a> {
    pub computed: &'a MechanismPrediction,
    pub measured: &'a Measurements,
    pub list: Vec<Fact>,
}

impl Facts<'_> {
    fn add(&mut self, name: &str, unit: &'static str) -> &mut Fact {
        self.list.push(Fact {
            name: name.to_owned(),
            unit,
            ..Fact::default()
        });
        let last = self.list.len() - 1;
        &mut self.list[last]
    }

    /// Adds a value that is only computed.
    pub fn predicted(&mut self, name: &str, value: impl Into<FactValue>, unit: &'static str) {
        self.add(name, unit).predicted = Some(value.into());
    }

    /// Adds a value that the scene gives.
    pub fn given(&mut self, name: &str, value: impl Into<FactValue>, unit: &'static str) {
        let fact = self.add(name, unit);
        fact.predicted = Some(value.into());
        fact.is_given = true;
    }

    /// Adds a value that is only measured; `None` if it is not yet.
    pub fn found<T>(&mut self, name: &str, value: Option<T>, unit: &'static str) -> &mut Fact
    where
        T: Into<FactValue>,
    {
        let fact = self.add(name, unit);
        fact.measured = value.map(Into::into);
        fact
    }

    /// Adds a measured number with its interval.
    pub fn estimate(&mut self, name: &str, x: Option<Measured>, unit: &'static str) -> &mut Fact {
        let fact = self.found(name, x.map(|x| x.value), unit);
        fact.half_width = x.map(|x| x.half_width);
        fact
    }

    /// Adds which of two cases is predicted, and which is observed. The first case may follow if it is predicted; if it is
    /// not, it contradicts the lesson.
    pub fn claim(&mut self, name: &str, cases: [&str; 2], predicted: bool, observed: Option<bool>) {
        let describe = |first| if first { cases[0] } else { cases[1] };
        let fact = self.found(name, observed.map(describe), "");
        fact.predicted = Some(describe(predicted).into());
        let decided = observed.filter(|observed| *observed || !predicted);
        fact.agrees = decided.map(|observed| observed == predicted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Block, markdown};

    fn line(fact: &Fact) -> String {
        markdown(&[Block::Text(fact.line())])
    }

    fn rate(value: f64, half_width: f64) -> Fact {
        Fact {
            name: "rate".to_owned(),
            unit: "1/s",
            measured: Some(value.into()),
            half_width: Some(half_width),
            ..Fact::default()
        }
    }

    #[test]
    fn an_estimate_agrees_with_a_number_within_its_interval() {
        let mut fact = rate(80.0, 1.0);
        assert_eq!(line(&fact), "rate: **80.0 ± 1.0 1/s**\n");
        fact.against(Some(80.5));
        let text = "rate: predicted 80.5 1/s, measured **80.0 ± 1.0 1/s, agrees**\n";
        assert_eq!((fact.agrees, &*line(&fact)), (Some(true), text));
        fact.against(Some(100.0));
        let text = "rate: predicted 100 1/s, measured **80.0 ± 1.0 1/s, differs by -20.0 %**\n";
        assert_eq!((fact.agrees, &*line(&fact)), (Some(false), text));
        fact.against(Some(-5.0));
        let text = "rate: predicted -5 1/s, measured **80.0 ± 1.0 1/s, differs**\n";
        assert_eq!((fact.agrees, &*line(&fact)), (Some(false), text));
        let mut unknown = rate(80.0, f64::INFINITY);
        unknown.against(Some(80.0));
        assert_eq!(unknown.agrees, None);
    }

    #[test]
    fn numbers_have_the_unit_of_the_reader() {
        let shown = |number: f64, unit| {
            let fact = Fact {
                name: "x".to_owned(),
                unit,
                predicted: Some(number.into()),
                ..Fact::default()
            };
            line(&fact)
        };
        assert_eq!(shown(0.05, "rad"), "x: predicted 2.86°\n");
        assert_eq!(shown(0.25, "share"), "x: predicted 25 %\n");
        assert_eq!(shown(4117.0, "Hz"), "x: predicted 4.12 kHz\n");
        assert_eq!(shown(-2.5, "s/m"), "x: predicted -2.5 s/m\n");
        assert_eq!(shown(0.273, ""), "x: predicted 0.273\n");
        let open = Fact {
            name: "x".to_owned(),
            ..Fact::default()
        };
        assert_eq!(line(&open), "x: not yet measured\n");
    }

    #[test]
    fn facts_are_json_with_numbers_and_texts() {
        let mut fact = rate(80.0, 1.0);
        fact.predicted = Some("none".into());
        let json = serde_json::to_value(&fact).unwrap();
        let expected = serde_json::json!({
            "name": "rate", "unit": "1/s", "predicted": "none", "measured": 80.0, "half_width": 1.0, "agrees": null,
        });
        assert_eq!(json, expected);
    }
}
