//! Which version of the oracle says what a ray hits in screen space.

use crate::parameter::{Domain, Field, Value};

/// A version of the oracle ([`reference::oracle`](crate::reference::oracle)); `unified` hits what either says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OracleVersion {
    /// DEFINITIONS, "Oracle": the first block that the ray's depth meets.
    #[default]
    V1,
    /// The same, and the ray must come from in front: it passes the first block if it leaves that surface, and what
    /// it meets from behind, or past the edge of a surface, is a miss.
    V2,
}

impl OracleVersion {
    /// Whether it is the one that is meant where none is named.
    pub fn is_first(&self) -> bool {
        *self == Self::V1
    }
}

impl From<OracleVersion> for u32 {
    fn from(version: OracleVersion) -> Self {
        match version {
            OracleVersion::V1 => 1,
            OracleVersion::V2 => 2,
        }
    }
}

impl Field for OracleVersion {
    fn domain() -> Domain {
        Domain::Count(1, 2)
    }

    fn value(self) -> Value {
        Value::Count(self.into())
    }

    fn from_value(value: Value) -> Option<Self> {
        match value {
            Value::Count(1) => Some(Self::V1),
            Value::Count(2) => Some(Self::V2),
            _ => None,
        }
    }
}
