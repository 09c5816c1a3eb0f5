//! What a recording of what accuracy costs is made of.

use crate::scene::Held;

/// The work-precision sets of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct CostView {
    /// Name of the scene.
    pub scene: String,
    /// Its title.
    pub title: String,
    /// Text of the scene file.
    pub scene_text: String,
    /// How the program was started.
    pub command: String,
    /// Where the scene was held, of what varies in it.
    pub held: Held,
    /// Time over which trajectories are compared, s.
    pub horizon: f64,
    /// The knobs that were turned.
    pub knobs: Vec<KnobView>,
}

/// What was turned, all else held at its reference.
#[derive(Clone, Debug, PartialEq)]
pub struct KnobView {
    /// Its name: that of its tab and of the folder of its entities.
    pub name: &'static str,
    /// What is turned and what the error is compared with, in a sentence or two.
    pub about: &'static str,
    /// What the error is, with its unit if it has one.
    pub error: &'static str,
    /// The families of its settings.
    pub families: Vec<FamilyView>,
    /// The cheapest setting for each of some errors; empty for a knob without advice.
    pub advice: Vec<AdviceView>,
}

/// Settings of one kind, such as the tolerances of a method.
#[derive(Clone, Debug, PartialEq)]
pub struct FamilyView {
    /// What it is called.
    pub name: String,
    /// What is turned within it, and its unit after a comma if it has one.
    pub turned: &'static str,
    /// The error of the reference itself.
    pub floor: Option<f64>,
    /// The settings.
    pub settings: Vec<SettingView>,
}

/// A setting: what it costs, and its error.
#[derive(Clone, Debug, PartialEq)]
pub struct SettingView {
    /// Its value.
    pub value: f64,
    /// CPU time, s.
    pub seconds: f64,
    /// Calls of the right-hand side; 0 where there are none.
    pub calls: u64,
    /// Its error, or why there is none.
    pub error: Result<f64, String>,
    /// What its value does not tell; empty where that is nothing.
    pub detail: String,
}

/// The cheapest setting for an error.
#[derive(Clone, Debug, PartialEq)]
pub struct AdviceView {
    /// The error allowed.
    pub target: f64,
    /// The family of the setting.
    pub family: String,
    /// Its value.
    pub value: f64,
}

impl KnobView {
    /// An advised setting with its family; `None` if it is none of the knob's.
    pub fn advised(&self, advice: &AdviceView) -> Option<(&FamilyView, &SettingView)> {
        let mut families = self.families.iter();
        let family = families.find(|family| family.name == advice.family)?;
        let mut settings = family.settings.iter();
        let setting = settings.find(|setting| setting.value == advice.value)?;
        Some((family, setting))
    }

    /// All settings.
    pub fn settings(&self) -> impl Iterator<Item = &SettingView> {
        self.families.iter().flat_map(|family| &family.settings)
    }
}
