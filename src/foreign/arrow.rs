//! Arrow's streaming format, read from memory.
//!
//! A stream is a schema followed by batches, each with a header (a flatbuffer) and a body. The reader of the library would
//! allocate the body that a header claims, which may exceed the memory; its decoder takes the bytes that follow. The library
//! limits what a header describes to a million tables and 2 GiB with shared parts counted each time.

use std::{fmt, io, iter};

use arrow_array::RecordBatch;
use arrow_buffer::Buffer;
use arrow_ipc::reader::StreamDecoder;
use arrow_schema::SchemaRef;

use super::{one_line, truncated};

/// A message without content, which ends a stream.
const END_MARK: [u8; 8] = [0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0];

/// The error for data that cannot be decoded.
pub(super) fn damaged(reason: impl fmt::Display) -> io::Error {
    io::Error::other(one_line(reason))
}

/// The schema and the batches of a stream; do not read on after a fault. Decoding may panic: call it within
/// [`super::without_panic`].
pub(crate) fn stream_batches(
    bytes: impl Into<Buffer>,
) -> io::Result<(SchemaRef, impl Iterator<Item = io::Result<RecordBatch>>)> {
    let (mut decoder, mut rest) = (StreamDecoder::new(), bytes.into());
    // With the schema, the first batch is read.
    let mut first = decoder.decode(&mut rest);
    if decoder.schema().is_none() && first.is_ok() {
        // The decoder completes the empty body of a schema with the next bytes.
        first = decoder.decode(&mut Buffer::from(END_MARK));
    }
    let Some(schema) = decoder.schema() else {
        return Err(first.map_or_else(damaged, |_| truncated()));
    };
    let mut first = Some(first);
    let batches = iter::from_fn(move || {
        let batch = first.take();
        let batch = batch.unwrap_or_else(|| decoder.decode(&mut rest));
        let end = decoder.finish();
        match batch {
            Ok(Some(batch)) => Some(Ok(batch)),
            Ok(None) => Some(Err(damaged(end.err()?))),
            // Behind the end mark is the footer of an Arrow file.
            Err(fault) => end.is_err().then(|| Err(damaged(fault))),
        }
    });
    Ok((schema, batches))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use arrow_array::{ArrayRef, Float64Array};
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
            let mut count = 0;
            for batch in stream_batches(bytes.to_vec())?.1 {
                let Ok(batch) = batch else {
                    return Ok::<_, io::Error>((count, false));
                };
                assert_eq!(batch.num_rows(), 3);
                count += 1;
            }
            Ok((count, true))
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

    /// A stream that ends after its schema, as after kill -9, and one with a footer behind its end mark.
    #[test]
    fn streams_without_batches_and_with_a_footer_are_whole() {
        let bytes = stream();
        let next = bytes.windows(4).skip(8).position(|w| w == [0xff; 4]);
        let schema = &bytes[..next.unwrap() + 8];
        assert_eq!(read(schema), (0, true));
        assert_eq!(
            read(&[schema, &[0xff; 4], &[0; 4], b"ARROW1"].concat()),
            (0, true)
        );
        assert_eq!(read(&[&bytes[..], b"footer"].concat()), (2, true));
    }

    /// Nothing is allocated for bytes that do not follow.
    #[test]
    fn excessive_claims_end_the_stream() {
        let header = |claim: u32| [&[0xff; 4][..], &claim.to_le_bytes(), &stream()[8..]].concat();
        for claim in [(64 << 20) + 1, u32::MAX - 1] {
            let refused = stream_batches(header(claim)).err();
            let kind = refused.map(|error| error.kind());
            assert_eq!(kind, Some(io::ErrorKind::UnexpectedEof), "{claim}");
        }
        let bytes = stream();
        for at in (0..bytes.len() - 8).step_by(8) {
            for claim in [-1, 1 << 40, i64::MAX] {
                let mut bytes = bytes.clone();
                bytes[at..at + 8].copy_from_slice(&i64::to_le_bytes(claim));
                assert!(read(&bytes).0 <= 2, "{claim} at {at}");
            }
        }
    }
}
