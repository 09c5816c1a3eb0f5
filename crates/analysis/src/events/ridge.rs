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

    /// Frequency at a time, interpolated, constant beyond the ends, Hz.
    pub fn frequency_at(&self, time_s: f64) -> f64 {
        let after = self.points.partition_point(|p| p[0] <= time_s);
        let [t, f, _] = self.points[after.saturating_sub(1)];
        match self.points.get(after) {
            Some([end, to, _]) if after > 0 => f + (time_s - t) / (end - t) * (to - f),
            _ => f,
        }
    }
}
