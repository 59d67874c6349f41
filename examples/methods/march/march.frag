#version 330 core
// A march in view space, written for OpenGL: uniforms outside of blocks, no bindings, a camera that looks along -z.
in vec2 uv;
out vec4 reflection;

uniform sampler2D colour;
uniform sampler2D depth;      // linear, in metres
uniform sampler2D normals;    // view space
uniform mat4 projection;
uniform vec2 tangents;        // of half the field of view
uniform int steps;
uniform float stride;         // metres
uniform float thickness;      // metres

vec3 Place(vec2 position_uv) { // the view-space position of the surface at a pixel, in metres
    vec2 ndc = position_uv * 2.0 - 1.0;
    return vec3(ndc.x * tangents.x, -ndc.y * tangents.y, -1.0) * texture(depth, position_uv).r;
}

void main() {
    reflection = vec4(0.0);
    vec3 normal = texture(normals, uv).xyz;
    if (dot(normal, normal) < 0.5)
        return;
    vec3 place = Place(uv), along = reflect(normalize(place), normalize(normal)) * stride;
    for (int i = 0; i < steps; ++i) {
        place += along;
        vec4 clip = projection * vec4(place, 1.0);
        vec2 screen_uv = clip.xy / clip.w * 0.5 + 0.5;
        if (clip.w <= 0.0 || any(lessThan(screen_uv, vec2(0.0))) || any(greaterThan(screen_uv, vec2(1.0))))
            return;
        float behind = -place.z - texture(depth, screen_uv).r;
        if (behind > 0.0 && behind < thickness) {
            reflection = vec4(texture(colour, screen_uv).rgb, 1.0);
            return;
        }
    }
}
