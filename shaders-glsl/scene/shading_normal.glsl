// The shading normal on the front of a surface: normalize(mix(geometric, normal-mapped, deviation)), as in the author's
// program. The G-buffer and the colours of hits on triangles share this file.

#ifndef SCENE_SHADING_NORMAL_GLSL
#define SCENE_SHADING_NORMAL_GLSL

// `geometric` is a unit vector; `tangent` runs along +u and has the bitangent's sign in w; `mapped` is the map's vector,
// -1 to 1.
vec3 ShadingNormal(vec3 geometric, vec4 tangent, vec3 mapped, float deviation) {
    vec3 tangent_direction = tangent.xyz - geometric * dot(geometric, tangent.xyz);
    float tangent_length = length(tangent_direction);
    if (!(tangent_length > 1e-6))
        return geometric;
    tangent_direction /= tangent_length;
    vec3 bitangent = tangent.w * cross(geometric, tangent_direction);
    vec3 bumped = normalize(tangent_direction * mapped.x + bitangent * mapped.y + geometric * max(mapped.z, 1e-3));
    return normalize(mix(geometric, bumped, deviation));
}

#endif
