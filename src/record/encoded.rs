//! A recording as separately encoded messages, for viewers that connect and disconnect during a run. Each
//! message states whether a viewer that connects later needs it.

use std::{fmt, sync::Arc};

use super::{paths::TIMELINE, stream::MessageSink};
use rerun::{
    external::{
        re_build_info::CrateVersion,
        re_log_encoding::{EncodeError, Encoder, EncodingOptions},
    },
    log::{Chunk, LogMsg},
};

/// Receives the messages of a recording in order.
pub trait MessageReceiver: Send + Sync {
    /// Receives a message; must not block.
    fn receive(&self, piece: EncodedMessage);
}

/// An encoded message of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EncodedMessage {
    /// A complete recording stream with only this message. Concatenated messages are a valid stream, too.
    pub bytes: Vec<u8>,
    /// Key: the same for messages with the same components of the same entity. A viewer that connects later
    /// needs the last message of each key, regardless of its age.
    pub name: String,
    /// Whether the message is static: a viewer that connects later needs it before all others.
    pub is_static: bool,
    /// Whether the message starts another recording.
    pub starts_recording: bool,
    /// Latest simulated time in the message, s; `None` for static messages.
    pub end_time: Option<f64>,
}

/// Encodes messages and passes them to a receiver.
#[derive(Clone)]
pub struct EncodingSink(pub Arc<dyn MessageReceiver>);

impl fmt::Debug for EncodingSink {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("EncodingSink")
    }
}

impl MessageSink for EncodingSink {
    fn send(&self, message: LogMsg) {
        // A message that cannot be encoded could not be read either.
        if let Ok(bytes) = encode(&message) {
            self.0.receive(EncodedMessage {
                bytes,
                ..describe(&message)
            });
        }
    }
}

/// A stream with a single message, uncompressed because it is sent to a local viewer.
fn encode(message: &LogMsg) -> Result<Vec<u8>, EncodeError> {
    let options = EncodingOptions::PROTOBUF_UNCOMPRESSED;
    let mut encoder = Encoder::new_eager(CrateVersion::LOCAL, options, Vec::new())?;
    encoder.do_not_emit_footer();
    encoder.append(message)?;
    encoder.into_inner()
}

/// Everything about a message except its bytes.
fn describe(message: &LogMsg) -> EncodedMessage {
    let static_message = EncodedMessage {
        is_static: true,
        ..EncodedMessage::default()
    };
    match message {
        LogMsg::SetStoreInfo(info) => EncodedMessage {
            name: format!("store {:?}", info.info.store_id),
            starts_recording: info.info.store_id.is_recording(),
            ..static_message
        },
        LogMsg::BlueprintActivationCommand(_) => EncodedMessage {
            name: "blueprint".to_owned(),
            ..static_message
        },
        LogMsg::ArrowMsg(store, message) => {
            let Ok(chunk) = Chunk::from_arrow_msg(message) else {
                return EncodedMessage::default();
            };
            if store.is_blueprint() {
                return EncodedMessage {
                    name: format!("blueprint {}", chunk.id()),
                    ..static_message
                };
            }
            let mut components: Vec<_> = chunk.components_identifiers().collect();
            components.sort();
            let timeline = chunk.timelines().get(&TIMELINE.into());
            EncodedMessage {
                name: format!("{} {components:?}", chunk.entity_path()),
                is_static: chunk.is_static(),
                end_time: timeline.map(|times| 1e-9 * times.time_range().max().as_i64() as f64),
                ..EncodedMessage::default()
            }
        }
    }
}
