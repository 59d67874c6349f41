// What a mirror pixel shows: one ray, one sample of the lit colour at its hit, and the composite.
// Needs parameters.glsl.

layout(binding = 1) uniform sampler2D pyramid;         // front and back depths
layout(binding = 2) uniform sampler2D normal_buffer;   // view space
layout(binding = 3) uniform sampler2D material_buffer; // reflectivity, roughness
layout(binding = 4) uniform sampler2D color_buffer;    // lit colour, linear

#include "unified/pyramid.glsl"
#include "unified/ray.glsl"
#include "unified/traverse.glsl"
#include "unified/fade.glsl"

struct Mirror {
    vec4 reflection; // colour, and fade in a; a miss is 0
    vec4 composite;  // lit colour + reflectivity * fade * reflection
    Hit hit;
};

Mirror TraceMirror(ivec2 pixel) {
    Mirror mirror;
    mirror.reflection = vec4(0.0);
    mirror.composite = vec4(texelFetch(color_buffer, pixel, 0).rgb, 1.0);
    mirror.hit = Hit(HIT_NONE, pixel, vec2(0.0), 0.0, 0);
    float reflectivity = texelFetch(material_buffer, pixel, 0).r;
    if (!(reflectivity > REFLECTS_ABOVE))
        return mirror;
    float depth = texelFetch(pyramid, pixel, 0).r;
    vec3 normal = texelFetch(normal_buffer, pixel, 0).xyz;
    if (!(depth > 0.0) || normal == vec3(0.0))
        return mirror;

    bool faces;
    mirror.hit = Traverse(MirrorRay(pixel, depth, normal, faces));
    if (mirror.hit.code == HIT_SURFACE && faces) {
        vec2 uv = mirror.hit.position / vec2(unified.size);
        mirror.reflection = vec4(textureLod(color_buffer, uv, 0.0).rgb, Fade(uv));
        mirror.composite.rgb += reflectivity * mirror.reflection.a * mirror.reflection.rgb;
    }
    return mirror;
}
