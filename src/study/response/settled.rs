//! A settled response: what is written of a point of a sweep.

use serde::{Deserialize, Serialize};

use super::columns;
use crate::analysis::{Measures, Regime, SpectralLine};
use crate::dynamics::{LyapunovSpectrum, Tally};
use crate::study::StabilityAt;

/// A settled response. Lengths are in metres, as everywhere; what an analysis could not tell is
/// empty. Serialised, it is a row of a table: names carry units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// Time before the measurement began, s: a motion that only looked settled, and gave way to another
    /// one, is part of it.
    #[serde(rename = "transient_s")]
    pub transient: f64,
    /// Whether the transient was over by then, and the motion one and the same from then on.
    pub settled: bool,
    /// Half the range of the probe's displacement, m.
    #[serde(rename = "amplitude_m")]
    pub amplitude: f64,
    /// Root mean square of the probe's velocity, m/s.
    #[serde(rename = "rms_velocity_m_per_s")]
    pub rms_velocity: f64,
    /// The probe's largest speed, m/s.
    #[serde(rename = "peak_velocity_m_per_s")]
    pub peak_velocity: f64,
    /// Kind of motion.
    pub regime: Regime,
    /// How sure that is, 0 to 1.
    pub confidence: f64,
    /// Share of the power between the lines.
    pub floor_share: f64,
    /// Local maxima of the displacement, m, the newest ones: a column of the bifurcation diagram.
    #[serde(rename = "maxima_m")]
    pub maxima: Vec<f64>,
    /// The newest passages through the section: `y(t)` and `y(t + 2 tau)` where `y(t + tau)` rises
    /// through zero, m.
    #[serde(flatten, with = "columns::section")]
    pub section: Vec<[f64; 2]>,
    /// Spectral lines, the strongest first.
    #[serde(flatten, with = "columns::lines")]
    pub lines: Vec<SpectralLine>,
    /// The exponents; `None` if none were followed.
    #[serde(flatten, with = "columns::exponents")]
    pub exponents: Option<LyapunovSpectrum>,
    /// Recurrence quantification; `None` where nothing moves.
    #[serde(flatten, with = "columns::recurrence")]
    pub recurrence: Option<Measures>,
    /// Period of the diagonal lines of the recurrence plot, s.
    #[serde(rename = "recurrence_period_s")]
    pub recurrence_period: Option<f64>,
    /// Linear modes at steady sliding; `None` for a system that is no joint.
    #[serde(flatten, with = "columns::linear")]
    pub linear: Option<StabilityAt>,
    /// The state `[q | dq/dt]` at the end, to go on from.
    pub state: Vec<f64>,
    /// Work done.
    #[serde(flatten)]
    pub tally: Tally,
    /// Pieces of the motion to draw from, if asked for.
    #[serde(flatten)]
    pub portrait: Option<Portrait>,
}

/// Pieces of a settled motion to draw from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Portrait {
    /// Spacing of the samples, s.
    #[serde(rename = "portrait_dt_s")]
    pub dt: f64,
    /// The newest displacements, m.
    #[serde(rename = "portrait_u_m")]
    pub displacement: Vec<f32>,
    /// The probe's velocities at the same instants, m/s.
    #[serde(rename = "portrait_v_m_per_s")]
    pub velocity: Vec<f32>,
    /// Spacing of the spectrum's bins, Hz, the first at 0.
    #[serde(rename = "spectrum_bin_hz")]
    pub bin: f64,
    /// Amplitude spectrum of the displacement over the whole measurement, m.
    #[serde(rename = "spectrum_m")]
    pub spectrum: Vec<f32>,
}
