// The side of a surface that a fragment shows.

#ifndef SCENE_SIDE_GLSL
#define SCENE_SIDE_GLSL

// Whether a surface is seen from behind. A mirrored view reverses the winding of triangles.
bool IsSeenFromBehind() {
    bool mirrored = determinant(mat3(camera.world_to_view)) < 0.0;
    return gl_FrontFacing == mirrored;
}

// Whether a single-sided surface is seen from behind, so that nothing of it shows.
bool IsInvisibleBack(bool is_behind) {
    return is_behind && (draw.maps & SINGLE_SIDED) != 0u;
}

#endif
