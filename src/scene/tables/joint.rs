//! Tables of the joint: body, socket, contact, damping; assembly with friction and loading.

use std::sync::Arc;

use strum::{EnumString, IntoStaticStr, VariantArray};

use super::SCHEMA;
use super::friction;
use super::knots::{Curve, MAX_POINTS};
use super::load::{AZIMUTH, CARRY, CONVECTION, FACTOR, LOAD, MOVES_PATCH, ROTATION, SPIN, TILT};
use crate::fem::{Elements, Families, Geometry, LengthReading, Material};
use crate::joint::{
    BallOnBeam, BodySpec, Contact, ContactDamping, Frequencies, Friction, ImportedModes,
    ImportedModesError, JointSpec, MAX_MODES, MAX_NODES_WITH_STATES, PUBLISHED, PressureTable,
    Quadrature, Socket, StiffnessLaw,
};
use crate::numpy::Npz;
use crate::scene::document::{Document, FromTable, Table};
use crate::scene::error::{SceneError, ensure};
use crate::scene::schedule::Schedule;
use crate::scene::schema::kind::Range::{Closed, HalfOpen, Open, Positive};
use crate::scene::schema::kind::{Kind, choice, count, flag, number, one_or_many, tables, text};
use crate::scene::schema::unit::*;
use crate::scene::schema::{IfAbsent, Key, Schema, keys};
use crate::scene::subject::LoadedJoint;

/// Tables that are specific to a joint.
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

/// Range of Young's moduli.
const YOUNG: Kind<f64> = number(GIGAPASCAL, Closed(0.001, 2000.0));

/// Range of Poisson's ratios.
const POISSON: Kind<f64> = number(ONE, Open(-1.0, 0.5));

pub fn declare(schema: &mut Schema) {
    schema.add("body", &MODES);
    BallOnBeam::declare(schema, "body");
    Socket::declare(schema, "socket");
    super::load::declare(schema);
    Contact::declare(schema, "contact");
    PRESSURE.declare(schema);
    friction::declare(schema);
    schema.add("damping", &DAMPING);
}

keys! {
    /// File (.npz) of modes and contact patch from another finite-element program, relative to the folder of the scene file; excludes all other keys of `[body]`, `[socket]` and the layout of the patch.
    static MODES: String = "modes": text(), else "ball and beam, as defined below";

    BallOnBeam {
        /// Dimensions.
        ..geometry: Geometry;
        /// Material of ball and beam.
        ..material: Material;
        /// Finite elements.
        ..elements: Elements;
        /// Natural frequencies: the seven published in Fig. 2 of the paper; these, each scaled by the ratio of the finite-element frequency of this body to that of the body of the paper; or those of the finite-element model.
        frequencies = "frequencies": choice::<Frequencies>(), default "published";
        /// Numbers of modes.
        ..families: Families;
    }

    Geometry {
        /// Diameter of the ball; smaller than that of the socket.
        ball_diameter = "ball_diameter_mm": number(MILLIMETRE, Closed(1.0, 500.0)), default 31.75;
        /// Diameter of the beam; smaller than that of the ball.
        beam_diameter = "beam_diameter_mm": number(MILLIMETRE, Closed(0.5, 500.0)), default 20;
        /// Length of the beam.
        beam_length = "beam_length_mm": number(MILLIMETRE, Closed(1.0, 5000.0)), default 200;
        /// End point of the beam length: the junction of beam and sphere, or the centre of the ball.
        reading = "beam_length_to": choice::<LengthReading>(), default "sphere";
    }

    Material {
        /// Young's modulus of ball and beam.
        young = "youngs_modulus_gpa": YOUNG, default 207;
        /// Poisson's ratio of ball and beam.
        poisson = "poissons_ratio": POISSON, default 0.30;
        /// Density of ball and beam.
        density = "density_kg_m3": number(KILOGRAM_PER_CUBIC_METRE, Closed(10.0, 30_000.0)), default 7800;
    }

    Elements {
        /// Maximum edge length of the finite elements.
        size = "element_size_mm": number(MILLIMETRE, Closed(0.1, 100.0)), default 16.0;
        /// Polynomial order of the finite elements: 1 linear (locks in bending), 2 quadratic, 3 cubic and so on.
        order = "element_order": count(*Elements::ORDERS.start(), *Elements::ORDERS.end()), default 4;
    }

    Families {
        /// Number of bending pairs, from the lowest frequency; each pair is two modes.
        bending_pairs = "bending_pairs": count(0, 50), default 4;
        /// Number of torsion modes, from the lowest frequency.
        torsion = "torsion_modes": count(0, 50), default 2;
        /// Number of axial modes, from the lowest frequency.
        axial = "axial_modes": count(0, 50), default 1;
    }

    Socket {
        /// Diameter of the socket; larger than that of the ball.
        diameter = "diameter_mm": number(MILLIMETRE, Closed(1.0, 1000.0)), default 31.95;
        /// Young's modulus of the socket.
        young = "youngs_modulus_gpa": YOUNG, default 70;
        /// Poisson's ratio of the socket.
        poisson = "poissons_ratio": POISSON, default 0.33;
    }

    Contact |table| {
        /// Number of contact nodes.
        nodes = "nodes": count(1, 10_000), default 16;
        /// Layout of the nodes: rings of cells of equal area, or a Gauss rule for the Hertz pressure and a uniform stiffness.
        quadrature = "quadrature": choice::<Quadrature>(), default "gauss";
        /// Factor on the Hertz contact stiffness 2 E\* a / (pi a^2).
        stiffness_factor = "stiffness_factor": number(ONE, Positive(1e4)), default 1.0;
        /// Distribution of the contact stiffness over the patch: uniform, or proportional to the pre-stress.
        stiffness = "stiffness_distribution": choice::<StiffnessLaw>(), default "uniform";
        /// Factor on the Hertz radius of the patch; load and total stiffness are unchanged.
        radius_factor = "radius_factor": number(ONE, Closed(0.1, 5.0)), default 1.0;
        /// Whether contact nodes can separate, Eq. (2).
        unilateral = "unilateral": flag(), default true;
        /// Damping of the normal contact.
        ..damping: Option<ContactDamping> => "contact_damping";
    } => {
        let damping = damping.unwrap_or_default();
        Contact { nodes, quadrature, stiffness_factor, stiffness, radius_factor, unilateral, damping }
    };
}

/// Names of the contact damping laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray, IntoStaticStr, EnumString)]
#[strum(serialize_all = "kebab-case")]
enum DampingLaw {
    /// A dashpot in parallel with the spring.
    KelvinVoigt,
    /// Damping proportional to the stress of the spring.
    HuntCrossley,
}

keys! {
    ContactDamping |table| {
        /// Law of contact damping: a dashpot in parallel with the spring of each node, whose force jumps at closing (steps then end at events for any value of `time.events`), or Hunt-Crossley damping proportional to the stress of the spring, which is continuous. A node never pulls: its force ends where spring and dashpot together would pull.
        law = "law": choice::<DampingLaw>();
        /// Retardation time of the dashpot: its viscosity divided by the contact stiffness.
        time = "retardation_time_us": number(MICROSECOND, Positive(1e4)), with ["kelvin-voigt"];
        /// Dissipation factor `chi`: the normal stress is that of the spring times 1 + chi du_r/dt.
        dissipation = "dissipation_s_per_m": number(SECOND_PER_METRE, Positive(100.0)), with ["hunt-crossley"];
    } => {
        table.reject_unused("law", law.into())?;
        match law {
            DampingLaw::KelvinVoigt => ContactDamping::KelvinVoigt { time: table.needed("retardation_time_us", time)? },
            DampingLaw::HuntCrossley => {
                ContactDamping::HuntCrossley { dissipation: table.needed("dissipation_s_per_m", dissipation)? }
            }
        }
    };
}

keys! {
    /// Pressure over the radius of the patch instead of that of Hertz, linear between these points and scaled to carry the load along its direction; for wide patches. The last point is the edge of the patch, whose radius does not change with the load. The total stiffness stays that of Hertz: adjust `stiffness_factor`.
    static PRESSURE_POINTS: usize = "pressure": tables(MAX_POINTS), else "the pressure of Hertz";
    /// Distance of the point from the axis of the patch: zero for the first point, then larger than that of the previous point.
    static RADIUS: f64 = "radius_mm": number(MILLIMETRE, Closed(0.0, 250.0));
    /// Pressure at this distance; positive, or zero at the edge.
    static LOCAL_PRESSURE: f64 = "pressure_mpa": number(MEGAPASCAL, Closed(0.0, 1e6));
}

/// The pressure over the radius.
static PRESSURE: Curve = Curve {
    table: "contact",
    list: &PRESSURE_POINTS,
    point: [&RADIUS, &LOCAL_PRESSURE],
    order: ["radius", "larger"],
};

/// Largest half-angle of a Hertz patch, degrees.
const WIDEST_HERTZ_PATCH: f64 = 40.0;

/// Largest radius of a patch with another pressure, in radii of the ball.
const WIDEST_PATCH: f64 = 0.98;

keys! {
    /// Modal damping ratio of all modes, or of each mode in order of frequency.
    static DAMPING: Vec<f64> = "ratio": one_or_many(number(ONE, HalfOpen(0.0, 1.0)));
}

/// Reads the joint and its loading.
pub fn read_joint(document: &Document<'_>) -> Result<LoadedJoint, SceneError> {
    let loaded = document.table("load");
    let (load, _) = loaded.needed("load_n", LOAD.read(document)?)?;
    let mut spec = joint(document, load.at(0.0))?;
    let (largest, degrees) = (load.max(), spec.hertz_half_angle(load.max()));
    let degrees = degrees.map_or(0.0, f64::to_degrees);
    ensure!(document, degrees <= WIDEST_HERTZ_PATCH => "load.load_n", &LOAD.paths();
        "at {largest} N the contact patch has a half-angle of {degrees:.0} degrees, for which Hertz contact is not valid";
        "reduce the load for at most {WIDEST_HERTZ_PATCH} degrees, or give the pressure over the radius as contact.pressure; \
         modes of another program (body.modes) have a patch of their own");
    let (tilt, tilt_is_function) = loaded.needed("tilt_deg", TILT.read(document)?)?;
    let moves_patch = document.table("rotation").get(&MOVES_PATCH)?;
    ensure!(document, !(moves_patch && tilt_is_function) => "rotation.moves_patch", &TILT.paths();
        "the tilt is also a function of time";
        "give the tilt at the start as load.tilt_deg, or remove rotation.moves_patch");
    let full_rotation = spec.rotation;
    let factor = FACTOR.read(document)?.map(|(factor, _)| factor);
    let rotation_factor = factor.unwrap_or_else(|| Schedule::constant(1.0));
    let component = SPIN.limits;
    let fastest = rotation_factor.min().abs().max(rotation_factor.max());
    let largest = full_rotation.iter().fold(0.0, |a: f64, w| a.max(w.abs())) * fastest;
    ensure!(document,
        component.range.contains(largest) => "rotation.angular_velocity_rad_per_s", &FACTOR.paths();
        "with its factor a component reaches {largest} rad/s";
        "reduce the angular velocity or the factor; each component must be {}", component.expected());
    spec.rotation = full_rotation.map(|w| rotation_factor.at(0.0) * w);
    Ok(LoadedJoint {
        spec,
        full_rotation,
        tilt,
        load,
        rotation_factor,
        patch_moves_from: moves_patch.then_some(0.0),
        carry: document.table("time").get(&CARRY)?,
    })
}

/// Reads the pressure over the radius of the patch, if it is given.
fn pressure(
    document: &Document<'_>,
    body: &BallOnBeam,
) -> Result<Option<Arc<PressureTable>>, SceneError> {
    let table = document.table("contact");
    if !table.has(PRESSURE.list.name) {
        return Ok(None);
    }
    ensure!(document, !table.has("radius_factor") => "contact.radius_factor", &["contact.pressure"];
        "the table contact.pressure defines the radius of the patch";
        "remove this key");
    let pressure = PressureTable::new(PRESSURE.points(document)?);
    ensure!(document, pressure.is_some() => "contact.pressure", &[];
        "the points do not define a pressure in the whole patch";
        "give at least two, the first at radius_mm = 0, with a pressure above 0; it may be 0 at the last");
    let radius = pressure.as_ref().map_or(0.0, PressureTable::radius);
    let largest = 0.5e3 * WIDEST_PATCH * body.geometry.ball_diameter;
    ensure!(document, 1e3 * radius <= largest => "contact.pressure", &["body.ball_diameter_mm"];
        "the patch is as wide as the ball";
        "end the table at most at {largest:.2} mm");
    Ok(pressure.map(Arc::new))
}

fn joint(document: &Document<'_>, load: f64) -> Result<JointSpec, SceneError> {
    let mut contact = Contact::read(document.table("contact"))?;
    let socket = Socket::read(document.table("socket"))?;
    let mut own_pressure = None;
    let body = match document.table("body").find(&MODES)? {
        Some(named) => {
            let modes = imported_modes(document, &named)?;
            contact.nodes = modes.nodes();
            BodySpec::Imported(modes)
        }
        None => {
            let body = BallOnBeam::read(document.table("body"))?;
            check_dimensions(document, &body.geometry, &body.elements, &socket)?;
            check_modes(document, &body)?;
            own_pressure = pressure(document, &body)?;
            BodySpec::BallOnBeam(body)
        }
    };
    let [loaded, turned] = ["load", "rotation"].map(|path| document.table(path));
    let friction = Option::<Friction>::read(document.table("friction"))?;
    let friction = friction.unwrap_or(Friction::None);
    let is_limited = friction.states() > 0;
    ensure!(document, !is_limited || contact.nodes <= MAX_NODES_WITH_STATES => "contact.nodes", &["friction.law"];
        "the friction law has states at each contact node, and there are {} nodes", contact.nodes;
        "use at most {MAX_NODES_WITH_STATES} nodes, or choose another friction.law");
    Ok(JointSpec {
        socket,
        load,
        azimuth: loaded.get(&AZIMUTH)?,
        rotation: turned.get(&ROTATION)?,
        convection: turned.get(&CONVECTION)?,
        contact,
        pressure: own_pressure,
        friction,
        damping: damping(document, body.modes())?,
        body,
    })
}

/// Reads the imported modes of a scene, which define body and contact patch.
fn imported_modes(document: &Document<'_>, named: &str) -> Result<Arc<ImportedModes>, SceneError> {
    let patch = [
        "nodes",
        "quadrature",
        "stiffness_distribution",
        "radius_factor",
        "pressure",
    ];
    let excluded = SCHEMA.0.iter().filter(|key| match &key.table[..] {
        "body" => key.name != MODES.name,
        "contact" => patch.contains(&key.name),
        table => table == "socket",
    });
    for key in excluded {
        ensure!(document, !document.has(&key.path) => &key.path, &[];
            "body.modes imports body and contact patch from `{named}`";
            "remove this key, or body.modes");
    }
    if let Some(known) = document.known_modes.filter(|known| known.name() == named) {
        return Ok(Arc::clone(known));
    }
    let path = document.path().with_file_name(named);
    let modes = Npz::open(&path).map_err(|problem| ImportedModesError::File(problem.into()));
    let modes = modes.and_then(|mut file| ImportedModes::read(&mut file, named));
    let modes = modes.map_err(|problem| {
        SceneError::modes(document.place_of(["body.modes"]), path.display(), &problem)
    });
    modes.map(Arc::new)
}

/// Checks the dimensions: beam thinner than ball and longer than its radius, mesh size, ball smaller than
/// socket.
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
        "reduce it below body.ball_diameter_mm");
    ensure!(document,
        body.reading == LengthReading::ToSphere || body.beam_length > body.ball_diameter / 2.0 => "body.beam_length_mm", &["body.ball_diameter_mm"];
        "a beam with this length to the centre of the ball ends inside the ball";
        "increase it above half of body.ball_diameter_mm");
    // The meridian section filled with squares of the element size.
    let section = body.beam_length * body.beam_diameter / 2.0
        + std::f64::consts::PI / 8.0 * body.ball_diameter.powi(2);
    let count = section / elements.size.powi(2);
    let (limit, order) = (elements.limit(), elements.order);
    ensure!(document,
        count <= limit as f64 => "body.element_size_mm", &["body.element_order", "body.beam_length_mm"];
        "a body of this size requires about {count:.0} elements";
        "increase the element size to use at most {limit} elements of order {order}");
    ensure!(document, socket > ball => "socket.diameter_mm", &["body.ball_diameter_mm"];
        "the socket ({socket} mm) is not larger than the ball ({ball} mm)";
        "increase it above body.ball_diameter_mm");
    Ok(())
}

/// Checks the number of modes, and that all have a published frequency if these are selected.
fn check_modes(document: &Document<'_>, body: &BallOnBeam) -> Result<(), SceneError> {
    const COUNTS: [&str; 3] = [
        "body.bending_pairs",
        "body.torsion_modes",
        "body.axial_modes",
    ];
    let families = &body.families;
    let count = families.count();
    ensure!(document, count > 0 => "body.bending_pairs", &COUNTS;
        "the model has no modes";
        "set at least one of body.bending_pairs, body.torsion_modes and body.axial_modes to 1 or more");
    ensure!(document, count <= MAX_MODES => "body.bending_pairs", &COUNTS;
        "the model has {count} modes (a bending pair is two modes)";
        "use at most {MAX_MODES} modes");
    let most = PUBLISHED;
    let are_published = families.bending_pairs <= most.bending_pairs
        && families.torsion <= most.torsion
        && families.axial <= most.axial;
    ensure!(document,
        are_published || body.frequencies == Frequencies::FiniteElement => "body.frequencies", &COUNTS;
        "the paper publishes the frequencies of {} bending pairs, {} torsion modes and {} axial mode only, and the model has more",
        most.bending_pairs, most.torsion, most.axial;
        "use fewer modes, or set body.frequencies = \"fe\"");
    Ok(())
}

fn damping(document: &Document<'_>, modes: usize) -> Result<Vec<f64>, SceneError> {
    let table = document.table("damping");
    if !table.is_given() {
        return Ok(Vec::new());
    }
    let mut ratios = table.get(&DAMPING)?;
    if let [ratio] = ratios[..]
        && !table.is_list(DAMPING.name)
    {
        ratios.resize(modes, ratio);
    }
    ensure!(document, ratios.len() == modes => "damping.ratio", &[];
        "{} ratios for {modes} modes", ratios.len();
        "give one ratio for each mode (a bending pair is two modes), or a single number");
    Ok(ratios)
}
