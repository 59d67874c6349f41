#version 460
#pragma program(Billboard)
#pragma in_either_stage
// The method `billboard` traces a mirror ray from each pixel of the G-buffer against impostor quads, "in the G-buffer
// stage" (Schmidt 2013, section 5.3). The listings blur nothing; the uniform `blur` can add a blur. The method `ibr`
// draws its planes by the same program, with images captured from the scene (thesis 3.1.4).

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "thesis/cone_angle.glsl"
#include "schmidt/billboard_reflections.glsl"

layout(binding = 3) uniform sampler2D depth_buffer;    // reversed
layout(binding = 4) uniform sampler2D normal_buffer;
layout(binding = 5) uniform sampler2D material_buffer;

OUTPUT(0, rgba16f, vec4, out_reflection);

// The most samples of a ray on the screen. A ray takes a sample for each pixel, up to this number.
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
        float least_gap = -1.0;
        for (int side = -1; side <= 1; side += 2) {
            ivec2 beside = pixel;
            beside[axis] += side;
            if (beside[axis] < 0 || beside[axis] >= int(camera.resolution[axis]))
                continue;
            float neighbour_z = ViewZ(beside);
            if (neighbour_z > 0.0 && (least_gap < 0.0 || abs(neighbour_z - z) < least_gap))
                least_gap = abs(neighbour_z - z);
        }
        slope[axis] = max(least_gap, 0.0);
    }
    return slope.x + slope.y + SHARE_OF_DEPTH * z;
}

// Whether the depth buffer shows something between a pixel and its hit on a billboard, `t` metres away. Beyond the
// screen nothing is known, and nothing hides the billboard.
bool Occluded(vec3 wsPosition, vec3 wsReflectVec, float t) {
    if (occlusion == 0)
        return false;
    vec3 begin = (camera.world_to_view * vec4(wsPosition, 1.0)).xyz;
    vec3 along = mat3(camera.world_to_view) * wsReflectVec;
    float far_end = max((begin + t * along).z, camera.near_plane);
    // A thing this near to the billboard is the thing that the billboard stands for, and does not hide it.
    t -= VISIBLE_WITHIN + VISIBLE_WITHIN * far_end;
    // The ray is cut off before the near plane, where the projection ends.
    if (along.z < 0.0)
        t = min(t, (begin.z - camera.near_plane) / -along.z * 0.999);
    if (t <= 0.0)
        return false;
    vec3 start = Screen(begin);
    vec3 step = Screen(begin + t * along) - start;
    float length_px = max(abs(step.x), abs(step.y));
    // `on_screen_share` is the share of the ray that lies on the screen.
    vec2 to_border = mix(start.xy, camera.resolution - start.xy, greaterThan(step.xy, vec2(0.0)))
                   / max(abs(step.xy), 1e-6);
    float on_screen_share = min(1.0, min(to_border.x, to_border.y));
    int steps = int(clamp(ceil(length_px * on_screen_share), 1.0, float(MARCH_MAX)));
    step *= on_screen_share / float(steps);
    ivec2 own_pixel = ivec2(start.xy);
    for (int i = 0; i < steps; ++i) {
        vec3 a = start + float(i) * step;
        vec3 b = a + step;
        ivec2 pixel = ivec2(0.5 * (a.xy + b.xy));
        if (pixel == own_pixel)
            continue;
        float pixel_z = ViewZ(pixel);
        if (pixel_z < 0.0)
            continue;
        float z_a = ViewPosition(a.xy, a.z).z;
        float z_b = ViewPosition(b.xy, b.z).z;
        if (max(z_a, z_b) >= pixel_z && min(z_a, z_b) <= pixel_z + Thickness(pixel, pixel_z))
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
    float pixel_angle = 2.0 / (camera.view_to_clip[1][1] * camera.resolution.y);
    float path_length = distance(wsPosition, eye) + t;
    float width = path_length * pixel_angle;
    if (blur != BLUR_NONE)
        width += 2.0 * tan(ConeAngle(roughness)) * (blur == BLUR_DISTANCE ? path_length : t);
    mat4 model = Impostor[i].ModelMatrix;
    vec2 texels = TexelCount(i) / vec2(length(model[0].xyz), length(model[2].xyz));
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
