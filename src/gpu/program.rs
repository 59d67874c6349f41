//! Shader programs on the host: a program is a struct of everything that its shaders read. `build.rs` writes a struct
//! for each program that `shaders-glsl/` names, so that a binding that is missing, or of the wrong kind, does not
//! compile. A program may have permutations: shaders of either stage, and for each source of rays. Permutations share
//! the struct, and a binding that only some permutations have is an `Option`.

use super::frame::Resource;
use super::image::ImageSlice;
use super::pixels::ShaderStage;
use super::sampler::Sampler;
use super::shader::Shader;
use crate::error::{Error, Result};
use ash::vk;

/// How a shader finds where its rays end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RaySource {
    /// A walk over the screen's depth.
    Screen,
    /// A walk over the screen, whose ends the triangles that pixels show confirm.
    Confirmed,
    /// A walk through the tree of a scene's triangles.
    Tree,
    /// The device's ray queries.
    Query,
}

/// A shader of a program.
#[derive(Debug)]
pub struct Permutation {
    /// The compiled stage.
    pub shader: &'static Shader,
    /// Whether the shader is a compute shader.
    pub is_compute: bool,
    /// How the shader finds where rays end; `None` for a program that has no choice of a source of rays.
    pub rays: Option<RaySource>,
    /// Ids of the shader's specialization constants.
    pub constants: &'static [u32],
}

/// The choice of a program's permutation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PermutationChoice {
    /// The shader stage.
    pub stage: ShaderStage,
    /// How the shader finds where rays end; `None` for a program that has no choice of a source of rays.
    pub rays: Option<RaySource>,
}

impl From<ShaderStage> for PermutationChoice {
    fn from(stage: ShaderStage) -> Self {
        Self { stage, rays: None }
    }
}

impl PermutationChoice {
    /// The choice of a compute shader with a source of rays.
    pub fn compute(rays: RaySource) -> Self {
        Self { stage: ShaderStage::Compute, rays: Some(rays) }
    }
}

/// A program. Its fields are the bindings and push constants of its permutations, as in GLSL ([`super::programs`]).
pub trait Program {
    /// The program's type without borrowed lifetimes, which is part of a pipeline's type.
    type Kind: 'static;

    /// The type of the program's specialization constants; `()` for a program without such constants.
    type Constants: Constants;

    /// The program's shaders.
    const PERMUTATIONS: &'static [Permutation];

    /// The shader of a program that has only one. For any other program, code with this constant does not compile.
    const SHADER: &'static Shader = {
        assert!(Self::PERMUTATIONS.len() == 1, "the program has several permutations");
        Self::PERMUTATIONS[0].shader
    };

    /// The resource of a binding, by its name; `None` if none is given.
    fn resource(&self, name: &str) -> Option<Resource<'_>>;

    /// The bytes of the program's push constants; empty without a push-constant block.
    fn push(&self) -> &[u8];
}

/// A program that makes vertices.
pub trait VertexProgram: Program {}

/// A program that colours pixels.
pub trait Fragment: Program {
    /// An array with one `T` for each output, by location.
    type Outputs<T>: AsRef<[T]>;
}

/// A fragment program whose compute permutations, one for each choice of formats, store what the fragment ones draw.
pub trait InEitherStage: Fragment {}

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

/// Finds the permutation of a choice. A compute permutation that stands in for a fragment permutation must store to
/// images of the formats `targets`, among which UNDEFINED fits every format. Fails if there is no such permutation.
pub(super) fn find_permutation<P: Program>(
    choice: PermutationChoice,
    targets: &[vk::Format],
) -> Result<&'static Permutation> {
    let PermutationChoice { stage, rays } = choice;
    let stores =
        |((_, format), target): (&(u32, vk::Format), &vk::Format)| *target == vk::Format::UNDEFINED || format == target;
    let is_chosen = |permutation: &&Permutation| {
        permutation.is_compute == (stage == ShaderStage::Compute)
            && permutation.rays == rays
            && permutation.shader.stored.iter().zip(targets).all(stores)
    };
    P::PERMUTATIONS.iter().find(is_chosen).ok_or_else(|| {
        let names: Vec<&str> = P::PERMUTATIONS.iter().map(|permutation| permutation.shader.name).collect();
        let source = rays.map_or(String::new(), |rays| format!(" whose rays end by {rays:?}"));
        Error::Usage(format!(
            "there is no {stage:?} shader{source}, for images of the formats {targets:?}, among these: {}",
            names.join(", ")
        ))
    })
}

/// Returns id and bits of each specialization constant that a permutation has, sorted by id.
pub(super) fn constant_entries(permutation: &Permutation, constants: &impl Constants) -> Vec<(u32, u32)> {
    let mut entries = constants.entries();
    entries.retain(|(id, _)| permutation.constants.contains(id));
    entries.sort_unstable();
    entries
}

/// Whether a fragment program's shaders agree with a vertex shader on the bindings that both have.
pub(super) const fn permutations_agree(fragments: &[Permutation], vertex: &Shader) -> bool {
    let mut i = 0;
    while i < fragments.len() {
        if !fragments[i].is_compute && !bindings_agree(fragments[i].shader, vertex) {
            return false;
        }
        i += 1;
    }
    true
}

/// Whether the two stages of a pipeline agree on the kind and the count of the bindings that both have.
const fn bindings_agree(fragment: &Shader, vertex: &Shader) -> bool {
    let mut i = 0;
    while i < fragment.bindings.len() {
        let mut j = 0;
        while j < vertex.bindings.len() {
            let (own, other) = (&fragment.bindings[i], &vertex.bindings[j]);
            if own.binding == other.binding && (own.kind as u8 != other.kind as u8 || own.count != other.count) {
                return false;
            }
            j += 1;
        }
        i += 1;
    }
    true
}
