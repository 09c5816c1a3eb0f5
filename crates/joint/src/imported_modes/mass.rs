//! Check that mode shapes are orthonormal with respect to the mass matrix.

use faer::{Mat, MatRef, Scale};

use super::ImportedModesError::{self, Content};
use super::arrays::{Arrays, Named};

/// Maximum deviation of `Phi^T M Phi` from the unit matrix: above the rounding of single precision, far
/// below the error of another normalisation.
const TOLERANCE: f64 = 1e-4;

const DOF_SHAPES: Named = Named(
    "dof_shapes",
    "the full mode shapes, (dofs, modes), 1/sqrt(kg)",
);
const DENSE: Named = Named("mass", "the mass matrix, (dofs, dofs), kg");
const DATA: Named = Named("mass_data", "its entries row by row, (entries), kg");
const COLUMNS: Named = Named("mass_indices", "the column of each entry, (entries)");
const STARTS: Named = Named("mass_indptr", "the first entry of each row, (dofs + 1)");

/// Checks `Phi^T M Phi = I` if the file contains a mass matrix, dense or in compressed sparse rows.
pub(super) fn check(arrays: &mut Arrays<'_>, modes: usize) -> Result<(), ImportedModesError> {
    let Some((dofs, entries)) = mass(arrays)? else {
        return Ok(());
    };
    let shapes = arrays.need(&DOF_SHAPES, &[dofs, modes])?;
    let shapes = MatRef::from_row_major_slice(&shapes, dofs, modes);
    let mut weighted = Mat::<f64>::zeros(dofs, modes);
    for (row, column, mass) in entries {
        let mut weighted = weighted.row_mut(row);
        weighted += Scale(mass) * shapes.row(column);
    }
    let product = shapes.transpose() * weighted;
    let due = |first, second| f64::from(u8::from(first == second));
    let deviation = |(i, j): &(usize, usize)| (product[(*i, *j)] - due(*i, *j)).abs();
    let pairs = (0..modes).flat_map(|second| (0..=second).map(move |first| (first, second)));
    let worst = pairs.max_by(|a, b| deviation(a).total_cmp(&deviation(b)));
    let (first, second) = worst.unwrap_or_default();
    if deviation(&(first, second)) <= TOLERANCE {
        return Ok(());
    }
    Err(Content(format!(
        "`dof_shapes` are not mass-normalised: shape {}, `mass`, shape {} (from 1) gives {:.6} instead of {}, the \
         largest deviation; divide each shape by the root of its modal mass, also in `shapes`, and orthogonalise \
         shapes of equal frequencies",
        first + 1,
        second + 1,
        product[(first, second)],
        due(first, second)
    )))
}

/// Entries of a matrix: row, column, value.
type Entries = Vec<(usize, usize, f64)>;

/// Reads the number of rows and the entries of the mass matrix, if present.
fn mass(arrays: &mut Arrays<'_>) -> Result<Option<(usize, Entries)>, ImportedModesError> {
    let count = arrays.len(&DATA)?;
    if let Some(dofs) = arrays.len(&DENSE)? {
        if count.is_some() {
            let text = "the file contains both `mass` and `mass_data`; remove one of the matrices";
            return Err(Content(text.to_owned()));
        }
        let dense = arrays.need(&DENSE, &[dofs, dofs])?;
        let entries = dense.into_iter().enumerate();
        let entries = entries.map(|(k, mass)| (k / dofs, k % dofs, mass));
        return Ok(Some((dofs, entries.collect())));
    }
    let Some(count) = count else {
        return Ok(None);
    };
    let data = arrays.need(&DATA, &[count])?;
    let starts = arrays.len(&STARTS)?.unwrap_or(0);
    let starts = arrays.indices(&STARTS, &[starts], count + 1)?;
    if starts.first() != Some(&0) || starts.last() != Some(&count) || !starts.is_sorted() {
        return Err(Content(
            "`mass_indptr` does not increase from 0 to the number of entries; save the mass matrix in the format of \
             scipy.sparse.csr_array"
                .to_owned(),
        ));
    }
    let dofs = starts.len() - 1;
    let columns = arrays.indices(&COLUMNS, &[count], dofs)?;
    let rows = starts.windows(2).enumerate();
    let rows = rows.flat_map(|(row, ends)| std::iter::repeat_n(row, ends[1] - ends[0]));
    let entries = rows.zip(columns).zip(data);
    let entries = entries.map(|((row, column), mass)| (row, column, mass));
    Ok(Some((dofs, entries.collect())))
}
