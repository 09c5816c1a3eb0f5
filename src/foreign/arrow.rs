//! Arrow's streaming format with checks of all lengths.
//!
//! A stream is a schema followed by batches, each with a header (a flatbuffer) and a body. The reader of the
//! library allocates the body that a header claims, which may exceed the memory. This reader requires that
//! both lie within the stream and are below [`MAX_MESSAGE`], and that a header does not expand beyond
//! [`MAX_HEADER`] when its shared parts are counted each time.

use std::collections::HashMap;
use std::fmt;
use std::io::{self, Read};
use std::sync::Arc;

use arrow_array::{ArrayRef, RecordBatch};
use arrow_ipc::convert::fb_to_schema;
use arrow_ipc::reader::{read_dictionary, read_record_batch};
use arrow_ipc::{MessageHeader, root_as_message_with_opts};
use arrow_schema::{Schema, SchemaRef};
use flatbuffers::VerifierOptions;

use super::{one_line, read_exactly, truncated};

/// Maximum size of a message body, bytes.
pub(crate) const MAX_MESSAGE: u64 = 256 << 20;

/// Maximum size of a message header, bytes: a schema with its texts.
const MAX_HEADER: u64 = 64 << 20;

/// Maximum number of tables within a header: a schema has a few per field.
const MAX_TABLES: usize = 1 << 16;

/// Start of a message since version 0.15 of the format.
const CONTINUATION: u32 = u32::MAX;

/// The error for data that cannot be decoded.
pub(super) fn damaged(reason: impl fmt::Display) -> io::Error {
    io::Error::other(one_line(reason))
}

/// The batches of a stream. Decoding may panic: call it within [`super::without_panic`].
pub(crate) struct ArrowStream<R> {
    reader: R,
    schema: SchemaRef,
    dictionaries: HashMap<i64, ArrayRef>,
}

impl<R: Read> ArrowStream<R> {
    /// Reads the schema.
    pub fn new(mut reader: R) -> io::Result<Self> {
        let header = read_header(&mut reader)?.ok_or_else(truncated)?;
        let message = root_as_message_with_opts(&limits(), &header).map_err(damaged)?;
        let schema = message
            .header_as_schema()
            .ok_or_else(|| damaged("the stream does not start with a schema"))?;
        let schema = Arc::new(fb_to_schema(schema));
        read_body(&mut reader, message.bodyLength())?;
        Ok(Self {
            reader,
            schema,
            dictionaries: HashMap::new(),
        })
    }

    /// Schema of the batches.
    pub fn schema(&self) -> &Schema {
        &self.schema
    }

    /// The next batch; `None` at the end.
    pub fn next_batch(&mut self) -> io::Result<Option<RecordBatch>> {
        while let Some(header) = read_header(&mut self.reader)? {
            let message = root_as_message_with_opts(&limits(), &header).map_err(damaged)?;
            let body = read_body(&mut self.reader, message.bodyLength())?.into();
            let version = message.version();
            let schema = &self.schema;
            let known = &mut self.dictionaries;
            match message.header_type() {
                MessageHeader::RecordBatch => {
                    let batch = message.header_as_record_batch();
                    let batch = batch.ok_or_else(|| damaged("a batch is empty"))?;
                    let schema = Arc::clone(schema);
                    let read = read_record_batch(&body, batch, schema, known, None, &version);
                    return read.map(Some).map_err(damaged);
                }
                MessageHeader::DictionaryBatch => {
                    let batch = message.header_as_dictionary_batch();
                    let batch = batch.ok_or_else(|| damaged("a dictionary is empty"))?;
                    read_dictionary(&body, batch, schema, known, &version).map_err(damaged)?;
                }
                MessageHeader::NONE => {}
                _ => return Err(damaged("unexpected message type in a stream")),
            }
        }
        Ok(None)
    }
}

/// Limits for the verification of a header.
fn limits() -> VerifierOptions {
    VerifierOptions {
        max_tables: MAX_TABLES,
        max_apparent_size: MAX_HEADER as usize,
        ..VerifierOptions::default()
    }
}

/// The next header; `None` at the end of the stream, with or without an end mark.
fn read_header(reader: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    let mut number = read_number(reader)?;
    if number == Some(CONTINUATION) {
        number = Some(read_number(reader)?.ok_or_else(truncated)?);
    }
    match number.map(u64::from) {
        None | Some(0) => Ok(None),
        Some(length) if length > MAX_HEADER => Err(damaged(format!(
            "a header claims {length} bytes; the maximum is {MAX_HEADER}"
        ))),
        Some(length) => read_exactly(reader, length).map(Some),
    }
}

/// The next four bytes as a number; `None` at the end.
pub(super) fn read_number(reader: &mut impl Read) -> io::Result<Option<u32>> {
    let mut bytes = Vec::with_capacity(4);
    reader.take(4).read_to_end(&mut bytes)?;
    match bytes.as_slice().try_into() {
        Ok(bytes) => Ok(Some(u32::from_le_bytes(bytes))),
        Err(_) if bytes.is_empty() => Ok(None),
        Err(_) => Err(truncated()),
    }
}

/// Reads the body of a message.
fn read_body(reader: &mut impl Read, length: i64) -> io::Result<Vec<u8>> {
    let length = u64::try_from(length).map_err(|_| damaged("a length is negative"))?;
    if length > MAX_MESSAGE {
        return Err(damaged(format!(
            "a message claims {length} bytes; the maximum is {MAX_MESSAGE}"
        )));
    }
    read_exactly(reader, length)
}

#[cfg(test)]
mod tests {
    use arrow_array::Float64Array;
    use arrow_ipc::writer::StreamWriter;

    use super::super::without_panic;
    use super::*;

    /// A stream of two batches.
    fn stream() -> Vec<u8> {
        let numbers: ArrayRef = Arc::new(Float64Array::from(vec![1.0, 2.0, 3.0]));
        let batch = RecordBatch::try_from_iter([("x", numbers)]).unwrap();
        let mut bytes = Vec::new();
        let mut writer = StreamWriter::try_new(&mut bytes, batch.schema_ref()).unwrap();
        writer.write(&batch).unwrap();
        writer.write(&batch).unwrap();
        writer.finish().unwrap();
        bytes
    }

    /// Number of readable batches, and whether the stream ends without an error.
    fn read(bytes: &[u8]) -> (usize, bool) {
        let read = without_panic(|| {
            let mut stream = ArrowStream::new(bytes)?;
            let mut count = 0;
            while let Some(batch) = stream.next_batch().unwrap_or(None) {
                assert_eq!(batch.num_rows(), 3);
                count += 1;
            }
            Ok::<_, io::Error>((count, stream.next_batch().is_ok()))
        });
        read.and_then(Result::ok).unwrap_or((0, false))
    }

    #[test]
    fn batches_are_read_with_and_without_an_end_mark() {
        let bytes = stream();
        assert_eq!(read(&bytes), (2, true));
        assert_eq!(read(&bytes[..bytes.len() - 8]), (2, true));
        assert_eq!(read(&bytes[..bytes.len() - 9]).0, 1);
        assert_eq!(read(b""), (0, false));
    }

    #[test]
    fn excessive_claims_are_rejected_before_allocation() {
        let header = |claim: u32| [&[0xff; 4][..], &claim.to_le_bytes(), &stream()[8..]].concat();
        for claim in [MAX_HEADER as u32 + 1, u32::MAX - 1] {
            let refused = ArrowStream::new(&header(claim)[..]).err();
            let reason = refused.expect("an error").to_string();
            assert!(reason.contains("claims"), "{reason}");
        }
        for length in [-1, MAX_MESSAGE as i64 + 1, i64::MAX] {
            let refused = read_body(&mut &stream()[..], length).err();
            let kind = refused.map(|error| error.kind());
            assert_eq!(kind, Some(io::ErrorKind::Other), "{length}");
        }
        let refused = read_body(&mut &stream()[..], MAX_MESSAGE as i64).err();
        let kind = refused.map(|error| error.kind());
        assert_eq!(kind, Some(io::ErrorKind::UnexpectedEof));
    }
}
