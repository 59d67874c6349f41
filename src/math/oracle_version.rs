//! Which version of the oracle says what a ray hits in screen space.

use serde::{Deserialize, Serialize};

/// A version of the oracle ([`reference::oracle`](crate::reference::oracle)); `unified` hits what either says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, Serialize, Deserialize)]
#[serde(into = "u32", try_from = "u32")]
pub enum OracleVersion {
    /// DEFINITIONS, "Oracle": the first block that the ray's depth meets.
    #[default]
    #[value(name = "1")]
    V1,
    /// The same, and the ray must come from in front: it passes the first block if it leaves that surface, and what
    /// it meets from behind, or past the edge of a surface, is a miss.
    #[value(name = "2")]
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

impl TryFrom<u32> for OracleVersion {
    type Error = String;

    fn try_from(number: u32) -> Result<Self, String> {
        match number {
            1 => Ok(Self::V1),
            2 => Ok(Self::V2),
            _ => Err(format!("there is no version {number} of the oracle")),
        }
    }
}
