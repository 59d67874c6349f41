#version 460
#pragma program(Environment)
#pragma in_either_stage
// The method `environment` looks the reflection up in a pre-filtered cube map, by its direction alone (thesis 3.1.3).
// This is right for the sky, which is infinitely far away, and for nothing else.

#include "common/either_stage.glsl"
#include "common/camera.glsl"
#include "common/reflecting_pixel.glsl"
#include "common/cube_map.glsl"

layout(binding = 4) uniform samplerCube environment;

OUTPUT(0, rgba16f, vec4, out_reflection); // colour, and 1 in a: nothing fades

SHADE(out_reflection) {
    ReflectingPixel pixel = FetchReflectingPixel(PIXEL_CENTRE);
    out_reflection = vec4(0.0);
    if (pixel.reflects) {
        out_reflection = vec4(SampleCube(environment, pixel.reflection, pixel.roughness).rgb, 1.0);
    }
}
