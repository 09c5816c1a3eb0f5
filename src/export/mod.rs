//! Plain NumPy arrays on disk: the model of Eq. (8), and the samples of a run.
//!
//! Both are `.npz` files without compression: `numpy.load(path)` reads them. [`crate::numpy`] reads and
//! writes single arrays.

mod file;
mod model;
mod samples;

pub use file::{OutputError, is_protected, replace_file, try_folder_of};
pub use model::encode_model;
pub use samples::SamplesSink;
