//! `traced`: every ray of every reflecting pixel followed through the triangles of the scene, by a tree in compute shaders:
//! mirrors by their one ray, lobes by the rays that `unified` shares among neighbours. No ray walks over the screen. It is
//! what a renderer with ray tracing would do, and the baseline that screen-space methods are held against.

use super::MethodInfo;
use super::unified::UnifiedMethod;

/// The table's row.
pub const INFO: MethodInfo = MethodInfo {
    takes_triangles: true,
    takes_orthographic: true,
    ..MethodInfo::scene("traced", "every ray followed through the scene's triangles", "this project", |gpu, request| {
        Ok(Box::new(UnifiedMethod::among_triangles(gpu, request)?))
    })
};
