//! The layout of the tangent-flow analyses: Lyapunov exponents, and the perturbed trajectory.

use rerun::external::re_sdk_types::blueprint::components::Corner2D;

use super::{ContainerLike, Layout, Parts, tab};
use crate::{
    pipeline::message::{AnalysisKind, Header, Subject},
    record::{exponents::ExponentsPlot, paths, perturbed::PerturbedTrajectory},
};

/// Time window in which both trajectories are compared, s.
const COMPARED: f64 = 5e-3;

impl Layout {
    /// The Lyapunov exponents over time.
    pub fn lyapunov_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        if !header.has(AnalysisKind::Exponents) {
            return None;
        }
        let running = self.series_of(
            "Running Lyapunov exponents λ, 1/s, with 95 % intervals (whole run)",
            &[paths::EXPONENTS_RUNNING, paths::EXPONENTS_ZERO],
            None,
        );
        let spectrum = self.picture(
            "Current Lyapunov spectrum",
            paths::EXPONENTS_SPECTRUM,
            ExponentsPlot::bounds(),
        );
        let words = self.text("Exponents and attractor", paths::EXPONENTS_TEXT);
        let low = Parts::new().add(1.1, spectrum).add(1.0, words).row();
        let screen = Parts::new().add(1.0, running).add(1.0, low);
        tab("Lyapunov exponents", screen.column())
    }

    /// The reference trajectory and the perturbed trajectory.
    pub fn perturbed_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        if !header.has(AnalysisKind::PerturbedTrajectory) {
            return None;
        }
        let [traces, distance, portraits] = self.both_trajectories(header);
        let words = self.text("Divergence", paths::DIVERGENCE_TEXT);
        let left = Parts::new().add(1.0, traces).add(1.0, distance).column();
        let right = Parts::new().add(1.9, portraits).add(1.0, words).column();
        let screen = Parts::new().add(1.5, left).add(1.0, right);
        tab("Perturbed trajectory", screen.row())
    }

    /// Displacement of both trajectories, their distance, and their phase portraits.
    pub fn both_trajectories(&mut self, header: &Header) -> [ContainerLike; 3] {
        let traces = self.series_of(
            "Displacement u of both trajectories, µm (last 5 ms)",
            &[paths::DISPLACEMENT, paths::PERTURBED_DISPLACEMENT],
            Some(COMPARED),
        );
        if let Subject::Joint(joint) = &header.subject {
            self.displacement_range(&traces, joint);
        }
        let distance = self.many_series(
            "log₁₀ of the distance of both trajectories, relative to the motion (whole run)",
            &[paths::DIVERGENCE_DISTANCE, paths::DIVERGENCE_FIT],
            Corner2D::RightBottom,
        );
        let portraits = self.picture(
            "Phase portraits of both trajectories (last 4 ms)",
            paths::DIVERGENCE_PORTRAIT,
            PerturbedTrajectory::bounds(),
        );
        [traces, distance, portraits]
    }
}
