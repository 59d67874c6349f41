//! The version of the oracle that decides what a ray hits in screen space.

use serde::{Deserialize, Serialize};

/// A version of the oracle ([`reference::oracle`](crate::reference::oracle)). The method `unified` can follow
/// either.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, Serialize, Deserialize)]
#[serde(into = "u32", try_from = "u32")]
pub enum OracleVersion {
    /// DEFINITIONS, "Oracle": a ray hits the first block whose depth it meets.
    #[default]
    #[value(name = "1")]
    V1,
    /// As version 1, but the ray must come from in front. It passes the first block if it leaves that surface;
    /// if it meets a block from behind, or past the edge of a surface, it misses.
    #[value(name = "2")]
    V2,
}

impl OracleVersion {
    /// Whether this is version 1, the default.
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
