//! Tables of three formats: an Arrow stream, an Arrow file, Parquet.

use std::fs::File;
use std::io::{self, BufReader, Cursor, Read, Seek};

use arrow_array::RecordBatch;
use arrow_schema::{Schema, SchemaRef};
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};

use super::arrow::{ArrowStream, damaged, read_number};
use super::truncated;

/// The batches of a table: a stream, an Arrow file or Parquet, which differ in their first bytes. Decoding may panic:
/// call it within [`super::without_panic`].
pub(crate) enum TableBatches {
    /// A stream, also that within an Arrow file.
    Arrow(ArrowStream<Box<dyn Read>>),
    /// Parquet, with the schema that it was written from.
    Parquet(SchemaRef, ParquetRecordBatchReader),
}

impl TableBatches {
    /// Reads the schema.
    pub fn new(mut file: File) -> io::Result<Self> {
        let mut start = Vec::with_capacity(8);
        (&mut file).take(8).read_to_end(&mut start)?;
        if start.starts_with(b"PAR1") {
            let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(damaged)?;
            let schema = builder.schema().clone();
            return Ok(Self::Parquet(schema, builder.build().map_err(damaged)?));
        }
        let mut reader = BufReader::new(file);
        if !start.starts_with(b"ARROW1") {
            reader.rewind()?;
            return ArrowStream::new(Box::new(reader) as Box<dyn Read>).map(Self::Arrow);
        }
        // Zeros fill the space up to the stream.
        let mut first = 0;
        while first == 0 {
            first = read_number(&mut reader)?.ok_or_else(truncated)?;
        }
        let stream = Cursor::new(first.to_le_bytes()).chain(reader);
        ArrowStream::new(Box::new(stream) as Box<dyn Read>).map(Self::Arrow)
    }

    /// Schema of the batches.
    pub fn schema(&self) -> &Schema {
        match self {
            Self::Arrow(stream) => stream.schema(),
            Self::Parquet(schema, _) => schema,
        }
    }

    /// The next batch; `None` at the end.
    pub fn next_batch(&mut self) -> io::Result<Option<RecordBatch>> {
        match self {
            Self::Arrow(stream) => stream.next_batch(),
            Self::Parquet(_, batches) => batches.next().transpose().map_err(damaged),
        }
    }
}
