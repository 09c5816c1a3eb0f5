//! The samples of a run as arrays.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::file::{output_error, unnamed_file_near};
use super::replace_file;
use crate::numpy::NpzWriter;
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
    /// Names of arrays in addition to [`NAMES`].
    more: Vec<&'static str>,
    /// Present after the first samples.
    spooled: Option<SpooledSamples>,
}

impl SamplesSink {
    /// Creates a sink for the file `path`.
    pub fn new(path: PathBuf) -> Self {
        Self {
            path,
            more: Vec::new(),
            spooled: None,
        }
    }
}

impl Sink for SamplesSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        match record {
            Record::Header(header) => {
                let joint = header.joint();
                let varies = [
                    (LOAD, joint.is_some_and(JointInfo::load_varies)),
                    (ROTATION, joint.is_some_and(JointInfo::rotation_varies)),
                ];
                let varying = varies.into_iter().filter(|(_, varies)| *varies);
                self.more = varying.map(|(name, _)| name).collect();
            }
            Record::Samples(frame) => {
                let kept = match &mut self.spooled {
                    Some(spooled) => spooled.keep(&frame),
                    None => SpooledSamples::in_folder_of(&self.path, &self.more)
                        .and_then(|spooled| self.spooled.insert(spooled).keep(&frame)),
                };
                kept.map_err(|fault| output_error(&self.path, fault))?;
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        let spooled = match self.spooled.take() {
            Some(spooled) => spooled,
            None => SpooledSamples::in_folder_of(&self.path, &self.more)
                .map_err(|fault| output_error(&self.path, fault))?,
        };
        Ok(replace_file(&self.path, |file| spooled.write(file))?)
    }
}

/// Arrays of every run.
const NAMES: [&str; 6] = ["t", "q", "qdot", "u", "v", "tilt_deg"];
/// Arrays of varying quantities.
const LOAD: &str = "load_n";
const ROTATION: &str = "rotation_factor";

/// Samples to be written: an array in a file is contiguous, but its values arrive frame by frame.
#[derive(Debug)]
struct SpooledSamples {
    samples: usize,
    /// Arrays by name.
    spools: Vec<(&'static str, Spool)>,
}

impl SpooledSamples {
    /// Creates the temporary files in the folder of the output, including the arrays `more`.
    fn in_folder_of(path: &Path, more: &[&'static str]) -> io::Result<Self> {
        let names = NAMES.iter().chain(more);
        let spools = names.map(|&name| {
            let file = BufWriter::new(unnamed_file_near(path)?);
            Ok((name, Spool { file, count: 0 }))
        });
        Ok(Self {
            samples: 0,
            spools: spools.collect::<io::Result<_>>()?,
        })
    }

    fn keep(&mut self, frame: &Frame) -> io::Result<()> {
        let samples = frame.len();
        self.samples += samples;
        for (name, spool) in &mut self.spools {
            match *name {
                "t" => spool.extend((0..samples).map(|k| frame.time(k))),
                "q" => spool.extend(frame.q.iter().copied()),
                "qdot" => spool.extend(frame.qdot.iter().copied()),
                "u" => spool.extend(frame.displacement.iter().copied()),
                "v" => spool.extend(frame.velocity.iter().copied()),
                LOAD => spool.extend(std::iter::repeat_n(frame.load, samples)),
                ROTATION => spool.extend(std::iter::repeat_n(frame.rotation_factor, samples)),
                _ => spool.extend(std::iter::repeat_n(frame.tilt.to_degrees(), samples)),
            }?;
        }
        Ok(())
    }

    fn write(self, out: &mut (impl Write + Seek)) -> io::Result<()> {
        let mut npz = NpzWriter::new(out);
        for (name, spool) in self.spools {
            let columns = spool.count.checked_div(self.samples).unwrap_or(0);
            let shape = [self.samples, columns];
            let shape = match name {
                "q" | "qdot" => &shape[..],
                _ => &shape[..1],
            };
            npz.array(name, shape, spool.values()?)?;
        }
        npz.finish()
    }
}

/// Numbers in an unnamed temporary file.
#[derive(Debug)]
struct Spool {
    file: BufWriter<File>,
    count: usize,
}

impl Spool {
    fn extend(&mut self, values: impl Iterator<Item = f64>) -> io::Result<()> {
        for value in values {
            self.file.write_all(&value.to_le_bytes())?;
            self.count += 1;
        }
        Ok(())
    }

    fn values(self) -> io::Result<impl Iterator<Item = io::Result<f64>>> {
        let mut file = self.file.into_inner()?;
        file.rewind()?;
        let mut file = BufReader::new(file);
        Ok((0..self.count).map(move |_| {
            let mut bytes = [0; 8];
            file.read_exact(&mut bytes)?;
            Ok(f64::from_le_bytes(bytes))
        }))
    }
}
