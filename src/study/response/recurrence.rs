//! The recurrence plot of a settled motion.

use super::measure::{DIMENSION, LAG};
use super::settled::Portrait;
use crate::analysis::{
    AnalysisError, DelayVectors, Norm, RecurrenceImage, RecurrencePlot, Threshold,
};

/// Length of the window, s; shorter if less of the motion was kept.
const WINDOW: f64 = 5e-3;

/// The most states that are compared, and the most points along a side of the picture.
const STATES: usize = 1000;
const SIZE: usize = 340;

/// Points below which there is nothing to see.
const LEAST: usize = 16;

/// Share of all pairs that counts as recurrent, as in the scenes of the joint: then plots of strong
/// and of faint motions can be compared.
const RATE: f64 = 0.1;

impl Portrait {
    /// The recurrence plot of the newest 5 ms, of delay vectors of dimension 5 a quarter of a period
    /// of 4.1 kHz apart. `None` where too little of the motion was kept.
    ///
    /// A point stands for a few neighbouring states: it is recurrent if any of their pairs is. Plots of
    /// single states that are a good part of a period apart show broad bands where the diagonals of a
    /// high tone fall between the points.
    ///
    /// # Errors
    /// When the samples are not finite numbers.
    pub fn recurrence(&self) -> Result<Option<RecurrenceImage>, AnalysisError> {
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
        let step = vectors.div_ceil(STATES);
        let side = (vectors / step).div_ceil(SIZE);
        let size = vectors / step / side;
        // The newest is one of them.
        let picks = (0..size * side).rev().map(|k| vectors - 1 - k * step);
        let mut plot = RecurrencePlot::with(Norm::Euclidean, 1);
        plot.measure(
            &DelayVectors::new(&newest, lag, DIMENSION)?,
            &picks.collect::<Vec<_>>(),
        );
        let found = plot.recurrences(Threshold::Rate(RATE))?;
        Ok(Some(RecurrenceImage {
            window: (size * side * step) as f64 * self.dt,
            size,
            distance: pooled(&plot.distance_picture(), side, u8::min),
            recurrent: pooled(&found.pixels, side, u8::max),
            threshold: found.distance,
            rate: found.rate,
            lag: lag as f64 * self.dt,
            dimension: DIMENSION,
        }))
    }
}

/// A square picture with `side x side` points joined to one.
fn pooled(picture: &[u8], side: usize, join: fn(u8, u8) -> u8) -> Vec<u8> {
    let size = picture.len().isqrt();
    let rows = picture.chunks_exact((size * side).max(1));
    let join = |a: Option<u8>, &b: &u8| Some(a.map_or(b, |a| join(a, b)));
    rows.flat_map(|rows| {
        (0..size / side).map(move |column| {
            let pieces = rows.chunks_exact(size);
            let pieces = pieces.flat_map(|row| &row[column * side..][..side]);
            pieces.fold(None, join).unwrap_or_default()
        })
    })
    .collect()
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
        assert_eq!((plot.size, plot.dimension), (333, 5));
        assert!((plot.window - 4.995e-3).abs() < 1e-12 && (plot.lag - 60e-6).abs() < 1e-12);
        assert!((plot.rate - 0.1).abs() < 0.02, "{}", plot.rate);
        // 250 us are 50 samples, in points of three.
        assert_eq!((plot.recurrent[50 / 3], plot.recurrent[25 / 3]), (255, 0));
        assert_eq!(plot.distance[0], 0);
    }

    #[test]
    fn what_is_short_has_a_small_plot_or_none() {
        let plot = portrait(200).recurrence().unwrap().unwrap();
        assert_eq!(plot.size * plot.size, plot.recurrent.len());
        assert!(plot.size < 200);
        assert_eq!(portrait(50).recurrence().unwrap(), None);
        assert_eq!(portrait(0).recurrence().unwrap(), None);
    }

    #[test]
    fn points_are_joined_in_squares() {
        let picture: Vec<u8> = (0..16).collect();
        assert_eq!(pooled(&picture, 2, u8::max), [5, 7, 13, 15]);
        assert_eq!(pooled(&picture, 2, u8::min), [0, 2, 8, 10]);
        assert_eq!(pooled(&picture, 1, u8::min), picture);
    }
}
