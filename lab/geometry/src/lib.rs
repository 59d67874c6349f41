//! Triangles, images and rays on the CPU. They are a package of their own because loops over vertices, texels and rays
//! must be optimised. The readers of files need no optimisation, which would make them slow to compile.
//!
//! [`assemble`] makes meshes of triangles, and [`bvh`] and [`triangles`] trace rays against triangles. [`viewpoint`]
//! and [`placement`] find places for cameras and captures. [`texture`] decodes and samples images, [`pattern`] makes
//! the images of the built-in scenes, and [`impostor_image`] makes those of impostors. [`bounded`] limits the cost of a
//! file.

pub mod assemble;
pub mod bounded;
pub mod bvh;
pub mod impostor_image;
pub mod pattern;
pub mod placement;
pub mod texture;
pub mod triangles;
pub mod viewpoint;
