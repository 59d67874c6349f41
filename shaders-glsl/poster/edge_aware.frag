#version 460
#pragma program(EdgeAware)
#pragma in_either_stage
// Makes a level of the poster's G-buffer from the level below it, edge-aware as the poster's conclusion asks for. Of
// the texels below, only those on the surface that most of them show count, so that no depth is a mean of two surfaces.

#include "common/either_stage.glsl"

layout(push_constant) uniform EdgeAwareBlock {
    float tolerance; // texels lie on one surface if their depths differ by no more than this part of the lesser one
} edge;

// The level below, as views of one level.
layout(binding = 0) uniform sampler2D depth_source; // view-space z, metres
layout(binding = 1) uniform sampler2D normal_source;
layout(binding = 2) uniform sampler2D color_source;

OUTPUT(0, r32f, float, out_depth);
OUTPUT(1, rgba16f, vec4, out_normal);
OUTPUT(2, rgba16f, vec4, out_color);

// Whether two view depths lie on one surface.
bool SameSurface(float a, float b) {
    return abs(a - b) <= edge.tolerance * min(a, b);
}

SHADE_ALL(out_depth, STORE(out_normal) STORE(out_color)) {
    ivec2 size = textureSize(depth_source, 0);
    ivec2 target_texel = ivec2(PIXEL_CENTRE);
    ivec2 first = 2 * target_texel;
    // The last texel takes the row or column that is left over where a size is odd.
    ivec2 last = mix(first + 1, size - 1, greaterThanEqual(target_texel + 1, max(size / 2, ivec2(1))));

    float depths[9];
    int count = 0;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            depths[count++] = texelFetch(depth_source, ivec2(x, y), 0).r;

    // `common_depth` is the depth with which most others agree. Of several with as many, the nearest counts.
    float common_depth = depths[0];
    int most_agreeing = 0;
    for (int i = 0; i < count; ++i) {
        int agreeing = 0;
        for (int j = 0; j < count; ++j)
            agreeing += int(SameSurface(depths[i], depths[j]));
        if (agreeing > most_agreeing || (agreeing == most_agreeing && depths[i] < common_depth)) {
            most_agreeing = agreeing;
            common_depth = depths[i];
        }
    }

    out_depth = 0.0;
    out_normal = out_color = vec4(0.0);
    int next = 0;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            float depth = depths[next++];
            if (!SameSurface(depth, common_depth))
                continue;
            out_depth += depth;
            out_normal += texelFetch(normal_source, ivec2(x, y), 0);
            out_color += texelFetch(color_source, ivec2(x, y), 0);
        }
    float weight = 1.0 / float(most_agreeing);
    out_depth *= weight;
    out_normal *= weight;
    out_color *= weight;
}
