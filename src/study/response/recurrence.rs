//! The recurrence plot of a settled motion.

use super::measure::{DIMENSION, LAG, Portrait};
use crate::analysis::{AnalysisError, DelayVectors, Norm, RecurrencePlot, Threshold};

/// Length of the window, s; shorter if less of the motion was kept.
const WINDOW: f64 = 5e-3;

/// The most points along a side.
const SIZE: usize = 250;

/// Points below which there is nothing to see.
const LEAST: usize = 16;

/// Share of all pairs that counts as recurrent, as in the scenes of the joint: then plots of strong
/// and of faint motions can be compared.
const RATE: f64 = 0.1;

/// A recurrence plot, Eq. (26).
#[derive(Clone, Debug, PartialEq)]
pub struct RecurrenceWindow {
    /// Length of the window, s.
    pub window: f64,
    /// Points along a side.
    pub size: usize,
    /// Distance of each pair, 0 to 255, `size x size`, oldest first.
    pub distance: Vec<u8>,
    /// 255 where recurrent, else 0.
    pub recurrent: Vec<u8>,
    /// Threshold, m; `None` if each state has its own.
    pub threshold: Option<f64>,
    /// Recurrence rate, 0 to 1.
    pub rate: f64,
    /// Delay, s.
    pub lag: f64,
    /// Embedding dimension.
    pub dimension: usize,
}

impl Portrait {
    /// The recurrence plot of the newest 5 ms, of delay vectors of dimension 5 a quarter of a period
    /// of 4.1 kHz apart. `None` where too little of the motion was kept.
    ///
    /// # Errors
    /// When the samples are not finite numbers.
    pub fn recurrence(&self) -> Result<Option<RecurrenceWindow>, AnalysisError> {
        let lag = ((LAG / self.dt).round() as usize).max(1);
        let reach = DelayVectors::samples_for(0, lag, DIMENSION);
        let wanted = (WINDOW / self.dt).round() as usize;
        let vectors = wanted.min(self.displacement.len().saturating_sub(reach));
        if vectors < LEAST {
            return Ok(None);
        }
        let needed = DelayVectors::samples_for(vectors, lag, DIMENSION);
        let newest = &self.displacement[self.displacement.len() - needed..];
        let newest: Vec<f64> = newest.iter().map(|&u| f64::from(u)).collect();
        let size = SIZE.min(vectors);
        let spacing = vectors as f64 / size as f64;
        // The newest is one of them.
        let picks = (1..=size).map(|i| (i as f64 * spacing).round() as usize - 1);
        let mut plot = RecurrencePlot::with(Norm::Euclidean, 1);
        plot.measure(
            &DelayVectors::new(&newest, lag, DIMENSION)?,
            &picks.collect::<Vec<_>>(),
        );
        let found = plot.recurrences(Threshold::Rate(RATE))?;
        Ok(Some(RecurrenceWindow {
            window: vectors as f64 * self.dt,
            size,
            distance: plot.distance_picture(),
            recurrent: found.pixels,
            threshold: found.distance,
            rate: found.rate,
            lag: lag as f64 * self.dt,
            dimension: DIMENSION,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::test_signals::sines;

    fn portrait(samples: usize) -> Portrait {
        let tone = sines(200e3, samples, &[(4000.0, 1e-6, 0.0)]);
        Portrait {
            dt: 5e-6,
            displacement: tone.iter().map(|&u| u as f32).collect(),
            velocity: vec![0.0; samples],
            bin: 5.0,
            spectrum: Vec::new(),
        }
    }

    #[test]
    fn a_tone_comes_back_after_its_period() {
        let plot = portrait(2000).recurrence().unwrap().unwrap();
        assert_eq!((plot.size, plot.dimension), (250, 5));
        assert!((plot.window - 5e-3).abs() < 1e-12 && (plot.lag - 60e-6).abs() < 1e-12);
        assert!((plot.rate - 0.1).abs() < 0.02, "{}", plot.rate);
        // 250 us are 12.5 of the points, 20 us apart.
        assert_eq!((plot.recurrent[25], plot.recurrent[6]), (255, 0));
    }

    #[test]
    fn what_is_short_has_a_small_plot_or_none() {
        let plot = portrait(200).recurrence().unwrap().unwrap();
        assert_eq!(plot.size * plot.size, plot.recurrent.len());
        assert!(plot.size < 200);
        assert_eq!(portrait(50).recurrence().unwrap(), None);
        assert_eq!(portrait(0).recurrence().unwrap(), None);
    }
}
