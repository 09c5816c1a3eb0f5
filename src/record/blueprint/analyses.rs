//! The layout of the signal analyses: embedding, recurrence, type of motion.

use rerun::external::re_sdk_types::blueprint::components::Corner2D;

use super::{ContainerLike, Layout, Parts, tab};
use crate::{
    pipeline::message::{AnalysisKind, Header},
    record::{chaos::Chaos, delay::Delay, paths, section::Section},
};

impl Layout {
    /// Choice of delay and dimension, delay embedding, and Poincaré section.
    pub fn embedding_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        let delay = header.has(AnalysisKind::Delay).then(|| {
            let mutual = self.picture(
                "Delay τ: mutual information",
                paths::DELAY_MUTUAL,
                Delay::bounds(),
            );
            let neighbours = self.picture(
                "Dimension m: false nearest neighbours",
                paths::DELAY_NEIGHBOURS,
                Delay::bounds(),
            );
            Parts::new().add(1.0, mutual).add(1.0, neighbours).column()
        });
        let section = self.section(header).map(|section| {
            let map = self.picture("Return map", paths::RETURN_MAP, Section::bounds());
            Parts::new().add(1.0, section).add(1.0, map).column()
        });
        if delay.is_none() && section.is_none() {
            return None;
        }
        let embedding = self.embedding(header, 5.2);
        let screen = Parts::new()
            .add(1.0, delay.flatten())
            .add(1.2, embedding)
            .add(0.85, section.flatten());
        tab("Embedding", screen.row())
    }

    /// The recurrence plot and its measures.
    pub fn recurrence_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        if !header.has(AnalysisKind::Quantification) {
            return None;
        }
        let recurrence = self.recurrence(header);
        let shares = self.many_series(
            "Recurrence rate RR, determinism DET, laminarity LAM (0 to 1)",
            &[
                paths::RECURRENCE_RATE,
                paths::DETERMINISM,
                paths::LAMINARITY,
            ],
            Corner2D::LeftTop,
        );
        self.range(&shares, 0.0, 1.05);
        let diagonals = self.many_series(
            "Diagonal lines: mean length L, longest Lmax",
            &[paths::MEAN_DIAGONAL, paths::LONGEST_DIAGONAL],
            Corner2D::LeftTop,
        );
        let times = self.many_series(
            "Period, recurrence times T1 and T2, trapping time TT",
            &[
                paths::PERIOD,
                paths::RECURRENCE_TIME_1,
                paths::RECURRENCE_TIME_2,
                paths::TRAPPING_TIME,
            ],
            Corner2D::LeftTop,
        );
        let entropy = self.many_series(
            "Entropy ENTR of diagonal line lengths; divergence DIV = 1/Lmax",
            &[paths::ENTROPY, paths::DIVERGENCE_RATE],
            Corner2D::LeftTop,
        );
        let trend = self.many_series(
            "TREND: drift of the recurrence rate",
            &[paths::TREND],
            Corner2D::LeftTop,
        );
        let middle = Parts::new().add(1.0, diagonals).add(1.0, times).row();
        let low = Parts::new().add(1.0, entropy).add(1.0, trend).row();
        let right = Parts::new().add(1.0, shares).add(1.0, middle).add(1.0, low);
        let screen = Parts::new().add(0.42, recurrence).add(0.58, right.column());
        tab("Recurrence quantification", screen.row())
    }

    /// The type of motion, and the evidence of chaos.
    pub fn regime_tab(&mut self, header: &Header) -> Option<ContainerLike> {
        let [verdict, history] = self.regime(header);
        let chaos = header.has(AnalysisKind::Chaos).then(|| {
            let divergence = self.picture(
                "Divergence of nearby states",
                paths::DIVERGENCE,
                Chaos::divergence_bounds(),
            );
            let path = self.picture(
                "0-1 test: bounded path or random walk",
                paths::ZERO_ONE_PICTURE,
                Chaos::path_bounds(),
            );
            let exponent = self.picture(
                "Largest Lyapunov exponent λ ± error of each window",
                paths::EXPONENT,
                Chaos::exponent_bounds(),
            );
            let zero_one = self.series("0-1 test: K (0 regular, 1 chaotic)", paths::ZERO_ONE, None);
            self.range(&zero_one, -0.1, 1.1);
            let pictures = Parts::new().add(1.5, divergence).add(1.0, path).row();
            let histories = Parts::new().add(1.5, exponent).add(1.0, zero_one).row();
            [pictures, histories]
        });
        let [pictures, histories] = chaos.unwrap_or_default();
        let right = Parts::new()
            .add(0.3, history)
            .add(0.42, pictures)
            .add(0.28, histories);
        let screen = Parts::new().add(0.3, verdict).add(0.7, right.column());
        tab("Type of motion", screen.row())
    }

    /// The classification as text and over time.
    fn regime(&mut self, header: &Header) -> [Option<ContainerLike>; 2] {
        if !header.has(AnalysisKind::Regime) {
            return [None, None];
        }
        let verdict = self.text("Classification", paths::REGIME_VERDICT);
        // The legend is placed at low confidence, where a clear motion has no points.
        let history = self.many_series(
            "Confidence of each type of motion (0 to 1)",
            &[paths::REGIME_CONFIDENCE],
            Corner2D::RightBottom,
        );
        self.range(&history, 0.0, 1.05);
        [Some(verdict), Some(history)]
    }
}
