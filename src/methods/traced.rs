//! `traced`: compute shaders follow every ray of every reflecting pixel through a tree over the triangles of the scene. Mirrors
//! have one ray each, and lobes have the rays that `unified` shares among neighbours. No ray walks over the screen. A renderer with
//! ray tracing would do the same, and screen-space methods are compared with this baseline.

use super::MethodInfo;
use super::unified::UnifiedMethod;

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    takes_triangles: true,
    takes_orthographic: true,
    ..MethodInfo::scene("traced", "every ray followed through the scene's triangles", "this project", |gpu, request| {
        Ok(Box::new(UnifiedMethod::among_triangles(gpu, request)?))
    })
};
