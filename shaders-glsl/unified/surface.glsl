// The colour that a ray sees where it hits on the screen: of the texels around the hit, those count that the ray can have seen. Needs
// the images `pyramid`, `normal_buffer` and `color_buffer`, and unified/traverse.glsl. CPU twin: reference::unified::surface.

#ifndef UNIFIED_SURFACE_GLSL
#define UNIFIED_SURFACE_GLSL

#include "unified/traverse.glsl"

// Whether a ray that hit nothing went beyond the far plane, where no other image is asked; where it did so then stands in `hit`.
// If the screen shows sky there, it is the colour of the ray.
bool GoesFar(Ray ray, inout Hit hit) {
    precise vec2 place = ray.start + ray.end * ray.rate.xy;
    place = clamp(place, vec2(0.0), vec2(unified.size));
    ivec2 side = ivec2(greaterThan(ray.inverse, vec2(0.0))) * unified.size;
    precise vec2 sides = (vec2(side) - ray.start) * ray.inverse;
    bool is_far = !FOLLOWED && hit.code == PATH_MISS && ray.rate.z < 0.0 && ray.end < min(sides.x, sides.y);
    hit.pixel = is_far ? min(ivec2(place), unified.size - 1) : hit.pixel;
    hit.position = is_far ? place : hit.position;
    return is_far;
}

// The surface that reflects, and the pixel that its ray hit.
struct Seeing {
    vec3 point;  // of the surface, in ViewPoint's scale
    vec3 normal; // of any length
    float size;  // its length
    float own;   // depth of the pixel that was hit; that of EMPTY_BLOCK for sky
};

Seeing SeeingFrom(vec3 point, vec3 normal, float own) {
    precise float size = sqrt(Dot(normal, normal));
    return Seeing(point, normal, size, own);
}

// Whether a ray can have seen what a pixel of a depth shows, in the middle of a texel that is so many pixels wide. On the screen something
// may stand before what was hit, and beside it, that does not in the reflection; what stands behind it is beside it there, too. And
// nothing of the surface that reflects is seen, or of what is below it. Sky lies behind all.
bool IsSeen(Seeing from, vec2 middle, float depth, float texel) {
    precise float width = 2.0 * unified.pixel_to_view.y * texel;
    precise float before = STANDS_BEFORE * width;
    precise float nearest = ORTHOGRAPHIC ? from.own + before * unified.depth_offset
                                         : from.own + (from.own + unified.depth_offset) * before;
    vec3 there = ViewPoint(middle, max(depth, 0.0));
    precise vec3 away = there - from.point;
    precise float least = STANDS_ABOVE * width * (ORTHOGRAPHIC ? 1.0 : there.z) * from.size;
    bool is_before = depth > nearest, is_above = Dot(from.normal, away) > least;
    return depth < 0.0 || (from.own >= 0.0 && !is_before && is_above);
}

// Adds a texel to a weighted sum of colours. `a` is the part that is no sky.
void AddTexel(inout vec4 sum, inout float counted, vec4 seen, bool counts, float weight) {
    bool shows_sky = unified.sky != 0 && seen.a == 0.0;
    precise float share = counts ? weight : 0.0;
    precise vec4 added = share * (shows_sky ? vec4(0.0) : vec4(seen.rgb, 1.0));
    sum += added;
    counted += share;
}

// What the screen shows at a hit in full resolution.
struct Mirrored {
    vec3 color;  // lit, between the four pixels around it that count; that which was hit is one of them, and counts
    bool is_sky; // that pixel shows sky
};

// `along` is the sky along the ray, which sky and what shows it have: it is looked up once, since a device that takes both ways of
// a branch pays for every look. Loads stand before what they decide, so that the pixel that was hit is not loaded twice.
Mirrored MirroredAt(Hit hit, vec3 point, vec3 normal, vec3 along) {
    precise vec2 from_middle = hit.position - 0.5;
    vec2 low = floor(from_middle), part = from_middle - low;
    ivec2 last = unified.size - 1;
    float depths[4];
    float own = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 here = clamp(ivec2(low) + ivec2(i & 1, i >> 1), ivec2(0), last);
        depths[i] = BLOCK_AT(PixelTexel(here)).x;
        own = here == hit.pixel ? depths[i] : own;
    }
    Seeing from = SeeingFrom(point, normal, own);
    precise vec4 sum = vec4(0.0);
    precise float counted = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 here = clamp(ivec2(low) + next, ivec2(0), last);
        vec2 weight = mix(1.0 - part, part, vec2(next));
        bool counts = here == hit.pixel || IsSeen(from, vec2(here) + 0.5, depths[i], 1.0);
        AddTexel(sum, counted, texelFetch(color_buffer, here, 0), counts, weight.x * weight.y);
    }
    float whole = 1.0 / counted;
    return Mirrored(Sound(sum.rgb * whole) + max(1.0 - sum.a * whole, 0.0) * along, own < 0.0);
}

#endif
