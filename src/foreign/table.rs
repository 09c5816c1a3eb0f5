//! Tables of three formats: an Arrow stream, an Arrow file, Parquet.

use std::fs::File;
use std::io::{self, Read};

use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::arrow::{damaged, stream_batches};

/// Maximum size of a message header, bytes: a schema with its texts.
const MAX_HEADER: u32 = 64 << 20;

/// The batches of a table.
type Batches = Box<dyn Iterator<Item = io::Result<RecordBatch>>>;

/// The schema and the batches of a stream, an Arrow file or Parquet, which differ in their first bytes. Decoding may panic:
/// call it within [`super::without_panic`].
pub(crate) fn read_batches(mut file: File) -> io::Result<(SchemaRef, Batches)> {
    let mut bytes = Vec::new();
    (&mut file).take(6).read_to_end(&mut bytes)?;
    if bytes.starts_with(b"PAR1") {
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(damaged)?;
        // The schema that it was written from.
        let schema = builder.schema().clone();
        let batches = builder.build().map_err(damaged)?;
        let batches = batches.map(|batch| batch.map_err(damaged));
        return Ok((schema, Box::new(batches)));
    }
    let is_file = bytes == b"ARROW1";
    let claim = bytes.first_chunk().copied().map_or(0, u32::from_le_bytes);
    if !is_file && claim > MAX_HEADER && claim != u32::MAX {
        // A large file of another kind is not read.
        return Err(damaged(format!(
            "a header claims {claim} bytes; the maximum is {MAX_HEADER}"
        )));
    }
    file.read_to_end(&mut bytes)?;
    if is_file {
        // Zeros fill the space up to the stream.
        let space = bytes[6..].iter().take_while(|byte| **byte == 0).count();
        bytes.drain(..6 + space);
    }
    let (schema, batches) = stream_batches(bytes)?;
    Ok((schema, Box::new(batches)))
}
