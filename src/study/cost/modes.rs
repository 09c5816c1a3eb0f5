//! Number of modes, by invariants of the settled vibration.
//!
//! A trajectory with fewer modes deviates immediately, even if the omitted modes hardly matter. Therefore
//! each mode set settles separately and invariants are compared.

use super::averages::{INVARIANT_TIME, INVARIANTS, invariant_point, relative};
use super::baseline::{Baseline, timed};
use super::{CostError, CostSetting, WorkPrecisionSet};
use crate::fem::Families;
use crate::joint::{BallJoint, Frequencies};
use crate::pipeline::prepare_reusing_body;
use crate::scene::Scene;
use crate::study::OnProgress;
use crate::study::response::{
    InitialState, ResponseError, ResponsePlan, SettledResponse, response,
};

/// Modes of the reference with finite-element frequencies, unless the scene has more; and additional modes
/// of the second reference that gives its error. The paper's model has exactly eleven modes with published
/// frequencies.
const REFERENCE_MODES: Families = Families {
    bending_pairs: 10,
    torsion: 5,
    axial: 4,
};
const EXTRA_MODES: usize = 3;
const PUBLISHED: Families = Families {
    bending_pairs: 4,
    torsion: 2,
    axial: 1,
};

/// Maximum number of mode sets.
const MAX_SETS: usize = 8;

/// Tolerances while invariants are measured, and while the motion settles.
const TOLERANCE: f64 = 1e-7;
const SETTLING_TOLERANCE: f64 = 1e-5;

/// Number of invariants compared: the first ones.
const COMPARED: usize = 2;

/// Nested mode sets in order of frequency. The reference is measured in two successive windows; their
/// difference is its error.
pub(super) fn mode_sets(
    baseline: &mut Baseline<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<WorkPrecisionSet>>, CostError> {
    let scene = &baseline.plan.scene;
    let spec = &scene.joint()?.spec;
    let body = scene.ball_on_beam()?;
    let own = &body.families;
    let uneven = spec.damping.windows(2).any(|pair| pair[0] != pair[1]);
    let published = body.frequencies != Frequencies::FiniteElement;
    let all = match (uneven, published) {
        // The damping ratios of additional modes are unknown.
        (true, _) => *own,
        (false, true) => PUBLISHED,
        (false, false) => larger_of(own, &REFERENCE_MODES),
    };
    let mut ball = baseline.ball.take();
    let reference = with(scene, &all)?;
    let steps = nested(&reference, &mut ball)?;
    let work = (steps.len() + 2) as f64;
    let mut on = || should_continue(0.0);
    let Some((best, _)) = settled(&reference, &mut ball, &mut on)? else {
        return Ok(None);
    };
    let Some((next, _)) = measured(&reference, &best.state, &mut ball, &mut on)? else {
        return Ok(None);
    };
    let mut others = vec![next];
    if !published && !uneven {
        let larger = with(scene, &more(&all))?;
        let Some((found, _)) = settled(&larger, &mut ball, &mut || should_continue(1.0 / work))?
        else {
            return Ok(None);
        };
        others.push(found);
    }
    let mut sets: Vec<WorkPrecisionSet> = INVARIANTS[..COMPARED]
        .iter()
        .map(|&(name, of)| WorkPrecisionSet {
            setting: CostSetting::Modes,
            family: name.to_owned(),
            parameter: "modes".into(),
            floor: others
                .iter()
                .filter_map(|other| relative(of, other, &best))
                .reduce(f64::max),
            points: Vec::new(),
        })
        .collect();
    for (k, families) in steps.iter().enumerate() {
        let scene = with(scene, families)?;
        let mut on = || should_continue((k + 2) as f64 / work);
        let (found, seconds) = match settled(&scene, &mut ball, &mut on) {
            Ok(None) => return Ok(None),
            Ok(Some((found, seconds))) => (Ok(found), seconds),
            Err(error) => (Err(error), 0.0),
        };
        for (set, (_, of)) in sets.iter_mut().zip(INVARIANTS) {
            let value = families.count() as f64;
            let mut point = invariant_point(value, seconds, &found, &best, of);
            point.detail = mode_text(families);
            set.points.push(point);
        }
    }
    baseline.ball = ball;
    Ok(Some(sets))
}

/// A scene with another mode set; additional modes have the damping ratio of the last one.
fn with(scene: &Scene, families: &Families) -> Result<Scene, CostError> {
    let mut scene = scene.clone();
    scene.integrator.tolerance = TOLERANCE;
    scene.ball_on_beam_mut()?.families = *families;
    let spec = &mut scene.joint_mut()?.spec;
    if let Some(&last) = spec.damping.last() {
        spec.damping.resize(families.count(), last);
    }
    Ok(scene)
}

fn larger_of(a: &Families, b: &Families) -> Families {
    Families {
        bending_pairs: a.bending_pairs.max(b.bending_pairs),
        torsion: a.torsion.max(b.torsion),
        axial: a.axial.max(b.axial),
    }
}

fn more(families: &Families) -> Families {
    Families {
        bending_pairs: families.bending_pairs + EXTRA_MODES,
        torsion: families.torsion + EXTRA_MODES,
        axial: families.axial + EXTRA_MODES,
    }
}

/// Nested sets of a scene's modes up to a frequency; bending pairs stay together.
fn nested(scene: &Scene, ball: &mut Option<BallJoint>) -> Result<Vec<Families>, CostError> {
    use crate::fem::ModeKind::{Axial, BendingX, BendingY, Torsion};
    prepare_reusing_body(scene, ball)?;
    let Some(joint) = ball else {
        return Ok(Vec::new());
    };
    let body = joint.body()?.modes();
    let mut modes: Vec<_> = joint
        .frequencies_hz()
        .iter()
        .zip(body)
        .filter(|(_, mode)| mode.kind != BendingY)
        .map(|(hz, mode)| (*hz, mode.kind))
        .collect();
    modes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut families = Families {
        bending_pairs: 0,
        torsion: 0,
        axial: 0,
    };
    let mut steps = Vec::new();
    for (_, kind) in modes {
        match kind {
            BendingX | BendingY => families.bending_pairs += 1,
            Torsion => families.torsion += 1,
            Axial => families.axial += 1,
        }
        steps.push(families);
    }
    // The last set is the reference itself.
    steps.pop();
    let every = steps.len().div_ceil(MAX_SETS).max(1);
    Ok(steps.into_iter().step_by(every).collect())
}

/// A mode set as text: "2 bending pairs, 1 torsion".
fn mode_text(families: &Families) -> String {
    let parts = [
        (families.bending_pairs, "bending pair"),
        (families.torsion, "torsion"),
        (families.axial, "axial"),
    ];
    let there = parts.into_iter().filter(|(count, _)| *count > 0);
    let mode_text = there.map(|(count, name)| match (count, name) {
        (2.., "bending pair") => format!("{count} bending pairs"),
        _ => format!("{count} {name}"),
    });
    mode_text.collect::<Vec<_>>().join(", ")
}

/// The settled motion of a scene from its own start, and the CPU time of its measurement, s; `None` if
/// stopped.
fn settled(
    scene: &Scene,
    ball: &mut Option<BallJoint>,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Option<(SettledResponse, f64)>, ResponseError> {
    let look = ResponsePlan {
        exponents: 0,
        orbits: false,
        portrait: false,
        max_transient: 0.4,
        measurement_time: 0.01,
        ..ResponsePlan::default()
    };
    let mut coarse = scene.clone();
    coarse.integrator.tolerance = SETTLING_TOLERANCE;
    let found = response(&coarse, InitialState::Fresh, &look, ball, &mut |_| {
        should_continue()
    })?;
    match found {
        Some(found) => measured(scene, &found.state, ball, should_continue),
        None => Ok(None),
    }
}

/// The motion measured from a given state, and its CPU time, s.
fn measured(
    scene: &Scene,
    state: &[f64],
    ball: &mut Option<BallJoint>,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Option<(SettledResponse, f64)>, ResponseError> {
    let look = ResponsePlan {
        min_transient: 0.0,
        max_transient: 0.0,
        measurement_time: INVARIANT_TIME,
        exponents: 0,
        orbits: false,
        portrait: false,
        max_rhs_evals: None,
    };
    let (found, seconds) = timed(1, || {
        response(scene, InitialState::State(state), &look, ball, &mut |_| {
            should_continue()
        })
    });
    Ok(found?.map(|found| (found, seconds)))
}
