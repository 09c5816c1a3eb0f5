//! Where the motion starts.

use crate::scene::error::SceneError;
use crate::scene::file::Document;
use crate::scene::keys;
use crate::scene::spec::Start;
use crate::scene::subject::SubjectSpec;

pub(super) fn start(document: &Document<'_>, subject: &SubjectSpec) -> Result<Start, SceneError> {
    if let SubjectSpec::Joint(_) = subject {
        for key in [&keys::START_POSITION, &keys::START_VELOCITY] {
            if document.has(key.path) {
                return Err(document.inconsistent(
                    key.path,
                    &[],
                    "a ball joint starts from steady sliding",
                    "leave it out; start.kick_mm_per_s sets the joint in motion",
                ));
            }
        }
    }
    Ok(Start {
        position: document.get(&keys::START_POSITION)?,
        velocity: document.get(&keys::START_VELOCITY)?,
        kick: document.get(&keys::KICK)?,
        seed: document.get(&keys::SEED)?,
    })
}
