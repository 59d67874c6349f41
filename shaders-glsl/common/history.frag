#version 460
#pragma program(History)
// Temporal filtering (thesis 4.2.11): the reflection of earlier frames, taken from where its point was seen then, kept
// within what the pixels around show now (variance clipping, Salvi 2016), and averaged with that of this frame.

#include "common/octahedral.glsl"
#include "common/sight.glsl"
#include "common/sound.glsl"

// Filled in by src/passes/history.rs.
layout(std140, binding = 0) uniform HistoryBlock {
    mat4 clip_to_view;        // of this frame, reversed depth
    mat4 view_to_view_before; // from this frame's view space to that of the frame before
    mat4 view_to_clip_before; // of the frame before, reversed depth
    mat4 clip_to_view_before;
    vec2 resolution;          // pixels
    float unit;               // metres to one unit of `distance_buffer`
    float frames;             // that are averaged at most
    float deviations;         // standard deviations around the mean within which the history is kept
    int begins;               // 1: there is no frame before
    int has_distance;         // 1: `distance_buffer` is known
} history;

layout(binding = 1) uniform sampler2D depth_buffer;      // reversed; 0 is sky
layout(binding = 2) uniform sampler2D normal_buffer;     // view space
layout(binding = 3) uniform sampler2D reflection_buffer; // of this frame: colour, and fade in a
layout(binding = 4) uniform sampler2D material_buffer;   // reflectivity, roughness
layout(binding = 5) uniform sampler2D color_before;      // out_reflection and out_guide of the frame before
layout(binding = 6) uniform sampler2D guide_before;
layout(binding = 7) uniform sampler2D distance_buffer;   // from each pixel's point to what it reflects; 0 for nothing

layout(location = 0) out vec4 out_reflection; // colour, and fade in a
layout(location = 1) out vec4 out_guide;      // reversed depth, frames averaged, normal as an octahedral pair

// A point of an earlier frame is the same surface if its normal is turned by less than this cosine, and it lies off the
// plane by less than this share of its depth.
#define SAME_NORMAL 0.9
#define SAME_PLANE 0.02
// Least weight that pixels of the same surface must have among the four pixels around a place.
#define LEAST_SHARE 0.05

float Luminance(vec3 color) {
    return dot(color, vec3(0.2126, 0.7152, 0.0722));
}

// A reflection in a form of which means may be taken: its colour, black for a miss, and in a the luminance that is left
// of it after its fade.
vec4 Linear(vec4 reflection) {
    vec3 color = Sound(reflection.rgb);
    return vec4(color, Luminance(color) * reflection.a);
}

vec4 FromLinear(vec4 mean) {
    float whole = Luminance(mean.rgb);
    return vec4(Sound(mean.rgb), whole > 0.0 ? clamp(mean.a / whole, 0.0, 1.0) : 0.0);
}

vec3 Unproject(mat4 clip_to_view, vec2 position, float depth) {
    vec2 ndc = position / history.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    vec4 h = clip_to_view * vec4(ndc, depth, 1.0);
    return h.xyz / h.w;
}

// What the frame before showed of a surface (a point and its normal there) where a point was seen in it, in the form of
// Linear(). `age` is the number of frames that this averages; 0 if the frame before did not show the surface.
vec4 Before(vec3 seen, vec3 surface, vec3 normal, out float age) {
    age = 0.0;
    vec4 clip = history.view_to_clip_before * vec4(seen, 1.0);
    if (!(clip.w > 0.0))
        return vec4(0.0);
    vec2 position = (clip.xy / clip.w * vec2(0.5, -0.5) + 0.5) * history.resolution - 0.5;
    if (!(all(greaterThan(position, vec2(-1.0))) && all(lessThan(position, history.resolution))))
        return vec4(0.0);
    vec2 first = floor(position), part = position - first;
    vec4 sum = vec4(0.0);
    float ages = 0.0, weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 at = ivec2(first) + next;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(history.resolution))))
            continue;
        vec4 guide = texelFetch(guide_before, at, 0);
        if (!(guide.y > 0.0))
            continue;
        vec3 there = Unproject(history.clip_to_view_before, vec2(at) + 0.5, guide.x);
        bool same_plane = abs(dot(there - surface, normal)) < SAME_PLANE * Reach(there.z, history.clip_to_view_before);
        bool same_normal = dot(FromOctahedral(guide.zw), normal) > SAME_NORMAL;
        vec2 near = mix(1.0 - part, part, vec2(next));
        float weight = same_plane && same_normal ? near.x * near.y : 0.0;
        sum += weight * Linear(texelFetch(color_before, at, 0));
        ages += weight * guide.y;
        weights += weight;
    }
    if (!(weights > LEAST_SHARE))
        return vec4(0.0);
    age = ages / weights;
    return sum / weights;
}

bool ReflectsAt(ivec2 pixel) {
    return texelFetch(depth_buffer, pixel, 0).r > 0.0 && texelFetch(material_buffer, pixel, 0).r > REFLECTS_ABOVE;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 last = ivec2(history.resolution) - 1;
    out_reflection = texelFetch(reflection_buffer, pixel, 0);
    out_guide = vec4(0.0);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    if (!ReflectsAt(pixel) || !(dot(normal, normal) > NO_NORMAL))
        return;
    normal = normalize(normal);
    vec4 now = Linear(out_reflection);
    float age = 0.0;
    vec4 before = vec4(0.0);
    if (history.begins == 0) {
        vec3 point = Unproject(history.clip_to_view, vec2(pixel) + 0.5, depth);
        vec3 surface = (history.view_to_view_before * vec4(point, 1.0)).xyz;
        vec3 turned = mat3(history.view_to_view_before) * normal;
        if (history.has_distance != 0) {
            // What a plane mirror shows stands behind it, on the line of sight, and stays there while the camera moves.
            float away = texelFetch(distance_buffer, pixel, 0).r * history.unit;
            vec3 image = point + normalize(Sight(point)) * away;
            before = Before((history.view_to_view_before * vec4(image, 1.0)).xyz, surface, turned, age);
        }
        // On the surface itself, where nothing is known of what it reflects, or the mirror is too curved for that.
        if (!(age > 0.0))
            before = Before(surface, surface, turned, age);
    }
    if (age > 0.0) {
        vec4 sum = vec4(0.0), squares = vec4(0.0);
        float count = 0.0; // the pixel itself at least
        for (int i = 0; i < 9; ++i) {
            ivec2 at = clamp(pixel + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
            // What reflects nothing says nothing.
            if (!ReflectsAt(at))
                continue;
            count += 1.0;
            vec4 color = Linear(texelFetch(reflection_buffer, at, 0));
            sum += color;
            squares += color * color;
        }
        vec4 mean = sum / count;
        vec4 reach = history.deviations * sqrt(max(squares / count - mean * mean, vec4(0.0)));
        // What the pixel itself shows is as good as what is around it: so what stays as it is is not blurred.
        before = clamp(before, min(mean - reach, now), max(mean + reach, now));
    }
    age = min(age + 1.0, history.frames);
    vec4 mixed = mix(before, now, 1.0 / age);
    out_reflection = FromLinear(mixed);
    out_guide = vec4(depth, age, Octahedral(normal));
}
