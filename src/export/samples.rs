//! The samples of a run as arrays.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::iter::repeat_n;
use std::path::PathBuf;

use zip::ZipWriter;

use super::file::{output_error, unnamed_file_near};
use super::replace_file;
use crate::numpy::write_array;
use crate::pipeline::message::{Frame, JointInfo, Record};
use crate::pipeline::{Sink, SinkError};

/// A sink that writes the samples of a run at its end. Until then they are stored in unnamed temporary files
/// in the same folder: memory does not grow with the duration.
///
/// Arrays for `s` samples and `m` modes from t = 0: `t` (s), `q` (s, m) and `qdot` (s, m) relative to the
/// equilibrium (the coordinates of `z0` in a model file), `u` and `v` (Eq. 24 and its derivative),
/// `tilt_deg`; for a joint also `load_n` and `rotation_factor` if they vary.
#[derive(Debug)]
pub struct SamplesSink {
    path: PathBuf,
    samples: usize,
    /// Arrays by name: contiguous in a file, but their values arrive frame by frame.
    spools: Vec<(&'static str, BufWriter<File>)>,
}

impl SamplesSink {
    /// Creates a sink for the file `path`.
    pub fn new(path: PathBuf) -> Self {
        Self {
            path,
            samples: 0,
            spools: Vec::new(),
        }
    }

    /// Creates the temporary files of a run with this joint, or of a small system.
    fn begin(&mut self, joint: Option<&JointInfo>) -> io::Result<()> {
        let load = joint.is_some_and(JointInfo::load_varies);
        let rotation = joint.is_some_and(JointInfo::rotation_varies);
        let varying = [load.then_some(LOAD), rotation.then_some(ROTATION)];
        let names = NAMES.into_iter().chain(varying.into_iter().flatten());
        let spools = names.map(|name| {
            let file = unnamed_file_near(&self.path)?;
            Ok((name, BufWriter::new(file)))
        });
        self.spools = spools.collect::<io::Result<_>>()?;
        Ok(())
    }

    fn keep(&mut self, frame: &Frame) -> io::Result<()> {
        let samples = frame.len();
        self.samples += samples;
        for (name, file) in &mut self.spools {
            let values: Box<dyn Iterator<Item = f64>> = match *name {
                "t" => Box::new((0..samples).map(|k| frame.time(k))),
                "q" => Box::new(frame.q.iter().copied()),
                "qdot" => Box::new(frame.qdot.iter().copied()),
                "u" => Box::new(frame.displacement.iter().copied()),
                "v" => Box::new(frame.velocity.iter().copied()),
                LOAD => Box::new(repeat_n(frame.load, samples)),
                ROTATION => Box::new(repeat_n(frame.rotation_factor, samples)),
                _ => Box::new(repeat_n(frame.tilt.to_degrees(), samples)),
            };
            for value in values {
                file.write_all(&value.to_le_bytes())?;
            }
        }
        Ok(())
    }
}

impl Sink for SamplesSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        let kept = match record {
            Record::Header(header) if self.spools.is_empty() => self.begin(header.joint()),
            Record::Samples(frame) => self.keep(&frame),
            _ => Ok(()),
        };
        Ok(kept.map_err(|fault| output_error(&self.path, fault))?)
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        let (samples, spools) = (self.samples, std::mem::take(&mut self.spools));
        Ok(replace_file(&self.path, |file| {
            let mut npz = ZipWriter::new(file);
            for (name, spool) in spools {
                let mut file = spool.into_inner()?;
                let count = file.stream_position()? as usize / size_of::<f64>();
                file.rewind()?;
                let mut file = BufReader::new(file);
                let values = (0..count).map(|_| {
                    let mut bytes = [0; 8];
                    file.read_exact(&mut bytes)?;
                    Ok(f64::from_le_bytes(bytes))
                });
                let shape = [samples, count.checked_div(samples).unwrap_or(0)];
                let axes = if ["q", "qdot"].contains(&name) { 2 } else { 1 };
                write_array(&mut npz, name, &shape[..axes], values)?;
            }
            npz.finish()?;
            Ok(())
        })?)
    }
}

/// Arrays of every run.
const NAMES: [&str; 6] = ["t", "q", "qdot", "u", "v", "tilt_deg"];
/// Arrays of varying quantities.
const LOAD: &str = "load_n";
const ROTATION: &str = "rotation_factor";
