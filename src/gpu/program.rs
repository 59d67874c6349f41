//! Shader programs on the host: a program is a struct of everything that the shader reads. `build.rs` writes a struct
//! for each program that `shaders-glsl/` names, so that a binding that is missing, or of the wrong kind, does not
//! compile.

use super::frame::Resource;
use super::image::ImageSlice;
use super::sampler::Sampler;
use super::shader::Shader;

/// A program: one shader stage with its macros. Its fields are its bindings and its push constants, named as in GLSL;
/// see [`programs`](super::programs).
pub trait Program {
    /// The program's type without borrowed lifetimes, which is part of a pipeline's type.
    type Kind: 'static;

    /// Values of its specialization constants; `()` where it has none.
    type Constants: Constants;

    /// The compiled stage.
    const SHADER: &'static Shader;

    /// The resources to bind, in the order of the shader's bindings.
    fn resources(&self) -> Vec<Resource<'_>>;

    /// The bytes of its push constants; empty without a push-constant block.
    fn push(&self) -> &[u8];
}

/// A program that makes vertices.
pub trait VertexProgram: Program {}

/// A program that colours pixels.
pub trait Fragment: Program {
    /// An array with one `T` for each output, by location.
    type Outputs<T>: AsRef<[T]>;
}

/// A fragment program that exists as a compute program, too, made from the same source (`#pragma in_either_stage`).
pub trait InEitherStage: Fragment {
    /// The compute programs: one for each choice of formats of its outputs.
    const COMPUTE: &'static [Shader];
}

/// A program that is dispatched.
pub trait Compute: Program {}

/// Values of specialization constants.
pub trait Constants {
    /// Id and bits of each constant.
    fn entries(&self) -> Vec<(u32, u32)>;
}

impl Constants for () {
    fn entries(&self) -> Vec<(u32, u32)> {
        Vec::new()
    }
}

/// An image with its sampler.
#[derive(Clone, Copy)]
pub struct Sampled<'a>(pub ImageSlice<'a>, pub Sampler);

impl<'a> Sampled<'a> {
    /// An image that is fetched, or sampled at the nearest texel.
    pub fn nearest(slice: ImageSlice<'a>) -> Self {
        Self(slice, Sampler::NearestClamp)
    }

    /// An image that is sampled with trilinear filtering.
    pub fn trilinear(slice: ImageSlice<'a>) -> Self {
        Self(slice, Sampler::TrilinearClamp)
    }
}

/// Whether two stages of a pipeline agree on the bindings that both have.
pub(super) const fn bindings_agree(a: &Shader, b: &Shader) -> bool {
    let mut i = 0;
    while i < a.bindings.len() {
        let mut j = 0;
        while j < b.bindings.len() {
            let (x, y) = (&a.bindings[i], &b.bindings[j]);
            if x.binding == y.binding && (x.kind as u8 != y.kind as u8 || x.count != y.count) {
                return false;
            }
            j += 1;
        }
        i += 1;
    }
    true
}
