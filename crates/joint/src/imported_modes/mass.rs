//! Check that mode shapes are orthonormal with respect to the mass matrix.

use super::ImportedModesError::{self, Content};
use super::arrays::{Arrays, Named};

/// Maximum deviation of `Phi^T M Phi` from the unit matrix: above the rounding of single precision, far
/// below the error of another normalisation.
const TOLERANCE: f64 = 1e-4;

const DOF_SHAPES: Named = Named {
    name: "dof_shapes",
    what: "the mode shapes at all degrees of freedom, (dofs, modes), 1/sqrt(kg)",
};
const DENSE: Named = Named {
    name: "mass",
    what: "the mass matrix, (dofs, dofs), kg",
};
const DATA: Named = Named {
    name: "mass_data",
    what: "the entries of the mass matrix row by row, (entries), kg",
};
const INDICES: Named = Named {
    name: "mass_indices",
    what: "the column of each entry of the mass matrix, (entries)",
};
const STARTS: Named = Named {
    name: "mass_indptr",
    what: "the entry at which each row of the mass matrix starts, and their number, (dofs + 1)",
};

/// A mass matrix in compressed sparse rows.
struct Rows {
    data: Vec<f64>,
    columns: Vec<usize>,
    /// Start of each row in `data`, followed by the total number of entries.
    starts: Vec<usize>,
}

/// Checks `Phi^T M Phi = I` if the file contains a mass matrix, dense or in compressed sparse rows.
pub(super) fn check(arrays: &mut Arrays<'_>, modes: usize) -> Result<(), ImportedModesError> {
    let Some((given, mass)) = mass(arrays)? else {
        return Ok(());
    };
    let dofs = mass.starts.len() - 1;
    let shapes = arrays.belonging(&DOF_SHAPES, given, &[dofs, modes])?;
    let mut worst = (0.0, 0, 0, 0.0);
    let mut weighted = vec![0.0; dofs];
    for second in 0..modes {
        mass.times(&shapes[second..], modes, &mut weighted);
        for first in 0..=second {
            let shape = shapes[first..].iter().step_by(modes);
            let product: f64 = shape.zip(&weighted).map(|(a, b)| a * b).sum();
            let due = f64::from(u8::from(first == second));
            let deviation = (product - due).abs();
            if deviation > worst.0 {
                worst = (deviation, first, second, product);
            }
        }
    }
    let (deviation, first, second, product) = worst;
    if deviation <= TOLERANCE {
        return Ok(());
    }
    Err(Content(format!(
        "`dof_shapes` are not mass-normalised: shape {}, `mass`, shape {} (from 1) gives {product:.6} instead of {}, the \
         largest deviation; divide each shape by the root of its modal mass, also in `shapes`, and orthogonalise \
         shapes of equal frequencies",
        first + 1,
        second + 1,
        u8::from(first == second)
    )))
}

/// Reads the mass matrix, if present, with the name of one of its arrays.
fn mass(arrays: &mut Arrays<'_>) -> Result<Option<(&'static str, Rows)>, ImportedModesError> {
    if let Some(shape) = arrays.shape(&DENSE)? {
        for sparse in [&DATA, &INDICES, &STARTS] {
            if arrays.shape(sparse)?.is_some() {
                return Err(Content(format!(
                    "the file contains both `mass` and `{}`; remove the dense or the sparse mass matrix",
                    sparse.name
                )));
            }
        }
        let dofs = shape.first().copied().unwrap_or(0);
        let rows = Rows {
            data: arrays.need(&DENSE, &[dofs, dofs])?,
            columns: (0..dofs * dofs).map(|entry| entry % dofs).collect(),
            starts: (0..=dofs).map(|row| row * dofs).collect(),
        };
        return Ok(Some((DENSE.name, rows)));
    }
    let Some(data) = arrays.find(&DATA)? else {
        return Ok(None);
    };
    let entries = data.len();
    let columns = arrays.belonging(&INDICES, DATA.name, &[entries])?;
    let Some(starts) = arrays.find(&STARTS)? else {
        return Err(STARTS.incomplete(DATA.name));
    };
    let fault = |problem: &str| {
        Content(format!(
            "{problem}; save the mass matrix in the format of scipy.sparse.csr_array"
        ))
    };
    let whole = |values: Vec<f64>, name: &Named| {
        let index = |x: f64| (x >= 0.0 && x.fract() == 0.0).then_some(x as usize);
        let indices: Option<Vec<usize>> = values.into_iter().map(index).collect();
        indices.ok_or_else(|| {
            fault(&format!(
                "`{}` contains numbers that are not indices",
                name.name
            ))
        })
    };
    let columns = whole(columns, &INDICES)?;
    let starts = whole(starts, &STARTS)?;
    let ordered =
        starts.first() == Some(&0) && starts.last() == Some(&entries) && starts.is_sorted();
    if !ordered {
        return Err(fault(
            "`mass_indptr` does not increase from 0 to the number of entries",
        ));
    }
    let dofs = starts.len() - 1;
    if columns.iter().any(|column| *column >= dofs) {
        return Err(fault("`mass_indices` contains a column beyond the rows"));
    }
    let rows = Rows {
        data,
        columns,
        starts,
    };
    Ok(Some((DATA.name, rows)))
}

impl Rows {
    /// Multiplies the matrix by every `stride`-th number of `x`.
    fn times(&self, x: &[f64], stride: usize, out: &mut [f64]) {
        for (out, ends) in out.iter_mut().zip(self.starts.windows(2)) {
            let entries = ends[0]..ends[1];
            let row = self.data[entries.clone()].iter();
            let columns = &self.columns[entries];
            *out = row.zip(columns).map(|(m, k)| m * x[k * stride]).sum();
        }
    }
}
