//! `poster`: the first screen space cone tracing (Hermanns and Franke, SIGGRAPH 2014 poster): a cone that
//! marches through the pre-filtered G-buffer. Ray trace and cone trace are one here, not two.

use super::{Input, Intermediate, Method, MethodInfo, Preset, Sees, Setup, Traced};
use crate::error::Result;
use crate::gpu::shader::PosterBlock;
use crate::gpu::{Frame, Gpu};
use crate::passes::cone_march::ConeMarchPass;
use crate::passes::filtered_gbuffer::FilteredGBufferPass;
use crate::passes::{Content, PosterFilter};

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    name: "poster",
    summary: "cone march through a pre-filtered G-buffer of depth, normal and colour",
    source: "Hermanns and Franke 2014",
    sees: Sees::Screen,
    settings: |base| {
        let author = Setup { preset: Preset::Author, ..base };
        let volume = Setup { preset: Preset::Published, poster_filter: PosterFilter::Volume, ..base };
        [super::full_and_half(base), vec![author, volume]].concat()
    },
    create: |gpu, setup| Ok(Box::new(PosterMethod::new(gpu, setup)?)),
};

struct PosterMethod {
    filter: FilteredGBufferPass,
    march: ConeMarchPass,
    parameters: PosterBlock,
}

impl PosterMethod {
    fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        Ok(Self {
            filter: FilteredGBufferPass::new(gpu, setup.extent, setup.poster_filter)?,
            march: ConeMarchPass::new(gpu, setup.extent, setup.poster_filter, setup.split)?,
            parameters: parameters(setup),
        })
    }
}

fn parameters(setup: &Setup) -> PosterBlock {
    PosterBlock {
        // Printed.
        step_increase: 1.5,
        step_count: 100,
        search_count: 30,
        search_decrease: 0.5,
        // Not printed: the numbers of the author's later program, and of the thesis's Eq. 4.7. There the
        // first step and epsilon are of screen space; here parts of the screen and of the depth.
        first_step: setup.tuning.march_stride.unwrap_or(0.001),
        epsilon: 2e-4,
        fade_start: 0.8,
        fade_end: 1.0,
        edge_retries: match setup.preset {
            // The poster has nothing of a step that leaves the screen: a miss.
            Preset::Published => 0,
            // The later program steps back and halves the step.
            Preset::Author => 3,
        },
        fade: i32::from(setup.fade),
    }
}

impl Method for PosterMethod {
    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<Traced<'a>> {
        let filtered = self.filter.record(frame, &input.gbuffer, input.camera)?;
        let (reflection, hits) = self.march.record(frame, &input.gbuffer, filtered, input.camera, &self.parameters)?;
        let made = |name, content, image| Intermediate { name, content, image };
        let mut intermediates = vec![
            made("filtered-depth", Content::LinearDepth, filtered.depth),
            made("filtered-normal", Content::Normal, filtered.normal),
        ];
        // The colour's mip chain is the G-buffer's own, which is shown anyway.
        if !std::ptr::eq(filtered.color, input.gbuffer.color) {
            intermediates.push(made("filtered-color", Content::Color, filtered.color));
        }
        Ok(Traced { hits, intermediates, ..Traced::new(reflection) })
    }
}
