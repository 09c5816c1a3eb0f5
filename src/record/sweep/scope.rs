//! The scales that the pictures of a sweep share, so that they can be compared: those of all points,
//! and those of the points at one value.

use super::{SweepStudy, ladder::Ladder, words};
use crate::{
    analysis::range,
    plot::{
        exponent_ends,
        response::{SMALLEST, SectionPlane, SpectrumPlane, common_reach, largest},
    },
    study::response::Response,
};

/// Decades of a spectrum on show.
const DECADES: i32 = 7;
/// Lines weaker than this share of the strongest need not be on show.
const WEAK: f64 = 3e-3;
/// Frequencies on show are whole multiples of this, Hz.
const FREQUENCY_STEP: f64 = 2.5e3;
/// Smallest full scale of a portrait, as a share of that of the largest motion of the sweep: what
/// is silent beside the others looks silent.
const LEAST_SHARE: f64 = 0.01;

/// What all points share.
#[derive(Clone, Debug)]
pub struct Scope {
    /// The timeline.
    pub ladder: Ladder,
    /// The plane of spectra.
    pub spectrum: SpectrumPlane,
    /// How many exponents there are at the most.
    pub exponents: usize,
    /// The ends of the exponents' axis, 1/s.
    pub exponent_range: [f64; 2],
    /// The largest displacement (m) and speed (m/s).
    largest: [f64; 2],
    /// Letter of the displacement.
    letter: &'static str,
}

/// What the points at one value share.
#[derive(Clone, Debug)]
pub struct Planes {
    /// Displacement (m) and speed (m/s) to which the portraits reach.
    pub reach: [f64; 2],
    /// The plane of the sections.
    pub section: SectionPlane,
}

impl Scope {
    /// That of a sweep.
    pub fn new(sweep: &SweepStudy<'_>) -> Self {
        let found = sweep
            .points
            .iter()
            .filter_map(|point| point.outcome.as_ref().ok());
        let found: Vec<&Response> = found.collect();
        let sizes = found.iter().map(|response| largest(response));
        let largest = sizes.fold(SMALLEST, |[a, b], [c, d]| [a.max(c), b.max(d)]);
        let spectra = || {
            found
                .iter()
                .filter_map(|response| response.exponents.as_ref())
        };
        let exponents = spectra().flat_map(|spectrum| spectrum.exponents.iter().copied());
        let [low, high] = range(exponent_ends(exponents).chain([-1.0, 1.0]));
        let margin = 0.08 * (high - low);
        Self {
            ladder: Ladder::new(&words::parameter(sweep), words::unit(sweep), sweep.values()),
            spectrum: spectrum(&found, largest[0]),
            exponents: spectra().map(|s| s.exponents.len()).max().unwrap_or(0),
            exponent_range: [low - margin, high + margin],
            largest,
            letter: sweep.letter(),
        }
    }

    /// What the points at one value share.
    pub fn planes(&self, found: &[&Response]) -> Planes {
        Planes {
            reach: common_reach(found, self.largest.map(|size| LEAST_SHARE * size)),
            section: SectionPlane::new(found, self.letter, self.largest[0]),
        }
    }
}

fn spectrum(found: &[&Response], largest: f64) -> SpectrumPlane {
    let lines = || found.iter().flat_map(|response| &response.lines);
    let strongest = lines().map(|line| line.amplitude).fold(0.0, f64::max);
    let strong = lines().filter(|line| line.amplitude >= WEAK * strongest);
    let highest = strong.map(|line| line.frequency).fold(0.0, f64::max);
    let motions = found
        .iter()
        .filter_map(|response| response.portrait.as_ref());
    let ends = motions.map(|motion| motion.bin * motion.spectrum.len() as f64);
    let highest = (1.1 * highest / FREQUENCY_STEP).ceil().max(2.0) * FREQUENCY_STEP;
    // The last bin may be a little beyond a round number.
    let end = (ends.fold(0.0, f64::max) / 1e3).round() * 1e3;
    let highest = if end > 0.0 { highest.min(end) } else { highest };
    // Of a displacement without lines there is at least a size.
    let top = if strongest > 0.0 { strongest } else { largest };
    SpectrumPlane::new(top, DECADES, highest)
}
