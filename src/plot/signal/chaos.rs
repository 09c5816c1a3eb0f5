//! Evidence of chaos: divergence of nearby states, 0-1 test, type of motion.

use super::{SignalFigures, skipped_panel};
use crate::analysis::{Divergence, Evidence, Regime};
use crate::plot::{Axis, Color, Figure, Layer, Panel, chaos};
use crate::study::signal::Outcome;

impl SignalFigures<'_> {
    pub fn divergence(&self) -> Figure {
        let row = vec![
            self.divergence_panel("Rosenstein", &self.report.rosenstein),
            self.divergence_panel("Kantz", &self.report.kantz),
        ];
        Figure::new(
            "divergence",
            self.title("Divergence of nearby states"),
            82.0,
            vec![row],
        )
    }

    /// Mean logarithmic distance over time, with the linear scaling region.
    fn divergence_panel(&self, title: &str, divergence: &Outcome<Divergence>) -> Panel {
        let divergence = match divergence.get() {
            Ok(divergence) => divergence,
            Err(reason) => return skipped_panel(&format!("{title}: skipped"), reason),
        };
        chaos::divergence(divergence, &self.unit).with_title(title)
    }

    pub fn zero_one(&self) -> Figure {
        let test = match self.report.zero_one.get() {
            Ok(test) => test,
            Err(reason) => return self.skipped("zero_one", "0–1 test for chaos", reason),
        };
        let k = Panel::new(
            format!("K = {:.3}: 0 regular, 1 chaotic", test.k),
            Axis::with_margin("frequency c, rad", test.by_frequency.iter().map(|p| p[0])),
            Axis::linear("K", [-1.05, 1.05]),
            vec![Layer::points(test.by_frequency.clone(), 1.7, Color::Ink)],
        );
        // The other panel has K as its title.
        let path =
            chaos::zero_one_path(test, &self.report.signal.unit, test.path.len()).with_caption("");
        let title = self.title("0–1 test for chaos");
        Figure::new("zero_one", title, 84.0, vec![vec![k, path]])
    }

    pub fn regime(&self) -> Figure {
        let verdict = match self.report.verdict.get() {
            Ok(verdict) => verdict,
            Err(reason) => return self.skipped("regime", "Type of motion", reason),
        };
        // What matters, as many as a slide has room for.
        let evidence = verdict.evidence.iter().filter(|piece| piece.matters());
        let evidence: Vec<&Evidence> = evidence.take(8).collect();
        let bars = evidence.iter().enumerate();
        let parts = bars.map(|(row, piece)| {
            let ends = [0.0, piece.contribution];
            (row, ends, Color::Regime(piece.supports))
        });
        let names: Vec<String> = evidence
            .iter()
            .map(|piece| piece.criterion.clone())
            .collect();
        let height = 34.0 + 7.0 * names.len() as f64;
        let largest = evidence.iter().map(|piece| piece.contribution);
        let axis = Axis::linear("change of ln(odds)", [0.0, largest.fold(1.0, f64::max)]);
        let mut panel = Panel::bars(verdict.summary(), axis, names, parts);
        let supported = |regime: &Regime| evidence.iter().any(|e| e.supports == *regime);
        let keys = Regime::ALL.into_iter().filter(supported);
        let keys =
            keys.map(|regime| Layer::legend_entry(regime.to_string(), Color::Regime(regime)));
        panel.layers.extend(keys);
        let title = self.title("Type of motion");
        Figure::new("regime", title, height, vec![vec![panel]])
    }
}
