// What a mirror pixel shows: one ray, one sample of the lit colour at its hit, and the composite.
// Needs parameters.glsl.

layout(binding = 1, rg32f) uniform readonly image2D pyramid; // front and back depths
layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;           // lit colour, linear

#include "unified/normal.glsl"
#include "unified/tiles.glsl"
#include "unified/pyramid.glsl"
#include "unified/ray.glsl"
#include "unified/traverse.glsl"
#include "unified/fade.glsl"
#include "unified/sound.glsl"

struct Mirror {
    vec4 reflection; // colour, and fade in a; a miss is 0
    vec4 composite;  // lit colour + reflectivity * fade * reflection
    Ray ray;
    Hit hit;
};

// Over tiles, what is no mirror is discarded: the images already hold what it shows. With WHOLE the images
// hold nothing, all that reflects is a mirror, and the other pixels show their lit colour.
Mirror TraceMirror(ivec2 pixel) {
    vec2 material = imageLoad(material_buffer, pixel).xy;
    float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
    vec3 normal = Normal(pixel);
    bool traced = Reflects(material) && depth > 0.0 && normal != vec3(0.0);
    Mirror mirror;
    mirror.reflection = vec4(0.0);
    mirror.composite = vec4(texelFetch(color_buffer, pixel, 0).rgb, 1.0);
#ifdef WHOLE
    if (!traced)
        return mirror;
#else
    if (!traced || ListOf(material) != MIRROR_LIST)
        discard;
#endif
    bool faces;
    mirror.ray = MirrorRay(pixel, depth, normal, faces);
    mirror.hit = Traverse(mirror.ray);
    if (mirror.hit.code == HIT_SURFACE && faces) {
        vec2 uv = mirror.hit.position * unified.pixel_to_clip;
        mirror.reflection = vec4(Sound(textureLod(color_buffer, uv, 0.0).rgb), Fade(uv));
        vec3 seen = mirror.composite.rgb + material.x * mirror.reflection.a * mirror.reflection.rgb;
        mirror.composite.rgb = min(seen, GREATEST);
    }
    return mirror;
}
