#version 460
#pragma program(Billboard)
#pragma in_either_stage
// `billboard`: impostor quads traced per pixel from the G-buffer, "in the G-buffer stage" (Schmidt 2013,
// section 5.3). Mirrors, unless `blur` asks for more: the listings know no roughness. `ibr` draws its planes by the same
// program, with images captured from the scene (thesis 3.1.4).

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "thesis/cone_angle.glsl"
#include "schmidt/billboard_reflections.glsl"

layout(binding = 3) uniform sampler2D depth_buffer;    // reversed
layout(binding = 4) uniform sampler2D normal_buffer;
layout(binding = 5) uniform sampler2D material_buffer;

OUTPUT(0, rgba16f, vec4, out_reflection);

// The most samples of a ray on the screen. A ray takes one for each pixel; a longer ray takes no more than these.
#define MARCH_MAX 512

// The view-space point at a position in pixels and a reversed depth.
vec3 ViewPosition(vec2 position, float depth) {
    vec4 h = camera.clip_to_view_reversed * vec4(position / camera.resolution * vec2(2.0, -2.0) + vec2(-1.0, 1.0), depth, 1.0);
    return h.xyz / h.w;
}

// The pixel coordinates and the reversed depth of a view-space point.
vec3 Screen(vec3 view) {
    vec4 clip = camera.view_to_clip_reversed * vec4(view, 1.0);
    return vec3((0.5 + vec2(0.5, -0.5) * clip.xy / clip.w) * camera.resolution, clip.z / clip.w);
}

// The view depth that a pixel shows, in metres; -1 for sky.
float ViewZ(ivec2 pixel) {
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    return depth > 0.0 ? ViewPosition(vec2(pixel) + 0.5, depth).z : -1.0;
}

// The extent in depth that the surface of a pixel is taken to have, in metres: T of docs/definitions.md, "Oracle", item
// 3.
float Thickness(ivec2 pixel, float z) {
    vec2 slope = vec2(0.0);
    for (int axis = 0; axis < 2; ++axis) {
        float least = -1.0;
        for (int side = -1; side <= 1; side += 2) {
            ivec2 beside = pixel;
            beside[axis] += side;
            if (beside[axis] < 0 || beside[axis] >= int(camera.resolution[axis]))
                continue;
            float other = ViewZ(beside);
            if (other > 0.0 && (least < 0.0 || abs(other - z) < least))
                least = abs(other - z);
        }
        slope[axis] = max(least, 0.0);
    }
    return slope.x + slope.y + SHARE_OF_DEPTH * z;
}

// Whether the depth buffer shows something on the way from a pixel to its hit on a billboard, `t` metres away. Beyond
// the screen nothing is known, and nothing hides the billboard.
bool Occluded(vec3 wsPosition, vec3 wsReflectVec, float t) {
    if (occlusion == 0)
        return false;
    vec3 from = (camera.world_to_view * vec4(wsPosition, 1.0)).xyz;
    vec3 along = mat3(camera.world_to_view) * wsReflectVec;
    float far_end = max((from + t * along).z, camera.near_plane);
    // A thing this near to the billboard is the thing that the billboard stands for, and does not hide it.
    t -= VISIBLE_WITHIN + VISIBLE_WITHIN * far_end;
    // The way ends before the near plane, where the projection ends.
    if (along.z < 0.0)
        t = min(t, (from.z - camera.near_plane) / -along.z * 0.999);
    if (t <= 0.0)
        return false;
    vec3 start = Screen(from);
    vec3 step = Screen(from + t * along) - start;
    float pixels = max(abs(step.x), abs(step.y));
    // `inside` is the part of the way until the ray leaves the screen.
    vec2 room = mix(start.xy, camera.resolution - start.xy, greaterThan(step.xy, vec2(0.0))) / max(abs(step.xy), 1e-6);
    float inside = min(1.0, min(room.x, room.y));
    int steps = int(clamp(ceil(pixels * inside), 1.0, float(MARCH_MAX)));
    step *= inside / float(steps);
    ivec2 own = ivec2(start.xy);
    for (int i = 0; i < steps; ++i) {
        vec3 a = start + float(i) * step;
        vec3 b = a + step;
        ivec2 pixel = ivec2(0.5 * (a.xy + b.xy));
        if (pixel == own)
            continue;
        float front = ViewZ(pixel);
        if (front < 0.0)
            continue;
        float z_a = ViewPosition(a.xy, a.z).z;
        float z_b = ViewPosition(b.xy, b.z).z;
        if (max(z_a, z_b) >= front && min(z_a, z_b) <= front + Thickness(pixel, front))
            return true;
    }
    return false;
}

// Roughness of the pixel that is drawn.
float roughness = 0.0;

// The level of a billboard's image for the width of a pixel seen along the whole path, as a mirror shows it. With a
// blur, the width of the cone at the hit is added. `t` is the distance from the pixel to the hit, in metres.
float BillboardLod(int i, vec3 wsPosition, float t) {
    vec3 eye = camera.view_to_world[3].xyz;
    float pixel = 2.0 / (camera.view_to_clip[1][1] * camera.resolution.y);
    float path = distance(wsPosition, eye) + t;
    float width = path * pixel;
    if (blur != BLUR_NONE)
        width += 2.0 * tan(ConeAngle(roughness)) * (blur == BLUR_DISTANCE ? path : t);
    mat4 m = Impostor[i].ModelMatrix;
    vec2 texels = TexelCount(i) / vec2(length(m[0].xyz), length(m[2].xyz));
    return log2(max(width * max(texels.x, texels.y), 1.0));
}

SHADE(out_reflection) {
    ivec2 pixel = ivec2(PIXEL_CENTRE);
    out_reflection = vec4(0.0);
    float depth = texelFetch(depth_buffer, pixel, 0).r;
    vec2 material = texelFetch(material_buffer, pixel, 0).rg;
    if (depth <= 0.0 || material.r <= REFLECTS_ABOVE)
        return;
    roughness = material.g;
    vec3 position = ViewPosition(PIXEL_CENTRE, depth);
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    vec3 reflected = reflect(normalize(position), normal);
    vec3 wsPosition = (camera.view_to_world * vec4(position, 1.0)).xyz;
    vec3 wsReflectVec = normalize(mat3(camera.view_to_world) * reflected);
    out_reflection = order == ORDER_NEAREST ? NearestBillboardReflections(wsPosition, wsReflectVec)
                                  : BillboardReflections(wsPosition, wsReflectVec);
    if (GLOW) {
        vec3 light = BillboardGlow(wsPosition, wsReflectVec);
        out_reflection.rgb += light;
        if (any(greaterThan(light, vec3(0.0))))
            out_reflection.a = 1.0;
    }
}
