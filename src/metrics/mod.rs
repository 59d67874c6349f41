//! Figures over plain slices: what an image or a set of hits is worth against a reference.

pub mod world;
