//! Floquet multipliers as eigenvalues of a product of matrices that is never formed.
//!
//! A product of segments mixes directions that grow with directions that decay: if the largest and the smallest
//! multiplier differ by more than 16 decades, its eigenvalues have no correct digit of the smallest one (T. F.
//! Fairgrieve, A. D. Jepson, SIAM J. Numer. Anal. 28 (1991) 1446-1462). The periodic Schur decomposition transforms
//! each factor on its own (A. Bojanczyk, G. H. Golub, P. Van Dooren, Proc. SPIE 1770 (1992) 31-42; K. Lust, Int. J.
//! Bifurcation Chaos 11 (2001) 2389-2410). Each multiplier is then a product of diagonal elements.
//!
//! The relative error of a multiplier is that of a backward error of `f64::EPSILON` in each factor, whose effect is
//! multiplied by the condition of that factor. Short segments therefore give accurate multipliers, however small.

mod rotation;
mod schur;

use super::Multiplier;
use schur::PeriodicSchur;

pub use schur::SchurError;

/// The eigenvalues of the product `factors[p - 1] ... factors[1] factors[0]` of real `n x n` matrices (row-major), the
/// largest first, complex pairs with the positive angle first.
///
/// A factor that is singular to rounding gives multipliers that are exactly zero.
///
/// # Errors
/// If the iteration does not converge, or an element is not finite.
///
/// # Panics
/// If a factor does not have `n * n` elements.
pub fn floquet_multipliers(n: usize, factors: &[Vec<f64>]) -> Result<Vec<Multiplier>, SchurError> {
    let mut all = PeriodicSchur::new(n, factors)?.eigenvalues()?;
    make_real(&mut all);
    all.sort_by(Multiplier::order);
    Ok(all)
}

/// Makes a computed spectrum that of a real matrix: each eigenvalue is either real, or one of a conjugate pair.
///
/// The complex iteration gives conjugates only to rounding. The eigenvalue that is furthest from the real axis is
/// paired first, with that which is closest to its conjugate, unless itself is closer to it.
fn make_real(all: &mut [Multiplier]) {
    let is_zero = |m: &Multiplier| m.ln_magnitude == f64::NEG_INFINITY;
    let mut open: Vec<usize> = (0..all.len()).filter(|&k| !is_zero(&all[k])).collect();
    // Distance of an eigenvalue from the real axis, relative to its magnitude.
    let height = |m: &Multiplier| m.angle.sin().abs();
    while let Some(place) =
        (0..open.len()).max_by(|&a, &b| height(&all[open[a]]).total_cmp(&height(&all[open[b]])))
    {
        let k = open.swap_remove(place);
        let here = all[k];
        let partner = (0..open.len())
            .map(|place| (place, distance_from_conjugate(here, all[open[place]])))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|&(_, distance)| distance < 2.0 * height(&here));
        let Some((place, _)) = partner else {
            all[k].angle = if here.angle.cos() < 0.0 {
                std::f64::consts::PI
            } else {
                0.0
            };
            continue;
        };
        let other = open.swap_remove(place);
        let ln_magnitude = 0.5 * (here.ln_magnitude + all[other].ln_magnitude);
        let angle = 0.5 * (here.angle.abs() + all[other].angle.abs());
        (all[k], all[other]) = (
            Multiplier {
                ln_magnitude,
                angle,
            },
            Multiplier {
                ln_magnitude,
                angle: -angle,
            },
        );
    }
}

/// Distance of `b` from the conjugate of `a`, relative to the magnitude of `a`.
fn distance_from_conjugate(a: Multiplier, b: Multiplier) -> f64 {
    let ratio = (b.ln_magnitude - a.ln_magnitude).exp();
    let turn = a.angle + b.angle;
    (ratio * turn.cos() - 1.0).hypot(ratio * turn.sin())
}
