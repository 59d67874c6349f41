//! `planar`: a mirrored camera draws the scene once more for each mirror (thesis §3.1.2), inside a stencil or into a
//! render target. The mirrors are planes found in the scene: the coplanar reflecting triangles that cover most of the
//! screen, hidden or not. Since each plane costs another drawing of the scene, few planes are used.
//!
//! The reflection is that of a perfect mirror, whatever the roughness and the normal map say: the mirrored matrix "does
//! not allow any distortions". Mirrors in the mirror don't reflect. A pixel where the mirrored camera sees nothing is a
//! miss. The stencil saves shading outside the mirror, but no work on vertices, and lighting runs over the whole image.

use super::needs::Need;
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, SceneInput, Setup};
use crate::error::Result;
use crate::gpu::{Frame, FrameContext, Gpu};
use crate::passes::Content;
use crate::passes::gbuffer::{DEPTH_STENCIL, GBufferPass};
use crate::passes::lighting::LightingPass;
use crate::passes::planar::{MAX_PLANES, MirrorDrawing, PlanarPass};
use glam::Vec4;
use ssct_ground::math::frustum::projected_area;
use ssct_ground::parameter::{Parameter, Parameters, Preset, parameters};
use ssct_ground::scene::planes::{CoplanarGroup, merged};
use ssct_ground::scene::{Camera, GBufferData};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    needs: &[Need::Planes],
    parameters: PlanarParams::table,
    ..MethodInfo::scene("planar", "mirrored camera for the largest planes", "Hermanns 2015, §3.1.2", |gpu, request| {
        Ok(Box::new(PlanarMethod::new(gpu, &request.setup)?))
    })
};

parameters! {
    /// Parameters of `planar`.
    pub struct PlanarParams {
        /// How planar gets its mirrored scene: inside the stencil, or as a render target.
        planar_variant: MirrorDrawing = Parameter::new(MirrorDrawing::Stencil)
            .sweep(Preset::Published, &[MirrorDrawing::Target])
            .source("Hermanns 2015, §3.1.2"),
        /// Planes that planar mirrors the scene at: those that cover most of the screen.
        planar_planes: u32 = Parameter::new(1)
            .within(1, MAX_PLANES)
            .sweep(Preset::Published, &[2, 4])
            .source("Hermanns 2015, §3.1.2: one mirror"),
    }
}

/// Number of planes, the largest of the scene, that are considered in every frame.
const CANDIDATES: usize = 64;
/// Distance from a plane, in metres, below which the camera sees the plane edge on.
const EDGE_ON_M: f32 = 1e-3;
/// Share of the screen below which a plane is not worth another drawing of the scene.
const AREA_MIN: f32 = 1e-4;

/// The passes, and the planes that reflect with the present materials.
struct PlanarMethod {
    scene: GBufferPass,
    lighting: LightingPass,
    planar: PlanarPass,
    parameters: PlanarParams,
    candidates: Vec<CoplanarGroup>,
}

impl PlanarMethod {
    fn new(gpu: &Gpu, setup: &Setup) -> Result<Self> {
        let parameters: PlanarParams = setup.parameters();
        let scene = match parameters.planar_variant {
            MirrorDrawing::Stencil => GBufferPass::where_marked(gpu, setup.extent)?,
            MirrorDrawing::Target => GBufferPass::new(gpu, setup.extent)?,
        };
        Ok(Self {
            scene: scene.labelled("mirrored g-buffer"),
            lighting: LightingPass::in_stage(gpu, setup.stage())?.labelled("mirrored lighting"),
            planar: PlanarPass::new(gpu, setup.stage(), setup.extent, DEPTH_STENCIL)?,
            parameters,
            candidates: Vec::new(),
        })
    }

    /// Returns the planes that cover most of the screen, the largest first: unit normal and offset in world space.
    fn planes(&self, camera: &Camera) -> Vec<Vec4> {
        let world_to_clip = camera.view_to_clip() * camera.world_to_view;
        let eye = camera.eye();
        let mut planes_by_area: Vec<(f32, Vec4)> = self
            .candidates
            .iter()
            .filter(|group| group.plane.truncate().dot(eye) + group.plane.w > EDGE_ON_M)
            .map(|group| (group.triangles.iter().map(|t| projected_area(&world_to_clip, t)).sum(), group.plane))
            .filter(|(area, _)| *area >= AREA_MIN)
            .collect();
        planes_by_area.sort_by(|(area, _), (other_area, _)| other_area.total_cmp(area));
        planes_by_area.truncate(self.parameters.planar_planes as usize);
        planes_by_area.into_iter().map(|(_, plane)| plane).collect()
    }
}

impl Method for PlanarMethod {
    fn prepare(&mut self, _context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        let reflects = |g: &&CoplanarGroup| scene.materials[g.material].reflectivity > GBufferData::REFLECTS_ABOVE;
        self.candidates = merged(scene.data.coplanar_groups().iter().filter(reflects), CANDIDATES);
        Ok(())
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let (gbuffer, camera, scene) = (&input.gbuffer, input.camera, input.scene()?);
        let mirrored = self.scene.gbuffer();
        self.planar.record_clear(frame)?;
        let planes = self.planes(camera);
        for &plane in &planes {
            let mirrored_camera = camera.mirrored(plane);
            if self.parameters.planar_variant == MirrorDrawing::Stencil {
                self.planar.record_mark(frame, gbuffer, camera, plane, mirrored.depth)?;
            }
            self.scene.record(frame, scene.data, scene.materials, &mirrored_camera)?;
            self.lighting.record(frame, &mirrored, self.scene.albedo(), scene.data, &mirrored_camera)?;
            match self.parameters.planar_variant {
                MirrorDrawing::Stencil => self.planar.record_copy(frame, &mirrored)?,
                MirrorDrawing::Target => self.planar.record_lookup(frame, gbuffer, camera, plane, &mirrored)?,
            }
        }
        let intermediate = |name, content, image| Intermediate { name, content, image };
        // The images of the last plane, if there was a plane.
        let intermediates = if planes.is_empty() {
            Vec::new()
        } else {
            vec![
                intermediate("mirrored-albedo", Content::Color, self.scene.albedo()),
                intermediate("mirrored-normal", Content::Normal, mirrored.normal),
            ]
        };
        Ok(MethodOutput { intermediates, ..MethodOutput::new(self.planar.reflection()) })
    }
}
