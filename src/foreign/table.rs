//! Tables of three formats: an Arrow stream, an Arrow file, Parquet.

use std::fs::File;
use std::io::{self, Read, Seek};

use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::arrow::{ArrowStream, damaged};

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
        return Ok((
            schema,
            Box::new(batches.map(|batch| batch.map_err(damaged))),
        ));
    }
    if bytes != b"ARROW1" {
        file.rewind()?;
    }
    bytes.clear();
    file.read_to_end(&mut bytes)?;
    // In an Arrow file zeros fill the space up to the stream.
    let space = bytes.iter().take_while(|byte| **byte == 0).count();
    bytes.drain(..space);
    let stream = ArrowStream::new(bytes)?;
    Ok((stream.schema.clone(), Box::new(stream)))
}
