//! The course of a run that shows a mechanism, for the picture beside the lesson.

/// Loudness and pitch at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Simulated time, s.
    pub time: f64,
    /// Measured: root mean square of the probe's velocity over the half natural period that ends then, m/s.
    pub level: f64,
    /// Computed: where that would be if it had grown, from its first value on, at the largest computed
    /// growth rate; `None` once the vibration is too large for the linear theory.
    pub foretold: Option<f64>,
    /// Of a tilt that changes: what is heard at which tilt.
    pub tone: Option<TiltedTone>,
}

/// What is heard at a tilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltedTone {
    /// Tilt in the middle of the window that was listened to, rad.
    pub tilt: f64,
    /// Which way it went.
    pub way: Way,
    /// The strongest line, Hz.
    pub frequency: f64,
}

/// Which way a tilt goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Way {
    /// Up, and at the top.
    Up,
    /// Down, and at the bottom afterwards.
    Down,
}
