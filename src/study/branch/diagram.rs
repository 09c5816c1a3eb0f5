//! The branch diagram of a scene over the tilt of the load, in columns for drawing: periodic motions, bifurcations,
//! settled responses and unstable modes of steady sliding.
//!
//! The diagrams of the scenes that ship are stored in `assets/diagrams`, one JSON file each. `assets/diagrams/make`
//! computes them with `squeakscope branch SCENE --tilt 0:10 --diagram FILE`.

use include_dir::{Dir, File, include_dir};
use serde::{Deserialize, Serialize};

use super::equilibria::{BranchPlan, SteadyBifurcation, SteadyBifurcationKind};
use super::orbits::OrbitStarts;
use super::result::{Branch, BranchBifurcation, OrbitBifurcation};
use crate::analysis::regime::Regime;
use crate::dynamics::continuation::{Bifurcation, BifurcationKind, Criticality, PeriodicOrbit};
use crate::number::{quantity, significant, to_digits};
use crate::scene::{Parameter, Scene, preset};
use crate::study::response::{ResponsePlan, SettledResponse};
use crate::study::sweep::{Axis, Shard, Start, SweepPlan, SweepPoint, sweep};
use crate::study::{OnProgress, StudyError};
use crate::text::capitalize;

/// Number of points of steady sliding.
const EQUILIBRIA: usize = 81;
/// Number of tilts of the settled responses: 0.25 degrees apart over 10 degrees, so that the motions that follow one another
/// while the torus doubles have cells of their own.
const RESPONSES: u32 = 41;
/// Significant digits of the columns, and of the tilt of a bifurcation.
const DIGITS: [usize; 2] = [5, 8];

/// A branch diagram over the tilt.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TiltDiagram {
    /// The branches of periodic motions.
    pub branches: Vec<DiagramBranch>,
    /// The bifurcations of steady sliding and of the periodic motions, in ascending order of the tilt.
    pub bifurcations: Vec<DiagramBifurcation>,
    /// The settled responses of a sweep, one entry for each start.
    pub responses: Vec<DiagramResponses>,
    /// Intervals of the tilt with a constant number of unstable modes of steady sliding, in ascending order.
    pub unstable_modes: Vec<UnstableModes>,
}

/// A branch of periodic motions in a diagram: one entry per orbit in each column, in the order along the branch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DiagramBranch {
    /// Tilt, degrees (deg).
    pub tilt_deg: Vec<f64>,
    /// Half the range of the displacement at the probe, the amplitude, m.
    pub amplitude_m: Vec<f64>,
    /// Frequency, Hz.
    pub frequency_hz: Vec<f64>,
    /// Whether the motion is stable: it attracts.
    pub stable: Vec<bool>,
}

/// The kind of a bifurcation in a diagram: of periodic motions, or of steady sliding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum DiagramBifurcationKind {
    /// Of a periodic motion.
    Orbit(BifurcationKind),
    /// Of steady sliding.
    Steady(SteadyBifurcationKind),
}

/// A bifurcation in a diagram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiagramBifurcation {
    /// Kind of the bifurcation.
    pub kind: DiagramBifurcationKind,
    /// Tilt, degrees (deg).
    pub tilt_deg: f64,
    /// Frequency of the motion, or of the mode that becomes unstable, Hz.
    pub frequency_hz: f64,
    /// Whether the motion attracts on one side. Otherwise a settled motion does not change at this tilt.
    pub attracts: bool,
    /// What happens when the tilt passes it, as one sentence of text.
    pub text: String,
}

/// Settled responses of a sweep in a diagram: one entry per tilt in each column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiagramResponses {
    /// Start of each response.
    pub start: Start,
    /// Tilt, degrees (deg), ascending.
    pub tilt_deg: Vec<f64>,
    /// Regime: type of motion.
    pub regime: Vec<Regime>,
    /// Frequency of the strongest line, Hz; `None` for a silent joint.
    pub frequency_hz: Vec<Option<f64>>,
}

/// An interval of the tilt with a constant number of unstable modes of steady sliding.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnstableModes {
    /// Ends of the interval of the tilt, degrees (deg), ascending.
    pub tilt_deg: [f64; 2],
    /// Count of the unstable modes.
    pub count: usize,
}

impl TiltDiagram {
    /// The diagram of the branches over the tilt and of their settled motions.
    pub fn new(branch: &Branch) -> Self {
        let branches = (0..branch.orbit_branches()).map(|k| columns(&branch.course(k)));
        let found = branch.bifurcations.iter();
        let mut bifurcations: Vec<_> = found.map(|found| bifurcation(branch, found)).collect();
        bifurcations.sort_by(|a, b| a.tilt_deg.total_cmp(&b.tilt_deg));
        let mut responses = Start::ALL.map(|it| responses(it, &branch.settled)).to_vec();
        responses.retain(|row| !row.tilt_deg.is_empty());
        let modes = branch.unstable_intervals().into_iter();
        Self {
            branches: branches.collect(),
            bifurcations,
            responses,
            unstable_modes: modes
                .map(|(ends, count)| UnstableModes {
                    tilt_deg: ends.map(|end| to_digits(end, DIGITS[0])),
                    count,
                })
                .collect(),
        }
    }

    /// The bifurcations of settled motions that a change of the tilt (degrees) passes or reaches, in the order in which it
    /// does.
    pub fn passed(&self, from: f64, to: f64) -> Vec<&DiagramBifurcation> {
        let is_passed = |at: f64| (from < at && at <= to) || (to <= at && at < from);
        let all = self.bifurcations.iter();
        let passed = all.filter(|found| found.attracts && is_passed(found.tilt_deg));
        let mut passed: Vec<_> = passed.collect();
        if to < from {
            passed.reverse();
        }
        passed
    }
}

/// The diagram of a scene over an interval of the tilt (degrees), on one thread. `on_part` receives the diagram so far,
/// after steady sliding, the settled responses, and each branch. If `progress` stops the study, the rest is missing.
///
/// # Errors
/// If the joint cannot be built, or has no steady sliding, or no thread can be started.
pub fn tilt_diagram(
    scene: &Scene,
    interval: [f64; 2],
    progress: OnProgress<'_>,
    mut on_part: impl FnMut(TiltDiagram),
) -> Result<TiltDiagram, StudyError> {
    let plan = BranchPlan::new(scene.clone(), Parameter::tilt(), interval, EQUILIBRIA);
    let mut on_branch = |branch: &Branch| on_part(TiltDiagram::new(branch));
    let starts = Some(OrbitStarts::Sweep(scene, 1));
    let branch = plan.follow(starts, progress, &mut on_branch)?;
    Ok(TiltDiagram::new(&branch))
}

/// The settled responses for a diagram: from fresh starts and by continuation downwards from the largest tilt and upwards from
/// the tilt of the scene, as the tilt of its run rises. If `progress` stops the study, the rest is missing.
///
/// # Errors
/// If no thread can be started.
pub(super) fn settled_responses(
    scene: &Scene,
    [from, to]: [f64; 2],
    threads: usize,
    progress: OnProgress<'_>,
) -> Result<Vec<SweepPoint>, StudyError> {
    let step = (to - from) / f64::from(RESPONSES - 1);
    let tilts = (0..RESPONSES).map(|k| from + f64::from(k) * step);
    // With a tolerance for the conversion of the angle.
    let own = scene.start_tilt().unwrap_or(0.0).to_degrees().min(to) - 1e-9;
    let parts = [
        (vec![Start::Fresh, Start::Downward], from, [0.0, 0.7]),
        (vec![Start::Upward], own, [0.7, 0.3]),
    ];
    let mut settled = Vec::new();
    for (starts, lowest, [before, part]) in parts {
        let tilts = tilts.clone().filter(|tilt| *tilt >= lowest);
        let plan = SweepPlan {
            subject: scene.clone(),
            axes: vec![Axis::new(Parameter::tilt(), tilts)],
            starts,
            response: ResponsePlan {
                exponents: 0,
                orbits: false,
                portrait: false,
                ..ResponsePlan::default()
            },
        };
        let mut progress = |share: f64, _: &str| progress(before + part * share, "settled motions");
        let keep = |_: &SweepPoint| Ok::<_, StudyError>(());
        let (shard, known) = (Shard::WHOLE, Vec::new());
        let points = sweep(&plan, shard, known, threads, &mut progress, keep)?;
        let is_whole = points.len() == plan.size();
        settled.extend(points);
        if !is_whole {
            break;
        }
    }
    Ok(settled)
}

fn columns(course: &[(&PeriodicOrbit, bool)]) -> DiagramBranch {
    let column = |of: fn(&PeriodicOrbit) -> f64| {
        let values = course
            .iter()
            .map(|(orbit, _)| to_digits(of(orbit), DIGITS[0]));
        values.collect()
    };
    DiagramBranch {
        tilt_deg: column(|orbit| orbit.parameter),
        amplitude_m: column(|orbit| orbit.amplitude),
        frequency_hz: column(PeriodicOrbit::frequency_hz),
        stable: course.iter().map(|(_, stable)| *stable).collect(),
    }
}

fn bifurcation(branch: &Branch, found: &BranchBifurcation) -> DiagramBifurcation {
    let exact = match found {
        BranchBifurcation::Orbit(OrbitBifurcation { bifurcation, .. }) => DiagramBifurcation {
            kind: DiagramBifurcationKind::Orbit(bifurcation.kind),
            tilt_deg: bifurcation.parameter,
            frequency_hz: bifurcation.frequency_hz,
            attracts: bifurcation.has_stable_side(),
            text: orbit_sentence(bifurcation),
        },
        BranchBifurcation::Steady(steady) => DiagramBifurcation {
            kind: DiagramBifurcationKind::Steady(steady.kind),
            tilt_deg: steady.at.value,
            frequency_hz: steady.frequency_hz,
            attracts: branch.slides_stably_beside(steady.at.value),
            text: steady_sentence(steady),
        },
    };
    DiagramBifurcation {
        tilt_deg: to_digits(exact.tilt_deg, DIGITS[1]),
        frequency_hz: to_digits(exact.frequency_hz, DIGITS[1]),
        ..exact
    }
}

fn responses(start: Start, settled: &[SweepPoint]) -> DiagramResponses {
    let settled = settled.iter().filter(|point| point.place.start == start);
    let found = settled.filter_map(|point| Some((point.place.values[0], point.found()?)));
    let tilts = found.clone().map(|(tilt, _)| to_digits(tilt, DIGITS[0]));
    let regimes = found.clone().map(|(_, found)| found.regime);
    let line = |found: &SettledResponse| Some(to_digits(found.lines.first()?.frequency, DIGITS[0]));
    DiagramResponses {
        start,
        tilt_deg: tilts.collect(),
        regime: regimes.collect(),
        frequency_hz: found.map(|(_, found)| line(found)).collect(),
    }
}

/// The stored diagrams, one JSON file each with the name of a scene. Scenes that differ in their loading over time share one.
static SHIPPED: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/assets/diagrams");

/// The stored diagram (JSON) of the joint and the start of a scene, at any tilt; `None` if no scene that ships has them.
pub fn shipped_diagram(scene: &Scene) -> Option<&'static str> {
    let upright = |scene: &Scene| Some((scene.clone().with_tilt(0.0).ok()?.subject, scene.start));
    let own = upright(scene)?;
    let name = |file: &File<'static>| file.path().file_stem()?.to_str();
    let is_own = |file: &&File<'static>| {
        let stored = name(file).and_then(preset).and_then(|it| it.scene().ok());
        stored.is_some_and(|stored| upright(&stored).as_ref() == Some(&own))
    };
    let stored = SHIPPED.files().filter(is_own);
    // Its own, or that of a scene with the same joint and start.
    let file = stored.min_by_key(|file| name(file) != Some(&*scene.name))?;
    file.contents_utf8()
}

/// What happens to a periodic motion.
fn orbit_sentence(found: &Bifurcation) -> String {
    let tone = format!("the tone of {}", quantity(found.frequency_hz, 4, "Hz"));
    let tilt = degrees(found.parameter);
    if !found.has_stable_side() {
        let point = match found.kind {
            BifurcationKind::NeimarkSacker => " point",
            _ => "",
        };
        return format!(
            "At {tilt}, {tone}, which repels on both sides, has a {}{point}: the settled motion does not change.",
            found.kind
        );
    }
    let jumps = found
        .birth
        .is_some_and(|birth| birth.criticality == Criticality::Subcritical);
    match found.kind {
        BifurcationKind::Fold => {
            let side = match found.fold_curvature {
                Some(curvature) if curvature > 0.0 => "above",
                _ => "below",
            };
            format!(
                "{} exists only {side} {tilt} (fold): beyond, the motion jumps to another one.",
                capitalize(&tone)
            )
        }
        BifurcationKind::PeriodDoubling | BifurcationKind::NeimarkSacker if jumps => format!(
            "When the tilt {}, {tone} becomes unstable and the motion jumps to another one (subcritical {}).",
            passes(found.crossing_rate, &tilt),
            match found.kind {
                BifurcationKind::PeriodDoubling => "period doubling",
                _ => "Neimark-Sacker point",
            },
        ),
        BifurcationKind::PeriodDoubling => format!(
            "When the tilt {}, {tone} becomes unstable and the motion repeats only every second period: a line appears \
             at {} (period doubling).",
            passes(found.crossing_rate, &tilt),
            quantity(0.5 * found.frequency_hz, 4, "Hz"),
        ),
        BifurcationKind::NeimarkSacker => format!(
            "When the tilt {}, {tone} becomes unstable and a second tone grows {} beside it: the motion becomes a torus \
             (Neimark-Sacker point).",
            passes(found.crossing_rate, &tilt),
            quantity(found.torus_frequency_hz.unwrap_or(f64::NAN), 4, "Hz"),
        ),
        BifurcationKind::BranchPoint => {
            format!(
                "At {tilt}, another periodic motion crosses {tone} and may take over its stability."
            )
        }
        BifurcationKind::Grazing => format!(
            "At {tilt}, a contact node of {tone} just touches zero pressure: its sequence of separations changes."
        ),
    }
}

/// What happens to steady sliding.
fn steady_sentence(found: &SteadyBifurcation) -> String {
    let tilt = degrees(found.at.value);
    if found.kind == SteadyBifurcationKind::ZeroEigenvalue {
        return format!("At {tilt}, steady sliding loses its balance without vibration.");
    }
    let criticality = found.cycle.as_ref().map(|cycle| cycle.criticality);
    let birth = match criticality {
        Some(Criticality::Supercritical) => ": its squeak starts softly",
        Some(Criticality::Subcritical) => ": its squeak starts with a jump",
        Some(Criticality::Undetermined) | None => "",
    };
    format!(
        "When the tilt {}, steady sliding becomes unstable in the mode {} at {} ({}){birth}.",
        passes(found.crossing_speed, &tilt),
        found.label,
        quantity(found.frequency_hz, 4, "Hz"),
        found.kind,
    )
}

/// How the tilt passes a bifurcation beyond which a motion is unstable, by the rate of its growth with the tilt.
fn passes(rate: Option<f64>, tilt: &str) -> String {
    match rate {
        Some(rate) if rate > 0.0 => format!("rises above {tilt}"),
        Some(_) => format!("falls below {tilt}"),
        None => format!("passes {tilt}"),
    }
}

fn degrees(tilt: f64) -> String {
    format!("{} degrees", significant(tilt, 4))
}

#[cfg(test)]
mod tests {
    use super::super::equilibria::add_equilibria;
    use super::super::orbits::add_orbits;
    use super::*;
    use crate::study::sweep::tests::run;

    /// The part of the diagram of a scene that starts from the fresh response without tilt, which is the first of the sweep.
    fn first_part(scene: &Scene) -> TiltDiagram {
        let interval = [0.0, 10.0];
        let plan = BranchPlan::new(scene.clone(), Parameter::tilt(), interval, EQUILIBRIA);
        let responses = SweepPlan {
            subject: scene.clone(),
            axes: vec![Axis::new(Parameter::tilt(), [0.0])],
            starts: vec![Start::Fresh],
            response: ResponsePlan {
                exponents: 0,
                orbits: false,
                portrait: false,
                ..ResponsePlan::default()
            },
        };
        let points = run(&responses, Shard::WHOLE, Vec::new(), 1);
        let mut branch = Branch::new(&plan);
        add_equilibria(&plan, &mut branch, &mut |_, _| Ok(())).unwrap();
        let starts = OrbitStarts::Settled(&points);
        add_orbits(&plan, starts, &mut branch, &mut |_, _| Ok(()), &mut |_| ()).unwrap();
        branch.settled = points;
        TiltDiagram::new(&branch)
    }

    /// Columns that differ only in their last digits, by the order of operations of another processor.
    fn assert_close(one: &[f64], other: &[f64]) {
        assert_eq!(one.len(), other.len());
        for (a, b) in one.iter().zip(other) {
            assert!(
                (a - b).abs() <= 2e-4 * a.abs().max(b.abs()) + 1e-9,
                "{a} {b}"
            );
        }
    }

    #[test]
    fn a_stored_diagram_is_what_the_command_computes() {
        let scene = Scene::load("torus-birth").unwrap();
        let stored: TiltDiagram = serde_json::from_str(shipped_diagram(&scene).unwrap()).unwrap();
        let found = first_part(&scene);
        assert_eq!(found.unstable_modes.len(), stored.unstable_modes.len());
        for (a, b) in found.unstable_modes.iter().zip(&stored.unstable_modes) {
            assert_eq!(a.count, b.count);
            assert_close(&a.tilt_deg, &b.tilt_deg);
        }
        let (a, b) = (&found.branches[0], &stored.branches[0]);
        assert_close(&a.tilt_deg, &b.tilt_deg);
        assert_close(&a.amplitude_m, &b.amplitude_m);
        assert_close(&a.frequency_hz, &b.frequency_hz);
        assert_eq!(a.stable, b.stable);
        assert!(!found.bifurcations.is_empty());
        for own in &found.bifurcations {
            let same = stored.bifurcations.iter().find(|other| {
                other.kind == own.kind && (other.tilt_deg - own.tilt_deg).abs() < 1e-5
            });
            assert_eq!(same.map(|other| &other.text), Some(&own.text), "{own:?}");
        }
        let (a, b) = (&found.responses[0], &stored.responses[0]);
        assert_eq!((a.start, a.regime[0]), (b.start, b.regime[0]));
        assert_eq!(a.frequency_hz[0], b.frequency_hz[0]);
    }

    /// The rows below the slider are those of `sweep` with the same start and direction.
    #[test]
    fn stored_responses_agree_with_a_sweep() {
        for name in ["hysteresis", "periodic-2deg"] {
            let scene = Scene::load(name).unwrap();
            let stored: TiltDiagram =
                serde_json::from_str(shipped_diagram(&scene).unwrap()).unwrap();
            let starts = [
                (Start::Fresh, vec![1.75, 3.0, 5.0]),
                (Start::Upward, vec![2.0, 2.25, 2.5, 2.75]),
            ];
            for (start, tilts) in starts {
                let plan = SweepPlan {
                    subject: scene.clone(),
                    axes: vec![Axis::new(Parameter::tilt(), tilts)],
                    starts: vec![start],
                    response: ResponsePlan::default(),
                };
                let points = run(&plan, Shard::WHOLE, Vec::new(), 1);
                let found = responses(start, &points);
                let row = stored
                    .responses
                    .iter()
                    .find(|row| row.start == start)
                    .unwrap();
                for (k, tilt) in found.tilt_deg.iter().enumerate() {
                    let cell = row.tilt_deg.iter().position(|at| at == tilt).unwrap();
                    assert_eq!(row.regime[cell], found.regime[k], "{name} at {tilt}");
                    let [own, other] =
                        [row.frequency_hz[cell], found.frequency_hz[k]].map(Option::unwrap);
                    assert!(
                        (own / other - 1.0).abs() < 0.02,
                        "{name} at {tilt}: {own} {other}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_stored_diagram_belongs_to_a_scene_and_is_small() {
        let is_diagram = |file: &&File<'_>| file.path().extension().is_some_and(|it| it == "json");
        assert!(SHIPPED.files().filter(is_diagram).count() >= 10);
        for file in SHIPPED.files().filter(is_diagram) {
            let name = file.path().file_stem().unwrap().to_str().unwrap();
            let text = file.contents_utf8().unwrap();
            let scene = Scene::load(name).unwrap();
            assert_eq!(shipped_diagram(&scene), Some(text), "{name}");
            assert!(text.len() < 40_000, "{name}: {} bytes", text.len());
            let diagram: TiltDiagram = serde_json::from_str(text).unwrap();
            assert_eq!(diagram.responses.len(), 3, "{name}");
            assert!(!diagram.unstable_modes.is_empty(), "{name}");
            for branch in &diagram.branches {
                let length = branch.tilt_deg.len();
                let others = [branch.amplitude_m.len(), branch.frequency_hz.len()];
                assert_eq!(others, [length; 2], "{name}");
                assert_eq!(branch.stable.len(), length, "{name}");
            }
        }
    }

    #[test]
    fn bifurcations_are_passed_in_the_order_of_the_tilt() {
        let at = |tilt_deg: f64| DiagramBifurcation {
            kind: DiagramBifurcationKind::Orbit(BifurcationKind::Fold),
            tilt_deg,
            frequency_hz: 1e3,
            attracts: true,
            text: String::new(),
        };
        let diagram = TiltDiagram {
            bifurcations: vec![
                at(1.0),
                DiagramBifurcation {
                    attracts: false,
                    ..at(1.5)
                },
                at(2.0),
                at(3.0),
            ],
            ..TiltDiagram::default()
        };
        let passed = |from, to| -> Vec<f64> {
            let passed = diagram.passed(from, to);
            passed.iter().map(|found| found.tilt_deg).collect()
        };
        assert_eq!(passed(0.5, 2.5), [1.0, 2.0]);
        assert_eq!(passed(2.5, 0.5), [2.0, 1.0]);
        // A bifurcation that is reached counts once, on whichever side the tilt leaves it.
        assert_eq!(passed(0.5, 1.0), [1.0]);
        assert!(passed(1.0, 1.5).is_empty() && passed(1.0, 1.0).is_empty());
        assert_eq!(passed(1.0, 0.5), [0.0; 0]);
        let json = serde_json::to_value(at(1.0)).unwrap();
        assert_eq!(json["kind"], "fold");
        let hopf = DiagramBifurcation {
            kind: DiagramBifurcationKind::Steady(SteadyBifurcationKind::Hopf),
            ..at(1.0)
        };
        let text = serde_json::to_string(&hopf).unwrap();
        assert_eq!(
            serde_json::from_str::<DiagramBifurcation>(&text).unwrap(),
            hopf
        );
    }
}
