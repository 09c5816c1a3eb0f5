//! What accuracy costs as its recording shows it: what a study found, in the terms of a recording.

use crate::record::cost::{AdviceView, CostView, FamilyView, KnobView, SettingView};
use crate::study::cost::{CostPlan, CostSet, CostStudy, Knob, advice};

/// The work-precision sets of a plan, with the advice that follows.
pub(super) fn cost_view(plan: &CostPlan, study: &CostStudy, command: &str) -> CostView {
    let knobs = Knob::ALL.into_iter().filter_map(|knob| {
        let sets = study.sets.iter().filter(|set| set.knob == knob);
        let families: Vec<FamilyView> = sets.map(family_view).collect();
        (!families.is_empty()).then(|| KnobView {
            name: knob.name(),
            about: about(knob),
            error: knob.error(),
            families,
            advice: match knob {
                Knob::Integrator => advice_views(study),
                _ => Vec::new(),
            },
        })
    });
    CostView {
        scene: study.scene.clone(),
        title: plan.scene.title.clone(),
        scene_text: plan.scene.text.clone(),
        command: command.to_owned(),
        held: study.held,
        horizon: study.horizon,
        knobs: knobs.collect(),
    }
}

fn family_view(set: &CostSet) -> FamilyView {
    let settings = set.points.iter().map(|point| SettingView {
        value: point.value,
        seconds: point.seconds,
        calls: point.calls,
        error: point.error.clone(),
        detail: point.detail.clone(),
    });
    FamilyView {
        name: set.family.clone(),
        turned: set.turned,
        floor: set.floor,
        settings: settings.collect(),
    }
}

fn advice_views(study: &CostStudy) -> Vec<AdviceView> {
    let advised = advice(&study.sets).into_iter().map(|advice| AdviceView {
        target: advice.target,
        family: advice.method,
        value: advice.value,
    });
    advised.collect()
}

/// What is turned and what its error is compared with.
fn about(knob: Knob) -> &'static str {
    match knob {
        Knob::Integrator => {
            "Method and tolerance (of `rk4` the step), by the trajectory: the largest deviation of the state \
             from that of a reference with a tolerance of 1e-12, in the norm of the vibration's energy, \
             relative to its size."
        }
        Knob::Invariants => {
            "The tolerance of the scene's own method, by what does not depend on the trajectory and so can \
             be compared beyond its horizon, in chaos, too."
        }
        Knob::Events => {
            "Whether steps of `lawson54` go through events (a node opens or closes) or end exactly there, \
             by the trajectory."
        }
        Knob::Nodes => {
            "Family and number of the contact nodes, by the trajectory, beside a reference with 4000 of them."
        }
        Knob::Modes => {
            "How many natural modes the body has, from the lowest up, by what the vibration settles to, beside \
             that with all modes: eleven of the paper's frequencies, or many of the finite elements' own."
        }
        Knob::Elements => {
            "Size of the finite elements, by the natural frequencies, beside those of a finer mesh."
        }
        Knob::Exponents => {
            "How long the growth of tangent vectors is averaged, by half of the 95 % interval of the \
             largest Lyapunov exponent. The reference is four times as long as the longest."
        }
        Knob::Recurrence => {
            "How many states are compared and what counts as near, by the determinism, beside that of a \
             longer series."
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::study::cost::CostPoint;

    #[test]
    fn knobs_come_in_their_order_and_only_the_integrator_is_advised() {
        let plan = CostPlan::new(Scene::load("torus-3deg").unwrap());
        let set = |knob, family: &str, error: Result<f64, String>| CostSet {
            knob,
            family: family.to_owned(),
            turned: "tolerance",
            floor: Some(1e-9),
            points: vec![CostPoint {
                value: 1e-4,
                seconds: 1e-3,
                calls: 1000,
                error,
                detail: String::new(),
            }],
        };
        let study = CostStudy {
            scene: "torus-3deg".to_owned(),
            held: Default::default(),
            horizon: 4e-3,
            exponent: None,
            stopped: false,
            sets: vec![
                set(Knob::Events, "exact", Ok(1e-5)),
                set(Knob::Integrator, "lawson54", Ok(1e-3)),
                set(Knob::Integrator, "rk4", Err("it blew up".to_owned())),
            ],
        };
        let view = cost_view(&plan, &study, "squeakscope cost");
        let names: Vec<&str> = view.knobs.iter().map(|knob| knob.name).collect();
        assert_eq!(names, ["integrator", "events"]);
        let [integrator, events] = &view.knobs[..] else {
            panic!("two knobs");
        };
        let targets: Vec<f64> = integrator.advice.iter().map(|a| a.target).collect();
        assert_eq!(targets, [1e-2, 1e-3]);
        assert!(
            integrator
                .advice
                .iter()
                .all(|a| integrator.advised(a).is_some())
        );
        assert!(events.advice.is_empty());
        assert_eq!(
            integrator.families[1].settings[0].error,
            Err("it blew up".to_owned())
        );
        assert!(view.scene_text.contains("tilt"));
    }
}
