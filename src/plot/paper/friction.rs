//! Fig. 3: the friction curve with the slope factors as printed in the paper and as used.

use crate::joint::Stribeck;
use crate::plot::{Axis, Color, Figure, Layer, Panel};

/// Largest slip speed shown, m/s.
const FASTEST: f64 = 0.1;

/// Slope factors as printed in the caption of Fig. 3: `d` of the creep and `f` of the Stribeck curve, s/m.
const PRINTED: [f64; 2] = [10.0, 1000.0];

/// Fig. 3: friction curves with the slope factors as printed and as used. `sliding` is the speed of steady
/// sliding at the patch centre, m/s.
pub fn friction_curves(law: &Stribeck, sliding: f64) -> Figure {
    let printed = Stribeck {
        creep: PRINTED[0],
        stribeck: PRINTED[1],
        ..*law
    };
    let curve = |law: &Stribeck| -> Vec<[f64; 2]> {
        let speeds = (0..=2000).map(|k| FASTEST * f64::from(k) / 2000.0);
        speeds
            .map(|speed| [1e3 * speed, law.coefficient(speed)])
            .collect()
    };
    let factors = |law: &Stribeck| format!("d = {}, f = {} s/m", law.creep, law.stribeck);
    let at = |law: &Stribeck| {
        let (mu, slope) = (law.coefficient(sliding), law.slope(sliding));
        format!("μ = {mu:.3}, slope {slope:.2} s/m")
    };
    let panel = Panel::new(
        format!("used here: {}; as printed: {}", at(law), at(&printed)),
        Axis::linear("slip speed, mm/s", [0.0, 1e3 * FASTEST]),
        Axis::linear("coefficient of friction", [0.0, 1.08 * law.mu_s]),
        vec![
            Layer::line(curve(law), Color::Series(0))
                .with_label(format!("used here: {}", factors(law))),
            Layer::line(curve(&printed), Color::Series(2))
                .with_label(format!("as printed: {}", factors(&printed))),
            Layer::vertical_line(1e3 * sliding, Color::Faint)
                .with_label(format!("steady sliding, {:.1} mm/s", 1e3 * sliding)),
        ],
    );
    let (mu_s, mu_d) = (law.mu_s, law.mu_d);
    let title = format!("Fig. 3: friction curve, μs = {mu_s}, μd = {mu_d}");
    Figure::new("figure-3", title, 85.0, vec![vec![panel]])
}
