// The colour that the screen shows at a hit, in full resolution. For a mirror's ray it is interpolated between the
// pixels, of the four around the hit, that the ray can have seen. For a ray of a lobe it is that of the pixel that was
// hit. Needs the image `pyramid`. CPU twin of LoadHitPixel: reference::unified::gloss. For mirrors, the screen
// reference has its own code.

#ifndef UNIFIED_MIRRORED_GLSL
#define UNIFIED_MIRRORED_GLSL

#include "captures/sky_along.glsl"
#include "unified/lit_color.glsl"
#include "unified/trace/surface.glsl"

// Adds a texel to a weighted sum of colours, if it counts. `sum.a` is the weight of texels that are no sky, and
// `counted` the weight of all that count.
void AddTexel(inout vec4 sum, inout float counted, vec4 seen, bool counts, float weight) {
    bool shows_sky = ShowsSky(seen);
    precise float share = counts ? weight : 0.0;
    precise vec4 added = share * (shows_sky ? vec4(0.0) : vec4(seen.rgb, 1.0));
    sum += added;
    counted += share;
}

struct ScreenHitColor {
    vec3 color;        // lit colour between the four pixels around the hit that count; if none counts, that of the pixel that was hit
    bool is_sky;       // the pixel that was hit shows sky
};

// Samples the screen's colour around a mirror ray's hit. `point` and `normal` are those of the surface that reflects.
// `sky_color` is the sky along the ray, the colour of pixels that show sky; it is looked up once, since a device that
// executes both sides of a branch pays for every look-up. Pixels are loaded before it is decided which of them count,
// so that the pixel that was hit is not loaded twice.
ScreenHitColor SampleScreenHit(Hit hit, vec3 point, vec3 normal, vec3 direction, vec3 sky_color) {
    precise vec2 from_middle = hit.position - 0.5;
    vec2 first_pixel = floor(from_middle), part = from_middle - first_pixel;
    ivec2 last = unified.size - 1;
    float depths[4];
    float hit_depth = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 pixel = clamp(ivec2(first_pixel) + ivec2(i & 1, i >> 1), ivec2(0), last);
        depths[i] = BLOCK_AT(PixelTexel(pixel)).x;
        hit_depth = pixel == hit.pixel ? depths[i] : hit_depth;
    }
    VisibilityTest test = MakeVisibilityTest(point, normal, direction, hit.pixel, hit_depth);
    precise vec4 sum = vec4(0.0);
    precise float counted = 0.0;
    vec4 hit_color = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 pixel = clamp(ivec2(first_pixel) + next, ivec2(0), last);
        vec2 weight = mix(1.0 - part, part, vec2(next));
        vec4 seen = ScreenColor(pixel);
        AddTexel(sum, counted, seen, IsVisibleAlongRay(test, vec2(pixel) + 0.5, depths[i]), weight.x * weight.y);
        hit_color = pixel == hit.pixel ? seen : hit_color;
    }
    float inverse_weight = 1.0 / max(counted, 1e-6);
    vec3 interpolated = Sound(sum.rgb * inverse_weight) + max(1.0 - sum.a * inverse_weight, 0.0) * sky_color;
    vec3 hit_pixel_color = ShowsSky(hit_color) ? sky_color : Sound(hit_color.rgb);
    return ScreenHitColor(counted > 0.0 ? interpolated : hit_pixel_color, hit_depth < 0.0);
}

// The pixel that a ray of a lobe hit.
struct HitPixel {
    vec3 color;        // lit colour of the pixel that was hit
    bool is_sky;       // the pixel shows sky
    bool is_reflector; // the pixel shows the surface that reflects
};

// Loads what the pixel shows that a lobe's ray hit. A mean of nine rays or more hides the edges of single pixels, so
// that this pixel stands for the four pixels around the hit, and no other surface takes part in the colour. `sky_color`
// is the sky along the ray.
HitPixel LoadHitPixel(ivec2 pixel, vec3 point, vec3 normal, vec3 sky_color) {
    float depth = BLOCK_AT(PixelTexel(pixel)).x;
    vec4 seen = ScreenColor(pixel);
    vec3 color = ShowsSky(seen) ? sky_color : Sound(seen.rgb);
    return HitPixel(color, depth < 0.0, ShowsReflector(point, normal, pixel, depth));
}

#endif
