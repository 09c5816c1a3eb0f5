//! The messages of a recording file, with bounds checks on every length.
//!
//! A stream has a header of 12 bytes, then messages, each with a header of 16 bytes (kind and length) and a
//! protobuf payload. An end mark closes the stream; newer streams have a footer of 32 bytes after it. Streams
//! can be concatenated. The library's own decoder is not used, because it allocates the lengths that the
//! headers claim.

use std::io::{self, BufReader, Read};

use crate::record::sdk::log::Chunk;
use arrow_buffer::Buffer;
use re_log_encoding::external::lz4_flex::block::decompress;
use re_log_encoding::{
    CodecError, Decodable, MessageHeader, MessageKind, RRD_FOURCC, StreamFooter, StreamHeader,
};
use re_protos::common::v1alpha1::{Compression, StoreKind};
use re_protos::log_msg::v1alpha1::{ArrowMsg, Encoding};

use crate::foreign::arrow::stream_batches;
use crate::foreign::{one_line, read_exactly, without_panic};

/// Maximum size of a message, bytes.
const MAX_MESSAGE: u64 = 256 << 20;

/// Maximum compression ratio of LZ4: each further byte of a length adds at most 255.
const MAX_RATIO: u64 = 255;

/// Position and reason of damage in a recording. The data behind it are not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("byte {at}: {reason}")]
pub struct Damage {
    /// Offset of the first damaged message, bytes.
    pub at: u64,
    /// Description of the damage.
    pub reason: String,
}

/// The part of a stream expected next.
#[derive(Clone, Copy)]
enum Expected {
    Message,
    /// The footer after an end mark; streams of old versions have none.
    Footer,
    Stream,
}

/// The chunks of the first recording in a file, up to its end or the first damage.
pub(super) struct Chunks<R> {
    file: R,
    /// Bytes read so far.
    at: u64,
    /// Offset of the last message read.
    start: u64,
    expected: Expected,
    /// Id of the recording that is read.
    recording: Option<String>,
    /// Damage that ended the reading.
    damage: Option<Damage>,
}

impl<R: Read> Chunks<BufReader<R>> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`CodecError`] if the file is not a recording or its version is not supported.
    pub fn new(file: R) -> Result<Self, CodecError> {
        let mut file = BufReader::new(file);
        let header = read_exactly(&mut file, StreamHeader::ENCODED_SIZE_BYTES as u64);
        check_header(&header.unwrap_or_default())?;
        Ok(Self {
            file,
            at: StreamHeader::ENCODED_SIZE_BYTES as u64,
            start: 0,
            expected: Expected::Message,
            recording: None,
            damage: None,
        })
    }

    /// Damage that ended the reading before the end of the file.
    pub fn damage(self) -> Option<Damage> {
        self.damage
    }

    /// Reads bytes of the file; an error if it is truncated.
    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, String> {
        let bytes = read_exactly(&mut self.file, count).map_err(one_line)?;
        self.at += count;
        Ok(bytes)
    }

    /// Reads the remaining bytes of a header of `size` bytes.
    fn complete(&mut self, mut start: Vec<u8>, size: usize) -> Result<Vec<u8>, String> {
        start.extend(self.bytes((size - start.len()) as u64)?);
        Ok(start)
    }

    /// Skips bytes of the file.
    fn skip(&mut self, count: u64) -> Result<(), String> {
        let skipped = io::copy(&mut (&mut self.file).take(count), &mut io::sink());
        self.at = self.at.saturating_add(count);
        if skipped.map_err(one_line)? == count {
            Ok(())
        } else {
            Err("the file is truncated within a message".to_owned())
        }
    }

    /// The next message with a chunk; `None` at the end of the file.
    fn next_message(&mut self) -> Result<Option<ArrowMsg>, String> {
        loop {
            self.start = self.at;
            let mut start = Vec::new();
            let mut file = (&mut self.file).take(StreamHeader::ENCODED_SIZE_BYTES as u64);
            self.at += file.read_to_end(&mut start).map_err(one_line)? as u64;
            if start.is_empty() {
                return match self.expected {
                    Expected::Message => {
                        Err("the file is truncated: it has no end mark".to_owned())
                    }
                    Expected::Footer | Expected::Stream => Ok(None),
                };
            }
            // Streams can be concatenated, also without an end mark between them.
            if start.starts_with(&RRD_FOURCC) {
                check_header(&start).map_err(one_line)?;
                self.expected = Expected::Message;
                continue;
            }
            match self.expected {
                Expected::Stream => {
                    return Err("there are data after the end of the recording".to_owned());
                }
                Expected::Footer => {
                    check_footer(&self.complete(start, StreamFooter::ENCODED_SIZE_BYTES)?)?;
                    self.expected = Expected::Stream;
                }
                Expected::Message => {
                    let header = self.complete(start, MessageHeader::ENCODED_SIZE_BYTES)?;
                    let header = MessageHeader::from_rrd_bytes(&header).map_err(one_line)?;
                    match header.kind {
                        MessageKind::ArrowMsg if header.len > MAX_MESSAGE => {
                            return Err(too_long(header.len));
                        }
                        MessageKind::ArrowMsg => {
                            let payload = self.bytes(header.len)?;
                            let message = ArrowMsg::from_rrd_bytes(&payload);
                            return message.map(Some).map_err(one_line);
                        }
                        MessageKind::End => self.expected = Expected::Footer,
                        MessageKind::SetStoreInfo | MessageKind::BlueprintActivationCommand => {}
                    }
                    self.skip(header.len)?;
                }
            }
        }
    }

    /// Whether a message belongs to the recording that is read: the first of the file.
    fn is_wanted(&mut self, message: &ArrowMsg) -> bool {
        let Some(store) = &message.store_id else {
            return false;
        };
        store.kind() != StoreKind::Blueprint
            && *self
                .recording
                .get_or_insert_with(|| store.recording_id.clone())
                == store.recording_id
    }

    fn next_chunk(&mut self) -> Result<Option<Chunk>, String> {
        while let Some(message) = self.next_message()? {
            if self.is_wanted(&message) {
                return decode(&message).map(Some);
            }
        }
        Ok(None)
    }
}

impl<R: Read> Iterator for Chunks<BufReader<R>> {
    type Item = Chunk;

    fn next(&mut self) -> Option<Chunk> {
        if self.damage.is_some() {
            return None;
        }
        let reason = match without_panic(|| self.next_chunk()) {
            Some(Ok(chunk)) => return chunk,
            Some(Err(reason)) => reason,
            None => "the data cannot be decoded".to_owned(),
        };
        self.damage = Some(Damage {
            at: self.start,
            reason,
        });
        None
    }
}

fn too_long(length: u64) -> String {
    format!("a message claims {length} bytes; the limit is {MAX_MESSAGE}")
}

/// Checks that the bytes are the header of a supported stream.
fn check_header(bytes: &[u8]) -> Result<(), CodecError> {
    StreamHeader::from_rrd_bytes(bytes)?.to_version_and_options()?;
    Ok(())
}

/// Checks that the bytes are the footer of a stream: number of entries (1), identifier, magic number. The
/// library's own check trusts the number of entries.
fn check_footer(bytes: &[u8]) -> Result<(), String> {
    let end = [
        &RRD_FOURCC[..],
        &StreamFooter::RRD_IDENTIFIER,
        &[1, 0, 0, 0],
    ]
    .concat();
    if bytes.ends_with(&end) {
        Ok(())
    } else {
        Err("the footer is damaged".to_owned())
    }
}

/// Decodes the chunk of a message.
fn decode(message: &ArrowMsg) -> Result<Chunk, String> {
    if message.encoding() != Encoding::ArrowIpc {
        return Err("the encoding of a message is unknown".to_owned());
    }
    let payload = &message.payload;
    let bytes: Buffer = match message.compression() {
        Compression::Lz4 => {
            let length = message.uncompressed_size;
            if length > MAX_MESSAGE.min(MAX_RATIO * payload.len() as u64) {
                return Err(too_long(length));
            }
            decompress(payload, length as usize)
                .map_err(one_line)?
                .into()
        }
        Compression::None | Compression::Unspecified => payload.clone().into(),
    };
    let (_, mut batches) = stream_batches(bytes).map_err(one_line)?;
    let batch = batches.next().ok_or("a message is empty")?;
    let batch = batch.map_err(one_line)?;
    Chunk::from_chunk_record_batch(&batch).map_err(one_line)
}
