// Finds the triangle that stops a ray by a ray query of the device instead of a walk through the tree. The device
// proposes triangles; the shader decides, as in the walk, whether the ray meets each of them and is stopped by it. So
// query and walk end rays alike, except where two triangles are equally near within rounding.

#ifndef TRIANGLES_QUERY_GLSL
#define TRIANGLES_QUERY_GLSL

layout(binding = 31) uniform accelerationStructureEXT ray_structure; // built over the corners in geometry, in their order

// The nearest triangle that stops the ray.
TriangleHit ClosestHit(TreeRay ray) {
    TriangleHit best = NO_HIT;
    // The ray of a query must be finite. In a walk, a ray that is not finite meets no box either.
    float magnitude = dot(abs(ray.origin), vec3(1.0)) + dot(abs(ray.direction), vec3(1.0));
    if (!(magnitude < NEVER))
        return best;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, ray_structure, gl_RayFlagsNoOpaqueEXT, 0xffu, ray.origin, 0.0, ray.direction, NEVER);
    while (rayQueryProceedEXT(query)) {
        TriangleHit hit = best;
        UpdateNearestHit(ray, rayQueryGetIntersectionPrimitiveIndexEXT(query, false), hit);
        bool asks_material = ASKS && (hit.id & ASKS_MATERIAL) != 0u;
        if (hit.id != best.id && (!asks_material || StopsRay(hit))) {
            best = hit;
            rayQueryConfirmIntersectionEXT(query);
        }
    }
    return best;
}

#endif
