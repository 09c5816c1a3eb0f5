//! Figures that correspond to those of the paper.
//!
//! | figure | content |
//! |---|---|
//! | 1 | [`configuration`]: ball, beam, load and rotation; pre-stress on the patch |
//! | 2 | [`mode_shapes`] |
//! | 3 | [`friction_curves`]: as printed and as used |
//! | 4 to 7 | [`motion`]: growth rates, time series, phase portrait, spectrum, delay reconstruction, recurrence plot |
//! | 8 | [`embedding`]: mutual information and false nearest neighbours |
//! | 9 | [`recurrence_plots`] |
//! | 10 | [`sections`] |
//! | 11 | [`bifurcation`]: maxima, exponents and spectral lines over the tilt |

use super::response::{
    self, LAG, SMALLEST, interpolated, largest, samples, section, section_axes, spectrum_axes,
};
pub use super::sweep::bifurcation;
use super::{Axis, Color, Figure, Layer, Panel, chaos};
use super::{figure::lettered, sensitivities::contributions};
use crate::analysis::{delay::DelayChoice, recurrence::RecurrenceImage};
use crate::fem::{ModeKind, SurfaceMesh};
use crate::joint::{AssemblyError, BallJoint, ExplainedMode, Model, Stribeck};
use crate::study::response::{PhasePortrait, SettledResponse};

/// Numbers of rings and of meridians of the wireframe.
const ALONG: usize = 40;
const ROUND: usize = 16;
/// Largest drawn displacement of a mode shape, m, and that of torsion, which would distort the beam at the larger value.
const LARGEST: f64 = 15e-3;
const LARGEST_TORSION: f64 = 7e-3;
/// Projection onto the page: an oblique view with the beam axis vertical.
const VIEW: [[f64; 3]; 2] = [[0.866, -0.5, 0.0], [0.12, 0.21, 0.97]];
/// Largest slip speed shown, m/s.
const FASTEST: f64 = 0.1;
/// Slope factors as printed in the caption of Fig. 3: `d` of the creep and `f` of the Stribeck curve, s/m.
const PRINTED: [f64; 2] = [10.0, 1000.0];
/// Highest frequency of a spectrum, Hz, and the decades of its amplitude axis.
const HIGHEST: f64 = 15e3;
const DECADES: i32 = 6;
/// Panels per row in comparisons over the tilt.
const COLUMNS: usize = 4;

/// Fig. 1: configuration at a tilt (rad), and pre-stress on the contact patch.
///
/// # Errors
/// [`AssemblyError`] if the modes come from a file, so the geometry of the body is unknown.
pub fn configuration(ball: &BallJoint, model: &Model, tilt: f64) -> Result<Figure, AssemblyError> {
    let mesh = ball.body()?.outline(ALONG, ROUND);
    let radius = ball.ball_radius();
    let direction = ball.direction(tilt);
    // The load presses the ball against the socket along `direction`, from outside.
    let load = arrow([3.4, 1.05].map(|by| direction.map(|x| by * radius * x)));
    let newtons = ball.spec().load;
    let load = Layer::line(load, Color::Accent).with_label(format!("load {newtons} N"));
    let rotation = ball.spec().rotation;
    let size = rotation.iter().map(|w| w * w).sum::<f64>().sqrt();
    let tip = rotation.map(|w| 2.6 * radius / size.max(f64::MIN_POSITIVE) * w);
    let turning = Layer::line(arrow([[0.0; 3], tip]), Color::Series(0))
        .with_label(format!("rotation {size:.3} rad/s"));
    let title = format!("load tilted by {:.1}°", tilt.to_degrees());
    let [x, y] = [[-105.0, 105.0], [-225.0, 65.0]].map(|range| Axis::linear("mm", range));
    let [load, turning] = [load, turning].map(|arrow| arrow.with_size(1.6));
    let layers = vec![wires(&mesh, Color::Ink, |_, at| at), load, turning];
    let configuration = Panel::new(title, x, y, layers);
    let title = "Fig. 1: configuration, and pre-stress on the contact patch";
    let row = vec![configuration, pre_stress(ball, model, direction)];
    Ok(Figure::new("figure-1", title, 112.0, vec![row]))
}

/// Pre-stress of the contact nodes over the distance from the centre of the patch, compared with Hertz.
fn pre_stress(ball: &BallJoint, model: &Model, direction: [f64; 3]) -> Panel {
    let distance = |position: &[f64; 3]| {
        let along: f64 = position.iter().zip(direction).map(|(a, b)| a * b).sum();
        let square: f64 = position.iter().map(|x| x * x).sum();
        (square - along * along).max(0.0).sqrt()
    };
    let nodes = model.positions.iter().zip(&model.pre_stress);
    let nodes = nodes.map(|(position, p)| [1e3 * distance(position), 1e-6 * p]);
    let radius = ball.patch_radius();
    // Hertz: the mean pressure is two thirds of the pressure at the centre.
    let middle = 1.5 * ball.spec().load / (std::f64::consts::PI * radius * radius);
    let curve = (0..=200).map(|k| {
        let s = f64::from(k) / 200.0;
        let pressure = middle * (1.0 - s * s).max(0.0).sqrt();
        [1e3 * radius * s, 1e-6 * pressure]
    });
    let title = format!("pre-stress on the patch, up to {:.2} MPa", 1e-6 * middle);
    let x = Axis::linear("distance from the centre, mm", [0.0, 1.05e3 * radius]);
    let y = Axis::linear("pre-stress, MPa", [0.0, 1.1e-6 * middle]);
    let hertz = Layer::line(curve.collect(), Color::Faint).with_label("Hertz");
    let nodes = Layer::points(nodes.collect(), 1.8, Color::Accent);
    let nodes = nodes.with_label(format!("{} contact nodes", model.nodes()));
    Panel::new(title, x, y, vec![hertz, nodes])
}

/// Fig. 2: mode shapes, one of each bending pair, drawn over the undeformed body.
///
/// # Errors
/// [`AssemblyError`] if the modes come from a file, so the geometry of the body is unknown.
pub fn mode_shapes(ball: &BallJoint) -> Result<Figure, AssemblyError> {
    let body = ball.body()?;
    let mesh = body.outline(ALONG, ROUND);
    let panel = |title: String, layers| {
        let x = Axis::linear("mm", [-60.0, 60.0]);
        Panel::new(title, x, Axis::linear("mm", [-230.0, 45.0]), layers)
    };
    let rest = |color| wires(&mesh, color, |_, at| at);
    let modes = body.families().into_iter().map(|(mode, name)| {
        let shape = |vertex| mesh.shapes_at(vertex)[mode];
        let size = |vertex| shape(vertex).iter().map(|x| x * x).sum::<f64>();
        let sizes = (0..mesh.vertices.len()).map(size);
        let largest = sizes.fold(f64::MIN_POSITIVE, f64::max).sqrt();
        let (color, drawn) = match body.modes()[mode].kind {
            ModeKind::BendingX | ModeKind::BendingY => (Color::Series(0), LARGEST),
            ModeKind::Torsion => (Color::Series(1), LARGEST_TORSION),
            ModeKind::Axial => (Color::Series(3), LARGEST),
        };
        let moved = wires(&mesh, color, |vertex, at| {
            std::array::from_fn(|i| at[i] + drawn / largest * shape(vertex)[i])
        });
        let title = format!("{name}, {:.0} Hz", ball.frequencies_hz()[mode]);
        panel(title, vec![rest(Color::Pale), moved])
    });
    let undeformed = panel("undeformed".to_owned(), vec![rest(Color::Ink)]);
    let panels = [undeformed].into_iter().chain(modes).collect();
    let title = "Fig. 2: mode shapes";
    Ok(Figure::grid("figure-2", title, 78.0, COLUMNS, panels))
}

/// Rings and meridians of the surface, with each vertex displaced by `moved`.
fn wires(mesh: &SurfaceMesh, color: Color, moved: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> Layer {
    let at = |ring: usize, j: usize| {
        let vertex = 1 + ring * ROUND + j % ROUND;
        place(moved(vertex, mesh.vertices[vertex]))
    };
    let rings = (0..ALONG).step_by(3);
    let rings = rings.map(|ring| (0..=ROUND).map(|j| at(ring, j)).collect());
    let meridians = (0..ROUND).step_by(2);
    let meridians = meridians.map(|j| (0..ALONG).map(|ring| at(ring, j)).collect());
    Layer::lines(rings.chain(meridians).collect(), color).with_size(0.5)
}

/// Projection of a point in space (m) onto the page (mm).
fn place(at: [f64; 3]) -> [f64; 2] {
    VIEW.map(|axis| 1e3 * axis.iter().zip(at).map(|(a, b)| a * b).sum::<f64>())
}

/// An arrow between points in space (m) as a polyline on the page (mm).
fn arrow(ends: [[f64; 3]; 2]) -> Vec<[f64; 2]> {
    let [from, to] = ends.map(place);
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let barb = |side: f64| {
        let side = side * 0.1;
        [to[0] - 0.2 * x + side * y, to[1] - 0.2 * y - side * x]
    };
    vec![from, to, barb(1.0), to, barb(-1.0)]
}

/// Fig. 3: friction curves with the slope factors as printed and as used. `sliding` is the speed of steady
/// sliding at the patch centre, m/s.
pub fn friction_curves(law: &Stribeck, sliding: f64) -> Figure {
    let printed = Stribeck {
        creep: PRINTED[0],
        stribeck: PRINTED[1],
        ..*law
    };
    let curve = |law: &Stribeck, color, name: &str| {
        let speeds = (0..=2000).map(|k| FASTEST * f64::from(k) / 2000.0);
        let points = speeds.map(|speed| [1e3 * speed, law.coefficient(speed)]);
        let (d, f) = (law.creep, law.stribeck);
        Layer::line(points.collect(), color).with_label(format!("{name}: d = {d}, f = {f} s/m"))
    };
    let at = |law: &Stribeck| {
        let (mu, slope) = (law.coefficient(sliding), law.slope(sliding));
        format!("μ = {mu:.3}, slope {slope:.2} s/m")
    };
    let title = format!("used here: {}; as printed: {}", at(law), at(&printed));
    let x = Axis::linear("slip speed, mm/s", [0.0, 1e3 * FASTEST]);
    let y = Axis::linear("coefficient of friction", [0.0, 1.08 * law.mu_s]);
    let label = format!("steady sliding, {:.1} mm/s", 1e3 * sliding);
    let layers = vec![
        curve(law, Color::Series(0), "used here"),
        curve(&printed, Color::Series(1), "as printed"),
        Layer::vertical_lines([1e3 * sliding], Color::Faint).with_label(label),
    ];
    let panel = Panel::new(title, x, y, layers);
    let (mu_s, mu_d) = (law.mu_s, law.mu_d);
    let title = format!("Fig. 3: friction curve, μs = {mu_s}, μd = {mu_d}");
    Figure::new("figure-3", &title, 85.0, vec![vec![panel]])
}

/// Fig. 4 to 7: growth rates of the linear modes `modes`, time series, phase portrait, spectrum, delay
/// reconstruction and recurrence plot of the motion at a tilt (degrees).
pub fn motion(
    number: usize,
    tilt_deg: f64,
    response: &SettledResponse,
    modes: &[ExplainedMode],
) -> Figure {
    let regime = response.regime.with_confidence(response.confidence);
    let title = format!("Fig. {number}: at {tilt_deg}°, {regime}");
    let unstable = modes.iter().filter(|mode| mode.unstable()).count();
    let name = |mode: &ExplainedMode| format!("{:.2} kHz", 1e-3 * mode.frequency_hz);
    let named: Vec<_> = modes.iter().map(|mode| (name(mode), mode)).collect();
    let growth = contributions(&named);
    let mut panels = vec![growth.with_title(format!("{unstable} unstable modes"))];
    if let Some(portrait) = &response.portrait {
        let (dt, color) = (portrait.dt_s, Color::Regime(response.regime));
        let strongest = response.lines.first();
        let strongest = strongest.map_or(SMALLEST[0], |line| line.amplitude);
        let plane = spectrum_axes(strongest, DECADES, HIGHEST);
        let fine = interpolated(&samples(portrait), dt);
        panels.extend([
            response::time_series(&fine, dt, color),
            response::phase_portrait(&fine, None, color),
            response::motion_spectrum(&plane, portrait, &response.lines),
            response::reconstruction(&fine, dt, color),
            response::recurrence(recurrence(portrait).as_ref(), false),
        ]);
    }
    let name = format!("figure-{number}");
    Figure::grid(&name, &title, 66.0, 3, lettered('a', panels))
}

/// The recurrence plot; `None` for a constant signal.
fn recurrence(portrait: &PhasePortrait) -> Option<RecurrenceImage> {
    let mut pairs = portrait.u_m.windows(2);
    let moves = pairs.any(|pair| pair[0] != pair[1]);
    portrait.recurrence().ok().flatten().filter(|_| moves)
}

/// Fig. 8: mutual information and fraction of false nearest neighbours of the motion at a tilt (degrees),
/// sampled every `dt` (s).
pub fn embedding(tilt_deg: f64, choice: &DelayChoice, dt: f64) -> Figure {
    let title = format!("Fig. 8: choice of delay and dimension at {tilt_deg}°");
    let panels = lettered('a', chaos::embedding(dt, choice));
    Figure::grid("figure-8", &title, 80.0, 2, panels)
}

/// Title of the motion at a tilt (degrees).
fn title((tilt, response): &(f64, &SettledResponse)) -> String {
    format!("{tilt}°, {}", response.regime)
}

/// Fig. 9: recurrence plots of 5 ms at several tilts (degrees).
pub fn recurrence_plots(points: &[(f64, &SettledResponse)]) -> Figure {
    let panels = points.iter().filter_map(|point| {
        let found = recurrence(point.1.portrait.as_ref()?);
        Some(response::recurrence(found.as_ref(), false).with_title(title(point)))
    });
    let title = "Fig. 9: recurrence plots";
    Figure::grid("figure-9", title, 54.0, COLUMNS, panels.collect())
}

/// Fig. 10: Poincaré sections at several tilts (degrees), all on the same axes.
pub fn sections(points: &[(f64, &SettledResponse)]) -> Figure {
    let found: Vec<&SettledResponse> = points.iter().map(|(_, response)| *response).collect();
    let size = found.iter().map(|response| largest(response)[0]);
    let plane = section_axes(&found, "u", size.fold(SMALLEST[0], f64::max));
    let panel = |point: &(f64, _)| section(&plane, Some(point.1)).with_title(title(point));
    let panels = points.iter().map(panel).collect();
    let us = 1e6 * LAG;
    let title = format!("Fig. 10: Poincaré sections at u(t + τ) = 0, τ = {us:.0} µs");
    Figure::grid("figure-10", &title, 54.0, COLUMNS, panels)
}
