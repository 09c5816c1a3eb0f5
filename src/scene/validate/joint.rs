//! The joint: body, socket, load, contact, friction, damping.

use std::path::Path;
use std::sync::Arc;

use super::schedule::{self, Table};
use crate::fem::{Elements, Families, Geometry, LengthReading, Material};
use crate::joint::{
    BallOnBeam, BodySpec, Constant, Contact, ContactDamping, Frequencies, Friction, JointSpec,
    MOST_MODES, OwnModes, PUBLISHED, Socket, Stribeck,
};
use crate::scene::error::{Fault, SceneError};
use crate::scene::file::Document;
use crate::scene::keys::{self, DampingLaw, Key, Law, split};
use crate::scene::kind::{Kind, Number, Numbers};
use crate::scene::schedule::Schedule;
use crate::scene::subject::{ScaledRotation, TiltedJoint};

/// The tables that only a joint has.
pub(super) const TABLES: [&str; 8] = [
    "body",
    "socket",
    "load",
    "rotation",
    "contact",
    "contact_damping",
    "friction",
    "damping",
];

/// The joint of a scene file and what acts on it, and the tables that other files hold; `known` are modes
/// that need not be read again.
pub(super) fn tilted(
    document: &Document<'_>,
    file: &str,
    known: Option<&Arc<OwnModes>>,
) -> Result<(TiltedJoint, Vec<Table>), SceneError> {
    let load = schedule::find(document, &keys::LOAD_SCHEDULE)?
        .ok_or_else(|| document.missing(&keys::LOAD))?;
    let mut joint = joint(document, load.schedule.at(0.0), file, known)?;
    let tilt = schedule::find(document, &keys::TILT_SCHEDULE)?
        .ok_or_else(|| document.missing(&keys::TILT))?;
    let factor = schedule::find(document, &keys::FACTOR_SCHEDULE)?;
    let mut tables: Vec<Table> = [load.table, tilt.table].into_iter().flatten().collect();
    let mut rotation = None;
    if let Some(factor) = factor {
        tables.extend(factor.table);
        let scaled = scaled(document, joint.rotation, factor.schedule)?;
        joint.rotation = scaled.at(0.0);
        rotation = Some(scaled);
    }
    let tilted = TiltedJoint {
        spec: joint,
        tilt: tilt.schedule,
        load: load.is_function.then_some(load.schedule),
        rotation,
    };
    Ok((tilted, tables))
}

/// A rotation none of whose components is ever larger than one may be.
fn scaled(
    document: &Document<'_>,
    rad_s: [f64; 3],
    factor: Schedule,
) -> Result<ScaledRotation, SceneError> {
    let largest = rad_s.iter().fold(0.0, |a: f64, w| a.max(w.abs())) * factor.max();
    if !keys::ROTATION.kind.component.range.contains(largest) {
        let forms: Vec<&str> = keys::FACTOR_SCHEDULE.forms().collect();
        return Err(document.inconsistent(
            keys::ROTATION.path,
            &forms,
            format!("with its factor a component would reach {largest} rad/s"),
            format!(
                "reduce one of them: {}",
                keys::ROTATION.kind.component.expected()
            ),
        ));
    }
    Ok(ScaledRotation { rad_s, factor })
}

fn joint(
    document: &Document<'_>,
    load: f64,
    file: &str,
    known: Option<&Arc<OwnModes>>,
) -> Result<JointSpec, SceneError> {
    let body = match document.find(&keys::MODES)? {
        Some(named) => BodySpec::Own(own_modes(document, file, &named, known)?),
        None => BodySpec::BallOnBeam(ball_on_beam(document)?),
    };
    let ball_diameter = match &body {
        BodySpec::BallOnBeam(body) => Some(body.geometry.ball_diameter),
        BodySpec::Own(_) => None,
    };
    let nodes = match &body {
        BodySpec::BallOnBeam(_) => document.get(&keys::NODES)?,
        BodySpec::Own(modes) => modes.nodes(),
    };
    Ok(JointSpec {
        socket: socket(document, ball_diameter)?,
        load,
        azimuth: document.get(&keys::AZIMUTH)?,
        rotation: document.get(&keys::ROTATION)?,
        convection: document.get(&keys::CONVECTION)?,
        contact: Contact {
            nodes,
            quadrature: document.get(&keys::QUADRATURE)?,
            stiffness_factor: document.get(&keys::STIFFNESS_FACTOR)?,
            stiffness: document.get(&keys::STIFFNESS)?,
            radius_factor: document.get(&keys::RADIUS_FACTOR)?,
            unilateral: document.get(&keys::UNILATERAL)?,
            damping: contact_damping(document)?,
        },
        friction: friction(document)?,
        damping: damping(document, body.modes())?,
        body,
    })
}

/// Modes from the file named in a scene file, which says all of the body and its contact patch.
fn own_modes(
    document: &Document<'_>,
    file: &str,
    named: &str,
    known: Option<&Arc<OwnModes>>,
) -> Result<Arc<OwnModes>, SceneError> {
    let patch = [
        keys::NODES.path,
        keys::QUADRATURE.path,
        keys::STIFFNESS.path,
        keys::RADIUS_FACTOR.path,
    ];
    let of_body = |key: &&str| {
        let table = split(key).0;
        (table == "body" || table == "socket") && *key != keys::MODES.path
    };
    let body = keys::ALL.iter().map(|key| key.path()).filter(of_body);
    if let Some(key) = body.chain(patch).find(|key| document.has(key)) {
        let fault = Fault::Inconsistent {
            key,
            problem: format!("body.modes takes body and contact patch from `{named}`"),
            remedy: "remove this key, or body.modes".to_owned(),
        };
        return Err(fault.at(document.place_of(&[key])));
    }
    if let Some(known) = known.filter(|known| known.name() == named) {
        return Ok(Arc::clone(known));
    }
    let beside = Path::new(file).parent().unwrap_or(Path::new(""));
    let path = beside.join(named);
    let modes = OwnModes::read(&path, named).map_err(|problem| SceneError::Modes {
        at: document.place_of(&[keys::MODES.path]),
        file: path.display().to_string(),
        problem: Box::new(problem),
    })?;
    Ok(Arc::new(modes))
}

fn ball_on_beam(document: &Document<'_>) -> Result<BallOnBeam, SceneError> {
    let geometry = Geometry {
        ball_diameter: document.get(&keys::BALL_DIAMETER)?,
        beam_diameter: document.get(&keys::BEAM_DIAMETER)?,
        beam_length: document.get(&keys::BEAM_LENGTH)?,
        reading: document.get(&keys::BEAM_REACHES)?,
    };
    let elements = Elements {
        size: document.get(&keys::ELEMENT_SIZE)?,
        order: document.get(&keys::ELEMENT_ORDER)?,
    };
    dimensions(document, &geometry, &elements)?;
    let families = Families {
        bending_pairs: document.get(&keys::BENDING_PAIRS)?,
        torsion: document.get(&keys::TORSION)?,
        axial: document.get(&keys::AXIAL)?,
    };
    let frequencies = document.get(&keys::FREQUENCIES)?;
    modes(document, &families, &frequencies)?;
    Ok(BallOnBeam {
        geometry,
        material: Material {
            young: document.get(&keys::BODY_YOUNG)?,
            poisson: document.get(&keys::BODY_POISSON)?,
            density: document.get(&keys::DENSITY)?,
        },
        elements,
        families,
        frequencies,
    })
}

/// The beam must be thinner than the ball, reach out of it, and be meshable.
fn dimensions(
    document: &Document<'_>,
    geometry: &Geometry,
    elements: &Elements,
) -> Result<(), SceneError> {
    if geometry.beam_diameter >= geometry.ball_diameter {
        return Err(document.inconsistent(
            keys::BEAM_DIAMETER.path,
            &[keys::BALL_DIAMETER.path],
            format!(
                "the beam ({} mm) is not thinner than the ball ({} mm)",
                geometry.beam_diameter * 1e3,
                geometry.ball_diameter * 1e3
            ),
            "make it smaller than body.ball_diameter_mm",
        ));
    }
    if geometry.reading == LengthReading::ToCentre
        && geometry.beam_length <= geometry.ball_diameter / 2.0
    {
        return Err(document.inconsistent(
            keys::BEAM_LENGTH.path,
            &[keys::BALL_DIAMETER.path],
            "a beam measured to the ball's centre ends inside the ball",
            "make it longer than half of body.ball_diameter_mm",
        ));
    }
    // Squares of the element size fill the meridian section.
    let section = geometry.beam_length * geometry.beam_diameter / 2.0
        + std::f64::consts::PI / 8.0 * geometry.ball_diameter.powi(2);
    let count = section / elements.size.powi(2);
    let limit = elements.limit();
    if count > limit as f64 {
        return Err(document.inconsistent(
            keys::ELEMENT_SIZE.path,
            &[keys::ELEMENT_ORDER.path, keys::BEAM_LENGTH.path],
            format!("a body of this size would take about {count:.0} elements"),
            format!(
                "choose a size that gives at most {limit} of order {}",
                elements.order
            ),
        ));
    }
    Ok(())
}

/// There must be a mode, and published frequencies exist for the paper's modes only.
fn modes(
    document: &Document<'_>,
    families: &Families,
    frequencies: &Frequencies,
) -> Result<(), SceneError> {
    let counts = [
        keys::BENDING_PAIRS.path,
        keys::TORSION.path,
        keys::AXIAL.path,
    ];
    if families.count() == 0 {
        return Err(document.inconsistent(
            keys::BENDING_PAIRS.path,
            &counts,
            "no mode takes part",
            "make one of body.bending_pairs, body.torsion, body.axial at least 1",
        ));
    }
    if families.count() > MOST_MODES {
        return Err(document.inconsistent(
            keys::BENDING_PAIRS.path,
            &counts,
            format!(
                "{} modes take part (a bending pair is two)",
                families.count()
            ),
            format!("take at most {MOST_MODES}"),
        ));
    }
    let beyond = families.bending_pairs > PUBLISHED.bending_pairs
        || families.torsion > PUBLISHED.torsion
        || families.axial > PUBLISHED.axial;
    if *frequencies == Frequencies::Published && beyond {
        return Err(document.inconsistent(
            keys::FREQUENCIES.path,
            &counts,
            format!(
                "the paper publishes frequencies of {} bending pairs, {} torsion modes and {} \
                 axial mode, and more take part",
                PUBLISHED.bending_pairs, PUBLISHED.torsion, PUBLISHED.axial
            ),
            "take fewer modes, or body.frequencies = \"fe\"",
        ));
    }
    Ok(())
}

fn socket(document: &Document<'_>, ball_diameter: Option<f64>) -> Result<Socket, SceneError> {
    let diameter = document.get(&keys::SOCKET_DIAMETER)?;
    if let Some(ball) = ball_diameter.filter(|ball| diameter <= *ball) {
        return Err(document.inconsistent(
            keys::SOCKET_DIAMETER.path,
            &[keys::BALL_DIAMETER.path],
            format!(
                "the socket ({} mm) is not larger than the ball ({} mm)",
                diameter * 1e3,
                ball * 1e3
            ),
            "make it larger than body.ball_diameter_mm",
        ));
    }
    Ok(Socket {
        diameter,
        young: document.get(&keys::SOCKET_YOUNG)?,
        poisson: document.get(&keys::SOCKET_POISSON)?,
    })
}

fn friction(document: &Document<'_>) -> Result<Friction, SceneError> {
    use keys::{CREEP_SLOPE, MU, MU_D, MU_S, RADIAL, STRIBECK_SLOPE};
    if !document.has("friction") {
        return Ok(Friction::None);
    }
    let law = document.get(&keys::LAW)?;
    let others: &[&Key<Number>] = match law {
        Law::None => &[&MU, &MU_S, &MU_D, &CREEP_SLOPE, &STRIBECK_SLOPE],
        Law::Constant => &[&MU_S, &MU_D, &STRIBECK_SLOPE],
        Law::Stribeck => &[&MU],
    };
    refuse(document, others, keys::LAW.path)?;
    let radial = document.get(&RADIAL)?;
    Ok(match law {
        Law::None => Friction::None,
        Law::Constant => Friction::Constant {
            law: Constant {
                mu: needed(document, &MU)?,
                creep: document.get(&CREEP_SLOPE)?,
            },
            radial,
        },
        Law::Stribeck => Friction::Stribeck {
            law: Stribeck {
                mu_s: needed(document, &MU_S)?,
                mu_d: needed(document, &MU_D)?,
                creep: document.get(&CREEP_SLOPE)?,
                stribeck: document.get(&STRIBECK_SLOPE)?,
            },
            radial,
        },
    })
}

fn contact_damping(document: &Document<'_>) -> Result<ContactDamping, SceneError> {
    use keys::{DISSIPATION, RETARDATION};
    if !document.has("contact_damping") {
        return Ok(ContactDamping::None);
    }
    let law = document.get(&keys::DAMPING_LAW)?;
    let other = match law {
        DampingLaw::KelvinVoigt => &DISSIPATION,
        DampingLaw::HuntCrossley => &RETARDATION,
    };
    refuse(document, &[other], keys::DAMPING_LAW.path)?;
    Ok(match law {
        DampingLaw::KelvinVoigt => ContactDamping::KelvinVoigt {
            time: needed(document, &RETARDATION)?,
        },
        DampingLaw::HuntCrossley => ContactDamping::HuntCrossley {
            dissipation: needed(document, &DISSIPATION)?,
        },
    })
}

/// A number that the law chosen needs.
fn needed(document: &Document<'_>, key: &Key<Number>) -> Result<f64, SceneError> {
    match document.find(key)? {
        Some(number) => Ok(number),
        None => Err(document.missing(key)),
    }
}

/// Numbers that the law chosen does not have must not be given: they would change nothing.
fn refuse(
    document: &Document<'_>,
    keys: &[&Key<Number>],
    law: &'static str,
) -> Result<(), SceneError> {
    match keys.iter().find(|key| document.has(key.path)) {
        None => Ok(()),
        Some(key) => Err(document.inconsistent(
            key.path,
            &[law],
            "the law chosen has no such number",
            format!("leave it out, or choose another {law}"),
        )),
    }
}

fn damping(document: &Document<'_>, modes: usize) -> Result<Vec<f64>, SceneError> {
    if !document.has("damping") {
        return Ok(Vec::new());
    }
    match document.get(&keys::DAMPING)? {
        Numbers::One(ratio) => Ok(vec![ratio; modes]),
        Numbers::Many(ratios) if ratios.len() == modes => Ok(ratios),
        Numbers::Many(ratios) => Err(document.inconsistent(
            keys::DAMPING.path,
            &[],
            format!("{} ratios for {modes} modes", ratios.len()),
            "give one for each mode (a bending pair is two), or a single number",
        )),
    }
}
