//! Versions that a user chooses by their number: of the oracle, and of the definitions.

use crate::parameter::{Domain, Field, Value};

/// Declares an enum of two versions, 1 and 2, of which one has the attribute `#[default]`.
macro_rules! versions {
    ($(#[$attribute:meta])* $name:ident { $(#[$first:meta])* V1, $(#[$second:meta])* V2, }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        pub enum $name {
            $(#[$first])*
            V1,
            $(#[$second])*
            V2,
        }

        impl $name {
            /// Whether this is version 1.
            pub fn is_first(&self) -> bool {
                *self == Self::V1
            }
        }

        impl From<$name> for u32 {
            fn from(version: $name) -> Self {
                if version.is_first() { 1 } else { 2 }
            }
        }

        impl Field for $name {
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
    };
}

versions! {
    /// A version of the oracle (`reference::oracle`), which decides what a ray hits in screen
    /// space. The method `unified` can follow either.
    OracleVersion {
        /// docs/definitions.md, "Oracle": a ray hits the first block whose depth it meets.
        #[default]
        V1,
        /// Version 1 with the condition that the ray comes from in front. It passes the first block if it leaves that surface;
        /// if it meets a block from behind, or past the edge of a surface, it misses.
        V2,
    }
}

versions! {
    /// A version of docs/definitions.md, by which the references judge.
    DefinitionsVersion {
        /// docs/definitions.md, "Version 1 of the definitions".
        V1,
        /// The environment along the ray on sky surfaces, the pixel's footprint, and the environment where rays escape
        /// (docs/definitions.md, "Image error").
        #[default]
        V2,
    }
}
