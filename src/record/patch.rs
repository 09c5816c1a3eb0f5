//! The contact patch: nodes coloured by state, friction arrows, edge of the patch, load, and numbers of nodes
//! in each state.
//!
//! All positions are relative to the ball centre, in mm: the patch is drawn at its true place on the ball and
//! moves as the load tilts.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::record::sdk::{Arrows3D, LineStrips3D, Points3D, Radius};

use super::camera::Camera;
use super::paths;
use super::stream::{RecordingStream, nanos};
use super::style::{self, short};
use crate::pipeline::message::{Frame, JointInfo, NodeState, PatchGeometry, PatchSnapshot};
use crate::plot::{Color, RedrawTimer, round_up};

/// Nodes per batch, summed over its snapshots.
const BATCH_NODES: usize = 32_000;
/// Relative radius at which the patch is drawn: slightly above the ball, so that the surface does not hide
/// it.
const LIFT: f64 = 1.002;
/// Relative radius of the tilt circles: below the nodes.
const SUNK: f64 = 0.995;
/// Relative radius of the mark of the beam axis: above the nodes.
const RAISED: f64 = 1.02;
/// Length of an arrow for a friction force equal to the node's mean share of the load, relative to the radius
/// of the patch. Steady friction with a coefficient of about 1/2 gives half of it.
const ARROW: f64 = 0.8;
/// Vertical position of the legend, relative to the half-width of the view.
const KEY: f64 = -1.02;

/// The states of nodes in the order of their numbers and of the legend.
const STATES: [NodeState; 3] = [NodeState::Slip, NodeState::Stick, NodeState::Separated];

/// The contact patch and its snapshots that are not sent yet.
#[derive(Debug, Default)]
pub struct Patch {
    /// Current geometry; frames of the same tilt and load share it.
    geometry: Arc<PatchGeometry>,
    /// Largest load of the run, N, and radius of the patch under it, m. They are the fixed scale of the
    /// forces, so that forces are comparable over the run.
    load: f64,
    radius: f64,
    ball_radius: f64,
    camera: Camera,
    times: Vec<i64>,
    lengths: Vec<usize>,
    colors: Vec<Color>,
    radii: Vec<Radius>,
    friction: Vec<[f32; 3]>,
    redraw: RedrawTimer,
}

impl Patch {
    /// Draws the static elements and starts empty.
    pub fn new(rec: &RecordingStream, joint: &JointInfo) -> Self {
        let counts = ["slip", "stick", "separated"].into_iter();
        let counts = counts.zip(STATES.map(style::node));
        rec.name(paths::NODE_COUNTS, counts);
        let forces = [
            ("normal force, N", style::LOAD),
            ("friction, N", style::FRICTION),
        ];
        rec.name(paths::CONTACT_FORCE, forces);
        draw_circles(rec, joint);
        draw_pole(rec, joint);
        Self {
            load: joint.largest_load(),
            radius: joint.patch_radius,
            ball_radius: joint.ball_radius,
            camera: Camera::new(joint),
            ..Self::default()
        }
    }

    /// Adds a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) {
        let same = Arc::ptr_eq(&self.geometry, &frame.geometry) || self.geometry == frame.geometry;
        if !same {
            let first = self.geometry.positions.is_empty();
            self.geometry = Arc::clone(&frame.geometry);
            self.draw_geometry(rec, frame.t0, frame.load);
            if first {
                self.draw_legend(rec);
            }
        }
        for snapshot in &frame.patch {
            if self.redraw.is_due(snapshot.time, frame.shown) {
                self.push_snapshot(rec, snapshot);
            }
        }
        if self.colors.len() >= BATCH_NODES {
            self.send(rec);
        }
    }

    fn push_snapshot(&mut self, rec: &RecordingStream, snapshot: &PatchSnapshot) {
        let geometry = &*self.geometry;
        let nodes = snapshot.states.len();
        self.times.push(nanos(snapshot.time));
        self.lengths.push(nodes);
        let colors = snapshot.states.iter().map(|&state| style::node(state));
        self.colors.extend(colors);

        // The radius of a node grows with the square root of its pressure. A separated node has a quarter of
        // the radius of its cell; a node at twice the mean pressure (above the peak of Hertz) nearly fills
        // its cell.
        let mean_pressure = self.load / (std::f64::consts::PI * self.radius.powi(2));
        let radius = |force: f64, area: f64| {
            let full = (area / std::f64::consts::PI).sqrt();
            let share = (force / (2.0 * mean_pressure * area)).sqrt();
            Radius::new_scene_units((1e3 * full * (0.25 + 0.65 * share).min(1.0)) as f32)
        };
        let forces = snapshot.normal_force.iter().zip(&geometry.areas);
        let radii = forces.map(|(&force, &area)| radius(force, area));
        self.radii.extend(radii);

        let scale = self.arrow_scale();
        let arrows = snapshot.friction.iter();
        let arrows = arrows.map(|f| f.map(|c| (scale * c) as f32));
        self.friction.extend(arrows);

        let counts = STATES.map(|state| snapshot.count(state) as f64);
        rec.row(paths::NODE_COUNTS, snapshot.time, counts);
        rec.row(paths::CONTACT_FORCE, snapshot.time, snapshot.forces());
    }

    /// Sends pending snapshots.
    pub fn send(&mut self, rec: &RecordingStream) {
        if self.times.is_empty() {
            return;
        }
        let lengths = self.lengths.iter().copied();
        let nodes = Points3D::update_fields()
            .with_colors(self.colors.drain(..))
            .with_radii(self.radii.drain(..))
            .columns(lengths.clone());
        rec.send_rows(paths::NODES, &self.times, nodes);
        let arrows = Arrows3D::update_fields()
            .with_vectors(self.friction.drain(..))
            .columns(lengths);
        rec.send_rows(paths::FRICTION, &self.times, arrows);
        self.times.clear();
        self.lengths.clear();
    }

    /// Scale of friction arrows, mm/N.
    fn arrow_scale(&self) -> f64 {
        let nodes = self.geometry.positions.len() as f64;
        1e3 * ARROW * self.radius * nodes / self.load
    }

    /// Draws the legend of node colours and friction arrows, in a row below the region of the patch.
    fn draw_legend(&self, rec: &RecordingStream) {
        let nodes = self.geometry.positions.len() as f64;
        let shown = round_up(0.5 * self.load / nodes);
        let [slip, stick, separated] = STATES.map(style::node);
        let names = ["slip", "stick", "separated"].map(str::to_owned);
        let friction = format!("friction {} N", short(shown));
        let names = names.into_iter().chain([friction]);
        let places = [-1.15, -0.7, -0.1, 0.82].map(|right| [right, KEY, 0.0]);
        let points = places.map(|place| self.camera.point(place).map(|c| c as f32));
        // The last entry has an arrow instead of a point.
        let dots = [4.0, 4.0, 4.0, 0.0].map(Radius::new_ui_points);
        let key = Points3D::new(points)
            .with_colors([slip, stick, separated, style::FRICTION])
            .with_labels(names)
            .with_show_labels(true)
            .with_radii(dots);
        rec.log_static("joint/patch/legend", &key);

        let [_, _, _, [right, up, near]] = places;
        let half = 0.5 * shown * self.arrow_scale() / self.camera.reach;
        let [from, to] = [right - half, right + half]
            .map(|right| self.camera.point([right, up, near]).map(|c| c as f32));
        let arrow = Arrows3D::from_vectors([std::array::from_fn::<f32, 3, _>(|i| to[i] - from[i])])
            .with_origins([from])
            .with_colors([style::FRICTION])
            .with_radii([Radius::new_ui_points(1.2)]);
        rec.log_static("joint/patch/legend_friction", &arrow);
    }

    /// Draws nodes, edge and load (N) from a time on.
    fn draw_geometry(&self, rec: &RecordingStream, time: f64, load: f64) {
        let geometry = &*self.geometry;
        let lifted = geometry.positions.iter();
        let positions = || lifted.clone().map(|p| p.map(|c| (1e3 * LIFT * c) as f32));
        let nodes = Points3D::update_fields().with_positions(positions());
        rec.log(paths::NODES, time, &nodes);
        let arrows = Arrows3D::update_fields()
            .with_origins(positions())
            .with_colors([style::FRICTION])
            .with_radii([Radius::new_ui_points(1.2)]);
        rec.log(paths::FRICTION, time, &arrows);

        let axis = geometry.direction;
        let angle = (geometry.radius / self.ball_radius).asin();
        let rim = circle(axis, LIFT * self.ball_radius, angle);
        let rim = LineStrips3D::new([rim])
            .with_colors([style::LOAD])
            .with_radii([Radius::new_ui_points(1.0)]);
        rec.log(paths::RIM, time, &rim);

        let length = 1e3 * 2.2 * self.ball_radius;
        let origin = axis.map(|c| ((1e3 * 1.05 * self.ball_radius + length) * c) as f32);
        let arrow = Arrows3D::from_vectors([axis.map(|c| (-length * c) as f32)])
            .with_origins([origin])
            .with_colors([style::LOAD])
            .with_radii([1.2])
            .with_labels([format!("load {} N", style::short(load))]);
        rec.log(paths::LOAD, time, &arrow);
    }
}

/// Spacing of the circles of equal tilt, degrees.
pub fn circle_step(joint: &JointInfo) -> f64 {
    if largest_tilt(joint) > 12.0 { 5.0 } else { 2.0 }
}

/// Largest absolute tilt of the run, degrees.
fn largest_tilt(joint: &JointInfo) -> f64 {
    let [low, high] = joint.tilt_range.unwrap_or([joint.min_tilt, joint.max_tilt]);
    low.abs().max(high.abs()).to_degrees()
}

/// Draws circles of equal tilt on the ball as a scale.
fn draw_circles(rec: &RecordingStream, joint: &JointInfo) {
    let step = circle_step(joint);
    let count = (largest_tilt(joint) / step - 1e-9).ceil().max(1.0) as u32;
    let strips = (1..=count).map(|k| {
        let angle = (f64::from(k) * step).to_radians();
        circle([0.0, 0.0, 1.0], SUNK * joint.ball_radius, angle)
    });
    let lines = LineStrips3D::new(strips)
        .with_colors([Color::Pale])
        .with_radii([Radius::new_ui_points(0.8)]);
    rec.log_static("joint/patch/circles", &lines);
}

/// Marks the beam axis on the ball: tilt zero.
fn draw_pole(rec: &RecordingStream, joint: &JointInfo) {
    let height = 1e3 * RAISED * joint.ball_radius;
    let pole = Points3D::new([[0.0, 0.0, height as f32]])
        .with_labels(["beam axis"])
        .with_show_labels(true)
        .with_colors([Color::Ink])
        .with_radii([Radius::new_ui_points(4.0)]);
    rec.log_static("joint/patch/pole", &pole);
}

/// The circle on a sphere of `radius` (m) at `angle` (rad) from the unit vector `axis`, mm.
fn circle(axis: [f64; 3], radius: f64, angle: f64) -> Vec<[f32; 3]> {
    const CORNERS: usize = 96;
    let radius = 1e3 * radius;
    // Two unit vectors perpendicular to the axis and to each other, starting from the coordinate direction
    // with the smallest component along the axis.
    let axis = Vector3::from(axis);
    let mut helper = Vector3::zeros();
    helper[axis.iamin()] = 1.0;
    let first = axis.cross(&helper).normalize();
    let second = axis.cross(&first);
    let points = (0..=CORNERS).map(|k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / CORNERS as f64).sin_cos();
        let across = cos * first + sin * second;
        let point = radius * (angle.cos() * axis + angle.sin() * across);
        point.map(|c| c as f32).into()
    });
    points.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_lie_on_the_ball_at_their_angle() {
        let axis: [f64; 3] = Vector3::new(0.1, -0.2, 1.0).normalize().into();
        for point in circle(axis, 0.0158, 0.1) {
            let p = point.map(f64::from);
            let length = p.iter().map(|c| c * c).sum::<f64>().sqrt();
            assert!((length - 15.8).abs() < 1e-4);
            let cosine = (0..3).map(|i| p[i] * axis[i]).sum::<f64>() / length;
            assert!((cosine - 0.1f64.cos()).abs() < 1e-6);
        }
    }
}
