//! Points of a branch of equilibria at which a mode changes its stability.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::equilibria::{BranchPlan, Tracked, fastest_alike, most_alike};
use super::family::{SteadyState, SubjectFamily};
use super::result::At;
use crate::dynamics::continuation::Criticality;
use crate::dynamics::equilibrium::{Eigenmode, FirstLyapunov, eigenvalue_derivative};
use crate::study::StudyError;

/// Iterations of the search for a root; bisection alone needs 60.
const MAX_ITERATIONS: usize = 100;
/// Relative width of the last bracket.
const WIDTH: f64 = 1e-13;
/// Rounding errors of a growth rate relative to the size of the eigenvalue.
const ROUNDING: f64 = 1e-9;
/// A first Lyapunov coefficient is zero within this multiple of its error.
const SIGNIFICANT: f64 = 10.0;

/// Kinds of bifurcations of an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "lowercase")]
pub enum SteadyBifurcationKind {
    /// A pair of complex eigenvalues crosses the imaginary axis.
    #[strum(serialize = "Hopf")]
    Hopf,
    /// Two undamped modes with different frequencies meet, and one of them grows beyond (mode coupling without
    /// damping). The growth rate has a vertical tangent there.
    Flutter,
    /// A real eigenvalue crosses zero: a fold or a branch point of equilibria.
    #[strum(serialize = "zero eigenvalue")]
    ZeroEigenvalue,
}

/// The method that determined the criticality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
pub enum CriticalityMethod {
    /// The cubic term of the normal form.
    #[strum(serialize = "normal form")]
    NormalForm,
    /// The parameter as a function of the amplitude along the branch of cycles born there.
    #[strum(serialize = "fitted branch")]
    FittedBranch,
}

/// The birth of a cycle at a Hopf point: the first Lyapunov coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CycleBirth {
    /// How the cycle is born.
    pub criticality: Criticality,
    /// The method that determined the criticality.
    pub method: CriticalityMethod,
    /// First Lyapunov coefficient `Re c / omega` (Kuznetsov), for an eigenvector of length 1 in `[omega q | dq/dt]`, in
    /// the unit of the state's velocity to the power -2.
    pub first_lyapunov: f64,
    /// Error estimate of the first Lyapunov coefficient.
    pub first_lyapunov_error: f64,
    /// Amplitude of the displacement at the probe at which the first contact node separates, or another kink of the law
    /// is reached, m; `None` for a smooth system. Beyond it the normal form does not hold.
    pub smooth_amplitude_m: Option<f64>,
    /// Range of the parameter from the Hopf point on in which the law is smooth over the cycle of the normal form, in
    /// the unit of the scene file.
    pub smooth_range: Option<f64>,
}

/// A point at which a mode of an equilibrium changes its stability.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SteadyBifurcation {
    /// Kind of bifurcation.
    pub kind: SteadyBifurcationKind,
    /// Number of the mode, as in the points of the branch.
    pub number: usize,
    /// Dominant mode of the body.
    pub label: String,
    /// Frequency of the mode, Hz.
    pub frequency_hz: f64,
    /// Derivative of the growth rate with the parameter, 1/s per unit of the scene file; positive if the mode becomes
    /// unstable with an increasing parameter.
    /// `None` where the tangent is vertical.
    pub crossing_speed: Option<f64>,
    /// Derivative of the frequency with the parameter, Hz per unit of the scene file. `None` where the tangent is
    /// vertical.
    pub frequency_slope: Option<f64>,
    /// Error estimate of the location, in the unit of the scene file.
    pub location_error: f64,
    /// The cycle that is born at a Hopf point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<CycleBirth>,
    /// Value of the parameter.
    #[serde(flatten)]
    pub at: At,
}

/// An interval in which the growth rate of a mode changes its sign.
pub(super) struct Bracket {
    number: usize,
    /// Value of the parameter and mode at each end.
    ends: [(f64, Eigenmode); 2],
    /// The growth rate that is crossed, 1/s: zero, or rounding errors if the mode is undamped at one end.
    level: f64,
}

impl Bracket {
    /// The brackets of all modes between two points.
    pub fn between<'a>(
        low: (f64, &'a [Tracked]),
        high: (f64, &'a [Tracked]),
    ) -> impl Iterator<Item = Self> + 'a {
        low.1.iter().filter_map(move |one| {
            let other = high.1.iter().find(|other| other.number == one.number)?;
            let signs = [&one.mode, &other.mode].map(sign);
            let level = match signs {
                [-1, 1] | [1, -1] => 0.0,
                [0, 1] => ROUNDING * one.mode.value.norm(),
                [1, 0] => ROUNDING * other.mode.value.norm(),
                _ => return None,
            };
            Some(Self {
                number: one.number,
                ends: [(low.0, one.mode.clone()), (high.0, other.mode.clone())],
                level,
            })
        })
    }
}

/// Sign of the growth rate of a mode; zero within rounding errors.
pub(super) fn sign(mode: &Eigenmode) -> i32 {
    match mode.value.re / (ROUNDING * mode.value.norm()) {
        1.0.. => 1,
        share if share <= -1.0 => -1,
        _ => 0,
    }
}

/// Locates the bifurcation in a bracket. `None` if the mode cannot be followed into it.
pub(super) fn locate(
    family: &SubjectFamily,
    bracket: &Bracket,
    plan: &BranchPlan,
) -> Result<Option<SteadyBifurcation>, StudyError> {
    let Some((value, error)) = root(family, bracket)? else {
        return Ok(None);
    };
    let (state, mode) = followed(family, bracket, value)?;
    let Some(mode) = mode else {
        return Ok(None);
    };
    let kind = match (mode.oscillates(), bracket.level > 0.0) {
        (true, false) => SteadyBifurcationKind::Hopf,
        (true, true) => SteadyBifurcationKind::Flutter,
        (false, _) => SteadyBifurcationKind::ZeroEigenvalue,
    };
    let named = state.named(&mode);
    let speed = match kind {
        SteadyBifurcationKind::Flutter => None,
        _ => {
            let slope = family.slope(value, plan.interval[1] - plan.interval[0])?;
            let left = state.linearised.left(&mode);
            Some(eigenvalue_derivative(&left, &slope, &mode.vector))
        }
    };
    let cycle = match (kind, speed) {
        (SteadyBifurcationKind::Hopf, Some(speed)) => Some(birth(&state, &mode, speed.re)?),
        _ => None,
    };
    let residual = speed.map_or(0.0, |speed| (mode.value.re / speed.re).abs());
    Ok(Some(SteadyBifurcation {
        kind,
        number: bracket.number,
        label: named.label,
        frequency_hz: named.frequency_hz,
        crossing_speed: speed.map(|speed| speed.re),
        frequency_slope: speed.map(|speed| speed.im / std::f64::consts::TAU),
        location_error: error + residual,
        cycle,
        at: At::new(plan.name(), value),
    }))
}

/// The zero of the growth rate and the width of the last bracket, by the method of Chandrupatla (Adv. Eng. Software 28
/// (1997) 145): inverse quadratic interpolation where it converges, bisection elsewhere.
fn root(family: &SubjectFamily, bracket: &Bracket) -> Result<Option<(f64, f64)>, StudyError> {
    let [(mut b, mode_b), (mut a, mode_a)] = bracket.ends.clone();
    let level = bracket.level;
    let (mut fb, mut fa) = (mode_b.value.re - level, mode_a.value.re - level);
    let (mut c, mut fc);
    let mut share = 0.5;
    for _ in 0..MAX_ITERATIONS {
        let x = a + share * (b - a);
        let (_, mode) = followed(family, bracket, x)?;
        let Some(mode) = mode else {
            return Ok(None);
        };
        let f = mode.value.re - level;
        if (f > 0.0) == (fa > 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc, b, fb) = (b, fb, a, fa);
        }
        (a, fa) = (x, f);
        let (best, f_best) = if fa.abs() < fb.abs() {
            (a, fa)
        } else {
            (b, fb)
        };
        let width = (b - a).abs();
        let tolerance = WIDTH * a.abs().max(b.abs());
        if width <= tolerance || f_best == 0.0 {
            return Ok(Some((best, width.min(tolerance))));
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        let interpolates = phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi;
        share = if interpolates {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        let least = 0.5 * tolerance / width;
        share = share.clamp(least, 1.0 - least);
    }
    Ok(Some((a, (b - a).abs())))
}

/// The steady state at a value within a bracket, and its mode most similar to those at the ends.
fn followed(
    family: &SubjectFamily,
    bracket: &Bracket,
    value: f64,
) -> Result<(SteadyState, Option<Eigenmode>), StudyError> {
    let state = family.at(&[value])?;
    let [(low, _), (high, _)] = bracket.ends;
    let nearest = usize::from((value - low).abs() > (high - value).abs());
    // Next to the point where two modes meet, their shapes are equal: the growing one counts.
    let alike = if bracket.level > 0.0 {
        fastest_alike
    } else {
        most_alike
    };
    let mode = alike(state.linearised.modes()?, &bracket.ends[nearest].1);
    Ok((state, mode))
}

/// The first Lyapunov coefficient and what it says.
fn birth(state: &SteadyState, mode: &Eigenmode, speed: f64) -> Result<CycleBirth, StudyError> {
    let found = FirstLyapunov::new(state.system.as_ref(), &state.linearised, mode)?;
    let is_significant = found.growth.abs() > SIGNIFICANT * found.error;
    let has_kinks = found.smooth_amplitude.is_finite();
    let amplitude = found.smooth_amplitude * state.probe_amplitude(mode);
    let range = (found.growth / speed).abs() * found.smooth_amplitude.powi(2);
    Ok(CycleBirth {
        criticality: match (is_significant, found.growth > 0.0) {
            (false, _) => Criticality::Undetermined,
            (true, true) => Criticality::Subcritical,
            (true, false) => Criticality::Supercritical,
        },
        method: CriticalityMethod::NormalForm,
        first_lyapunov: found.coefficient(mode),
        first_lyapunov_error: found.error / mode.value.im,
        smooth_amplitude_m: has_kinks.then_some(amplitude),
        smooth_range: has_kinks.then_some(range),
    })
}
