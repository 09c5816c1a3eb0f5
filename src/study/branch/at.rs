//! Values of the parameter of a branch.

use std::collections::BTreeMap;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The value of a parameter at a point, in the unit of the scene file. In JSON it is a field with the name of the key, such as
/// `tilt_deg`.
#[derive(Clone, Debug, PartialEq)]
pub struct At {
    /// Name of the key, such as `tilt_deg`.
    pub name: String,
    /// Value in the unit of the scene file.
    pub value: f64,
}

impl Serialize for At {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        BTreeMap::from([(&self.name, self.value)]).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for At {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let map = BTreeMap::<String, f64>::deserialize(from)?;
        let entry = map.into_iter().next();
        entry
            .map(|(name, value)| Self { name, value })
            .ok_or_else(|| D::Error::custom("the value of the parameter is missing"))
    }
}
