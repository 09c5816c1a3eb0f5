//! What theory predicts of a scene's mechanism before the run. Nothing here is measured.

use serde::Serialize;

use crate::joint::NamedMode;
use crate::scene::{Mechanism, Start};

/// What is computed of a scene that shows a mechanism.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Computed {
    /// The mechanism.
    #[serde(skip)]
    pub mechanism: Mechanism,
    /// The vibration modes linearised at steady sliding under the first load, tilt and rotation, by
    /// ascending frequency.
    pub modes: Vec<NamedMode>,
    /// The lowest natural frequency, without contact and friction, Hz.
    pub natural_hz: f64,
    /// The tilt that it holds for, rad; `None` of what has no tilt.
    pub tilt: Option<f64>,
    /// Sliding speed of steady sliding, m/s.
    pub sliding_speed: f64,
    /// How the run is kicked.
    #[serde(skip)]
    pub start: Start,
    /// The friction curve as the scene has it, and with its two slope factors exchanged.
    pub readings: Option<[FrictionReading; 2]>,
    /// Two modes that friction couples.
    pub coupling: Option<Coupling>,
    /// A picture of the computed.
    #[serde(skip)]
    pub picture: Option<ComputedPicture>,
}

/// One reading of the friction curve, Eq. (5).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrictionReading {
    /// Slope factor of the creep region, s/m.
    pub creep: f64,
    /// Slope factor of the sliding region, s/m.
    pub stribeck: f64,
    /// Coefficient of friction at the sliding speed.
    pub mu: f64,
    /// Its slope there, s/m.
    pub slope: f64,
    /// The modes under this curve.
    pub modes: Vec<NamedMode>,
}

/// The coefficient of friction of two coupled modes, and the one at which they begin to flutter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Coupling {
    /// That of the run.
    pub mu: f64,
    /// The critical one, from the run's own stiffness matrix; `None` if there is none.
    pub critical: Option<f64>,
}

/// Computed curves, and where the run is on them.
#[derive(Clone, Debug, PartialEq)]
pub struct ComputedPicture {
    /// What the curves are of.
    pub subject: CurveSubject,
    /// The points of each curve.
    pub curves: Vec<Vec<[f64; 2]>>,
    /// Where the run is.
    pub marks: Vec<[f64; 2]>,
}

/// What computed curves are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveSubject {
    /// Coefficient of friction over the sliding speed, mm/s: of the scene, then with the slope factors
    /// exchanged, if that is the mechanism.
    Friction,
    /// Over the coefficient of friction: the lower and the higher frequency of two coupled modes, Hz, and
    /// the growth rate, 1/s.
    Flutter,
}

impl Computed {
    /// The modes that grow, the fastest first.
    pub fn unstable(&self) -> Vec<&NamedMode> {
        unstable(&self.modes)
    }

    /// The largest growth rate of a mode, 1/s; `None` where there is no mode.
    pub fn fastest(&self) -> Option<f64> {
        fastest(&self.modes)
    }

    /// The mode, of those that grow, that has a frequency (Hz) to 5 %: a large vibration shifts the
    /// frequency a little.
    pub fn unstable_near(&self, frequency: f64) -> Option<&NamedMode> {
        let off = |mode: &NamedMode| (mode.frequency_hz / frequency - 1.0).abs();
        let unstable = self.modes.iter().filter(|mode| mode.unstable);
        let nearest = unstable.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(nearest) < 0.05).then_some(nearest)
    }
}

impl FrictionReading {
    /// See [`Computed::unstable`].
    pub fn unstable(&self) -> Vec<&NamedMode> {
        unstable(&self.modes)
    }

    /// See [`Computed::fastest`].
    pub fn fastest(&self) -> Option<f64> {
        fastest(&self.modes)
    }
}

fn unstable(modes: &[NamedMode]) -> Vec<&NamedMode> {
    let mut unstable: Vec<_> = modes.iter().filter(|mode| mode.unstable).collect();
    unstable.sort_by(|a, b| b.growth.total_cmp(&a.growth));
    unstable
}

fn fastest(modes: &[NamedMode]) -> Option<f64> {
    modes.iter().map(|mode| mode.growth).max_by(f64::total_cmp)
}
