//! A recording for people who come and go: every message by itself, as bytes that a viewer takes in, and
//! whether whoever comes later needs it, too.

use std::{fmt, sync::Arc};

use super::{paths::TIMELINE, stream::MessageSink};
use rerun::{
    external::{
        re_build_info::CrateVersion,
        re_log_encoding::{EncodeError, Encoder, EncodingOptions},
    },
    log::{Chunk, LogMsg},
};

/// Takes the pieces of a recording as they come, in order.
pub trait Audience: Send + Sync {
    /// Takes a piece; must not wait.
    fn hear(&self, piece: Piece);
}

/// A message of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// A whole recording stream with nothing but this message. Pieces joined in their order are one, too.
    pub bytes: Vec<u8>,
    /// What it is of: the same for pieces that tell the same things of the same entity. Whoever comes later needs
    /// the last one of each name, however long ago that was.
    pub name: String,
    /// Whether it holds at all times: whoever comes later needs it before all others.
    pub lasting: bool,
    /// Whether another recording begins with it.
    pub begins: bool,
    /// Simulated time of the newest that it tells, s; `None` of what holds at all times.
    pub until: Option<f64>,
}

/// Hands messages to an audience.
#[derive(Clone)]
pub struct ToAudience(pub Arc<dyn Audience>);

impl fmt::Debug for ToAudience {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("ToAudience")
    }
}

impl MessageSink for ToAudience {
    fn send(&self, message: LogMsg) {
        // A message that cannot be encoded is one that nobody could read.
        if let Ok(bytes) = encoded(&message) {
            self.0.hear(Piece {
                bytes,
                ..told(&message)
            });
        }
    }
}

/// A stream of one message. Uncompressed: it goes no farther than to a viewer near by.
fn encoded(message: &LogMsg) -> Result<Vec<u8>, EncodeError> {
    let options = EncodingOptions::PROTOBUF_UNCOMPRESSED;
    let mut encoder = Encoder::new_eager(CrateVersion::LOCAL, options, Vec::new())?;
    encoder.do_not_emit_footer();
    encoder.append(message)?;
    encoder.into_inner()
}

/// What a message tells, without its bytes.
fn told(message: &LogMsg) -> Piece {
    let lasting = Piece {
        lasting: true,
        ..Piece::default()
    };
    match message {
        LogMsg::SetStoreInfo(info) => Piece {
            name: format!("store {:?}", info.info.store_id),
            begins: info.info.store_id.is_recording(),
            ..lasting
        },
        LogMsg::BlueprintActivationCommand(_) => Piece {
            name: "blueprint".to_owned(),
            ..lasting
        },
        LogMsg::ArrowMsg(store, message) => {
            let Ok(chunk) = Chunk::from_arrow_msg(message) else {
                return Piece::default();
            };
            if store.is_blueprint() {
                return Piece {
                    name: format!("blueprint {}", chunk.id()),
                    ..lasting
                };
            }
            let mut components: Vec<_> = chunk.components_identifiers().collect();
            components.sort();
            let timeline = chunk.timelines().get(&TIMELINE.into());
            Piece {
                name: format!("{} {components:?}", chunk.entity_path()),
                lasting: chunk.is_static(),
                until: timeline.map(|times| 1e-9 * times.time_range().max().as_i64() as f64),
                ..Piece::default()
            }
        }
    }
}
