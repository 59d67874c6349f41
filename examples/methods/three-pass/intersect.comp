#version 460
// Traces one ray for each pixel of the listed tiles, through a chain of the greatest reversed depths (near 1, far 0).
// The ray is drawn at random within the lobe, in each frame anew.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D colour;
layout(binding = 1) uniform sampler2D depth;      // chain of greatest reversed depths, which are the nearest
layout(binding = 2) uniform sampler2D normals;    // view space
layout(binding = 3) uniform sampler2D material;
layout(binding = 4) uniform sampler2D noise;
layout(binding = 5, rgba16f) uniform writeonly image2D rays;
layout(binding = 6, rgba32f) uniform writeonly image2D ends;
layout(std430, binding = 7) readonly buffer Tiles { uint tiles[]; } list;

layout(std140, binding = 8) uniform Frame {
    mat4 view_to_clip;    // reversed depth
    mat4 clip_to_view;
    vec2 size;
    int frame;
    int steps;
    float thickness;      // of a surface, as a part of its reversed depth
} f;

// Returns the view-space position at texture coordinates and a reversed depth.
vec3 View(vec2 uv, float z) {
    vec4 h = f.clip_to_view * vec4(uv * vec2(2.0, -2.0) + vec2(-1.0, 1.0), z, 1.0);
    return h.xyz / h.w;
}

// Returns the texture coordinates and the reversed depth of a position in clip space.
vec3 Screen(vec4 clip) {
    vec3 ndc = clip.xyz / clip.w;
    return vec3(ndc.xy * vec2(0.5, -0.5) + 0.5, ndc.z);
}

void main() {
    uint tile = list.tiles[gl_WorkGroupID.x];
    ivec2 pixel = ivec2(tile & 0xffffu, tile >> 16) * 8 + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(f.size))))
        return;
    imageStore(rays, pixel, vec4(0.0));
    imageStore(ends, pixel, vec4(-1.0));
    vec2 surface = texelFetch(material, pixel, 0).rg;
    vec3 normal = texelFetch(normals, pixel, 0).xyz;
    if (surface.r <= 1e-4 || dot(normal, normal) < 0.5)
        return;

    vec2 uv = (vec2(pixel) + 0.5) / f.size;
    vec3 place = View(uv, texelFetch(depth, pixel, 0).r);
    vec3 along = reflect(normalize(place), normalize(normal));
    // A random direction in the cone of the roughness. Steps of the golden ratio shift the blue noise from frame to
    // frame.
    vec2 u = fract(texture(noise, (vec2(pixel) + 0.5) / 64.0).rg + float(f.frame) * vec2(0.618034, 0.754878));
    float c = mix(1.0, cos(0.5 * surface.g), u.x), s = sqrt(max(0.0, 1.0 - c * c));
    vec3 t = normalize(abs(along.y) < 0.9 ? cross(along, vec3(0, 1, 0)) : cross(along, vec3(1, 0, 0)));
    along = along * c + (t * cos(6.2831853 * u.y) + cross(along, t) * sin(6.2831853 * u.y)) * s;
    // The ray starts off the surface, by 0.003 of its depth, so that it does not hit the pixel from which it starts.
    place += normalize(normal) * place.z * 0.003;

    // The ray is a straight line in texture coordinates and depth. Its unit is one pixel along the longer side.
    vec3 from = Screen(f.view_to_clip * vec4(place, 1.0));
    float reach = along.z < 0.0 ? min(1.0, 0.9 * place.z / -along.z) : 1.0;
    vec3 line = Screen(f.view_to_clip * vec4(place + along * reach, 1.0)) - from;
    line /= max(max(abs(line.x) * f.size.x, abs(line.y) * f.size.y), 1e-6);
    vec2 pixels = line.xy * f.size;
    int level = 0, most = min(textureQueryLevels(depth) - 1, 6);
    float distance_px = 1.0;
    for (int i = 0; i < f.steps; ++i) {
        vec3 p = from + line * distance_px;
        if (any(lessThan(p.xy, vec2(0.0))) || any(greaterThanEqual(p.xy, vec2(1.0))) || p.z <= 0.0)
            return;
        // `way` is the distance, in the unit of `line`, to the side of the cell through which the ray leaves it.
        vec2 q = p.xy * f.size;
        ivec2 cell = ivec2(q) >> level;
        vec2 side = (vec2(cell) + step(vec2(0.0), pixels)) * float(1 << level);
        vec2 to_side = (side - q) / mix(pixels, vec2(1e-6), lessThan(abs(pixels), vec2(1e-6)));
        float way = max(min(to_side.x, to_side.y), 0.0) + 0.01;
        float nearest = texelFetch(depth, min(cell, textureSize(depth, level) - 1), level).r;
        float farthest_of_ray = min(p.z, p.z + line.z * way);
        if (farthest_of_ray >= nearest) {
            // The ray passes in front of all surfaces of the cell.
            distance_px += way;
            level = min(level + 1, most);
        } else if (level > 0) {
            --level;
        } else {
            if (nearest > 0.0 && max(p.z, p.z + line.z * way) > nearest * (1.0 - f.thickness)) {
                imageStore(rays, pixel, vec4(textureLod(colour, p.xy, 0.0).rgb, 1.0));
                imageStore(ends, pixel, vec4(p.xy, nearest, 1.0));
                return;
            }
            distance_px += way;
        }
    }
}
