//! The samples of a run as arrays.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use super::file::{failed, nameless_beside};
use super::replace_file;
use crate::numpy::NpzWriter;
use crate::pipeline::message::{Frame, Record};
use crate::pipeline::{Sink, SinkError};

/// A sink that writes the samples at the end. Until then they wait in files without a name beside it,
/// so that a run of any length needs the same memory.
///
/// Arrays, for `s` samples and `m` modes from t = 0: `t` (s), `q` (s, m) and `qdot` (s, m) in the
/// perturbation from the equilibrium (the coordinates of `z0` in a model file), `u` and `v`
/// (Eq. 24 and its rate), `tilt_deg`.
#[derive(Debug)]
pub struct SamplesSink {
    path: PathBuf,
    /// From the first samples on.
    waiting: Option<Waiting>,
}

impl SamplesSink {
    /// A sink that will write to `path`.
    pub fn new(path: PathBuf) -> Self {
        Self {
            path,
            waiting: None,
        }
    }
}

impl Sink for SamplesSink {
    fn accept(&mut self, record: Record) -> Result<(), SinkError> {
        if let Record::Samples(frame) = record {
            let kept = match &mut self.waiting {
                Some(waiting) => waiting.keep(&frame),
                None => Waiting::beside(&self.path)
                    .and_then(|waiting| self.waiting.insert(waiting).keep(&frame)),
            };
            kept.map_err(|fault| failed(&self.path, fault))?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), SinkError> {
        let waiting = match self.waiting.take() {
            Some(waiting) => waiting,
            None => Waiting::beside(&self.path).map_err(|fault| failed(&self.path, fault))?,
        };
        Ok(replace_file(&self.path, |file| waiting.write(file))?)
    }
}

/// Names of the arrays.
const NAMES: [&str; 6] = ["t", "q", "qdot", "u", "v", "tilt_deg"];

/// Samples that wait to be written: an array of a file must be in one piece, but its numbers come
/// frame by frame.
#[derive(Debug)]
struct Waiting {
    samples: usize,
    /// An array each, in the order of [`NAMES`].
    spools: [Spool; 6],
}

impl Waiting {
    /// In the folder of the file that they will be written to.
    fn beside(path: &Path) -> io::Result<Self> {
        let spool = || {
            Ok::<_, io::Error>(Spool {
                file: BufWriter::new(nameless_beside(path)?),
                count: 0,
            })
        };
        Ok(Self {
            samples: 0,
            spools: [spool()?, spool()?, spool()?, spool()?, spool()?, spool()?],
        })
    }

    fn keep(&mut self, frame: &Frame) -> io::Result<()> {
        let [t, q, qdot, u, v, tilt] = &mut self.spools;
        self.samples += frame.len();
        t.extend((0..frame.len()).map(|k| frame.time(k)))?;
        q.extend(frame.q.iter().copied())?;
        qdot.extend(frame.qdot.iter().copied())?;
        u.extend(frame.displacement.iter().copied())?;
        v.extend(frame.velocity.iter().copied())?;
        tilt.extend(std::iter::repeat_n(frame.tilt.to_degrees(), frame.len()))
    }

    fn write(self, out: &mut (impl Write + Seek)) -> io::Result<()> {
        let mut npz = NpzWriter::new(out);
        for (name, spool) in NAMES.into_iter().zip(self.spools) {
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
