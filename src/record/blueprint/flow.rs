//! The screens of the flow itself: its exponents, and two copies that part.

use rerun::external::re_sdk_types::blueprint::components::Corner2D;

use super::{ContainerLike, Layout, Parts, tab};
use crate::{
    pipeline::message::{AnalysisKind, Header, Subject},
    record::{butterfly::Butterfly, exponents::ExponentsPlot, paths},
};

/// Simulated time over which the two copies are compared, s.
const COMPARED: f64 = 5e-3;

impl Layout {
    /// The exponents as they converge.
    pub fn lyapunov_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        if !header.has(AnalysisKind::Exponents) {
            return None;
        }
        let running = self.series_of(
            "Lyapunov exponents λ so far, 1/s, with 95 % intervals (whole run)",
            &[paths::EXPONENTS_RUNNING, paths::EXPONENTS_ZERO],
            None,
        );
        let spectrum = self.picture(
            "The exponents now, in falling order",
            paths::EXPONENTS_SPECTRUM,
            ExponentsPlot::bounds(),
        );
        let words = self.text("What they say", paths::EXPONENTS_WORDS);
        let low = Parts::new().add(1.1, spectrum).add(1.0, words).row();
        let screen = Parts::new().add(1.0, running).add(1.0, low);
        tab("Lyapunov", screen.column())
    }

    /// Two copies from almost the same state.
    pub fn butterfly_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        if !header.has(AnalysisKind::Butterfly) {
            return None;
        }
        let traces = self.series_of(
            "Displacement u of both copies, µm (last 5 ms)",
            &[paths::DISPLACEMENT, paths::BUTTERFLY_DISPLACEMENT],
            Some(COMPARED),
        );
        if let Subject::Joint(joint) = &header.subject {
            self.displacement_range(&traces, joint);
        }
        let distance = self.many_series(
            "log₁₀ of their distance, relative to the motion (whole run)",
            &[paths::BUTTERFLY_DISTANCE, paths::BUTTERFLY_LINE],
            Corner2D::RightBottom,
        );
        let portraits = self.picture(
            "Phase portraits of both copies, the last 4 ms",
            paths::BUTTERFLY_PORTRAIT,
            Butterfly::bounds(),
        );
        let words = self.text("The butterfly", paths::BUTTERFLY_WORDS);
        let left = Parts::new().add(1.0, traces).add(1.0, distance).column();
        let right = Parts::new().add(1.9, portraits).add(1.0, words).column();
        let screen = Parts::new().add(1.5, left).add(1.0, right);
        tab("Butterfly", screen.row())
    }
}
