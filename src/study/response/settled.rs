//! A settled response: the row of a point in a sweep table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::{
    poincare::ClosedCurves,
    recurrence::{Measures, RecurrencePeriods},
    regime::Regime,
    tones::{Bases, SpectralLine},
};
use crate::dynamics::{LyapunovSpectrum, SolverStats};
use crate::study::StabilityAt;

/// A settled response of a scene, in SI units. Measures that could not be computed are empty. Each field is a column of
/// the table of a sweep, which is derived from this type: so no field may be flattened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SettledResponse {
    /// Transient time before the measurement, s. It includes earlier windows in which the motion changed.
    #[serde(rename = "transient_s")]
    pub transient: f64,
    /// Whether the motion is settled: the transient had ended, and the motion did not change while measured.
    pub settled: bool,
    /// Half the peak-to-peak displacement of the probe, m.
    #[serde(rename = "amplitude_m")]
    pub amplitude: f64,
    /// Mean displacement of the probe, m.
    #[serde(rename = "mean_m")]
    pub mean: f64,
    /// RMS velocity of the probe, m/s.
    #[serde(rename = "rms_velocity_m_per_s")]
    pub rms_velocity: f64,
    /// Peak absolute velocity of the probe, m/s.
    #[serde(rename = "peak_velocity_m_per_s")]
    pub peak_velocity: f64,
    /// Regime: the type of motion.
    pub regime: Regime,
    /// Confidence of the regime, 0 to 1.
    pub confidence: f64,
    /// Broadband share: share of the spectral power outside the lines, 0 to 1.
    pub broadband_share: f64,
    /// Newest local maxima of the displacement, m: a column of the bifurcation diagram.
    #[serde(rename = "maxima_m")]
    pub maxima: Vec<f64>,
    /// Newest points of the section: `y(t)` and `y(t + 2 tau)` where `y(t + tau)` crosses zero upwards, m.
    #[serde(rename = "section_m")]
    pub section: Vec<[f64; 2]>,
    /// Closed curves of the section: the motion is on a torus; `None` if there are none.
    pub curves: Option<ClosedCurves>,
    /// Doubling order of a periodic or quasi-periodic motion: 0; 1 if it has lines at halves of the
    /// combinations of its base frequencies, 2 if at quarters.
    pub doubling: u32,
    /// Spectral lines in descending order of amplitude.
    pub lines: Vec<SpectralLine>,
    /// Leading Lyapunov exponents; `None` if none were computed.
    pub exponents: Option<LyapunovSpectrum>,
    /// Recurrence quantification; `None` for a silent motion.
    pub recurrence: Option<Measures>,
    /// Periods of the diagonal lines of the recurrence plot: finest, beat, doubled; s.
    pub recurrence_periods: RecurrencePeriods,
    /// Linear modes at steady sliding; `None` for a system other than the joint.
    pub linear: Option<StabilityAt>,
    /// Final state `[q | dq/dt]`, for continuation.
    pub state: Vec<f64>,
    /// Solver statistics.
    pub stats: SolverStats,
    /// Samples and spectrum for plots, if requested.
    // JSON does not have them, see `SweepPoint`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(skip)]
    pub portrait: Option<PhasePortrait>,
}

impl SettledResponse {
    /// The regime, and the doubling of a motion that has doubled: "torus, doubled", "periodic, doubled
    /// twice".
    pub fn motion(&self) -> String {
        let kind = match (self.regime, self.doubling) {
            (Regime::QuasiPeriodic, 1..) => "torus".to_owned(),
            (regime, _) => regime.to_string(),
        };
        match self.doubling {
            0 => kind,
            1 => format!("{kind}, doubled"),
            _ => format!("{kind}, doubled twice"),
        }
    }

    /// Name of the lowest line of the last doubling, such as `(f1 + f2)/2`; `None` without one.
    pub fn doubling_line(&self) -> Option<&str> {
        let ending = match self.doubling {
            0 => return None,
            1 => "/2",
            _ => "/4",
        };
        let mut lines = self.lines.iter().map(|line| &*line.label);
        lines.find(|label| label.ends_with(ending))
    }

    /// Base frequencies by the names of the lines.
    pub fn bases(&self) -> Bases {
        Bases::of_names(|name| {
            let line = self.lines.iter().find(|line| line.label == name);
            line.map(|line| line.frequency)
        })
    }
}

/// Samples for the phase portrait and the recurrence plot, and the amplitude spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhasePortrait {
    /// Sampling interval `dt` of the portrait, s.
    #[serde(rename = "dt_s")]
    pub dt: f64,
    /// Newest displacements `u` of the probe for the portrait, m.
    #[serde(rename = "u_m")]
    pub displacement: Vec<f32>,
    /// Velocities `v` of the probe for the portrait, at the same times, m/s.
    #[serde(rename = "v_m_per_s")]
    pub velocity: Vec<f32>,
    /// Bin width of the spectrum, Hz; the first bin is at 0 Hz.
    #[serde(rename = "spectrum_bin_hz")]
    pub bin: f64,
    /// Amplitude spectrum of the displacement over the whole measurement window, m.
    #[serde(rename = "spectrum_m")]
    pub spectrum: Vec<f32>,
}
