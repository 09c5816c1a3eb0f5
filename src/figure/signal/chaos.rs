//! Whether it is chaos: parting neighbours, the 0-1 test, the verdict.

use super::{View, dots, line};
use crate::analysis::{Divergence, ScalingRegion};
use crate::figure::panel::{Axis, Bar, Mark, Panel, extent};
use crate::figure::style::{BLUE, FAINT, VERMILION};
use crate::figure::{Figure, FigureError};

impl View<'_> {
    pub fn divergence(&self) -> Result<Figure, FigureError> {
        let panel = |title: &str, divergence: &Divergence| {
            let ms = 1e3 * divergence.step;
            let curve: Vec<[f64; 2]> = divergence
                .curve
                .iter()
                .enumerate()
                .map(|(k, &v)| [k as f64 * ms, v])
                .collect();
            let mut marks = vec![line(curve.clone(), BLUE, "")];
            let verdict = match &divergence.region {
                Some(region) => {
                    let at = |t: f64| [1e3 * t, region.intercept + region.slope * t];
                    let ScalingRegion { slope, error, .. } = *region;
                    let ends = vec![at(region.from), at(region.to)];
                    marks.push(line(ends, VERMILION, "the straight part"));
                    // Two digits of the error, and as many places of the value.
                    let places = (1.0 - error.abs().max(1e-300).log10().floor()).clamp(0.0, 9.0);
                    let places = places as usize;
                    format!("{title}: {slope:.places$} ± {error:.places$} 1/s")
                }
                None => format!("{title}: no straight part"),
            };
            Panel {
                title: verdict,
                x: Axis::linear("time, ms", extent(curve.iter().map(|p| p[0]))),
                y: Axis::around("mean ln(distance)", curve.iter().map(|p| p[1])),
                marks,
            }
        };
        Figure::new(
            "divergence",
            &self.title("How neighbours part"),
            [1000, 440],
            &[vec![
                panel("Rosenstein", &self.report.rosenstein),
                panel("Kantz", &self.report.kantz),
            ]],
        )
    }

    pub fn zero_one(&self) -> Result<Figure, FigureError> {
        let test = &self.report.zero_one;
        let k = Panel {
            title: format!("K = {:.3}: 0 regular, 1 chaotic", test.k),
            x: Axis::linear(
                "frequency c, rad",
                extent(test.by_frequency.iter().map(|p| p[0])),
            ),
            y: Axis::linear("K", [-1.05, 1.05]),
            marks: vec![dots(test.by_frequency.clone(), 2.5, BLUE, "")],
        };
        let path = Panel {
            title: "path at the median: bounded or a random walk?".to_owned(),
            x: Axis::around("p", test.path.iter().map(|p| p[0])),
            y: Axis::around("q", test.path.iter().map(|p| p[1])),
            marks: vec![line(test.path.clone(), BLUE, "")],
        };
        Figure::new(
            "zero_one",
            &self.title("0–1 test for chaos"),
            [1000, 460],
            &[vec![k, path]],
        )
    }

    pub fn regime(&self) -> Result<Figure, FigureError> {
        let verdict = &self.report.verdict;
        let bars: Vec<Bar> = verdict
            .evidence
            .iter()
            .map(|piece| Bar {
                value: piece.weight,
                words: format!("{} → {}: {}", piece.what, piece.kinds(), piece.words),
                color: if piece.says.contains(&verdict.regime) {
                    BLUE
                } else {
                    FAINT
                },
            })
            .collect();
        let rows = bars.len().max(1);
        let panel = Panel {
            title: format!(
                "{}, confidence {:.0} %",
                verdict.regime,
                100.0 * verdict.confidence
            ),
            x: Axis::linear("weight of the evidence", [0.0, 1.0]),
            y: Axis::linear("", [0.0, rows as f64]),
            marks: vec![Mark::Bars { bars }],
        };
        let height = 130 + 44 * rows as u32;
        Figure::new(
            "regime",
            &self.title("Kind of motion"),
            [1000, height],
            &[vec![panel]],
        )
    }
}
