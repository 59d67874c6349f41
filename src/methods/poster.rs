//! `poster`: the first screen space cone tracing (Hermanns and Franke, SIGGRAPH 2014 poster). A cone marches through a
//! pre-filtered G-buffer, so that one march replaces ray trace and cone trace.

use super::layers::LayerParams;
use super::thesis::FadeParams;
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, MethodRequest};
use crate::error::Result;
use crate::gpu::shader::PosterBlock;
use crate::gpu::{Frame, Gpu};
use crate::passes::cone_march::{ConeMarchPass, MarchSteps};
use crate::passes::filtered_gbuffer::FilteredGBufferPass;
use crate::passes::{Content, PosterFilter};
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    parameters: PosterParams::table,
    ..MethodInfo::screen(
        "poster",
        "cone march through a pre-filtered G-buffer of depth, normal and colour",
        "Hermanns and Franke 2014",
        |gpu, request| Ok(Box::new(PosterMethod::new(gpu, request)?)),
    )
};

parameters! {
    /// Parameters of `poster`. What the poster does not print is of the author's later program; there the first step
    /// and the search's tolerance are of screen space, here parts of the screen and of the depth.
    pub struct PosterParams {
        /// How the poster's G-buffer is pre-filtered.
        poster_filter: PosterFilter = Parameter::new(PosterFilter::Mip)
            .sweep(Preset::Published, &[PosterFilter::Volume, PosterFilter::EdgeAware])
            .source("Hermanns and Franke 2014, figure 2; edge-aware: its conclusion"),
        /// Greatest difference of depth from texel to texel that the edge-aware filter takes for one surface, as a part
        /// of the depth.
        edge_tolerance: f32 = Parameter::new(0.1).above(0.0, 1.0).source("not in Hermanns and Franke 2014"),
        /// First step of the march.
        march_stride: f32 =
            Parameter::new(0.001).above(0.0, 1.0).unit("screen sides").source("not printed; the author's program"),
        /// Steps of the march at most.
        march_steps: u32 = Parameter::new(100).within(1, 65536).source("Hermanns and Franke 2014"),
        /// Length of each step of the march, divided by that of the step before.
        march_increase: f32 = Parameter::new(1.5).between(1.0, 16.0).source("Hermanns and Franke 2014"),
        /// Steps of the search for the surface after the march, at most.
        search_steps: u32 = Parameter::new(30).within(0, 65536).source("Hermanns and Franke 2014"),
        /// Length of each step of the search, divided by that of the step before.
        search_decrease: f32 = Parameter::new(0.5).above(0.0, 1.0).source("Hermanns and Franke 2014"),
        /// How near to a surface the search ends.
        search_tolerance: f32 =
            Parameter::new(2e-4).above(0.0, 1.0).unit("depth").source("not printed; the author's program"),
        /// How often a step that leaves the screen is taken back and halved.
        edge_retries: u32 =
            Parameter::new(0).author(3).within(0, 64).source("not printed: a miss; the author's program: three times"),
        /// With two layers of depth: what each measures in view depth. A ray that is farther behind it goes on.
        layer_thickness: f32 = Parameter::new(0.25).between(0.0, 1000.0).unit("m").source("as dda-thickness"),
        /// Where reflections fade.
        border: FadeParams,
        /// Layers of depth.
        layers: LayerParams,
    }
}

struct PosterMethod {
    filter: FilteredGBufferPass,
    /// Filters the second layer; `None` if there is one layer.
    second_filter: Option<FilteredGBufferPass>,
    march: ConeMarchPass,
    parameters: PosterBlock,
}

impl PosterMethod {
    fn new(gpu: &Gpu, request: &MethodRequest) -> Result<Self> {
        let (setup, p) = (&request.setup, request.setup.parameters::<PosterParams>());
        let has_second_layer = p.layers.has_second();
        let [fade_start, fade_end] = p.border.ends();
        let steps = MarchSteps {
            step_increase: p.march_increase,
            step_count: p.march_steps as i32,
            search_count: p.search_steps as i32,
            search_decrease: p.search_decrease,
        };
        let (stage, extent) = (setup.stage(), setup.extent);
        let make_filter = || FilteredGBufferPass::new(gpu, stage, extent, p.poster_filter, p.edge_tolerance);
        Ok(Self {
            filter: make_filter()?,
            second_filter: if has_second_layer { Some(make_filter()?.labelled("layer/")) } else { None },
            march: ConeMarchPass::new(gpu, stage, extent, p.poster_filter, steps, request.hits, has_second_layer)?,
            parameters: PosterBlock {
                first_step: p.march_stride,
                epsilon: p.search_tolerance,
                fade_start,
                fade_end,
                edge_retries: p.edge_retries as i32,
                fade: i32::from(setup.effect().fade),
                thickness: p.layer_thickness,
            },
        })
    }
}

impl Method for PosterMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let filtered = self.filter.record(frame, &input.gbuffer, input.camera)?;
        let second_layer = match (&self.second_filter, &input.second_layer) {
            (Some(filter), Some(layer)) => Some(filter.record(frame, layer, input.camera)?),
            _ => None,
        };
        let (reflection, hits) =
            self.march.record(frame, &input.gbuffer, filtered, second_layer, input.camera, &self.parameters)?;
        let intermediate = |name, content, image| Intermediate { name, content, image };
        let mut intermediates = vec![
            intermediate("filtered-depth", Content::LinearDepth, filtered.depth),
            intermediate("filtered-normal", Content::Normal, filtered.normal),
        ];
        // With mip chains, the filtered colour is the G-buffer's own, which is shown anyway.
        if !std::ptr::eq(filtered.color, input.gbuffer.color) {
            intermediates.push(intermediate("filtered-color", Content::Color, filtered.color));
        }
        Ok(MethodOutput { hits, intermediates, ..MethodOutput::new(reflection) })
    }
}
