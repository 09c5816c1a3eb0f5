//! The sources of error and their levels of refinement.

use serde::{Deserialize, Serialize};

use crate::fem::{Elements, Families};
use crate::joint::{Frequencies, MAX_NODES_WITH_STATES, Quadrature};
use crate::scene::{MAX_ADVISED_STEP, Scene, SceneSetting};

/// A source of error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, strum::IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Source {
    /// Tolerance or step of the integrator.
    Integrator,
    /// Number and quadrature of the contact nodes.
    Nodes,
    /// Number of modes.
    Modes,
    /// Order and size of the finite elements.
    Elements,
    /// Averaging time of the settled motion.
    Averaging,
}

impl Source {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A level of refinement of one source.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The setting in words, such as `100 nodes in rings`.
    pub label: String,
    /// Keys of the scene.
    pub settings: Vec<SceneSetting>,
    /// Index of the next finer level; its own for the finest.
    pub finer: usize,
}

/// A refinement: the levels of one source. Families such as quadratures follow each other, each from coarse to
/// fine. The last level is the reference; all errors are relative to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    pub source: Source,
    pub levels: Vec<Level>,
    /// Settings of the runs that compare the levels, in addition to those of the level.
    pub with: Vec<SceneSetting>,
    /// Whether the reference has no error because it defines the model.
    pub exact: bool,
}

/// Tolerances and fixed steps (s) of the integrator; the last is the reference.
const TOLERANCES: [f64; 8] = [1e-2, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
const STEPS: [f64; 6] = [6.4e-6, 3.2e-6, 1.6e-6, 8e-7, 4e-7, 2e-7];

/// Numbers of contact nodes: those of the rings, and of the Gauss rule with the reference.
const RINGS: [usize; 4] = [28, 64, 201, 452];
const GAUSS: [usize; 7] = [28, 64, 100, 201, 452, 1000, 2000];

/// Finite elements; the last are the reference.
const ELEMENTS: [Elements; 5] = [
    Elements {
        size: 40e-3,
        order: 3,
    },
    Elements {
        size: 40e-3,
        order: 4,
    },
    Elements {
        size: 16e-3,
        order: 4,
    },
    Elements {
        size: 8e-3,
        order: 4,
    },
    Elements {
        size: 4e-3,
        order: 4,
    },
];

/// Averaging times, s; the last is the reference.
pub const AVERAGING: [f64; 7] = [0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56];

impl Refinement {
    /// A refinement of one family from coarse to fine.
    fn new(source: Source, levels: Vec<(String, Vec<SceneSetting>)>) -> Self {
        let last = levels.len() - 1;
        let levels = levels.into_iter().enumerate();
        let level = |(k, (label, settings))| Level {
            label,
            settings,
            finer: last.min(k + 1),
        };
        Self {
            source,
            levels: levels.map(level).collect(),
            with: Vec::new(),
            exact: false,
        }
    }

    /// Index of the reference.
    pub fn reference(&self) -> usize {
        self.levels.len() - 1
    }

    /// Whether a level can be chosen: one whose error was measured against a finer level, or the exact one.
    pub fn is_selectable(&self, level: usize) -> bool {
        self.exact || level < self.reference()
    }
}

/// The refinement of the integrator, with the method of the scene. Its reference is also the setting at which the
/// other sources are compared, unless a looser tolerance is sufficient for them.
pub fn integrator(scene: &Scene) -> Refinement {
    let method = scene.integrator.method;
    let setting = |value: f64| {
        let micros = |step: f64| (1e9 * step).round() / 1e3;
        let (label, number, step) = match method.has_fixed_step() {
            true => (format!("{} us", micros(value)), None, value),
            false => (format!("{value:e}"), Some(value), MAX_ADVISED_STEP),
        };
        let tolerance = number.map(|value| SceneSetting::number("time.tolerance", value));
        let settings = [
            SceneSetting::word("time.method", method.name()),
            SceneSetting::number("time.max_step_us", micros(step)),
        ];
        (
            format!("{} {label}", method.name()),
            settings.into_iter().chain(tolerance).collect(),
        )
    };
    let values = match method.has_fixed_step() {
        true => &STEPS[..],
        false => &TOLERANCES[..],
    };
    Refinement::new(
        Source::Integrator,
        values.iter().map(|value| setting(*value)).collect(),
    )
}

/// The refinement of the contact nodes. Friction with states limits them.
fn contact(has_states: bool) -> Refinement {
    let most = if has_states {
        MAX_NODES_WITH_STATES
    } else {
        usize::MAX
    };
    let nodes = |quadrature: Quadrature, count: usize| {
        let name: &str = quadrature.into();
        let place = match quadrature {
            Quadrature::Rings => "in rings",
            Quadrature::Gauss => "of a Gauss rule",
        };
        let settings = vec![
            SceneSetting::number("contact.nodes", count as f64),
            SceneSetting::word("contact.quadrature", name),
        ];
        Level {
            label: format!("{count} nodes {place}"),
            settings,
            finer: 0,
        }
    };
    let up_to =
        |counts: &'static [usize]| counts.iter().copied().filter(move |count| *count <= most);
    let gauss = up_to(&GAUSS).map(|count| nodes(Quadrature::Gauss, count));
    let rings = up_to(&RINGS).map(|count| nodes(Quadrature::Rings, count));
    let mut levels: Vec<Level> = rings.chain(gauss).collect();
    let last = levels.len() - 1;
    let finest_rings = up_to(&RINGS).count() - 1;
    for (k, level) in levels.iter_mut().enumerate() {
        // The finest rings are compared with the reference.
        level.finer = if k == finest_rings {
            last
        } else {
            last.min(k + 1)
        };
    }
    Refinement {
        source: Source::Nodes,
        levels,
        with: Vec::new(),
        exact: false,
    }
}

fn elements() -> Refinement {
    let level = |elements: &Elements| {
        let millimetres = (1e9 * elements.size).round() / 1e6;
        let settings = vec![
            SceneSetting::number("body.element_size_mm", millimetres),
            SceneSetting::number("body.element_order", elements.order as f64),
        ];
        (
            format!("elements of order {} and {millimetres} mm", elements.order),
            settings,
        )
    };
    Refinement::new(Source::Elements, ELEMENTS.iter().map(level).collect())
}

/// Mode sets from that of the scene to twice its size. All modes have the damping ratio of the scene, or none if the
/// body is undamped. `None` if the modes define the model: published frequencies, or different damping ratios of the
/// modes.
fn modes(scene: &Scene) -> Option<Refinement> {
    let body = scene.ball_on_beam().ok()?;
    let damping = &scene.joint().ok()?.spec.damping;
    let uneven = damping.windows(2).any(|pair| pair[0] != pair[1]);
    if uneven || body.frequencies != Frequencies::FiniteElement {
        return None;
    }
    // A list in the scene would not have as many ratios as there are modes.
    let ratio = damping
        .first()
        .map(|ratio| SceneSetting::number("damping.ratio", *ratio));
    let own = body.families;
    let level = |share: f64| {
        let of = |count: usize| (share * count as f64).ceil() as usize;
        let families = Families {
            bending_pairs: of(own.bending_pairs),
            torsion: of(own.torsion),
            axial: of(own.axial),
        };
        let settings = [
            SceneSetting::number("body.bending_pairs", families.bending_pairs as f64),
            SceneSetting::number("body.torsion_modes", families.torsion as f64),
            SceneSetting::number("body.axial_modes", families.axial as f64),
        ];
        let settings = settings.into_iter().chain(ratio.clone()).collect();
        (format!("{} modes", families.count()), settings)
    };
    Some(Refinement::new(
        Source::Modes,
        [0.75, 1.0, 1.4, 2.0].map(level).into(),
    ))
}

/// The refinement of the averaging time, [`AVERAGING`] times `factor`. A run settles for `settling` (s) before.
fn averaging(scene: &Scene, settling: f64, factor: f64) -> Refinement {
    let milliseconds = |time: f64| (1e9 * time).round() / 1e6;
    let level = |&time: &f64| {
        let time = factor * time;
        let duration = scene.duration.max(settling + time);
        let mut settings = vec![SceneSetting::number(
            "time.duration_ms",
            milliseconds(duration),
        )];
        if let Some(spectrum) = &scene.analysis.spectrum {
            let window = spectrum.sliding.window.max(time);
            settings.push(SceneSetting::number(
                "analysis.spectrum.window_ms",
                milliseconds(window),
            ));
        }
        (format!("averaged over {} ms", milliseconds(time)), settings)
    };
    Refinement::new(Source::Averaging, AVERAGING.iter().map(level).collect())
}

/// All refinements of a scene but that of the integrator; averaging is the last, if the motion is measured
/// (`with_motion`).
pub fn others(scene: &Scene, settling: f64, factor: f64, with_motion: bool) -> Vec<Refinement> {
    let mut refinements = Vec::new();
    if let (Ok(joint), None) = (scene.joint(), scene.imported_modes()) {
        refinements.push(contact(joint.spec.friction.states() > 0));
        refinements.extend(modes(scene));
        refinements.push(elements());
    }
    if with_motion {
        refinements.push(averaging(scene, settling, factor));
    }
    refinements
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The body of `periodic-2deg` with modes from finite elements and a table of damping.
    fn levels(damping: &str) -> Option<Vec<Level>> {
        let text = Scene::load("periodic-2deg").unwrap().text;
        let text = text.replace("\"published\"", "\"fe\"");
        let scene = Scene::parse("fe", format!("{text}\n{damping}")).unwrap();
        modes(&scene).map(|refinement| refinement.levels)
    }

    #[test]
    fn every_mode_set_has_the_damping_of_the_scene() {
        let ratio = |level: &Level| {
            let mut settings = level.settings.iter();
            settings
                .find(|setting| setting.key == "damping.ratio")
                .cloned()
        };
        let given = SceneSetting::number("damping.ratio", 0.002);
        for (damping, expected) in [("", None), ("[damping]\nratio = 0.002", Some(given))] {
            let levels = levels(damping).unwrap();
            assert_eq!(levels.len(), 4);
            assert!(levels.iter().all(|level| ratio(level) == expected));
        }
        let uneven: Vec<&str> = [["0.001"; 10].as_slice(), &["0.002"]].concat();
        let uneven = format!("[damping]\nratio = [{}]", uneven.join(", "));
        assert_eq!(levels(&uneven), None);
    }
}
