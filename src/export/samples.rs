//! The samples of a run as arrays.

use std::path::PathBuf;

use super::{Array, write_npz};
use crate::pipeline::message::Record;
use crate::pipeline::{Sink, SinkError};

/// A sink that keeps the samples and writes them at the end.
///
/// Arrays, for `s` samples and `m` modes from t = 0: `t` (s), `q` (s, m) and `qdot` (s, m) in the
/// perturbation from the equilibrium (the coordinates of `z0` in a model file), `u` and `v`
/// (Eq. 24 and its rate), `tilt_deg`.
#[derive(Clone, Debug)]
pub struct SamplesSink {
    path: PathBuf,
    t: Vec<f64>,
    q: Vec<f64>,
    qdot: Vec<f64>,
    u: Vec<f64>,
    v: Vec<f64>,
    tilt_deg: Vec<f64>,
}

impl SamplesSink {
    /// A sink that will write to `path`.
    pub fn new(path: PathBuf) -> Self {
        let empty = Vec::new;
        Self {
            path,
            t: empty(),
            q: empty(),
            qdot: empty(),
            u: empty(),
            v: empty(),
            tilt_deg: empty(),
        }
    }
}

impl Sink for SamplesSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if let Record::Samples(frame) = record {
            self.t.extend((0..frame.len()).map(|k| frame.time(k)));
            self.q.extend(&frame.q);
            self.qdot.extend(&frame.qdot);
            self.u.extend(&frame.displacement);
            self.v.extend(&frame.velocity);
            self.tilt_deg
                .extend(std::iter::repeat_n(frame.tilt.to_degrees(), frame.len()));
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        let samples = self.t.len();
        let take = std::mem::take;
        Ok(write_npz(
            &self.path,
            &[
                ("t", Array::vector(take(&mut self.t))),
                ("q", Array::matrix(samples, take(&mut self.q))),
                ("qdot", Array::matrix(samples, take(&mut self.qdot))),
                ("u", Array::vector(take(&mut self.u))),
                ("v", Array::vector(take(&mut self.v))),
                ("tilt_deg", Array::vector(take(&mut self.tilt_deg))),
            ],
        )?)
    }
}
