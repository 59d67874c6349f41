#version 460
// The 7-tap separable Gaussian of thesis 4.3.2 (Eq. 4.8, sigma = 1; the listing's weights), which
// 4.2.6 names as the alternative to the hardware's mip chain. One direction; the horizontal pass
// also halves the level, as its bilinear taps lie at the coarse level's texel centres.

layout(binding = 0) uniform sampler2D tex; // the level below (horizontal), or the horizontal result

layout(push_constant) uniform BlurBlock {
    vec2 invSize;   // 1 / size of the level that is written
    vec2 direction; // (invTexWidth, 0) or (0, invTexHeight)
} blur;

layout(location = 0) out vec4 color;

void main() {
    vec2 texCoord = gl_FragCoord.xy * blur.invSize;
    color = vec4(0.0);
    color += textureLod(tex, texCoord + blur.direction * 3.0, 0.0) * 0.002;
    color += textureLod(tex, texCoord + blur.direction * 2.0, 0.0) * 0.028;
    color += textureLod(tex, texCoord + blur.direction * 1.0, 0.0) * 0.233;
    color += textureLod(tex, texCoord, 0.0) * 0.474;
    color += textureLod(tex, texCoord + blur.direction * -1.0, 0.0) * 0.233;
    color += textureLod(tex, texCoord + blur.direction * -2.0, 0.0) * 0.028;
    color += textureLod(tex, texCoord + blur.direction * -3.0, 0.0) * 0.002;
}
