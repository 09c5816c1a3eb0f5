//! Common scales of the plots of a sweep, which make them comparable: those of all points, and those of the
//! points at one parameter value.

use super::{SweepStudy, description, timeline::TimelineTicks};
use crate::plot::response::{SMALLEST, common_range, largest, section_axes, spectrum_axes};
use crate::plot::{Panel, SectionAxes};
use crate::study::response::SettledResponse;
use crate::study::sweep::SweepPoint;

/// Decades of the amplitude axis of a spectrum.
const DECADES: i32 = 7;
/// Lines weaker than this fraction of the strongest do not extend the frequency axis.
const WEAK: f64 = 3e-3;
/// The frequency axis ends at a multiple of this, Hz.
const FREQUENCY_STEP: f64 = 2.5e3;
/// Smallest full scale of a phase portrait relative to the largest motion of the sweep, so that a silent
/// motion appears as a point.
const LEAST_SHARE: f64 = 0.01;

/// Scales shared by all points.
#[derive(Clone, Debug)]
pub struct SharedScales {
    /// The timeline.
    pub timeline: TimelineTicks,
    /// Axes of the spectra.
    pub spectrum: Panel,
    /// Largest displacement (m) and speed (m/s).
    largest: [f64; 2],
    /// Symbol of the displacement.
    letter: &'static str,
}

impl SharedScales {
    /// The scales of a sweep.
    pub fn new(sweep: &SweepStudy<'_>) -> Self {
        let found: Vec<_> = sweep.points.iter().filter_map(SweepPoint::found).collect();
        let sizes = found.iter().map(|response| largest(response));
        let largest = sizes.fold(SMALLEST, |[a, b], [c, d]| [a.max(c), b.max(d)]);
        let (parameter, unit) = (description::parameter(sweep), description::unit(sweep));
        Self {
            timeline: TimelineTicks::new(&parameter, unit, sweep.values()),
            spectrum: spectrum(&found, largest[0]),
            largest,
            letter: sweep.letter(),
        }
    }

    /// The scales of the points at one parameter value: range of displacement (m) and speed (m/s) of the phase portraits, and
    /// axes of the Poincaré sections.
    pub fn point_scales(&self, found: &[&SettledResponse]) -> ([f64; 2], SectionAxes) {
        let least = self.largest.map(|size| LEAST_SHARE * size);
        let axes = section_axes(found, self.letter, self.largest[0]);
        (common_range(found, least), axes)
    }
}

fn spectrum(found: &[&SettledResponse], largest: f64) -> Panel {
    let lines = || found.iter().flat_map(|response| &response.lines);
    let strongest = lines().map(|line| line.amplitude).fold(0.0, f64::max);
    let strong = lines().filter(|line| line.amplitude >= WEAK * strongest);
    let highest = strong.map(|line| line.frequency).fold(0.0, f64::max);
    let motions = found.iter();
    let motions = motions.filter_map(|response| response.portrait.as_ref());
    let ends = motions.map(|motion| motion.spectrum_bin_hz * motion.spectrum_m.len() as f64);
    let highest = (1.1 * highest / FREQUENCY_STEP).ceil().max(2.0) * FREQUENCY_STEP;
    // The last bin can lie slightly above a round number.
    let end = (ends.fold(0.0, f64::max) / 1e3).round() * 1e3;
    let highest = if end > 0.0 { highest.min(end) } else { highest };
    // Without lines, the displacement determines the scale.
    let top = if strongest > 0.0 { strongest } else { largest };
    spectrum_axes(top, DECADES, highest)
}
