//! The versions of the oracle, which a user chooses by their number.

use crate::parameter::{Domain, Field, Value};

/// A version of the oracle (`reference::oracle`), which decides what a ray hits on the screen. The method `unified`
/// can follow either version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OracleVersion {
    /// docs/definitions.md, "Oracle": a ray hits the first block whose depth it meets.
    #[default]
    V1,
    /// A ray hits a block, which is the range of depth that a pixel fills, only if it comes to the block from in front. The ray passes
    /// its first block if it leaves the surface of that block. The ray misses if it reaches a block from behind, or passes behind the
    /// edge of a surface.
    V2,
}

impl OracleVersion {
    /// Whether this is version 1.
    pub fn is_first(&self) -> bool {
        *self == Self::V1
    }
}

impl From<OracleVersion> for u32 {
    fn from(version: OracleVersion) -> Self {
        if version.is_first() { 1 } else { 2 }
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
