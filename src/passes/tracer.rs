//! Rays among a scene's triangles by either tracer: a walk through the tree, which every device can do, or ray queries, for which
//! the device itself finds the nearest triangle. The programs of both tracers differ in nothing else.

use super::tiles::{TiledCompute, Tiles};
use crate::error::{Error, Result};
use crate::gpu::program::Compute;
use crate::gpu::shader::UnifiedBlock;
use crate::gpu::{Buffer, ComputePipeline, Frame};

/// A value for the program with the tree, or its counterpart for the program with ray queries.
pub enum ByTracer<T, Q> {
    /// Walks through the tree.
    Tree(T),
    /// Asks ray queries.
    Query(Q),
}

/// Makes the program of a tracer, with its bindings of a scene's triangles filled in: the program with ray queries if the triangles
/// have a structure for them.
macro_rules! by_tracer {
    ($tree:ident or $query:ident of $triangle_bindings:expr, $($field:ident: $value:expr),+ $(,)?) => {{
        let triangle_bindings: $crate::passes::triangle_scene::TriangleBindings = $triangle_bindings;
        match triangle_bindings.triangles.structure {
            None => $crate::passes::tracer::ByTracer::Tree(
                $crate::passes::triangle_scene::with_triangles! { $tree of triangle_bindings, $($field: $value),+ },
            ),
            Some(ray_structure) => $crate::passes::tracer::ByTracer::Query(
                $crate::passes::triangle_scene::with_triangles! { $query of triangle_bindings,
                    ray_structure: ray_structure, $($field: $value),+
                },
            ),
        }
    }};
}
pub(super) use by_tracer;

impl<T: Compute, Q: Compute> ByTracer<TiledCompute<T>, TiledCompute<Q>> {
    /// Records one pass over a list's tiles, or over the whole image.
    pub fn run(
        &self,
        frame: &mut Frame,
        name: &str,
        over: (&UnifiedBlock, Tiles),
        program: &ByTracer<T, Q>,
    ) -> Result<()> {
        match (self, program) {
            (Self::Tree(pipelines), ByTracer::Tree(program)) => pipelines.run(frame, name, over, program),
            (Self::Query(pipelines), ByTracer::Query(program)) => pipelines.run(frame, name, over, program),
            _ => Err(other_tracer()),
        }
    }
}

impl<T: Compute, Q: Compute> ByTracer<ComputePipeline<T>, ComputePipeline<Q>> {
    /// Records one pass over as many workgroups as a buffer says.
    pub fn follow(&self, frame: &mut Frame, name: &str, program: &ByTracer<T, Q>, counts: &Buffer) -> Result<()> {
        match (self, program) {
            (Self::Tree(pipeline), ByTracer::Tree(program)) => {
                frame.compute_indirect(name, pipeline, program, (counts, 0))
            }
            (Self::Query(pipeline), ByTracer::Query(program)) => {
                frame.compute_indirect(name, pipeline, program, (counts, 0))
            }
            _ => Err(other_tracer()),
        }
    }
}

fn other_tracer() -> Error {
    Error::Usage("the triangles are ready for one tracer, and this method was made for the other".into())
}
