//! Ridges: paths of one resolution as functions of time.

/// A ridge: time (s), frequency (Hz) and noise power per hertz of the peaks of a partial.
pub(super) struct Ridge {
    pub points: Vec<[f64; 3]>,
}

impl Ridge {
    /// First and last time, s.
    pub fn span(&self) -> [f64; 2] {
        [self.points[0][0], self.points[self.points.len() - 1][0]]
    }

    /// Frequency at a time, Hz.
    pub fn frequency_at(&self, time_s: f64) -> f64 {
        value_at(&self.points, |p| [p[0], p[1]], time_s).expect("a ridge has points")
    }
}

/// The value at a time along points of which `of` gives time and value, interpolated, constant beyond the ends; `None` without
/// points.
pub(super) fn value_at<P>(points: &[P], of: impl Fn(&P) -> [f64; 2], time_s: f64) -> Option<f64> {
    let after = points.partition_point(|point| of(point)[0] <= time_s);
    let [t, value] = of(points.get(after.saturating_sub(1))?);
    Some(match points.get(after).map(of) {
        Some([end, to]) if after > 0 => value + (time_s - t) / (end - t) * (to - value),
        _ => value,
    })
}
