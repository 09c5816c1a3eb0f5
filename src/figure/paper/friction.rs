//! Fig. 3: the friction curve, in both readings of its caption.

use crate::figure::panel::{Axis, Mark, Panel};
use crate::figure::style::{BLUE, FAINT, VERMILION};
use crate::figure::{Figure, FigureError};
use crate::joint::Stribeck;

/// The largest slip speed shown, m/s.
const FASTEST: f64 = 0.1;

/// Fig. 3: the curve in use, and the one with its two slope factors exchanged; `sliding` is the speed
/// of steady sliding at the middle of the patch, m/s.
///
/// # Errors
/// [`FigureError`].
pub fn friction_curves(law: &Stribeck, sliding: f64) -> Result<Figure, FigureError> {
    let exchanged = Stribeck {
        creep: law.stribeck,
        stribeck: law.creep,
        ..*law
    };
    let curve = |law: &Stribeck| -> Vec<[f64; 2]> {
        let speeds = (0..=2000).map(|k| FASTEST * f64::from(k) / 2000.0);
        speeds
            .map(|speed| [1e3 * speed, law.coefficient(speed)])
            .collect()
    };
    let words = |law: &Stribeck| format!("d = {}, f = {} s/m", law.creep, law.stribeck);
    let at = |law: &Stribeck| {
        format!(
            "μ = {:.3}, slope {:.2} s/m",
            law.coefficient(sliding),
            law.slope(sliding)
        )
    };
    let panel = Panel {
        title: format!("in use: {}; exchanged: {}", at(law), at(&exchanged)),
        x: Axis::linear("slip speed, mm/s", [0.0, 1e3 * FASTEST]),
        y: Axis::linear("coefficient of friction", [0.0, 1.08 * law.mu_s]),
        marks: vec![
            Mark::Line {
                points: curve(law),
                color: VERMILION,
                label: format!("in use: {}", words(law)),
            },
            Mark::Line {
                points: curve(&exchanged),
                color: BLUE,
                label: format!("exchanged: {}", words(&exchanged)),
            },
            Mark::Upright {
                x: 1e3 * sliding,
                words: format!("steady sliding, {:.1} mm/s", 1e3 * sliding),
                color: FAINT,
            },
        ],
    };
    let title = format!(
        "Fig. 3 — friction curve, μs = {}, μd = {}",
        law.mu_s, law.mu_d
    );
    Figure::new("figure-3", &title, [1000, 480], &[vec![panel]])
}
