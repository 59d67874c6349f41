// The colour of the surface that a ray has hit in an image: of the texels around the hit, those count that show this
// surface. Needs the images `pyramid` and `normal_buffer`, and unified/traverse.glsl. CPU twin: reference::unified::surface.

#ifndef UNIFIED_SURFACE_GLSL
#define UNIFIED_SURFACE_GLSL

#include "unified/traverse.glsl"

#ifndef COLOR_AT
#define COLOR_AT(pixel) texelFetch(color_buffer, pixel, 0)
#endif

// By how much depth may be rounded: a rasteriser interpolates it between corners that may lie at the near plane, where it is 1.
const float DEPTH_ERROR = 4.0 * ROUNDING;

// The plane in which a pixel's surface lies. Depth plus k is proportional to 1 / z, so that depth is linear on it over the
// image; if rays of sight are parallel, depth itself is linear in z.
struct Plane {
    vec2 pixel;
    float depth; // reversed, in the middle of the pixel; that of EMPTY_BLOCK for sky
    vec2 slope;  // what it changes by with each pixel to the right, and with each pixel down
    float off;   // by so much the depth of another pixel may differ from the plane's for each texel's width
    vec3 normal; // of the pixel, of any length
    float squared; // its squared length, times that of SAME_NORMAL
};

// `depth` is the pixel's own.
Plane PlaneOf(ivec2 pixel, float depth) {
    vec3 normal = NORMAL_AT(pixel);
    vec3 sight = ViewRay(vec2(pixel) + 0.5);
    precise float size = sqrt(Dot(normal, normal) * Dot(sight, sight));
    float facing = Dot(normal, sight);
    float least = LEAST_FACING * size;
    facing = facing < 0.0 ? min(facing, -least) : max(facing, least);
    precise float scale = ORTHOGRAPHIC ? unified.depth_offset : depth + unified.depth_offset;
    precise float rate = scale / facing;
    precise vec2 slope = rate * (2.0 * unified.pixel_to_view * vec2(normal.x, -normal.y));
    precise float off = abs(rate) * (size * (IN_PLANE * 2.0 * unified.pixel_to_view.y));
    precise float squared = (SAME_NORMAL * SAME_NORMAL) * Dot(normal, normal);
    return Plane(vec2(pixel), depth, slope, off, normal, squared);
}

// Whether a pixel of a depth shows the surface of a plane, within a share of a texel that is so many pixels wide. A pixel without a normal has no plane, and all that is not sky counts as its
// surface.
bool IsOn(Plane plane, ivec2 pixel, float depth, float texel) {
    precise vec2 across = plane.slope * (vec2(pixel) - plane.pixel);
    precise float apart = (depth - plane.depth) - (across.x + across.y);
    vec3 normal = NORMAL_AT(pixel);
    float along = Dot(plane.normal, normal);
    precise float turned = along * along - plane.squared * Dot(normal, normal);
    bool is_other = abs(apart) > plane.off * texel + DEPTH_ERROR || along < 0.0 || turned < 0.0;
    return plane.depth < 0.0 ? depth < 0.0 : depth >= 0.0 && !is_other;
}

// Adds a texel to a weighted sum of colours if the pixel in its middle shows the surface. `a` is the part that is no sky.
void AddTexel(inout vec4 sum, inout float counted, vec4 seen, bool counts, float weight) {
    bool shows_sky = unified.sky != 0 && seen.a == 0.0;
    precise float share = counts ? weight : 0.0;
    precise vec4 added = share * (shows_sky ? vec4(0.0) : vec4(seen.rgb, 1.0));
    sum += added;
    counted += share;
}

// What the screen shows at a hit in full resolution.
struct Mirrored {
    vec3 color;   // lit, between the four pixels around it that show the surface of the pixel that was hit, which is one of them
    bool is_sky;  // that pixel shows sky
};

// `along` is the sky along the ray, which sky and what shows it have: it is looked up once, since a device that takes both ways of
// a branch pays for every look. Loads stand before what they decide, so that the pixel that was hit is not loaded twice.
Mirrored MirroredAt(Hit hit, vec3 along) {
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
    Plane plane = PlaneOf(hit.pixel, own);
    precise vec4 sum = vec4(0.0);
    precise float counted = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 here = clamp(ivec2(low) + next, ivec2(0), last);
        vec2 weight = mix(1.0 - part, part, vec2(next));
        AddTexel(sum, counted, COLOR_AT(here), IsOn(plane, here, depths[i], 1.0), weight.x * weight.y);
    }
    float whole = 1.0 / counted;
    return Mirrored(Sound(sum.rgb * whole) + max(1.0 - sum.a * whole, 0.0) * along, own < 0.0);
}

#endif
