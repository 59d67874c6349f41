#version 460
#pragma program(Dda)
#pragma in_either_stage
// The method `dda` marches each mirror ray over pixels along its longer screen axis, and shows the colour where the ray
// ends, whatever the roughness. It follows the text of McGuire and Mara, "Efficient GPU Screen-Space Ray Tracing" (JCGT
// 3(4), 2014). ERRATA.md beside this file lists what this text leaves open and what differs.

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "common/sound.glsl"
#include "thesis/border_fade.glsl"

layout(constant_id = 0) const bool JITTER = false; // whether samples are shifted from pixel to pixel
layout(constant_id = 1) const bool REFINE = false; // whether a hit is searched for within its step
layout(constant_id = 2) const bool HITS = false;   // whether out_hit is wanted
layout(constant_id = 3) const int LAYERS = 1;      // layers of depth: 1 or 2

layout(push_constant) uniform DdaBlock {
    float stride;     // pixels from one sample to the next
    float thickness;  // metres that every surface is taken to measure in view depth
    float longest;    // metres after which a ray ends
    int steps;        // samples of a ray at most
    float fade_start; // I_start of the thesis's Eq. 4.7
    float fade_end;   // I_end of Eq. 4.7
    int fade;         // 0: no fade at all
} dda;

layout(binding = 1) uniform sampler2D depth_buffer;    // reversed; nearest
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, bilinear
layout(binding = 5) uniform sampler2D behind_depth;    // the same two of the second layer, which are read with two
layout(binding = 6) uniform sampler2D behind_color;

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and fade in alpha
OUTPUT(1, rgba32f, vec4, out_hit);        // texture coordinates, standard depth, PATH_*

// A ray on the screen. Its quantities are functions of s, which counts pixels along the longer of its two axes, from
// the centre of the pixel where it starts. Position and k = 1 / z are linear in s. The paper also interpolates Q k,
// with the view-space point Q. Here only the depth z of Q is needed, and z k is 1 along the whole ray, since w is z in
// our clip space.
struct Line {
    vec2 start; // pixels
    vec2 slope; // pixels of each axis to one of s; one of the two is 1 or -1
    float k;    // 1 / z at the start
    float dk;   // by how much k grows with each pixel of s
    float end;  // s where the ray ends, or leaves the screen
};

// The s up to which a ray is compared with no depth: it is still in its own pixel.
const float OWN_PIXEL = 0.5;
// The search within a step ends when its interval is as short as this, in pixels.
const float SEARCH_ENDS = 0.25;
// The pattern by which the samples of 4 x 4 pixels are shifted, in sixteenths of a stride. Neighbours differ much.
const int ORDER[16] = int[](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);

// The shift of a pixel's samples along its ray, in strides: between -1/2 and 1/2.
float Shift(ivec2 pixel) {
    if (!JITTER)
        return 0.0;
    return (float(ORDER[(pixel.y & 3) * 4 + (pixel.x & 3)]) + 0.5) / 16.0 - 0.5;
}

// The view depth that a layer shows at a position in pixels; NEVER where the layer shows nothing.
float SceneDepth(vec2 place, int layer) {
    ivec2 pixel = clamp(ivec2(place), ivec2(0), ivec2(camera.resolution) - 1);
    float depth;
    if (LAYERS > 1 && layer == 1)
        depth = texelFetch(behind_depth, pixel, 0).r;
    else
        depth = texelFetch(depth_buffer, pixel, 0).r;
    if (!(depth > 0.0))
        return NEVER;
    mat4 m = camera.clip_to_view_reversed;
    return (m[2][2] * depth + m[3][2]) / (m[2][3] * depth + m[3][3]);
}

// The position of a ray on the screen at s, in pixels.
vec2 Place(Line line, float s) {
    return line.start + line.slope * s;
}

// The view depth of a ray at s. The ray is cut off at the near plane and has a finite length, so that k is never 0.
float Depth(Line line, float s) {
    return 1.0 / (line.k + line.dk * s);
}

// Projects the ray from a view-space point, seen at `start` in pixels, along a view-space direction to the screen. The
// ray is cut off at the near plane, at its greatest length and where it leaves the screen. Its `end` is 0 if it never
// leaves its own pixel.
Line Project(vec2 start, vec3 position, vec3 direction) {
    float ray_length = dda.longest;
    if (direction.z < 0.0)
        ray_length = min(ray_length, (camera.near_plane - position.z) / direction.z);
    vec3 ray_end = position + direction * ray_length;
    vec4 clip = camera.view_to_clip * vec4(ray_end, 1.0);
    vec2 change_px = (clip.xy / clip.w * vec2(0.5, -0.5) + 0.5) * camera.resolution - start;
    float length_px = max(abs(change_px.x), abs(change_px.y));
    Line line = Line(start, vec2(0.0), 1.0 / position.z, 0.0, 0.0);
    // The condition also holds for a ray without a length on the screen, and where a number is NaN or infinite.
    if (!(length_px > OWN_PIXEL) || !(ray_end.z > 0.0) || isinf(length_px))
        return line;
    line.slope = change_px / length_px;
    line.dk = (1.0 / ray_end.z - line.k) / length_px;
    line.end = length_px;
    for (int axis = 0; axis < 2; ++axis) {
        float border = line.slope[axis] > 0.0 ? camera.resolution[axis] : 0.0;
        if (line.slope[axis] != 0.0)
            line.end = min(line.end, (border - start[axis]) / line.slope[axis]);
    }
    return line;
}

// Whether the depths of the ray between two values of s meet the surface that a layer shows at `place`.
bool Meets(Line line, vec2 place, float from, float to, int layer) {
    float surface_z = SceneDepth(place, layer);
    vec2 depths = vec2(Depth(line, from), Depth(line, to));
    return max(depths.x, depths.y) >= surface_z && min(depths.x, depths.y) <= surface_z + dda.thickness;
}

// Whether the ray at s is as far away as the surface that a layer shows there, or farther.
bool IsBehind(Line line, float s, int layer) {
    return Depth(line, s) >= SceneDepth(Place(line, s), layer);
}

// Returns the s at which a ray goes behind the surface that its sample at s met, by bisection between the sample before
// and `next`, the end of the sample's step.
float Refine(Line line, float s, float next, int layer) {
    bool behind = IsBehind(line, s, layer);
    float before = behind ? max(s - dda.stride, OWN_PIXEL) : s;
    float after = behind ? s : next;
    for (float width = after - before; width > SEARCH_ENDS; width *= 0.5) {
        float middle = 0.5 * (before + after);
        if (IsBehind(line, middle, layer))
            after = middle;
        else
            before = middle;
    }
    return after;
}

// Returns the s of the hit, or -1 for a miss. `layer` becomes the layer of the hit, and `path` how the ray ended
// (PATH_*).
float March(Line line, float shift, out int layer, out int path) {
    path = PATH_LINEAR_MISS;
    layer = 0;
    bvec2 was_behind = bvec2(false);
    for (int i = 1;; ++i) {
        float s = (float(i) + shift) * dda.stride;
        if (!(s < line.end))
            return -1.0;
        if (i > dda.steps)
            break;
        // A step reaches half-way to the samples before and after it. With REFINE, the first one begins at the end of
        // the ray's own pixel.
        float from = REFINE && i == 1 ? OWN_PIXEL : max(s - 0.5 * dda.stride, OWN_PIXEL);
        float next = min(s + 0.5 * dda.stride, line.end);
        for (int l = 0; l < LAYERS; ++l) {
            bool meets = Meets(line, Place(line, s), from, next, l);
            if (REFINE) {
                // A steep surface may lie between the depths of two steps: the ray was before it, and now is behind it.
                bool behind = IsBehind(line, s, l);
                meets = meets || (behind && !was_behind[l]);
                was_behind[l] = behind;
            }
            if (!meets)
                continue;
            float hit = REFINE ? Refine(line, s, next, l) : s;
            // The ray must also meet the layer where the search ended, within the last pixel before that position.
            if (!REFINE || Meets(line, Place(line, hit), max(hit - 1.0, OWN_PIXEL), hit, l)) {
                path = PATH_LINEAR;
                layer = l;
                return hit;
            }
        }
    }
    path = PATH_LINEAR_EXHAUSTED;
    return -1.0;
}

// Finds the vanishing point of a view-space direction, in texture coordinates. False if it is not on the screen, or if
// the screen shows something in front of the sky there.
bool MeetsSky(vec3 direction, out vec2 uv) {
    precise vec4 clip = camera.view_to_clip * vec4(direction, 0.0);
    precise vec2 place = clip.xy / clip.w * vec2(0.5, -0.5) + 0.5;
    uv = place;
    bool is_inside = direction.z > 0.0 && all(greaterThanEqual(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)));
    return is_inside && texelFetch(depth_buffer, ivec2(uv * camera.resolution), 0).r == 0.0;
}

// The colour of the sky at a position on the screen, interpolated between those of the four pixels around it that show
// sky; one of them must.
vec3 SkyShown(vec2 uv) {
    precise vec2 from_middle = uv * camera.resolution - 0.5;
    vec2 low = floor(from_middle), part = from_middle - low;
    precise vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 pixel = clamp(ivec2(low) + next, ivec2(0), ivec2(camera.resolution) - 1);
        vec2 weight = mix(1.0 - part, part, vec2(next));
        bool is_sky = texelFetch(depth_buffer, pixel, 0).r == 0.0;
        sum += is_sky ? weight.x * weight.y * vec4(texelFetch(color_buffer, pixel, 0).rgb, 1.0) : vec4(0.0);
    }
    return sum.rgb / sum.a;
}

SHADE_ALL(out_reflection, STORE_IF(HITS, out_hit)) {
    out_reflection = vec4(0.0);
    if (HITS)
        out_hit = vec4(vec3(-1.0), PATH_NONE);
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    float reflectivity = texelFetch(material_buffer, pixel, 0).r;
    if (!(depth > 0.0) || !(reflectivity > REFLECTS_ABOVE) || !(dot(normal, normal) > NO_NORMAL))
        return;

    vec2 ndc = PIXEL_CENTRE / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 homogeneous = camera.clip_to_view_reversed * vec4(ndc, depth, 1.0);
    vec3 position = homogeneous.xyz / homogeneous.w;
    vec3 direction = reflect(normalize(position), normalize(normal));
    Line line = Project(PIXEL_CENTRE, position, direction);
    int layer, path;
    float s = March(line, Shift(pixel), layer, path);
    if (s < 0.0) {
        if (HITS)
            out_hit.w = float(path);
        vec2 sky_uv;
        if (path == PATH_LINEAR_MISS && MeetsSky(direction, sky_uv)) {
            float sky_fade = dda.fade != 0 ? BorderFade(sky_uv, dda.fade_start, dda.fade_end) : 1.0;
            out_reflection = vec4(Sound(SkyShown(sky_uv)), sky_fade);
        }
        return;
    }

    vec2 uv = Place(line, s) / camera.resolution;
    float z = Depth(line, s);
    if (HITS)
        out_hit = vec4(uv, (camera.view_to_clip[2][2] * z + camera.view_to_clip[3][2]) / z, path);
    float fade = dda.fade != 0 ? BorderFade(uv, dda.fade_start, dda.fade_end) : 1.0;
    vec3 color;
    if (LAYERS > 1 && layer == 1)
        color = textureLod(behind_color, uv, 0.0).rgb;
    else
        color = textureLod(color_buffer, uv, 0.0).rgb;
    out_reflection = vec4(Sound(color), fade);
}
