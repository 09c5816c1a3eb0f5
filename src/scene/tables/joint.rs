//! The joint: body, socket, contact, friction, damping; with what acts on it.

use std::path::Path;
use std::sync::Arc;

use super::course::{Course, FileKnots};
use super::load::{AZIMUTH, CONVECTION, FACTOR, LOAD, ROTATION, TILT};
use crate::fem::{Elements, Families, Geometry, LengthReading, Material};
use crate::joint::{
    BallOnBeam, BodySpec, Constant, Contact, ContactDamping, Frequencies, Friction, JointSpec,
    MOST_MODES, OwnModes, PUBLISHED, Quadrature, Socket, StiffnessLaw, Stribeck,
};
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schedule::Schedule;
use crate::scene::schema::kind::Range::{Closed, HalfOpen, Open, Positive};
use crate::scene::schema::kind::{
    Count, Flag, Kind, Number, Numbers, OneOrMany, Text, choice, number,
};
use crate::scene::schema::unit::{
    GIGAPASCAL, KILOGRAM_PER_CUBIC_METRE, MICROSECOND, MILLIMETRE, ONE, SECOND_PER_METRE,
};
use crate::scene::schema::{Key, Otherwise, Schema, keys};
use crate::scene::subject::{ScaledRotation, TiltedJoint};

/// The tables that only a joint has.
pub const TABLES: [&str; 8] = [
    "body",
    "socket",
    "load",
    "rotation",
    "contact",
    "contact_damping",
    "friction",
    "damping",
];

/// What every Young's modulus must be.
const YOUNG: Number = number(GIGAPASCAL, Closed(0.001, 2000.0));

/// What every Poisson's ratio must be.
const POISSON: Number = number(ONE, Open(-1.0, 0.5));

/// What every coefficient of friction must be.
pub const FRICTION: Number = number(ONE, Closed(0.0, 10.0));

/// What the slope factor of a rise at rest must be.
pub const CREEP: Number = number(SECOND_PER_METRE, Positive(1e8));

pub fn declare(schema: &mut Schema) {
    schema.add("body", &MODES);
    BallOnBeam::declare(schema, "body");
    Socket::declare(schema, "socket");
    super::load::declare(schema);
    Contact::declare(schema, "contact");
    Friction::declare(schema, "friction");
    schema.add("damping", &DAMPING);
}

keys! {
    /// File (.npz) of modes and contact patch from another finite-element program, from the folder of the scene file; excludes every other key of `[body]`, `[socket]` and what lays out the patch.
    static MODES: Text = "modes": Text, else "ball and beam as below";

    BallOnBeam {
        /// Dimensions.
        ..geometry: Geometry;
        /// Material of ball and beam.
        ..material: Material;
        /// Finite elements.
        ..elements: Elements;
        /// Natural frequencies: the seven of Fig. 2 of the paper, or the finite-element model's own.
        frequencies = "frequencies": choice::<Frequencies>(), default "published";
        /// Which modes take part.
        ..families: Families;
    }

    Geometry {
        /// Diameter of the ball; smaller than the socket's.
        ball_diameter = "ball_diameter_mm": number(MILLIMETRE, Closed(1.0, 500.0)), default 31.75;
        /// Diameter of the beam; smaller than the ball's.
        beam_diameter = "beam_diameter_mm": number(MILLIMETRE, Closed(0.5, 500.0)), default 20;
        /// Length of the beam.
        beam_length = "beam_length_mm": number(MILLIMETRE, Closed(1.0, 5000.0)), default 200;
        /// Where that length ends: where beam and sphere meet, or at the ball's centre.
        reading = "beam_reaches": choice::<LengthReading>(), default "sphere";
    }

    Material {
        /// Young's modulus of ball and beam.
        young = "young_gpa": YOUNG, default 207;
        /// Poisson's ratio of ball and beam.
        poisson = "poisson": POISSON, default 0.30;
        /// Density of ball and beam.
        density = "density_kg_m3": number(KILOGRAM_PER_CUBIC_METRE, Closed(10.0, 30_000.0)), default 7800;
    }

    Elements {
        /// Longest edge of the finite elements.
        size = "element_size_mm": number(MILLIMETRE, Closed(0.1, 100.0)), default 16.0;
        /// Polynomial order of the finite elements: 1 linear (these lock in bending), 2 quadratic, 3 cubic and so on.
        order = "element_order": Count(*Elements::ORDERS.start() as u32, *Elements::ORDERS.end() as u32), default 4;
    }

    Families {
        /// Bending pairs that take part, from the lowest up; each gives two modes.
        bending_pairs = "bending_pairs": Count(0, 50), default 4;
        /// Torsion modes that take part, from the lowest up.
        torsion = "torsion": Count(0, 50), default 2;
        /// Axial modes that take part, from the lowest up.
        axial = "axial": Count(0, 50), default 1;
    }

    Socket {
        /// Diameter of the socket; larger than the ball's.
        diameter = "diameter_mm": number(MILLIMETRE, Closed(1.0, 1000.0)), default 31.95;
        /// Young's modulus of the socket.
        young = "young_gpa": YOUNG, default 70;
        /// Poisson's ratio of the socket.
        poisson = "poisson": POISSON, default 0.33;
    }

    Contact |table| {
        /// Number of contact nodes.
        nodes = "nodes": Count(1, 10_000), default 100;
        /// Where the nodes are: rings of cells, or a Gauss rule in the weight of the Hertz pressure.
        quadrature = "quadrature": choice::<Quadrature>(), default "rings";
        /// Factor on the Hertz contact stiffness 2 E\* a / (pi a^2).
        stiffness_factor = "stiffness_factor": number(ONE, Positive(1e4)), default 1.0;
        /// How the stiffness is spread over the patch: evenly, or like the pre-stress.
        stiffness = "stiffness": choice::<StiffnessLaw>(), default "uniform";
        /// Factor on the Hertz radius of the patch; load and total stiffness are kept.
        radius_factor = "radius_factor": number(ONE, Closed(0.1, 5.0)), default 1.0;
        /// Whether contact nodes can lift off, Eq. (2).
        unilateral = "unilateral": Flag, default true;
        /// What resists the speed at which the gap closes.
        ..damping: Option<ContactDamping> => "contact_damping";
    } => {
        let damping = damping.unwrap_or_default();
        Contact { nodes, quadrature, stiffness_factor, stiffness, radius_factor, unilateral, damping }
    };
}

/// The laws of contact damping by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
enum DampingLaw {
    /// A dashpot beside the spring.
    KelvinVoigt,
    /// In proportion to the spring's stress.
    HuntCrossley,
}

keys! {
    ContactDamping |table| {
        /// Damping of the contact: a dashpot beside each node's spring, whose force jumps at lift-off, where steps then end whatever `time.events` says; or one in proportion to the spring's stress, which lets go smoothly.
        law = "law": choice::<DampingLaw>();
        /// Retardation time of the dashpot, its viscosity by the contact stiffness.
        time = "retardation_time_us": number(MICROSECOND, Positive(1e4)), else "required with `kelvin-voigt`";
        /// Dissipation `chi`: the stress is that of the spring times 1 + chi du_r/dt.
        dissipation = "dissipation_s_per_m": number(SECOND_PER_METRE, Positive(100.0)), else "required with `hunt-crossley`";
    } => match law {
        DampingLaw::KelvinVoigt => {
            refuse_of_other_law(table, &["dissipation_s_per_m"])?;
            ContactDamping::KelvinVoigt { time: table.needed("retardation_time_us", time)? }
        }
        DampingLaw::HuntCrossley => {
            refuse_of_other_law(table, &["retardation_time_us"])?;
            ContactDamping::HuntCrossley { dissipation: table.needed("dissipation_s_per_m", dissipation)? }
        }
    };
}

/// The friction laws by name; their parameters are keys of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::VariantArray, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
enum Law {
    /// Eq. (5).
    Stribeck,
    /// A constant coefficient, smoothed at rest.
    Constant,
    /// No friction.
    None,
}

keys! {
    Friction |table| {
        /// The law of friction: Eq. (5), or without its fall, or none, which is the same as no table.
        law = "law": choice::<Law>(), default "stribeck";
        /// Coefficient of friction.
        mu = "mu": FRICTION, else "required with `constant`";
        /// Static coefficient of friction.
        mu_s = "mu_s": FRICTION, else "required with `stribeck`";
        /// Kinetic coefficient of friction; usually at most the static one.
        mu_d = "mu_d": FRICTION, else "required with `stribeck`";
        /// Slope factor of the creep region, `d` of Eq. (5); the larger, the sharper the rise at rest.
        creep = "creep_slope_s_per_m": CREEP, default 1000;
        /// Slope factor of the sliding region, `f` of Eq. (5); the larger, the steeper the fall.
        stribeck = "stribeck_slope_s_per_m": number(SECOND_PER_METRE, Closed(0.0, 1e6)), default 10;
        /// Whether the radial part of the friction force in Eq. (8) is kept.
        radial = "radial": Flag, default true;
    } => match law {
        Law::Stribeck => {
            refuse_of_other_law(table, &["mu"])?;
            let (mu_s, mu_d) = (table.needed("mu_s", mu_s)?, table.needed("mu_d", mu_d)?);
            Friction::Stribeck { law: Stribeck { mu_s, mu_d, creep, stribeck }, radial }
        }
        Law::Constant => {
            refuse_of_other_law(table, &["mu_s", "mu_d", "stribeck_slope_s_per_m"])?;
            Friction::Constant { law: Constant { mu: table.needed("mu", mu)?, creep }, radial }
        }
        Law::None => {
            let numbers = ["mu", "mu_s", "mu_d", "creep_slope_s_per_m", "stribeck_slope_s_per_m"];
            refuse_of_other_law(table, &numbers)?;
            Friction::None
        }
    };
}

/// Numbers that the law chosen does not have must not be given: they would change nothing.
fn refuse_of_other_law(table: Table<'_>, numbers: &[&str]) -> Result<(), SceneError> {
    let remedy = format!("leave it out, or choose another {}", table.path_of("law"));
    table.refuse(
        numbers,
        &["law"],
        "the law chosen has no such number",
        &remedy,
    )
}

keys! {
    /// Damping ratio of all modes, or of each mode in the order of frequency.
    static DAMPING: OneOrMany = "ratio": OneOrMany(number(ONE, HalfOpen(0.0, 1.0)));
}

/// The joint of a scene file and what acts on it, and the tables that other files hold; `known` are modes
/// that need not be read again.
pub fn tilted(
    document: &Document<'_>,
    file: &str,
    known: Option<&Arc<OwnModes>>,
) -> Result<(TiltedJoint, Vec<FileKnots>), SceneError> {
    let missing = |path: &str| document.missing(path);
    let load = Course::find(document, &LOAD)?.ok_or_else(|| missing("load.load_n"))?;
    let mut spec = joint(document, load.schedule.at(0.0), file, known)?;
    let tilt = Course::find(document, &TILT)?.ok_or_else(|| missing("load.tilt_deg"))?;
    let mut tables: Vec<FileKnots> = [load.from_file, tilt.from_file]
        .into_iter()
        .flatten()
        .collect();
    let mut rotation = None;
    if let Some(factor) = Course::find(document, &FACTOR)? {
        tables.extend(factor.from_file);
        let scaled = scaled(document, spec.rotation, factor.schedule)?;
        spec.rotation = scaled.at(0.0);
        rotation = Some(scaled);
    }
    let tilted = TiltedJoint {
        spec,
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
    let component = ROTATION.kind.0;
    let largest = rad_s.iter().fold(0.0, |a: f64, w| a.max(w.abs())) * factor.max();
    ensure!(document,
        component.range.contains(largest) => "rotation.rad_s", &FACTOR.paths().collect::<Vec<_>>();
        "with its factor a component would reach {largest} rad/s";
        "reduce one of them: {}", component.expected());
    Ok(ScaledRotation { rad_s, factor })
}

fn joint(
    document: &Document<'_>,
    load: f64,
    file: &str,
    known: Option<&Arc<OwnModes>>,
) -> Result<JointSpec, SceneError> {
    let mut contact = Contact::read(document.table("contact"))?;
    let socket = Socket::read(document.table("socket"))?;
    let body = match document.table("body").find(&MODES)? {
        Some(named) => {
            let modes = own_modes(document, file, &named, known)?;
            contact.nodes = modes.nodes();
            BodySpec::Own(modes)
        }
        None => {
            let body = BallOnBeam::read(document.table("body"))?;
            check_dimensions(document, &body.geometry, &body.elements, &socket)?;
            check_modes(document, &body)?;
            BodySpec::BallOnBeam(body)
        }
    };
    let [loaded, turned] = ["load", "rotation"].map(|path| document.table(path));
    let friction = Option::<Friction>::read(document.table("friction"))?;
    Ok(JointSpec {
        socket,
        load,
        azimuth: loaded.get(&AZIMUTH)?,
        rotation: turned.get(&ROTATION)?,
        convection: turned.get(&CONVECTION)?,
        contact,
        friction: friction.unwrap_or(Friction::None),
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
    let patch = ["nodes", "quadrature", "stiffness", "radius_factor"];
    let excluded = document.schema.0.iter().filter(|key| match &key.table[..] {
        "body" => key.key.name != MODES.name,
        "contact" => patch.contains(&key.key.name),
        table => table == "socket",
    });
    for key in excluded {
        ensure!(document, !document.has(&key.path) => &key.path, &[];
            "body.modes takes body and contact patch from `{named}`";
            "remove this key, or body.modes");
    }
    if let Some(known) = known.filter(|known| known.name() == named) {
        return Ok(Arc::clone(known));
    }
    let beside = Path::new(file).parent().unwrap_or(Path::new(""));
    let path = beside.join(named);
    let modes = OwnModes::read(&path, named).map_err(|problem| SceneError::Modes {
        at: document.place_of(["body.modes"]),
        file: path.display().to_string(),
        problem: Box::new(problem),
    })?;
    Ok(Arc::new(modes))
}

/// The beam must be thinner than the ball, reach out of it, and be meshable; the ball must fit in the socket.
fn check_dimensions(
    document: &Document<'_>,
    body: &Geometry,
    elements: &Elements,
    socket: &Socket,
) -> Result<(), SceneError> {
    let [ball, beam, socket] =
        [body.ball_diameter, body.beam_diameter, socket.diameter].map(|metres| metres * 1e3);
    ensure!(document,
        body.beam_diameter < body.ball_diameter => "body.beam_diameter_mm", &["body.ball_diameter_mm"];
        "the beam ({beam} mm) is not thinner than the ball ({ball} mm)";
        "make it smaller than body.ball_diameter_mm");
    ensure!(document,
        body.reading == LengthReading::ToSphere || body.beam_length > body.ball_diameter / 2.0 => "body.beam_length_mm", &["body.ball_diameter_mm"];
        "a beam measured to the ball's centre ends inside the ball";
        "make it longer than half of body.ball_diameter_mm");
    // Squares of the element size fill the meridian section.
    let section = body.beam_length * body.beam_diameter / 2.0
        + std::f64::consts::PI / 8.0 * body.ball_diameter.powi(2);
    let count = section / elements.size.powi(2);
    let (limit, order) = (elements.limit(), elements.order);
    ensure!(document,
        count <= limit as f64 => "body.element_size_mm", &["body.element_order", "body.beam_length_mm"];
        "a body of this size would take about {count:.0} elements";
        "choose a size that gives at most {limit} of order {order}");
    ensure!(document, socket > ball => "socket.diameter_mm", &["body.ball_diameter_mm"];
        "the socket ({socket} mm) is not larger than the ball ({ball} mm)";
        "make it larger than body.ball_diameter_mm");
    Ok(())
}

/// There must be a mode, and published frequencies exist for the paper's modes only.
fn check_modes(document: &Document<'_>, body: &BallOnBeam) -> Result<(), SceneError> {
    const COUNTS: [&str; 3] = ["body.bending_pairs", "body.torsion", "body.axial"];
    let families = &body.families;
    let count = families.count();
    ensure!(document, count > 0 => "body.bending_pairs", &COUNTS;
        "no mode takes part";
        "make one of body.bending_pairs, body.torsion, body.axial at least 1");
    ensure!(document, count <= MOST_MODES => "body.bending_pairs", &COUNTS;
        "{count} modes take part (a bending pair is two)";
        "take at most {MOST_MODES}");
    let Families {
        bending_pairs,
        torsion,
        axial,
    } = PUBLISHED;
    let are_published = families.bending_pairs <= bending_pairs
        && families.torsion <= torsion
        && families.axial <= axial;
    ensure!(document,
        are_published || body.frequencies == Frequencies::FiniteElement => "body.frequencies", &COUNTS;
        "the paper publishes frequencies of {bending_pairs} bending pairs, {torsion} torsion modes and {axial} axial mode, and more take part";
        "take fewer modes, or body.frequencies = \"fe\"");
    Ok(())
}

fn damping(document: &Document<'_>, modes: usize) -> Result<Vec<f64>, SceneError> {
    let table = document.table("damping");
    if !table.is_given() {
        return Ok(Vec::new());
    }
    let ratios = match table.get(&DAMPING)? {
        Numbers::One(ratio) => vec![ratio; modes],
        Numbers::Many(ratios) => ratios,
    };
    ensure!(document, ratios.len() == modes => "damping.ratio", &[];
        "{} ratios for {modes} modes", ratios.len();
        "give one for each mode (a bending pair is two), or a single number");
    Ok(ratios)
}
