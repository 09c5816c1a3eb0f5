//! Messages for the page's own views: a JSON header, followed by arrays of numbers.
//!
//! ```text
//! length of the header, bytes, u32 | header, JSON, padded with spaces to 4 bytes | arrays, each padded to 4 bytes
//! ```
//!
//! All numbers are little-endian. The header lists the arrays in `arrays`, as `[name, type, count]` with the type
//! `f32`, `i16`, `u16` or `u8`; its other keys are values.

use serde_json::{Map, Value};

/// A message that is being written, or a part of one.
#[derive(Clone, Debug, Default)]
pub struct Message {
    values: Map<String, Value>,
    arrays: Vec<Value>,
    bytes: Vec<u8>,
}

impl Message {
    /// Whether the message has neither values nor arrays.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty() && self.arrays.is_empty()
    }

    /// Adds a part.
    pub fn with(mut self, part: &Self) -> Self {
        self.values.extend(part.values.clone());
        self.arrays.extend_from_slice(&part.arrays);
        self.bytes.extend_from_slice(&part.bytes);
        self
    }

    /// Adds a value.
    pub fn value(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.values.insert(name.to_owned(), value.into());
        self
    }

    /// Adds an array of 32-bit floats.
    pub fn floats(self, name: &str, numbers: impl IntoIterator<Item = f32>) -> Self {
        self.array(name, "f32", numbers.into_iter().map(f32::to_le_bytes))
    }

    /// Adds an array of 16-bit indices.
    pub fn indices(self, name: &str, numbers: impl IntoIterator<Item = u16>) -> Self {
        self.array(name, "u16", numbers.into_iter().map(u16::to_le_bytes))
    }

    /// Adds an array of bytes.
    pub fn octets(self, name: &str, numbers: impl IntoIterator<Item = u8>) -> Self {
        self.array(name, "u8", numbers.into_iter().map(|x| [x]))
    }

    /// Adds numbers as 16-bit fractions of their largest magnitude, which is the value `NAME_scale`.
    pub fn fractions(self, name: &str, numbers: impl Iterator<Item = f32> + Clone) -> Self {
        let scale = numbers
            .clone()
            .fold(f32::MIN_POSITIVE, |m, x| m.max(x.abs()));
        let fraction = |x: f32| (x / scale * f32::from(i16::MAX)) as i16;
        self.value(&format!("{name}_scale"), scale).array(
            name,
            "i16",
            numbers.map(|x| fraction(x).to_le_bytes()),
        )
    }

    fn array<const N: usize>(
        mut self,
        name: &str,
        kind: &str,
        numbers: impl Iterator<Item = [u8; N]>,
    ) -> Self {
        let before = self.bytes.len();
        self.bytes.extend(numbers.flatten());
        let count = (self.bytes.len() - before) / N;
        self.arrays.push(serde_json::json!([name, kind, count]));
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self
    }

    /// The complete message.
    pub fn finish(mut self) -> Vec<u8> {
        self.values.insert("arrays".to_owned(), self.arrays.into());
        let mut header = Value::Object(self.values).to_string().into_bytes();
        header.resize(header.len().next_multiple_of(4), b' ');
        let mut message = (header.len() as u32).to_le_bytes().to_vec();
        message.append(&mut header);
        message.append(&mut self.bytes);
        message
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_has_its_header_and_aligned_arrays() {
        let message = Message::default();
        assert!(message.is_empty());
        let message = message.value("run", 3).octets("states", [1, 2, 0]);
        let message = message.fractions("u", [0.5_f32, -2.0, 0.0].into_iter());
        let bytes = message
            .with(&Message::default().floats("at", [1.5]))
            .finish();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let header: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        assert_eq!(header["run"], 3);
        assert_eq!(header["u_scale"], 2.0);
        let arrays = serde_json::json!([["states", "u8", 3], ["u", "i16", 3], ["at", "f32", 1]]);
        assert_eq!(header["arrays"], arrays);
        let body = &bytes[4 + length..];
        assert_eq!((length % 4, body.len()), (0, 4 + 8 + 4));
        assert_eq!(body[..4], [1, 2, 0, 0]);
        let u = [0, 2, 4].map(|k| i16::from_le_bytes([body[4 + k], body[5 + k]]));
        assert_eq!(u, [8191, -32767, 0]);
        assert_eq!(body[12..], 1.5_f32.to_le_bytes());
    }
}
