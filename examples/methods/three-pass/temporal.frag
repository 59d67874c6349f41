#version 460
// Averages the rays of this frame with the history. The motion vector says where the pixel's surface was in the frame
// before. The history's colour there is clamped to the spread of this frame's colours around the pixel.
layout(binding = 0) uniform sampler2D rays;
layout(binding = 1) uniform sampler2D before;
layout(binding = 2) uniform sampler2D motion;
layout(binding = 3) uniform sampler2D material;

layout(std140, binding = 4) uniform Frame {
    int is_first_frame;
    int frames;
} f;

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 average;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), most = textureSize(rays, 0) - 1;
    vec4 now = texelFetch(rays, pixel, 0);
    average = now;
    vec2 earlier = uv - texelFetch(motion, pixel, 0).rg;
    if (f.is_first_frame != 0 || any(lessThan(earlier, vec2(0.0))) || any(greaterThan(earlier, vec2(1.0))))
        return;
    vec4 sum = vec4(0.0), squares = vec4(0.0);
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            vec4 v = texelFetch(rays, clamp(pixel + ivec2(x, y), ivec2(0), most), 0);
            sum += v;
            squares += v * v;
        }
    }
    vec4 mean = sum / 9.0, spread = sqrt(max(squares / 9.0 - mean * mean, 0.0));
    vec4 history = clamp(textureLod(before, earlier, 0.0), mean - 1.5 * spread, mean + 1.5 * spread);
    average = mix(history, now, 1.0 / float(f.frames));
}
