// Takes the lit colour of a hit on a triangle from the screen where the screen shows the hit's place. A renderer may
// light its screen in its own way, and give no more of its triangles than their colour. Its reflections then show what
// its screen shows.

#ifndef TRIANGLES_SCREEN_COLOR_GLSL
#define TRIANGLES_SCREEN_COLOR_GLSL

#include "captures/captures.glsl"
#include "triangles/walk.glsl"

layout(constant_id = 25) const bool SCREEN_COLORS = false; // colours come from the screen where it shows the hit

layout(binding = 14) uniform sampler2D screen_color; // lit colour, linear, with its coarser levels; alpha is 0 where sky is
layout(binding = 15) uniform sampler2D screen_depth; // reversed; 0 is sky

// Sums are `precise`, so that fragment and compute programs get the same colour.

// The continuous pixel coordinates at which a view-space point is seen.
vec2 ProjectToScreen(vec3 view) {
    precise vec2 off_axis = ORTHOGRAPHIC ? view.xy : view.xy / view.z;
    precise vec2 centred = off_axis / unified.pixel_to_view + unified.shift;
    precise vec2 doubled = vec2(float(unified.size.x) + centred.x, float(unified.size.y) - centred.y);
    return 0.5 * doubled;
}

// Looks up the screen's colour at a hit, over a footprint that measures `width` metres across the ray there. The colour
// lies between the four texels around the place, in the level whose texels are nearest to the footprint in size. A
// texel counts if the pixel in its middle lies in the plane of the triangle, and if no sky is part of the texel. False
// if no texel counts, or if the screen shows the other side of the triangle.
bool SampleScreenColor(TreeRay ray, TriangleHit hit, float width, out vec3 color) {
    color = vec3(0.0);
    int corner = triangles.corners + 3 * int(Attribute(hit.id & ~ASKS_MATERIAL, 2).w);
    vec3 a = uintBitsToFloat(Geometry(corner).xyz);
    precise vec3 along_b = uintBitsToFloat(Geometry(corner + 1).xyz) - a;
    precise vec3 along_c = uintBitsToFloat(Geometry(corner + 2).xyz) - a;
    vec3 flat_normal = CrossInOrder(along_b, along_c);
    precise vec3 place = ray.origin + hit.t * ray.direction - triangles.eye;
    vec3 view = ToView(place);
    vec3 normal = ToView(flat_normal * inversesqrt(max(DotInOrder(flat_normal, flat_normal), 1e-38)));
    vec3 sight = ViewDirection(view);
    float facing = DotInOrder(normal, sight) * inversesqrt(max(DotInOrder(sight, sight), 1e-38));
    vec2 position = ProjectToScreen(view);
    bool inside = view.z > 0.0 && all(greaterThanEqual(position, vec2(0.0))) && all(lessThan(position, vec2(unified.size)));
    if (!inside || facing * DotInOrder(flat_normal, ray.direction) <= 0.0)
        return false;

    // The footprint stretches along the surface by the slant of the ray, and shrinks on the screen by the slant of the
    // line of sight.
    float pixel_width = 2.0 * unified.pixel_to_view.y * (ORTHOGRAPHIC ? 1.0 : view.z);
    float stretch = max(abs(facing), LEAST_FACING) / max(abs(hit.side), LEAST_FACING);
    float footprint_px = max(width / pixel_width * sqrt(stretch), 1.0);
    int level = int(min(log2(footprint_px) + 0.5, float(textureQueryLevels(screen_color) - 1)));
    // Some drivers take textureSize of one thread's level for all threads around it.
    ivec2 texels = max(unified.size >> level, ivec2(1));
    vec2 to_texels = vec2(texels) / vec2(unified.size);
    precise vec2 from_middle = position * to_texels - 0.5;
    vec2 first_texel = floor(from_middle), part = from_middle - first_texel;
    // A pixel's point may also lie beside its surface, as in begin.glsl.
    float point_error = triangles.beside * (ORTHOGRAPHIC ? captures.view_unit : sqrt(DotInOrder(view, view)));
    float tolerance = (SAME_SURFACE * pixel_width * exp2(float(level)) + point_error) / max(abs(facing), LEAST_FACING);
    precise vec3 sum = vec3(0.0);
    precise float counted_weight = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 texel = clamp(ivec2(first_texel) + next, ivec2(0), texels - 1);
        ivec2 middle_pixel = min(ivec2((vec2(texel) + 0.5) / to_texels), unified.size - 1);
        float depth = texelFetch(screen_depth, middle_pixel, 0).r;
        vec2 middle = vec2(middle_pixel) + 0.5;
        // The distance along the pixel's own ray, from the plane of the triangle to the surface that the pixel shows.
        vec3 seen = ViewPoint(middle, depth) * captures.view_unit;
        vec3 along = ORTHOGRAPHIC ? vec3(0.0, 0.0, 1.0) : ViewRay(middle);
        precise vec3 offset = seen - view;
        float plane_distance = DotInOrder(normal, offset) / DotInOrder(normal, along);
        vec4 screen_texel = texelFetch(screen_color, texel, level);
        vec2 weight = vec2(next.x == 0 ? 1.0 - part.x : part.x, next.y == 0 ? 1.0 - part.y : part.y);
        bool counts = depth > 0.0 && abs(plane_distance) < tolerance && screen_texel.a > 0.999;
        float share = counts ? weight.x * weight.y : 0.0;
        sum += counts ? share * screen_texel.rgb : vec3(0.0);
        counted_weight += share;
    }
    color = sum / max(counted_weight, 1e-6);
    return counted_weight > 0.0;
}

#endif
