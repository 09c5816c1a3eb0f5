//! The joint: body, socket, load, contact, friction, damping.

use super::schedule::{self, Table};
use crate::fem::{Elements, Families, Geometry, LengthReading, Material};
use crate::joint::{
    BodySpec, Contact, Frequencies, Friction, JointSpec, MOST_MODES, PUBLISHED, Socket, Stribeck,
};
use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys::{self, Law};
use crate::scene::kind::{Kind, Numbers};
use crate::scene::schedule::Schedule;
use crate::scene::subject::{ScaledRotation, TiltedJoint};

/// The tables that only a joint has.
pub(super) const TABLES: [&str; 7] = [
    "body", "socket", "load", "rotation", "contact", "friction", "damping",
];

/// The joint and what acts on it, and the tables that other files hold.
pub(super) fn tilted(document: &Document<'_>) -> Result<(TiltedJoint, Vec<Table>), SceneError> {
    let load = schedule::find(document, &keys::LOAD_SCHEDULE)?
        .ok_or_else(|| document.missing(&keys::LOAD))?;
    let mut joint = joint(document, load.schedule.at(0.0))?;
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

fn joint(document: &Document<'_>, load: f64) -> Result<JointSpec, SceneError> {
    let body = body(document)?;
    Ok(JointSpec {
        socket: socket(document, &body.geometry)?,
        load,
        azimuth: document.get(&keys::AZIMUTH)?,
        rotation: rotation(document)?,
        contact: Contact {
            nodes: document.get(&keys::NODES)?,
            quadrature: document.get(&keys::QUADRATURE)?,
            stiffness_factor: document.get(&keys::STIFFNESS_FACTOR)?,
            stiffness: document.get(&keys::STIFFNESS)?,
            radius_factor: document.get(&keys::RADIUS_FACTOR)?,
            unilateral: document.get(&keys::UNILATERAL)?,
        },
        friction: friction(document)?,
        damping: damping(document, body.families.count())?,
        body,
    })
}

fn body(document: &Document<'_>) -> Result<BodySpec, SceneError> {
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
    Ok(BodySpec {
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

fn socket(document: &Document<'_>, geometry: &Geometry) -> Result<Socket, SceneError> {
    let diameter = document.get(&keys::SOCKET_DIAMETER)?;
    if diameter <= geometry.ball_diameter {
        return Err(document.inconsistent(
            keys::SOCKET_DIAMETER.path,
            &[keys::BALL_DIAMETER.path],
            format!(
                "the socket ({} mm) is not larger than the ball ({} mm)",
                diameter * 1e3,
                geometry.ball_diameter * 1e3
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

fn rotation(document: &Document<'_>) -> Result<[f64; 3], SceneError> {
    let rotation = document.get(&keys::ROTATION)?;
    if rotation.iter().all(|&component| component == 0.0) {
        return Err(document.inconsistent(
            keys::ROTATION.path,
            &[],
            "the ball does not rotate, so nothing slides",
            "make one component other than 0",
        ));
    }
    Ok(rotation)
}

fn friction(document: &Document<'_>) -> Result<Friction, SceneError> {
    if !document.has("friction") {
        return Ok(Friction::None);
    }
    match document.get(&keys::LAW)? {
        Law::Stribeck => Ok(Friction::Stribeck {
            law: Stribeck {
                mu_s: document.get(&keys::MU_S)?,
                mu_d: document.get(&keys::MU_D)?,
                creep: document.get(&keys::CREEP_SLOPE)?,
                stribeck: document.get(&keys::STRIBECK_SLOPE)?,
            },
            radial: document.get(&keys::RADIAL)?,
        }),
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
