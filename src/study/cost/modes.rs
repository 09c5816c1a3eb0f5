//! The knob of the modes: how many take part, by what the vibration settles to with them.
//!
//! A trajectory with fewer modes leaves that with more at once, however little they matter; so each
//! set settles by itself, and invariants are compared.

use super::averages::{INVARIANTS, LONG, invariant_point, relative};
use super::ground::{Ground, timed};
use super::{CostError, CostSet, Knob};
use crate::fem::Families;
use crate::joint::{BallJoint, Frequencies};
use crate::pipeline::prepare_on;
use crate::scene::Scene;
use crate::study::Watch;
use crate::study::response::{From, Response, ResponseError, ResponsePlan, response};

/// The reference with finite-element frequencies, unless the scene has more; and what the other one has
/// in addition that tells its own error. Of the paper's frequencies there are eleven modes, which are
/// the whole of its model.
const OWN: Families = Families {
    bending_pairs: 10,
    torsion: 5,
    axial: 4,
};
const MORE: usize = 3;
const PUBLISHED: Families = Families {
    bending_pairs: 4,
    torsion: 2,
    axial: 1,
};

/// No more sets than this.
const MOST_SETS: usize = 8;

/// Error allowed in a step while the sets are compared, and while they settle.
const TOLERANCE: f64 = 1e-7;
const SETTLING: f64 = 1e-5;

/// Invariants that are compared: the first two.
const COMPARED: usize = 2;

/// Sets of modes, each with those of the one before, by frequency. The reference is measured twice, one
/// stretch after the other: the difference is its own error.
pub(super) fn mode_sets(
    ground: &mut Ground<'_>,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<CostSet>>, CostError> {
    let scene = &ground.plan.scene;
    let spec = &scene.joint()?.spec;
    let body = scene.ball_on_beam()?;
    let own = &body.families;
    let uneven = spec.damping.windows(2).any(|pair| pair[0] != pair[1]);
    let published = body.frequencies == Frequencies::Published;
    let all = match (uneven, published) {
        // Of other modes the damping is not known.
        (true, _) => *own,
        (false, true) => PUBLISHED,
        (false, false) => at_least(own, &OWN),
    };
    let mut ball = ground.ball.take();
    let reference = with(scene, &all)?;
    let steps = nested(&reference, &mut ball)?;
    let work = (steps.len() + 2) as f64;
    let mut on = || goes_on(0.0);
    let Some((best, _)) = settled(&reference, &mut ball, &mut on)? else {
        return Ok(None);
    };
    let Some((next, _)) = measured(&reference, &best.state, &mut ball, &mut on)? else {
        return Ok(None);
    };
    let mut others = vec![next];
    if !published && !uneven {
        let larger = with(scene, &more(&all))?;
        let Some((found, _)) = settled(&larger, &mut ball, &mut || goes_on(1.0 / work))? else {
            return Ok(None);
        };
        others.push(found);
    }
    let mut sets: Vec<CostSet> = INVARIANTS[..COMPARED]
        .iter()
        .map(|&(name, of)| CostSet {
            knob: Knob::Modes,
            family: name.to_owned(),
            turned: "modes",
            floor: others
                .iter()
                .filter_map(|other| relative(of, other, &best))
                .reduce(f64::max),
            points: Vec::new(),
        })
        .collect();
    for (k, families) in steps.iter().enumerate() {
        let scene = with(scene, families)?;
        let mut on = || goes_on((k + 2) as f64 / work);
        let (found, seconds) = match settled(&scene, &mut ball, &mut on) {
            Ok(None) => return Ok(None),
            Ok(Some((found, seconds))) => (Ok(found), seconds),
            Err(error) => (Err(error), 0.0),
        };
        for (set, (_, of)) in sets.iter_mut().zip(INVARIANTS) {
            let value = families.count() as f64;
            let mut point = invariant_point(value, seconds, &found, &best, of);
            point.detail = words(families);
            set.points.push(point);
        }
    }
    ground.ball = ball;
    Ok(Some(sets))
}

/// A scene with other modes, which are damped like its own.
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

fn at_least(a: &Families, b: &Families) -> Families {
    Families {
        bending_pairs: a.bending_pairs.max(b.bending_pairs),
        torsion: a.torsion.max(b.torsion),
        axial: a.axial.max(b.axial),
    }
}

fn more(families: &Families) -> Families {
    Families {
        bending_pairs: families.bending_pairs + MORE,
        torsion: families.torsion + MORE,
        axial: families.axial + MORE,
    }
}

/// The sets below a scene's own: all its modes up to a frequency, pairs together.
fn nested(scene: &Scene, ball: &mut Option<BallJoint>) -> Result<Vec<Families>, CostError> {
    use crate::fem::ModeKind::{Axial, BendingX, BendingY, Torsion};
    prepare_on(scene, ball)?;
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
    // The last is the scene's own.
    steps.pop();
    let every = steps.len().div_ceil(MOST_SETS).max(1);
    Ok(steps.into_iter().step_by(every).collect())
}

/// "2 bending pairs, 1 torsion".
fn words(families: &Families) -> String {
    let parts = [
        (families.bending_pairs, "bending pair"),
        (families.torsion, "torsion"),
        (families.axial, "axial"),
    ];
    let there = parts.into_iter().filter(|(count, _)| *count > 0);
    let words = there.map(|(count, name)| match (count, name) {
        (2.., "bending pair") => format!("{count} bending pairs"),
        _ => format!("{count} {name}"),
    });
    words.collect::<Vec<_>>().join(", ")
}

/// What a scene settles to from its own start, and the CPU time of measuring that, s. `None` if it was
/// told to stop.
fn settled(
    scene: &Scene,
    ball: &mut Option<BallJoint>,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Option<(Response, f64)>, ResponseError> {
    let look = ResponsePlan {
        exponents: 0,
        portrait: false,
        most: 0.4,
        measure: 0.01,
        ..ResponsePlan::default()
    };
    let mut coarse = scene.clone();
    coarse.integrator.tolerance = SETTLING;
    let found = response(&coarse, From::Cold, &look, ball, &mut |_| goes_on())?;
    match found {
        Some(found) => measured(scene, &found.state, ball, goes_on),
        None => Ok(None),
    }
}

/// The motion from a state on, and the CPU time that it took, s.
fn measured(
    scene: &Scene,
    state: &[f64],
    ball: &mut Option<BallJoint>,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Option<(Response, f64)>, ResponseError> {
    let look = ResponsePlan {
        least: 0.0,
        most: 0.0,
        measure: LONG,
        exponents: 0,
        portrait: false,
        most_calls: None,
    };
    let (found, seconds) = timed(1, || {
        response(scene, From::State(state), &look, ball, &mut |_| goes_on())
    });
    Ok(found?.map(|found| (found, seconds)))
}
