//! What is made of the flow itself: exponents, and a second copy of the joint.

use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys;
use crate::scene::spec::{Amount, ButterflySpec, ExponentsSpec};

/// The exponents of a system of so many dimensions.
pub(super) fn exponents(
    document: &Document<'_>,
    dimension: usize,
) -> Result<Option<ExponentsSpec>, SceneError> {
    if !document.has("analysis.exponents") {
        return Ok(None);
    }
    let count = match document.get(&keys::EXPONENT_COUNT)? {
        Amount::All => dimension,
        Amount::First(count) if count <= dimension => count,
        // The default is for joints of many modes.
        Amount::First(_) if !document.has(keys::EXPONENT_COUNT.path) => dimension,
        Amount::First(count) => {
            let families = [
                keys::BENDING_PAIRS.path,
                keys::TORSION.path,
                keys::AXIAL.path,
            ];
            return Err(document.inconsistent(
                keys::EXPONENT_COUNT.path,
                &families,
                format!("{count} exponents of a motion that has {dimension}"),
                "ask for fewer, or for \"all\"",
            ));
        }
    };
    Ok(Some(ExponentsSpec {
        count,
        settle: document.get(&keys::SETTLE)?,
        every: document.get(&keys::EXPONENTS_EVERY)?,
    }))
}

/// The second copy.
pub(super) fn butterfly(document: &Document<'_>) -> Result<Option<ButterflySpec>, SceneError> {
    if !document.has("analysis.butterfly") {
        return Ok(None);
    }
    Ok(Some(ButterflySpec {
        start: document.get(&keys::BUTTERFLY_START)?,
        distance: document.get(&keys::DISTANCE)?,
        every: document.get(&keys::BUTTERFLY_EVERY)?,
    }))
}
