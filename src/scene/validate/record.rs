//! What is recorded, and how often.

use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys;
use crate::scene::spec::RecordSpec;
use crate::scene::subject::SubjectSpec;

pub(super) fn record(
    document: &Document<'_>,
    sample_rate: f64,
    subject: &SubjectSpec,
) -> Result<RecordSpec, SceneError> {
    if let SubjectSpec::Small(_) = subject {
        if document.has("record") {
            return Err(document.inconsistent(
                "record",
                &[],
                "a small system has neither a contact patch nor a body to take snapshots of",
                "leave the table out; all samples are recorded",
            ));
        }
        return Ok(RecordSpec::SAMPLES_ONLY);
    }
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
