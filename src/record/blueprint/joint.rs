//! The layout of a joint: overview, contact, modes and solver.

use super::{ContainerLike, Layout, Parts, View, log, tab};
use crate::{
    pipeline::message::{Header, JointInfo},
    record::{camera::Camera, patch, paths, portrait::Portrait, samples, style},
    scene::RecordSpec,
};

/// Time window of the time series, s: about twenty periods of a 4 kHz squeak.
const SERIES_WINDOW: f64 = 5e-3;
/// Minimum number of contact snapshots in the time window of a series.
const SNAPSHOTS: f64 = 50.0;

impl Layout {
    pub fn overview_tab(
        &mut self,
        header: &Header,
        joint: &JointInfo,
        spec: RecordSpec,
    ) -> Option<ContainerLike> {
        let words = self.text("Observations", paths::NARRATION);
        let body = self.body(joint, spec);
        let patch = self.patch(joint);
        let portrait = self.picture(
            "Phase portrait of the patch centre",
            paths::PORTRAIT,
            Portrait::bounds(),
        );
        let recurrence = self.recurrence(header);
        let spectrogram = self.spectrogram(header);
        let spectrum = self.spectrum(header);
        let displacement = self.series(
            "Displacement u, µm (last 5 ms)",
            paths::DISPLACEMENT,
            Some(SERIES_WINDOW),
        );
        let velocity = self.series(
            "Velocity v, mm/s (last 5 ms)",
            paths::VELOCITY,
            Some(SERIES_WINDOW),
        );
        let tilt = self.tilt();
        let reach = joint.tilt_range.unwrap_or([joint.min_tilt, joint.max_tilt]);
        let [lowest, highest] = reach.map(|tilt| 1.15 * tilt.to_degrees());
        self.range(
            &tilt,
            lowest.min(0.0),
            highest.max(if lowest < 0.0 { 0.0 } else { 1.0 }),
        );
        let load = joint.load_varies().then(|| {
            let view = self.series("Load, N (whole run)", paths::LOAD_NOW, None);
            self.range(&view, 0.0, 1.15 * joint.largest_load());
            view
        });
        let rotation = joint.rotation_varies().then(|| {
            let name = "Rotation factor (whole run)";
            let view = self.series(name, paths::ROTATION_FACTOR, None);
            let [low, high] = joint.rotation_span;
            self.range(&view, 1.15 * low.min(0.0), 1.15 * high);
            view
        });
        self.displacement_range(&displacement, joint);
        let speed = joint.largest_sliding_speed();
        self.range(&velocity, -2e3 * speed, 2e3 * speed);

        let left = Parts::new().add(0.42, words).add(0.58, body).column();
        let top = Parts::new()
            .add(1.0, patch)
            .add(1.0, portrait)
            .add(1.0, recurrence)
            .row();
        let middle = Parts::new().add(1.62, spectrogram).add(1.0, spectrum).row();
        let bottom = Parts::new()
            .add(1.0, displacement)
            .add(1.0, velocity)
            .add(1.0, tilt)
            .add(1.0, load)
            .add(1.0, rotation)
            .row();
        let right = Parts::new()
            .add(0.44, top)
            .add(0.35, middle)
            .add(0.21, bottom)
            .column();
        let screen = Parts::new().add(0.25, left).add(0.75, right);
        tab("Overview", screen.row())
    }

    pub fn contact_tab(
        &mut self,
        header: &Header,
        joint: &JointInfo,
        spec: RecordSpec,
    ) -> Option<ContainerLike> {
        if spec.patch_rate == 0.0 {
            return None;
        }
        let patch = self.patch(joint);
        let [counts, force] = self.contact_series(joint, spec);
        let embedding = self.embedding(header, 3.9);
        let left = Parts::new().add(1.0, patch).add(1.0, embedding).column();
        let right = Parts::new().add(1.0, counts).add(1.0, force).column();
        let screen = Parts::new().add(0.45, left).add(0.55, right);
        tab("Contact", screen.row())
    }

    /// Status of the nodes, and contact force, of the newest snapshots.
    pub fn contact_series(&mut self, joint: &JointInfo, spec: RecordSpec) -> [ContainerLike; 2] {
        let rate = style::short(1e-3 * spec.patch_rate);
        let window = SERIES_WINDOW.max(SNAPSHOTS / spec.patch_rate);
        let [counts, force] = [
            (
                "Number of nodes slipping (blue), sticking (orange), separated (white)",
                paths::NODE_COUNTS,
            ),
            (
                "Contact force on the ball, N: normal (yellow), friction (pink)",
                paths::CONTACT_FORCE,
            ),
        ]
        .map(|(name, path)| {
            self.series(&format!("{name}; {rate} kHz snapshots"), path, Some(window))
        });
        self.range(&force, 0.0, 1.6 * joint.largest_load());
        [counts, force]
    }

    pub fn modes_tab(&mut self, spec: RecordSpec) -> Option<ContainerLike> {
        let window = Some(SERIES_WINDOW);
        let q = self.series(
            "Modal coordinates, √kg µm (last 5 ms)",
            paths::MODES_Q,
            window,
        );
        let qdot = self.series(
            "Modal velocities, √kg mm/s (last 5 ms)",
            paths::MODES_QDOT,
            window,
        );
        let energy = self.series(
            "Vibration energy of each mode, µJ (whole run)",
            paths::MODES_ENERGY,
            None,
        );
        let audit = self.series(
            "Energy, µJ: stored (blue), work of friction (pink), residual of the balance (orange)",
            paths::ENERGY,
            None,
        );
        let key = self.picture("Modes", paths::MODES_LEGEND, samples::mode_legend_bounds());
        let left = Parts::new().add(1.0, q).add(1.0, qdot).column();
        let mut screen = Parts::new().add(1.0, left).add(0.3, key);
        if spec.energy_rate > 0.0 {
            let right = Parts::new().add(1.0, energy).add(1.0, audit).column();
            screen = screen.add(1.0, right);
        }
        tab("Modes", screen.row())
    }

    pub fn tilt(&mut self) -> ContainerLike {
        self.series("Tilt of the load, deg (whole run)", paths::TILT, None)
    }

    /// Accuracy and cost of the integration, as text and over the run.
    pub fn health_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        let words = self.text("Current accuracy and cost", paths::SOLVER_TEXT);
        let error = self.series(
            "Largest local error estimate per frame, over the tolerance",
            paths::SOLVER_ERROR,
            None,
        );
        // An accepted step has a ratio of at most 1; the margin keeps a value of 1 visible.
        self.range(&error, 0.0, 1.05);
        let calls = self.series(
            "Right-hand-side evaluations per simulated ms",
            paths::SOLVER_RHS_EVALS,
            None,
        );
        let speed = self.series(
            "Simulation speed, simulated seconds per second",
            paths::SOLVER_SPEED,
            None,
        );
        let work = self.series(
            "Per simulated ms: steps (blue), rejected steps (orange), transitions (green)",
            paths::SOLVER_STEPS,
            None,
        );
        let queues = self.series(
            "Queues: frames (blue), records (orange); replaced pictures (green)",
            paths::SOLVER_QUEUES,
            None,
        );
        // The energy balance is known for a joint only.
        let audit = header.joint().map(|_| {
            self.series(
                "Energy audit: residual over the exchanged energy",
                paths::SOLVER_ENERGY_RESIDUAL,
                None,
            )
        });
        let accuracy = Parts::new().add(1.0, error).add(1.0, audit).column();
        let cost = Parts::new().add(1.0, calls).add(1.0, speed).column();
        let work = Parts::new().add(1.0, work).add(1.0, queues).column();
        let plots = Parts::new()
            .add(1.0, accuracy)
            .add(1.0, cost)
            .add(1.0, work);
        let screen = Parts::new()
            .add(0.11, words)
            .add(0.72, plots.row())
            .add(0.17, log());
        tab("Solver", screen.column())
    }

    /// Sets the range of the displacement. A squeak grows until the slip just reverses, so its velocity is of
    /// the order of the sliding speed, and its displacement at most that of the lowest mode at this velocity.
    pub fn displacement_range(&mut self, view: &ContainerLike, joint: &JointInfo) {
        if let Some(lowest) = joint.modes.first() {
            let largest =
                joint.largest_sliding_speed() / (std::f64::consts::TAU * lowest.frequency_hz);
            self.range(view, -1e6 * largest, 1e6 * largest);
        }
    }

    /// The body from the side, slightly from above.
    fn body(&mut self, joint: &JointInfo, spec: RecordSpec) -> ContainerLike {
        let name = match (joint.outline.vertices.is_empty(), spec.body_rate > 0.0) {
            (true, true) => format!("{}: load and rotation (surface not known)", joint.body),
            (true, false) => format!("{}: load and rotation", joint.body),
            (false, _) => format!(
                "{}, displacements × {}",
                joint.body,
                style::short(spec.deformation_scale)
            ),
        };
        let view = scene_view(
            name,
            &[
                paths::BODY,
                paths::BODY_LEGEND,
                paths::LOAD,
                paths::ROTATION,
                paths::RIM,
            ],
        );
        let vertices = &joint.outline.vertices;
        let lowest = vertices.iter().map(|v| v[2]).fold(-0.2, f64::min);
        let highest = 3.3 * joint.ball_radius;
        let middle = 1e3 * 0.5 * (lowest + highest);
        let distance = 1e3 * 1.12 * (highest - lowest);
        let eye = [0.80, -0.55, 0.22].map(|c: f64| c * distance);
        self.eye(
            &view,
            [eye[0], eye[1], middle + eye[2]],
            [0.0, 0.0, middle],
            [0.0, 0.0, 1.0],
        );
        view
    }

    /// The ball from above; the patch is visible at every tilt of the run.
    pub fn patch(&mut self, joint: &JointInfo) -> ContainerLike {
        let name = format!(
            "Contact patch (circles {}° apart)",
            style::short(patch::circle_step(joint)),
        );
        let view = scene_view(
            name,
            &[
                paths::NODES,
                paths::FRICTION,
                paths::RIM,
                paths::TILT_CIRCLES,
                paths::NODE_LEGEND,
                paths::FRICTION_LEGEND,
                paths::POLE,
            ],
        );
        let camera = Camera::new(joint);
        // The view is tilted slightly, and aimed below the centre to show the legend.
        let target = camera.point([0.0, -0.12, 0.0]);
        let from = camera.point([0.0, -0.6, 2.55]);
        self.eye(&view, from, target, camera.up());
        view
    }
}

/// A view of some entities of the scene.
fn scene_view(name: String, entities: &[&str]) -> ContainerLike {
    let contents = entities.iter().map(|path| format!("+ /{path}"));
    View::in_3d(name)
        .with_origin(paths::SCENE_3D)
        .with_contents(contents)
        .into()
}
