//! The samples of a run as arrays.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::file::{failed, nameless_beside};
use super::replace_file;
use crate::numpy::NpzWriter;
use crate::pipeline::message::{Frame, JointInfo, Record};
use crate::pipeline::{Sink, SinkError};

/// A sink that writes the samples at the end. Until then they wait in files without a name beside it,
/// so that a run of any length needs the same memory.
///
/// Arrays, for `s` samples and `m` modes from t = 0: `t` (s), `q` (s, m) and `qdot` (s, m) in the
/// perturbation from the equilibrium (the coordinates of `z0` in a model file), `u` and `v`
/// (Eq. 24 and its rate), `tilt_deg`; `load_n` and `rotation_factor` of a joint where they vary.
#[derive(Debug)]
pub struct SamplesSink {
    path: PathBuf,
    /// Names of the arrays besides [`NAMES`].
    more: Vec<&'static str>,
    /// From the first samples on.
    waiting: Option<Waiting>,
}

impl SamplesSink {
    /// A sink that will write to `path`.
    pub fn new(path: PathBuf) -> Self {
        Self {
            path,
            more: Vec::new(),
            waiting: None,
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
                let kept = match &mut self.waiting {
                    Some(waiting) => waiting.keep(&frame),
                    None => Waiting::beside(&self.path, &self.more)
                        .and_then(|waiting| self.waiting.insert(waiting).keep(&frame)),
                };
                kept.map_err(|fault| failed(&self.path, fault))?;
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        let waiting = match self.waiting.take() {
            Some(waiting) => waiting,
            None => Waiting::beside(&self.path, &self.more)
                .map_err(|fault| failed(&self.path, fault))?,
        };
        Ok(replace_file(&self.path, |file| waiting.write(file))?)
    }
}

/// Names of the arrays that every run has.
const NAMES: [&str; 6] = ["t", "q", "qdot", "u", "v", "tilt_deg"];
/// Names of those of what varies.
const LOAD: &str = "load_n";
const ROTATION: &str = "rotation_factor";

/// Samples that wait to be written: an array of a file must be in one piece, but its numbers come
/// frame by frame.
#[derive(Debug)]
struct Waiting {
    samples: usize,
    /// The arrays by name.
    spools: Vec<(&'static str, Spool)>,
}

impl Waiting {
    /// In the folder of the file that they will be written to; with `more` arrays than every run has.
    fn beside(path: &Path, more: &[&'static str]) -> io::Result<Self> {
        let names = NAMES.iter().chain(more);
        let spools = names.map(|&name| {
            let file = BufWriter::new(nameless_beside(path)?);
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

/// Numbers that wait in a file without a name.
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
