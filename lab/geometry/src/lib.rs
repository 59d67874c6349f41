//! Triangles, images and rays on the CPU. They are a package of their own, since their loops over vertices, texels and rays must be
//! optimised, and the readers of files must not, which would take long to compile. [`assemble`] makes meshes of triangles,
//! [`bvh`] and [`triangles`] trace rays against these, [`viewpoint`] and [`placement`] find places for cameras and captures,
//! [`texture`] decodes and samples images, [`pattern`] makes those of the built-in scenes, and [`impostor_image`] those of impostors. [`bounded`] limits what a file
//! may cost.

pub mod assemble;
pub mod bounded;
pub mod bvh;
pub mod impostor_image;
pub mod pattern;
pub mod placement;
pub mod texture;
pub mod triangles;
pub mod viewpoint;
