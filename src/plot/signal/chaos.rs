//! Evidence of chaos: divergence of nearby states, 0-1 test, type of motion.

use super::{Picture, SignalFigures, skipped_panel};
use crate::analysis::{chaos::Divergence, regime::Evidence};
use crate::plot::{Axis, Color, Layer, Panel, chaos, figure::regime_legend};
use crate::study::signal::Outcome;

impl SignalFigures<'_> {
    pub fn divergence(&self) -> Picture {
        let row = vec![
            self.divergence_panel("Rosenstein", &self.report.rosenstein),
            self.divergence_panel("Kantz", &self.report.kantz),
        ];
        Ok((82.0, vec![row]))
    }

    /// Mean logarithmic distance over time, with the linear scaling region.
    fn divergence_panel(&self, title: &str, divergence: &Outcome<Divergence>) -> Panel {
        match divergence.get() {
            Ok(divergence) => chaos::divergence(divergence, &self.unit).with_title(title),
            Err(reason) => skipped_panel(&format!("{title}: skipped"), reason),
        }
    }

    pub fn zero_one(&self) -> Picture {
        let test = self.report.zero_one.get()?;
        let k = Panel::new(
            format!("K = {:.3}: 0 regular, 1 chaotic", test.k),
            Axis::with_margin("frequency c, rad", test.by_frequency.iter().map(|p| p[0])),
            Axis::linear("K", [-1.05, 1.05]),
            vec![Layer::points(test.by_frequency.clone(), 1.7, Color::Ink)],
        );
        // The other panel has K as its title.
        let path =
            chaos::zero_one_path(test, &self.report.signal.unit, test.path.len()).with_caption("");
        Ok((84.0, vec![vec![k, path]]))
    }

    pub fn regime(&self) -> Picture {
        let verdict = self.report.verdict.get()?;
        // What matters, as many as a slide has room for.
        let evidence = verdict.evidence.iter().filter(|piece| piece.matters());
        let evidence: Vec<&Evidence> = evidence.take(8).collect();
        let parts = evidence.iter().enumerate().map(|(row, piece)| {
            let ends = [0.0, piece.contribution];
            (row, ends, Color::Regime(piece.supports))
        });
        let names = evidence.iter().map(|piece| piece.criterion.clone());
        let largest = evidence.iter().map(|piece| piece.contribution);
        let axis = Axis::linear("change of ln(odds)", [0.0, largest.fold(1.0, f64::max)]);
        let mut panel = Panel::bars(verdict.summary(), axis, names.collect(), parts);
        let is_supported = |regime| evidence.iter().any(|e| e.supports == regime);
        panel.layers.extend(regime_legend(is_supported));
        Ok((34.0 + 7.0 * evidence.len() as f64, vec![vec![panel]]))
    }
}
