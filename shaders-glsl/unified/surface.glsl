// The colour that a ray sees where it hits on the screen: of the texels around the hit, those count that the ray can have seen. Needs
// the images `pyramid`, `normal_buffer` and `color_buffer`, and unified/traverse.glsl. CPU twin: reference::unified::surface.

#ifndef UNIFIED_SURFACE_GLSL
#define UNIFIED_SURFACE_GLSL

#include "captures/sky_along.glsl"
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

// The surface that reflects, its ray, and the pixel that the ray hit, in an image whose texels are so many pixels wide.
struct Seeing {
    vec3 point;     // of the surface, in ViewPoint's scale
    vec3 normal;    // of any length
    vec3 direction; // of the ray, of any length
    vec2 sizes;     // lengths of the normal and the direction
    float width;    // of a texel, at z = 1 in a perspective
    float own;      // depth of the pixel that was hit; that of EMPTY_BLOCK for sky
    bool is_its;    // that pixel shows the surface that reflects
};

float WidthAt(Seeing from, float z) {
    precise float width = from.width * (ORTHOGRAPHIC ? 1.0 : z);
    return width;
}

// Whether a place is nothing of the surface that reflects, nor of what is below it.
bool IsAbove(Seeing from, vec3 there) {
    precise vec3 away = there - from.point;
    precise float least = STANDS_ABOVE * WidthAt(from, there.z) * from.sizes.x;
    return Dot(from.normal, away) > least;
}

Seeing SeeingFrom(vec3 point, vec3 normal, vec3 direction, ivec2 pixel, float own, float texel) {
    precise vec2 sizes = vec2(sqrt(Dot(normal, normal)), sqrt(Dot(direction, direction)));
    precise float width = 2.0 * unified.pixel_to_view.y * texel;
    Seeing from = Seeing(point, normal, direction, sizes, width, own, false);
    from.is_its = own >= 0.0 && !IsAbove(from, ViewPoint(vec2(pixel) + 0.5, max(own, 0.0)));
    return from;
}

// Whether a ray can have seen what a pixel of a depth shows, in the middle of a texel. What stands before the hit and far beside the
// ray stands elsewhere in the reflection. What stands behind the hit is beside it there, too. If the pixel that was hit shows the
// surface that reflects, the ray has met what stands on that surface, and nothing behind it counts. The surface that reflects is
// never seen, nor what is below it. Sky lies behind all.
bool IsSeen(Seeing from, vec2 middle, float depth) {
    precise float apart = STANDS_BEFORE * from.width;
    apart = apart * (ORTHOGRAPHIC ? unified.depth_offset : from.own + unified.depth_offset);
    vec3 there = ViewPoint(middle, max(depth, 0.0));
    precise vec3 away = there - from.point;
    precise float beside = STANDS_BESIDE * WidthAt(from, there.z) * from.sizes.y;
    precise vec3 off = away.yzx * from.direction.zxy - away.zxy * from.direction.yzx;
    bool is_beside = Dot(off, off) > beside * beside;
    bool is_seen = from.own >= 0.0 && IsAbove(from, there) && !(depth > from.own + apart && is_beside);
    return (depth < 0.0 || is_seen) && !(from.is_its && depth < from.own - apart);
}

// Adds a texel to a weighted sum of colours. `a` is the part that is no sky.
void AddTexel(inout vec4 sum, inout float counted, vec4 seen, bool counts, float weight) {
    bool shows_sky = ShowsSky(seen);
    precise float share = counts ? weight : 0.0;
    precise vec4 added = share * (shows_sky ? vec4(0.0) : vec4(seen.rgb, 1.0));
    sum += added;
    counted += share;
}

// What the screen shows at a hit in full resolution.
struct Mirrored {
    vec3 color;  // lit, between the four pixels around it that count; that of the pixel that was hit where none does
    bool is_sky; // that pixel shows sky
};

// `along` is the sky along the ray, which sky and what shows it have: it is looked up once, since a device that takes both ways of
// a branch pays for every look. Loads stand before what they decide, so that the pixel that was hit is not loaded twice.
Mirrored MirroredAt(Hit hit, vec3 point, vec3 normal, vec3 direction, vec3 along) {
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
    Seeing from = SeeingFrom(point, normal, direction, hit.pixel, own, 1.0);
    precise vec4 sum = vec4(0.0);
    precise float counted = 0.0;
    vec4 own_color = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 here = clamp(ivec2(low) + next, ivec2(0), last);
        vec2 weight = mix(1.0 - part, part, vec2(next));
        vec4 seen = texelFetch(color_buffer, here, 0);
        AddTexel(sum, counted, seen, IsSeen(from, vec2(here) + 0.5, depths[i]), weight.x * weight.y);
        own_color = here == hit.pixel ? seen : own_color;
    }
    float whole = 1.0 / max(counted, 1e-6);
    vec3 between = Sound(sum.rgb * whole) + max(1.0 - sum.a * whole, 0.0) * along;
    vec3 alone = ShowsSky(own_color) ? along : Sound(own_color.rgb);
    return Mirrored(counted > 0.0 ? between : alone, own < 0.0);
}

#endif
