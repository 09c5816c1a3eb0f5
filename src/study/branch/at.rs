//! Values of the parameter of a branch.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

/// The value of a parameter at a point, in the unit of the scene file. In JSON it is a field with the name of the key, such as
/// `tilt_deg`.
#[derive(Clone, Debug, PartialEq)]
pub struct At {
    /// Name of the key, such as `tilt_deg`.
    pub name: String,
    /// Value in the unit of the scene file.
    pub value: f64,
}

impl At {
    /// A value of the key with a name.
    pub fn new(name: &str, value: f64) -> Self {
        let name = name.to_owned();
        Self { name, value }
    }
}

impl Serialize for At {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        BTreeMap::from([(&self.name, self.value)]).serialize(serializer)
    }
}

impl JsonSchema for At {
    fn schema_name() -> Cow<'static, str> {
        "At".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "object",
            "additionalProperties": {
                "type": "number",
                "description": "Value of the parameter, in the unit of the scene file; the field has the name of the key."
            }
        })
    }
}
