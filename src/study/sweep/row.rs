//! A point of a sweep as a row of a table.

use serde::{Deserialize, Serialize};

use super::{Place, Start, SweepPoint};
use crate::analysis::{Measures, Regime, SpectralLine};
use crate::dynamics::{Exponent, LyapunovSpectrum, Tally};
use crate::joint::NamedMode;
use crate::study::StabilityAt;
use crate::study::response::{Portrait, Response};

/// A row. Names carry units; what is not known is null, or an empty list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    index: u64,
    start: String,
    values: Vec<f64>,
    error: Option<String>,
    transient_s: Option<f64>,
    settled: Option<bool>,
    amplitude_m: Option<f64>,
    rms_velocity_m_per_s: Option<f64>,
    peak_velocity_m_per_s: Option<f64>,
    regime: Option<String>,
    confidence: Option<f64>,
    floor_share: Option<f64>,
    maxima_m: Vec<f64>,
    section_y_m: Vec<f64>,
    section_y_2tau_m: Vec<f64>,
    line_hz: Vec<f64>,
    line_amplitude_m: Vec<f64>,
    line_name: Vec<String>,
    exponent_per_s: Vec<f64>,
    exponent_half_width_per_s: Vec<f64>,
    exponent_resolution_per_s: Option<f64>,
    exponent_time_s: Option<f64>,
    dimension: Option<u64>,
    kaplan_yorke: Option<f64>,
    kaplan_yorke_half_width: Option<f64>,
    recurrence_rate: Option<f64>,
    determinism: Option<f64>,
    mean_diagonal: Option<f64>,
    longest_diagonal: Option<u64>,
    divergence: Option<f64>,
    entropy: Option<f64>,
    trend: Option<f64>,
    laminarity: Option<f64>,
    trapping_time: Option<f64>,
    longest_vertical: Option<u64>,
    recurrence_time_1: Option<f64>,
    recurrence_time_2: Option<f64>,
    recurrence_period_s: Option<f64>,
    tilt_rad: Option<f64>,
    mode_hz: Vec<f64>,
    mode_growth_per_s: Vec<f64>,
    mode_label: Vec<String>,
    mode_unstable: Vec<bool>,
    state: Vec<f64>,
    steps: Option<u64>,
    rejections: Option<u64>,
    calls: Option<u64>,
    jacobians: Option<u64>,
    switches: Option<u64>,
    crossings: Option<u64>,
    events: Option<u64>,
    grazings: Option<u64>,
    overrun: Option<u64>,
    portrait_dt_s: Option<f64>,
    portrait_u_m: Vec<f32>,
    portrait_v_m_per_s: Vec<f32>,
    spectrum_bin_hz: Option<f64>,
    spectrum_m: Vec<f32>,
}

impl Row {
    /// The row of a point.
    pub fn new(point: &SweepPoint) -> Self {
        let place = &point.place;
        let row = Self {
            index: place.index as u64,
            start: place.start.to_string(),
            values: place.values.clone(),
            ..Self::default()
        };
        match &point.outcome {
            Err(error) => Self {
                error: Some(error.clone()),
                ..row
            },
            Ok(found) => row.with(found),
        }
    }

    fn with(self, found: &Response) -> Self {
        let spectrum = found.exponents.as_ref();
        let exponents = || spectrum.iter().flat_map(|s| &s.exponents);
        let recurrence = found.recurrence.as_ref();
        let modes = || found.linear.iter().flat_map(|linear| &linear.modes);
        let portrait = found.portrait.as_ref();
        Self {
            transient_s: Some(found.transient),
            settled: Some(found.settled),
            amplitude_m: Some(found.amplitude),
            rms_velocity_m_per_s: Some(found.rms_velocity),
            peak_velocity_m_per_s: Some(found.peak_velocity),
            regime: Some(found.regime.to_string()),
            confidence: Some(found.confidence),
            floor_share: Some(found.floor_share),
            maxima_m: found.maxima.clone(),
            section_y_m: found.section.iter().map(|p| p[0]).collect(),
            section_y_2tau_m: found.section.iter().map(|p| p[1]).collect(),
            line_hz: found.lines.iter().map(|l| l.frequency).collect(),
            line_amplitude_m: found.lines.iter().map(|l| l.amplitude).collect(),
            line_name: found.lines.iter().map(|l| l.label.clone()).collect(),
            exponent_per_s: exponents().map(|e| e.value).collect(),
            exponent_half_width_per_s: exponents().map(|e| e.half_width).collect(),
            exponent_resolution_per_s: spectrum.map(|s| s.resolution),
            exponent_time_s: spectrum.map(|s| s.time),
            dimension: spectrum.map(|s| s.dimension as u64),
            kaplan_yorke: spectrum.and_then(|s| s.kaplan_yorke).map(|d| d.value),
            kaplan_yorke_half_width: spectrum.and_then(|s| s.kaplan_yorke).map(|d| d.half_width),
            recurrence_rate: recurrence.map(|r| r.recurrence_rate),
            determinism: recurrence.and_then(|r| r.determinism),
            mean_diagonal: recurrence.and_then(|r| r.mean_diagonal),
            longest_diagonal: recurrence.map(|r| r.longest_diagonal as u64),
            divergence: recurrence.and_then(|r| r.divergence),
            entropy: recurrence.and_then(|r| r.entropy),
            trend: recurrence.and_then(|r| r.trend),
            laminarity: recurrence.and_then(|r| r.laminarity),
            trapping_time: recurrence.and_then(|r| r.trapping_time),
            longest_vertical: recurrence.map(|r| r.longest_vertical as u64),
            recurrence_time_1: recurrence.and_then(|r| r.recurrence_time_1),
            recurrence_time_2: recurrence.and_then(|r| r.recurrence_time_2),
            recurrence_period_s: found.recurrence_period,
            tilt_rad: found.linear.as_ref().map(|linear| linear.tilt),
            mode_hz: modes().map(|m| m.frequency_hz).collect(),
            mode_growth_per_s: modes().map(|m| m.growth).collect(),
            mode_label: modes().map(|m| m.label.clone()).collect(),
            mode_unstable: modes().map(|m| m.unstable).collect(),
            state: found.state.clone(),
            steps: Some(found.tally.steps),
            rejections: Some(found.tally.rejections),
            calls: Some(found.tally.calls),
            jacobians: Some(found.tally.jacobians),
            switches: Some(found.tally.switches),
            crossings: Some(found.tally.crossings),
            events: Some(found.tally.events),
            grazings: Some(found.tally.grazings),
            overrun: Some(found.tally.overrun),
            portrait_dt_s: portrait.map(|p| p.dt),
            portrait_u_m: portrait.map(|p| p.displacement.clone()).unwrap_or_default(),
            portrait_v_m_per_s: portrait.map(|p| p.velocity.clone()).unwrap_or_default(),
            spectrum_bin_hz: portrait.map(|p| p.bin),
            spectrum_m: portrait.map(|p| p.spectrum.clone()).unwrap_or_default(),
            ..self
        }
    }

    /// The point of a row, or what is wrong with it.
    pub fn into_point(self) -> Result<SweepPoint, String> {
        let starts = Start::ALL.into_iter();
        let start = starts
            .into_iter()
            .find(|start| start.to_string() == self.start);
        let place = Place {
            index: self.index as usize,
            start: start.ok_or_else(|| format!("no start is called `{}`", self.start))?,
            values: self.values.clone(),
        };
        let outcome = match self.error.clone() {
            Some(error) => Err(error),
            None => {
                let gap = format!("its point {} has gaps", self.index);
                Ok(self.into_response().ok_or(gap)?)
            }
        };
        Ok(SweepPoint { place, outcome })
    }

    fn into_response(self) -> Option<Response> {
        let regime = Regime::ALL.into_iter();
        let told = self.regime?;
        let regime = regime
            .into_iter()
            .find(|regime| regime.to_string() == told)?;
        let exponents = self
            .exponent_per_s
            .iter()
            .zip(&self.exponent_half_width_per_s);
        let exponents = exponents.map(|(&value, &half_width)| Exponent { value, half_width });
        let lines = self
            .line_hz
            .into_iter()
            .zip(self.line_amplitude_m)
            .zip(self.line_name);
        let modes = self.mode_hz.into_iter().zip(self.mode_growth_per_s);
        let modes = modes.zip(self.mode_label).zip(self.mode_unstable);
        let section = self.section_y_m.into_iter().zip(self.section_y_2tau_m);
        Some(Response {
            transient: self.transient_s?,
            settled: self.settled?,
            amplitude: self.amplitude_m?,
            rms_velocity: self.rms_velocity_m_per_s?,
            peak_velocity: self.peak_velocity_m_per_s?,
            maxima: self.maxima_m,
            section: section.map(|(a, b)| [a, b]).collect(),
            lines: lines
                .map(|((frequency, amplitude), label)| SpectralLine {
                    frequency,
                    amplitude,
                    label,
                })
                .collect(),
            floor_share: self.floor_share?,
            exponents: match (self.exponent_time_s, self.dimension) {
                (Some(time), Some(dimension)) => Some(LyapunovSpectrum {
                    exponents: exponents.collect(),
                    time,
                    dimension: dimension as usize,
                    resolution: self.exponent_resolution_per_s?,
                    kaplan_yorke: self.kaplan_yorke.map(|value| Exponent {
                        value,
                        half_width: self.kaplan_yorke_half_width.unwrap_or(f64::INFINITY),
                    }),
                }),
                _ => None,
            },
            recurrence: match self.recurrence_rate {
                Some(recurrence_rate) => Some(Measures {
                    recurrence_rate,
                    determinism: self.determinism,
                    mean_diagonal: self.mean_diagonal,
                    longest_diagonal: self.longest_diagonal? as f64,
                    divergence: self.divergence,
                    entropy: self.entropy,
                    trend: self.trend,
                    laminarity: self.laminarity,
                    trapping_time: self.trapping_time,
                    longest_vertical: self.longest_vertical? as f64,
                    recurrence_time_1: self.recurrence_time_1,
                    recurrence_time_2: self.recurrence_time_2,
                }),
                None => None,
            },
            recurrence_period: self.recurrence_period_s,
            linear: self.tilt_rad.map(|tilt| StabilityAt {
                tilt,
                modes: modes
                    .map(|(((frequency_hz, growth), label), unstable)| NamedMode {
                        frequency_hz,
                        growth,
                        label,
                        unstable,
                    })
                    .collect(),
            }),
            regime,
            confidence: self.confidence?,
            portrait: match (self.portrait_dt_s, self.spectrum_bin_hz) {
                (Some(dt), Some(bin)) => Some(Portrait {
                    dt,
                    displacement: self.portrait_u_m,
                    velocity: self.portrait_v_m_per_s,
                    bin,
                    spectrum: self.spectrum_m,
                }),
                _ => None,
            },
            state: self.state,
            tally: Tally {
                steps: self.steps?,
                rejections: self.rejections?,
                calls: self.calls?,
                jacobians: self.jacobians?,
                switches: self.switches?,
                crossings: self.crossings?,
                events: self.events?,
                grazings: self.grazings?,
                overrun: self.overrun?,
            },
        })
    }
}
