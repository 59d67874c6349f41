//! Keeps the triangles of a scene in device memory: a tree of the meshes at rest, and a small tree of those that move.

use super::{DrawingCost, SceneData};
use crate::error::Result;
use crate::gpu::{Frame, FrameContext, RayStructure};
use crate::passes::triangle_scene::{TriangleGeometry, TriangleImages, TriangleReading};
use ssct_ground::scene::Placement;
use ssct_ground::scene::tree::BuildTrees;
use std::time::Instant;

impl SceneData {
    /// Sets the builder of the trees over the scene's triangles. The tree of standing meshes is built when an effect
    /// first follows rays among triangles, and when a mesh moves for the first time; the tree of moving meshes, after
    /// each move. Without a builder no effect can follow such rays.
    pub fn set_tree_builder(&mut self, trees: impl BuildTrees + 'static) {
        self.trees = Some(Box::new(trees));
        self.triangle_geometry.take();
        self.ray_structure.take();
    }

    /// Sets whether shaders read the triangles as storage blocks even if the device could read them as texels.
    pub fn read_triangles_as_blocks(&mut self, as_blocks: bool) {
        self.triangles_as_blocks = as_blocks;
    }

    /// Makes the scene's triangles ready where its meshes stand now, and returns how shaders read them; `None` without
    /// a builder of trees. With `queries`, makes the structure for ray queries, too. Call this function before each
    /// frame that follows rays among triangles; the call costs nothing unless a mesh has moved.
    ///
    /// # Errors
    /// Errors of building the tree, [`Usage`](crate::error::Error::Usage) for ray queries on a device that has none, and
    /// [`Memory`](crate::error::Error::Memory) without memory.
    pub fn prepare_triangles(&self, context: &mut FrameContext, queries: bool) -> Result<Option<TriangleReading>> {
        let Some(trees) = &self.trees else { return Ok(None) };
        if queries {
            context.gpu().ray_queries()?;
        }
        self.prepare_trees(context, trees.as_ref())?;
        if let (true, None, Some((geometry, _))) = (queries, self.ray_structure.get(), self.triangle_geometry.get()) {
            // The structure is built from the triangles on the device, so that moved triangles are copied there first.
            context.once(|frame| geometry.copy_moving(frame))?;
            let structure = DrawingCost::measure(context, |context| geometry.build_structure(context))?;
            self.ray_structure.get_or_init(|| structure);
        }
        if self.triangle_images.get().is_none() {
            let textures: Vec<_> = self.textures.iter().zip(self.encodings.iter().copied()).collect();
            let images = DrawingCost::measure(context, |context| TriangleImages::new(context, &textures))?;
            self.triangle_images.get_or_init(|| images);
        }
        Ok(self.triangles().map(|(geometry, images)| {
            let reading = geometry.reading(images, self.lights.len() as u32);
            let allows_texels = !self.triangles_as_blocks;
            TriangleReading {
                geometry_texels: reading.geometry_texels && allows_texels,
                image_texels: reading.image_texels && allows_texels,
                queries,
                ..reading
            }
        }))
    }

    /// Builds the trees of standing and of moving meshes if there are none, or else that of meshes that have moved.
    fn prepare_trees(&self, context: &mut FrameContext, trees: &dyn BuildTrees) -> Result<()> {
        let placement = |name: &str| self.meshes.iter().find(|mesh| mesh.name == name).map(|mesh| mesh.placement);
        let placed: Vec<(&str, Placement)> =
            self.moving_names.iter().map(|name| (name.as_str(), placement(name).unwrap_or_default())).collect();
        match self.triangle_geometry.get() {
            None => {
                let names: Vec<&str> = placed.iter().map(|(name, _)| *name).collect();
                let geometry = DrawingCost::measure(context, |context| {
                    let (tree, records) = trees.standing(&names)?;
                    TriangleGeometry::new(context, (&tree, &records), &trees.moving(&placed)?)
                })?;
                self.triangle_geometry.get_or_init(|| geometry);
            }
            Some((geometry, _)) if self.has_moved.get() => {
                let begun = Instant::now();
                geometry.update(context.gpu(), &trees.moving(&placed)?)?;
                self.moving_ms.set(Some(1e3 * begun.elapsed().as_secs_f64()));
            }
            Some(_) => {}
        }
        self.has_moved.set(false);
        Ok(())
    }

    /// Copies the moving triangles that [`Self::prepare_triangles`] has built to the device in the pass "moving", and
    /// reports the time of building them as the host's pass "moving/tree". Records nothing if nothing has moved.
    pub fn copy_moving(&self, frame: &mut Frame) -> Result<()> {
        let Some((geometry, _)) = self.triangle_geometry.get() else { return Ok(()) };
        if let Some(ms) = self.moving_ms.take() {
            frame.note_host_work("moving/tree", ms);
        }
        geometry.copy_moving(frame)
    }

    /// The triangles that [`Self::prepare_triangles`] made ready; `None` before that, and after a mesh's first move.
    pub fn triangles(&self) -> Option<(&TriangleGeometry, &TriangleImages)> {
        let ((geometry, _), (images, _)) = self.triangle_geometry.get().zip(self.triangle_images.get())?;
        Some((geometry, images))
    }

    /// Returns the cost of each part of the triangles that [`Self::prepare_triangles`] made ready. The structure for ray
    /// queries is a part if `queries` is true.
    pub(crate) fn triangle_costs(&self, queries: bool) -> impl Iterator<Item = DrawingCost> {
        let structure = self.ray_structure.get().filter(|_| queries).map(|(_, cost)| *cost);
        let geometry = self.triangle_geometry.get().map(|(_, cost)| *cost);
        [structure, geometry, self.triangle_images.get().map(|(_, cost)| *cost)].into_iter().flatten()
    }

    /// The structure for ray queries of [`Self::prepare_triangles`]; `None` before that, and after a mesh has moved.
    pub fn ray_structure(&self) -> Option<&RayStructure> {
        self.ray_structure.get().map(|(structure, _)| structure)
    }
}
