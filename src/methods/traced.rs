//! `traced`: compute shaders trace every ray of every reflecting pixel against the triangles of the scene. Mirrors have
//! one ray each, and lobes have the rays that `unified` shares among neighbours. No ray walks over the screen. This is
//! what a renderer with ray tracing would do, a baseline for screen-space methods.

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
