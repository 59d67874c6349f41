//! The parameters of the thesis's methods, in groups that several methods share. Published numbers come from thesis
//! §4.2 and §4.3, and the author's numbers from the author's own program.

use crate::gpu::shader::ThesisBlock;
use crate::passes::MarchNumbers;
use ssct_ground::math::constants::{MIRROR_ALPHA, XI};
use ssct_ground::parameter::{Parameter, Parameters, Preset, Values, choices, parameters};
use ssct_ground::scene::Camera;

/// A bound for loops that the thesis leaves unbounded (docs/definitions.md, "Time").
pub const UNBOUNDED: u32 = 1024;

/// The source of numbers that the thesis does not print.
const UNPRINTED: &str = "not printed; the author's program";

parameters! {
    /// Parameters of the Hi-Z traversal (thesis Alg. 2 to 4).
    pub struct HiZParams {
        /// Bound of the Hi-Z traversal's iterations.
        iterations: u32 = Parameter::new(UNBOUNDED)
            .author(64)
            .within(1, 65536)
            .sweep(Preset::Author, &[16, 32, 256])
            .source("Alg. 4, line 3: unbounded"),
        /// Hi-Z level that the traversal begins at; beyond the coarsest, the coarsest.
        start_level: u32 = Parameter::new(0)
            .author(2)
            .within(0, 31)
            .sweep(Preset::Published, &[2])
            .source("Alg. 4, line 2"),
        /// How far past a cell's side the traversal steps.
        cross_offset: f32 = Parameter::new(0.5).above(0.0, 16.0).unit("pixels").source(UNPRINTED),
        /// A view direction whose depth changes less counts as towards the camera.
        direction_tolerance: f32 = Parameter::new(1e-5).between(0.0, 1.0).unit("depth").source(UNPRINTED),
    }
}

parameters! {
    /// Parameters of the linear march with its binary search (thesis §4.2.2).
    pub struct MarchParams {
        /// First step of the march.
        march_stride: f32 = Parameter::new(0.001).above(0.0, 1.0).unit("screen sides").source(UNPRINTED),
        /// Steps of the march at most.
        march_steps: u32 = Parameter::new(100).within(1, 65536).source("§4.2.2, listings 1 and 2"),
        /// Length of each step of the march, divided by that of the step before.
        march_increase: f32 = Parameter::new(1.5).between(1.0, 16.0).source("§4.2.2, listing 2"),
        /// Steps of the search for the surface after the march, at most.
        search_steps: u32 = Parameter::new(32).author(30).within(0, 65536).source("§4.2.2, listing 2"),
        /// Length of each step of the search, divided by that of the step before.
        search_decrease: f32 = Parameter::new(0.5).above(0.0, 1.0).source("§4.2.2, listing 2"),
        /// The search's first step over the march's next one. The author's is a quarter of the march's last; the
        /// listing's stride has grown since.
        search_first: f32 =
            Parameter::new(1.0).author(0.25 / 1.5).above(0.0, 16.0).source("§4.2.2, listing 2: dir * stride"),
        /// How near to a surface the search ends.
        search_tolerance: f32 =
            Parameter::new(0.01).author(2e-4).above(0.0, 1.0).unit("depth").source("§4.2.2, listing 2"),
    }
}

choices! {
    /// The half angle of the cone of a roughness ϱ. Eq. 4.5 cannot serve as it is printed: with its α, which grows with
    /// ϱ, mirrors have the widest cones.
    pub enum ConeAngle {
        /// The author's: ϱ/2. Eq. 4.5 gives this angle for this project's lobe of roughness ϱ, with an arc cosine in
        /// place of the printed cosine.
        Lobe = "lobe",
        /// The nearest to print that serves: Eq. 4.5 with an arc cosine and with the ends of its interpolation swapped,
        /// from `cone_alpha_max` for mirrors to `cone_alpha_min`; and no angle at all for an α above
        /// `cone_mirror_alpha`.
        Interpolated = "interpolated",
    }
}

parameters! {
    /// Parameters of the cone trace (thesis Alg. 5).
    pub struct ConeParams {
        /// The cone's angle for a roughness: the author's, since Eq. 4.5 is wrong in print, or the nearest to print.
        cone_angle: ConeAngle = Parameter::new(ConeAngle::Lobe)
            .sweep(Preset::Published, &[ConeAngle::Interpolated])
            .source("not Eq. 4.5, which is wrong in print; the author's program"),
        /// The exponent of the roughest surfaces, where it is interpolated.
        cone_alpha_min: f32 = Parameter::new(0.1).between(0.0, 1e4).source(UNPRINTED),
        /// The exponent of mirrors, where it is interpolated.
        cone_alpha_max: f32 = Parameter::new(1024.0).between(0.0, 1e4).source(UNPRINTED),
        /// Share of the lobe that lies outside of the cone: ξ of Eq. 4.5. With another one, cones are wider (below
        /// 0.244) or narrower for the same lobe, however the angle is found.
        cone_xi: f32 = Parameter::new(XI as f32).between(0.001, 0.999).source("§4.2.8: 0.244"),
        /// The exponent above which a cone is a mirror's and has no angle, where it is interpolated.
        cone_mirror_alpha: f32 =
            Parameter::new(MIRROR_ALPHA as f32).between(0.0, 1e6).source("§4.2.8: 1000 \"for instance\""),
        /// Circles of the cone.
        cone_samples: u32 = Parameter::new(7)
            .within(1, 64)
            .sweep(Preset::Published, &[3, 15])
            .source("Alg. 5; §4.2.8"),
        /// The cone is lengthened so that its first circle lies at the hit.
        cone_lengthened: bool = Parameter::new(false).author(true).source("Alg. 5, line 2"),
    }
}

parameters! {
    /// Parameters of the uniform march of SSLR (thesis §4.3.1).
    pub struct UniformMarchParams {
        /// Steps of the uniform march at most.
        uniform_steps: u32 = Parameter::new(200).within(1, 65536).source(UNPRINTED),
        /// Stride of the uniform march for mirrors.
        uniform_stride_min: f32 = Parameter::new(0.001).above(0.0, 1.0).unit("screen sides").source(UNPRINTED),
        /// Stride of the uniform march for the roughest surfaces.
        uniform_stride_max: f32 = Parameter::new(0.1).above(0.0, 1.0).unit("screen sides").source(UNPRINTED),
        /// How far a hit lies before the end of the step that found it, as a share of the step.
        uniform_back: f32 = Parameter::new(0.0).author(0.5).between(0.0, 1.0).source("§4.3.1: no refinement"),
    }
}

/// Returns a block with the members that camera and size in pixels decide; the groups of parameters fill in the rest.
/// `levels` is the number of levels of the Hi-Z chain, and `fade` whether reflections fade at the screen's border.
pub fn block(camera: &Camera, extent: [u32; 2], levels: u32, fade: bool) -> ThesisBlock {
    let projection = camera.view_to_clip().as_dmat4();
    ThesisBlock {
        projection: projection.as_mat4().to_cols_array_2d(),
        inverse_projection: projection.inverse().as_mat4().to_cols_array_2d(),
        resolution: extent.map(|v| v as f32),
        near_plane: camera.lens.near_m,
        far_plane: camera.lens.far_m,
        max_level: levels as i32 - 1,
        // The thesis does not print this number; it is the author's.
        reflection_offset: camera.lens.near_m,
        fade: i32::from(fade),
        ..FadeParams::default().fill(ThesisBlock::default())
    }
}

parameters! {
    /// Where reflections fade at the screen's border (thesis Eq. 4.7).
    pub struct FadeParams {
        /// Where the fade begins: the distance of a hit from the middle of the screen, of which 1 is half the screen's
        /// width, and height (I_start of Eq. 4.7).
        fade_start: f32 = Parameter::new(0.8).above(0.0, 2.0).unit("half screens").source("Hermanns 2015, §4.2.9: 0.8"),
        /// Where the fade is complete (I_end of Eq. 4.7). An end that does not lie beyond the start makes a hard edge
        /// at the start.
        fade_end: f32 = Parameter::new(1.0).above(0.0, 2.0).unit("half screens").source("Hermanns 2015, Eq. 4.7"),
    }
}

impl Default for FadeParams {
    /// The published fade.
    fn default() -> Self {
        Self::from_values(&Values::default())
    }
}

impl FadeParams {
    /// Returns start and end of the fade, with the end beyond the start, since Eq. 4.7 divides by their difference.
    pub fn ends(&self) -> [f32; 2] {
        [self.fade_start, self.fade_end.max(self.fade_start + 1e-6)]
    }

    /// Fills in the members of the block that the fade reads.
    pub fn fill(&self, block: ThesisBlock) -> ThesisBlock {
        let [fade_start, fade_end] = self.ends();
        ThesisBlock { fade_start, fade_end, ..block }
    }
}

impl HiZParams {
    /// Fills in the members of the block that the Hi-Z traversal reads.
    pub fn fill(&self, block: ThesisBlock) -> ThesisBlock {
        ThesisBlock {
            iterations: self.iterations as i32,
            start_level: (self.start_level as i32).min(block.max_level),
            cross_offset: self.cross_offset,
            view_direction_epsilon: self.direction_tolerance,
            ..block
        }
    }
}

impl MarchParams {
    /// Fills in the members of the block that the linear march reads.
    pub fn fill(&self, block: ThesisBlock) -> ThesisBlock {
        ThesisBlock { linear_march_stride: self.march_stride, binary_search_first: self.search_first, ..block }
    }

    /// Returns the numbers that are constants in the listings, and specialization constants of the shaders.
    pub fn numbers(&self) -> MarchNumbers {
        MarchNumbers {
            linear_march_count: self.march_steps as i32,
            linear_march_increase: self.march_increase,
            binary_search_count: self.search_steps as i32,
            binary_search_decrease: self.search_decrease,
            depth_delta_epsilon: self.search_tolerance,
        }
    }
}

impl ConeParams {
    /// Fills in the members of the block that the cone trace reads.
    pub fn fill(&self, block: ThesisBlock) -> ThesisBlock {
        ThesisBlock {
            cone_samples: self.cone_samples as i32,
            cone_lengthened: i32::from(self.cone_lengthened),
            cone_interpolated: i32::from(self.cone_angle == ConeAngle::Interpolated),
            cone_alpha_min: self.cone_alpha_min,
            cone_alpha_max: self.cone_alpha_max,
            cone_xi: self.cone_xi,
            cone_mirror_alpha: self.cone_mirror_alpha,
            ..block
        }
    }
}

impl UniformMarchParams {
    /// Fills in the members of the block that the uniform march reads.
    pub fn fill(&self, block: ThesisBlock) -> ThesisBlock {
        ThesisBlock {
            uniform_stride_min: self.uniform_stride_min,
            uniform_stride_max: self.uniform_stride_max,
            uniform_march_back: self.uniform_back,
            ..block
        }
    }
}
