// What the passes of `unified` know of the camera and the image (src/methods/unified.rs).

layout(std140, binding = 0) uniform UnifiedBlock {
    vec2 view_to_clip;   // M_00 and M_11 of the projection
    vec2 pixel_to_clip;  // 1 / width and 1 / height: see ray.glsl
    vec2 pixel_to_view;  // the same, divided by view_to_clip
    ivec2 size;          // pixels
    ivec2 padded;        // pixels of the pyramid: whole cells of its coarsest level
    int top_level;       // the pyramid's coarsest level
    float depth_offset;  // near / (far - near), which is -M_22 with reversed depth
    float fade_start;    // I_start and I_end of Eq. 4.7
    float fade_end;
    int fade;            // 0: no fade at all
} unified;

layout(constant_id = 0) const int STRIP = 2;  // log2 of the columns to a strip of the pyramid's image (pyramid.glsl)
layout(constant_id = 1) const int ORACLE = 1; // which version of it says what is hit
layout(constant_id = 2) const int OVER = 0;   // 1: another reflection shows where this one misses

// "A pixel reflects if its reflectivity exceeds 1e-4" (DEFINITIONS, "Surfaces").
#define REFLECTS_ABOVE 1e-4
