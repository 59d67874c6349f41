//! Measurements: run and return plain records. Nothing here prints or writes files.

pub mod age;
pub mod agreement;
pub mod bandwidth;
pub mod captions;
pub mod cell_list;
pub mod columns;
pub mod compare;
pub mod complaints;
mod drift;
pub mod engine;
pub mod error;
pub mod exhibit;
pub mod inspect;
pub mod interleave;
pub mod journal;
pub mod library;
pub mod merge;
pub mod names;
pub mod other_devices;
pub mod path;
pub mod pixel;
pub mod precision;
pub mod record;
pub mod shaders;
pub mod shard;
pub mod sound;
pub mod steps;
pub mod stress;
pub mod sweep;
pub mod table;
mod ties;
pub mod timing;
pub mod twin;
pub mod video;
mod zones;

pub use record::{Stats, TimeRecord};
