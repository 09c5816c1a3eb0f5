//! Nested lists of a response as table columns: one list per field.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::{
    ClosedCurves, Measures, RecurrenceKind, RecurrencePeriod, RecurrencePeriods, SpectralLine,
};
use crate::dynamics::{Exponent, LyapunovSpectrum};
use crate::joint::NamedMode;
use crate::study::StabilityAt;

/// A module for `serde(with)` that serialises a type through its columns.
macro_rules! columns {
    ($module:ident: $type:ty as $columns:ty) => {
        pub(super) mod $module {
            use super::*;

            pub fn serialize<S: serde::Serializer>(all: &$type, to: S) -> Result<S::Ok, S::Error> {
                <$columns>::of(all).serialize(to)
            }

            pub fn deserialize<'de, D: serde::Deserializer<'de>>(
                from: D,
            ) -> Result<$type, D::Error> {
                Ok(<$columns>::deserialize(from)?.join())
            }
        }
    };
}

columns!(section: Vec<[f64; 2]> as Section);
columns!(curves: Option<ClosedCurves> as Maybe<Curves>);
columns!(lines: Vec<SpectralLine> as Lines);
columns!(exponents: Option<LyapunovSpectrum> as Maybe<Exponents>);
columns!(recurrence: Option<Measures> as Maybe<Recurrence>);
columns!(periods: RecurrencePeriods as Periods);
columns!(linear: Option<StabilityAt> as Maybe<Linear>);

/// Conversion of a nested type to and from its columns.
trait Columns {
    type Joined;
    fn of(joined: &Self::Joined) -> Self;
    fn join(self) -> Self::Joined;
}

/// Columns that are null together.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
struct Maybe<C>(Option<C>);

impl<C: Columns> Columns for Maybe<C> {
    type Joined = Option<C::Joined>;

    fn of(joined: &Self::Joined) -> Self {
        Self(joined.as_ref().map(C::of))
    }

    fn join(self) -> Self::Joined {
        self.0.map(C::join)
    }
}

#[derive(Serialize, Deserialize, JsonSchema)]
pub(super) struct Section {
    /// Points of the section where `y(t + tau)` crosses zero upwards: `y(t)`, m.
    section_y_m: Vec<f64>,
    /// Section points: `y(t + 2tau)` of the same crossings, m.
    section_y_2tau_m: Vec<f64>,
}

impl Columns for Section {
    type Joined = Vec<[f64; 2]>;

    fn of(points: &Self::Joined) -> Self {
        Self {
            section_y_m: points.iter().map(|p| p[0]).collect(),
            section_y_2tau_m: points.iter().map(|p| p[1]).collect(),
        }
    }

    fn join(self) -> Self::Joined {
        let points = self.section_y_m.into_iter().zip(self.section_y_2tau_m);
        points.map(|(y, later)| [y, later]).collect()
    }
}

#[derive(Serialize, Deserialize, JsonSchema)]
pub(super) struct Curves {
    /// Number of closed curves of the section: 1 for a torus, 2 or more if the motion visits several in
    /// turn; `null` if the section has no closed curves.
    section_curves: u64,
    /// Number of times that the strongest oscillation along each curve repeats before it closes: 2 or 4
    /// for a torus that has doubled in length.
    section_windings: u64,
}

impl Columns for Curves {
    type Joined = ClosedCurves;

    fn of(curves: &ClosedCurves) -> Self {
        Self {
            section_curves: curves.count as u64,
            section_windings: curves.windings as u64,
        }
    }

    fn join(self) -> ClosedCurves {
        ClosedCurves {
            count: self.section_curves as usize,
            windings: self.section_windings as usize,
        }
    }
}

#[derive(Serialize, Deserialize, JsonSchema)]
pub(super) struct Lines {
    /// Frequencies of the spectral lines in descending order of amplitude, Hz.
    line_hz: Vec<f64>,
    /// Amplitudes of the lines, m.
    line_amplitude_m: Vec<f64>,
    /// Names of the lines, such as `f1`; empty for a line without a name.
    line_name: Vec<String>,
}

impl Columns for Lines {
    type Joined = Vec<SpectralLine>;

    fn of(lines: &Self::Joined) -> Self {
        Self {
            line_hz: lines.iter().map(|l| l.frequency).collect(),
            line_amplitude_m: lines.iter().map(|l| l.amplitude).collect(),
            line_name: lines.iter().map(|l| l.label.clone()).collect(),
        }
    }

    fn join(self) -> Self::Joined {
        let lines = self.line_hz.into_iter().zip(self.line_amplitude_m);
        lines
            .zip(self.line_name)
            .map(|((frequency, amplitude), label)| SpectralLine {
                frequency,
                amplitude,
                label,
            })
            .collect()
    }
}

#[derive(Serialize, Deserialize, JsonSchema)]
pub(super) struct Exponents {
    /// Largest Lyapunov exponents, 1/s.
    #[schemars(with = "Vec<Option<f64>>")]
    exponent_per_s: Vec<f64>,
    /// Half-widths of the 95 % intervals of the exponents, 1/s.
    #[schemars(with = "Vec<Option<f64>>")]
    exponent_half_width_per_s: Vec<f64>,
    /// Resolution of the exponents, 1/s: a smaller magnitude cannot be distinguished from zero.
    #[schemars(with = "Option<f64>")]
    exponent_resolution_per_s: f64,
    /// Averaging time of the exponents, s.
    exponent_time_s: f64,
    /// Dimension of the tangent space: the total number of exponents.
    dimension: usize,
    /// Kaplan-Yorke dimension; `null` if too few exponents are known.
    kaplan_yorke: Option<f64>,
    /// Half-width of the 95 % interval of the Kaplan-Yorke dimension.
    kaplan_yorke_half_width: Option<f64>,
}

impl Columns for Exponents {
    type Joined = LyapunovSpectrum;

    fn of(spectrum: &LyapunovSpectrum) -> Self {
        let exponents = &spectrum.exponents;
        Self {
            exponent_per_s: exponents.iter().map(|e| e.value).collect(),
            exponent_half_width_per_s: exponents.iter().map(|e| e.half_width).collect(),
            exponent_resolution_per_s: spectrum.resolution,
            exponent_time_s: spectrum.time,
            dimension: spectrum.dimension,
            kaplan_yorke: spectrum.kaplan_yorke.map(|d| d.value),
            kaplan_yorke_half_width: spectrum.kaplan_yorke.map(|d| d.half_width),
        }
    }

    fn join(self) -> LyapunovSpectrum {
        let values = self.exponent_per_s.into_iter();
        let exponents = values.zip(self.exponent_half_width_per_s);
        LyapunovSpectrum {
            exponents: exponents
                .map(|(value, half_width)| Exponent { value, half_width })
                .collect(),
            time: self.exponent_time_s,
            dimension: self.dimension,
            resolution: self.exponent_resolution_per_s,
            kaplan_yorke: self.kaplan_yorke.map(|value| Exponent {
                value,
                half_width: self.kaplan_yorke_half_width.unwrap_or(f64::INFINITY),
            }),
        }
    }
}

/// Recurrence measures; lengths and times in states.
#[derive(Serialize, Deserialize, JsonSchema)]
pub(super) struct Recurrence {
    /// Recurrence rate RR, 0 to 1.
    recurrence_rate: f64,
    /// Determinism DET, 0 to 1.
    determinism: Option<f64>,
    /// Mean diagonal line length L, states.
    mean_diagonal: Option<f64>,
    /// Longest diagonal line length Lmax, states.
    longest_diagonal: u64,
    /// Divergence DIV = 1 / Lmax, 1/states.
    divergence: Option<f64>,
    /// Entropy ENTR of the diagonal line lengths, nats.
    entropy: Option<f64>,
    /// TREND, per 1000 states.
    trend: Option<f64>,
    /// Laminarity LAM, 0 to 1.
    laminarity: Option<f64>,
    /// Trapping time TT, states.
    trapping_time: Option<f64>,
    /// Longest vertical line length Vmax, states.
    longest_vertical: u64,
    /// Mean recurrence time of type 1 (T1), states.
    recurrence_time_1: Option<f64>,
    /// Mean recurrence time of type 2 (T2), states.
    recurrence_time_2: Option<f64>,
}

impl Columns for Recurrence {
    type Joined = Measures;

    fn of(measures: &Measures) -> Self {
        Self {
            recurrence_rate: measures.recurrence_rate,
            determinism: measures.determinism,
            mean_diagonal: measures.mean_diagonal,
            longest_diagonal: measures.longest_diagonal as u64,
            divergence: measures.divergence,
            entropy: measures.entropy,
            trend: measures.trend,
            laminarity: measures.laminarity,
            trapping_time: measures.trapping_time,
            longest_vertical: measures.longest_vertical as u64,
            recurrence_time_1: measures.recurrence_time_1,
            recurrence_time_2: measures.recurrence_time_2,
        }
    }

    fn join(self) -> Measures {
        Measures {
            recurrence_rate: self.recurrence_rate,
            determinism: self.determinism,
            mean_diagonal: self.mean_diagonal,
            longest_diagonal: self.longest_diagonal as f64,
            divergence: self.divergence,
            entropy: self.entropy,
            trend: self.trend,
            laminarity: self.laminarity,
            trapping_time: self.trapping_time,
            longest_vertical: self.longest_vertical as f64,
            recurrence_time_1: self.recurrence_time_1,
            recurrence_time_2: self.recurrence_time_2,
        }
    }
}

#[derive(Serialize, Deserialize, JsonSchema)]
pub(super) struct Periods {
    /// Periods of the diagonal lines of the recurrence plot, shortest first, s.
    recurrence_period_s: Vec<f64>,
    /// Standard uncertainties of the recurrence periods, s.
    recurrence_period_uncertainty_s: Vec<f64>,
    /// Shares of the recurrent points on the diagonals at the multiples of each recurrence period, 0 to 1.
    recurrence_period_share: Vec<f64>,
    /// Kinds of the recurrence periods: `finest`, `beat` or `doubled`.
    recurrence_period_kind: Vec<String>,
}

impl Columns for Periods {
    type Joined = RecurrencePeriods;

    fn of(periods: &Self::Joined) -> Self {
        Self {
            recurrence_period_s: periods.iter().map(|p| p.period).collect(),
            recurrence_period_uncertainty_s: periods.iter().map(|p| p.uncertainty).collect(),
            recurrence_period_share: periods.iter().map(|p| p.share).collect(),
            recurrence_period_kind: periods.iter().map(|p| p.kind.to_string()).collect(),
        }
    }

    fn join(self) -> Self::Joined {
        let values = self.recurrence_period_s.into_iter();
        let values = values.zip(self.recurrence_period_uncertainty_s);
        let values = values.zip(self.recurrence_period_share);
        values
            .zip(self.recurrence_period_kind)
            .map(|(((period, uncertainty), share), kind)| RecurrencePeriod {
                kind: kind.parse().unwrap_or(RecurrenceKind::Finest),
                period,
                uncertainty,
                share,
            })
            .collect()
    }
}

#[derive(Serialize, Deserialize, JsonSchema)]
pub(super) struct Linear {
    /// Tilt of the load, rad.
    tilt_rad: f64,
    /// Frequencies of the linear modes at steady sliding, Hz.
    mode_hz: Vec<f64>,
    /// Growth rates of the linear modes, 1/s.
    mode_growth_per_s: Vec<f64>,
    /// Labels of the linear modes.
    mode_label: Vec<String>,
    /// Whether each linear mode is unstable.
    mode_unstable: Vec<bool>,
}

impl Columns for Linear {
    type Joined = StabilityAt;

    fn of(linear: &StabilityAt) -> Self {
        let modes = &linear.modes;
        Self {
            tilt_rad: linear.tilt,
            mode_hz: modes.iter().map(|m| m.frequency_hz).collect(),
            mode_growth_per_s: modes.iter().map(|m| m.growth).collect(),
            mode_label: modes.iter().map(|m| m.label.clone()).collect(),
            mode_unstable: modes.iter().map(|m| m.unstable).collect(),
        }
    }

    fn join(self) -> StabilityAt {
        let modes = self.mode_hz.into_iter().zip(self.mode_growth_per_s);
        let modes = modes.zip(self.mode_label).zip(self.mode_unstable);
        StabilityAt {
            tilt: self.tilt_rad,
            modes: modes
                .map(|(((frequency_hz, growth), label), unstable)| NamedMode {
                    frequency_hz,
                    growth,
                    label,
                    unstable,
                })
                .collect(),
        }
    }
}
