//! The messages of a recording file, with every length checked.
//!
//! A stream is a header of 12 bytes, then messages, each a header of 16 bytes (kind and length) and
//! a payload in protobuf. An end mark closes it; newer streams have a footer of 32 bytes after it.
//! Streams may follow one another. The library's own decoder allocates what such headers claim.

use std::fmt;
use std::io::{self, BufReader, Read};

use re_protos::common::v1alpha1::{Compression, StoreKind};
use re_protos::log_msg::v1alpha1::{ArrowMsg, Encoding};
use rerun::external::re_log_encoding::external::lz4_flex::block::decompress;
use rerun::external::re_log_encoding::{
    CodecError, Decodable, MessageHeader, MessageKind, RRD_FOURCC, StreamFooter, StreamHeader,
};
use rerun::log::Chunk;

use crate::foreign::arrow::{ArrowStream, MAX_MESSAGE};
use crate::foreign::{one_line, read_exactly, without_panic};

/// LZ4 makes a byte of at most so many: a length goes on by bytes of 255.
const MAX_RATIO: u64 = 255;

const BREAKS_OFF: &str = "it breaks off within a message";

/// Where a recording is damaged or breaks off. Nothing behind it is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Bytes before it.
    pub at: u64,
    /// What is wrong there.
    pub reason: String,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {}: {}", self.at, self.reason)
    }
}

/// What may come next.
#[derive(Clone, Copy)]
enum Expected {
    Message,
    /// Of the stream that an end mark has closed. Old streams have none.
    Footer,
    Stream,
}

/// The chunks of the first recording in a file, up to its end or the first damage.
pub(super) struct Chunks<R> {
    file: R,
    /// Bytes read.
    at: u64,
    /// Where the message begins that is read last.
    start: u64,
    expected: Expected,
    /// The recording that is read.
    recording: Option<String>,
    /// Where reading ended before the end of the file.
    damage: Option<Damage>,
}

impl<R: Read> Chunks<BufReader<R>> {
    /// Reads the header.
    ///
    /// # Errors
    /// If it is not that of a recording, or of one that this version of Rerun reads.
    pub fn new(file: R) -> Result<Self, CodecError> {
        let mut file = BufReader::new(file);
        let header = read_exactly(&mut file, StreamHeader::ENCODED_SIZE_BYTES as u64);
        check_header(&header.ok().flatten().unwrap_or_default())?;
        Ok(Self {
            file,
            at: StreamHeader::ENCODED_SIZE_BYTES as u64,
            start: 0,
            expected: Expected::Message,
            recording: None,
            damage: None,
        })
    }

    /// Where reading ended before the end of the file.
    pub fn damage(self) -> Option<Damage> {
        self.damage
    }

    /// Bytes of the file; fewer are left only if it breaks off.
    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, String> {
        let bytes = read_exactly(&mut self.file, count).map_err(one_line)?;
        self.at += count;
        bytes.ok_or_else(|| BREAKS_OFF.to_owned())
    }

    /// The bytes that begin with those that were read already.
    fn complete(&mut self, mut start: Vec<u8>, size: usize) -> Result<Vec<u8>, String> {
        start.extend(self.bytes((size - start.len()) as u64)?);
        Ok(start)
    }

    /// Passes over bytes of the file.
    fn skip(&mut self, count: u64) -> Result<(), String> {
        let skipped = io::copy(&mut (&mut self.file).take(count), &mut io::sink());
        self.at = self.at.saturating_add(count);
        match skipped.map_err(one_line)? == count {
            true => Ok(()),
            false => Err(BREAKS_OFF.to_owned()),
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
                    Expected::Message => Err("it breaks off without an end mark".to_owned()),
                    Expected::Footer | Expected::Stream => Ok(None),
                };
            }
            // Streams may follow one another, without an end mark between them.
            if start.starts_with(&RRD_FOURCC) {
                check_header(&start).map_err(one_line)?;
                self.expected = Expected::Message;
                continue;
            }
            match self.expected {
                Expected::Stream => return Err("something follows its end".to_owned()),
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
            None => "the library that decodes it fails".to_owned(),
        };
        self.damage = Some(Damage {
            at: self.start,
            reason,
        });
        None
    }
}

fn too_long(length: u64) -> String {
    format!("a message claims {length} bytes; at most {MAX_MESSAGE} are read")
}

/// Whether a stream begins like this that can be read.
fn check_header(bytes: &[u8]) -> Result<(), CodecError> {
    StreamHeader::from_rrd_bytes(bytes)?.to_version_and_options()?;
    Ok(())
}

/// Whether this is the footer of a stream: mark, name, and one entry before them. The library's own
/// check believes the number of entries.
fn check_footer(bytes: &[u8]) -> Result<(), String> {
    let end = [
        &RRD_FOURCC[..],
        &StreamFooter::RRD_IDENTIFIER,
        &[1, 0, 0, 0],
    ]
    .concat();
    match bytes.ends_with(&end) {
        true => Ok(()),
        false => Err("its footer is damaged".to_owned()),
    }
}

/// The chunk in a message.
fn decode(message: &ArrowMsg) -> Result<Chunk, String> {
    if message.encoding() != Encoding::ArrowIpc {
        return Err("a message has an unknown encoding".to_owned());
    }
    let payload = &message.payload;
    let unpacked;
    let bytes = match message.compression() {
        Compression::Lz4 => {
            let length = message.uncompressed_size;
            if length > MAX_MESSAGE.min(MAX_RATIO * payload.len() as u64) {
                return Err(too_long(length));
            }
            unpacked = decompress(payload, length as usize).map_err(one_line)?;
            &unpacked[..]
        }
        Compression::None | Compression::Unspecified => payload,
    };
    let mut stream = ArrowStream::new(bytes).map_err(one_line)?;
    let batch = stream.next_batch().map_err(one_line)?;
    let batch = batch.ok_or("a message is empty")?;
    Chunk::from_chunk_record_batch(&batch).map_err(one_line)
}
