//! What is recorded, and how often.

use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys;
use crate::scene::spec::RecordSpec;

pub(super) fn record(document: &Document<'_>, sample_rate: f64) -> Result<RecordSpec, SceneError> {
    let rate = |key| {
        let rate = document.get(key)?;
        if rate <= sample_rate {
            return Ok(rate);
        }
        Err(document.inconsistent(
            key.path,
            &[keys::SAMPLE_RATE.path],
            format!(
                "more often than samples are taken ({} kHz)",
                sample_rate / 1e3
            ),
            "make it at most time.sample_rate_khz",
        ))
    };
    Ok(RecordSpec {
        patch_rate: rate(&keys::PATCH_RATE)?,
        body_rate: rate(&keys::BODY_RATE)?,
        energy_rate: rate(&keys::ENERGY_RATE)?,
        exaggeration: document.get(&keys::EXAGGERATION)?,
    })
}
