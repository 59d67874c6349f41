#version 460
// Traces a ray through each pixel against a floor, a wall and two spheres.
layout(push_constant) uniform Camera { mat4 view_to_clip; mat4 world_to_view; };
layout(location = 0) out vec4 out_normal;   // view space
layout(location = 1) out vec4 out_material; // reflectivity, roughness
layout(location = 2) out vec4 out_color;    // lit, linear

void main() {
    vec2 ndc = gl_FragCoord.xy / vec2(640.0, 360.0) * 2.0 - 1.0;
    mat3 turn = mat3(world_to_view);
    vec3 view = vec3(ndc.x / view_to_clip[0][0], ndc.y / view_to_clip[1][1], -1.0);
    vec3 ray = transpose(turn) * view, eye = -(transpose(turn) * world_to_view[3].xyz);
    float t = 1e30;
    vec3 normal, color;
    vec2 material;
    if (ray.y < 0.0) {
        t = -eye.y / ray.y;
        vec3 point = eye + t * ray;
        float checker = mod(floor(point.x) + floor(point.z), 2.0);
        normal = vec3(0, 1, 0), color = mix(vec3(0.05), vec3(0.3, 0.28, 0.25), checker);
        material = vec2(0.6, point.x < 0.0 ? 0.0 : 0.15);
    }
    float wall = (-8.0 - eye.z) / ray.z;
    if (wall > 0.0 && wall < t) {
        vec3 point = eye + wall * ray;
        t = wall, normal = vec3(0, 0, 1), material = vec2(0);
        color = 0.5 + 0.4 * cos(vec3(0, 2, 4) + 0.9 * point.x + 0.4 * point.y);
    }
    for (int i = 0; i < 2; ++i) {
        vec3 centre = i == 0 ? vec3(-1.8, 1.0, -1.0) : vec3(1.6, 1.2, -2.0);
        float radius = centre.y;
        vec3 o = eye - centre;
        float b = dot(o, ray), a = dot(ray, ray), d = b * b - a * (dot(o, o) - radius * radius);
        float s = (-b - sqrt(max(d, 0.0))) / a;
        if (d > 0.0 && s > 0.0 && s < t) {
            t = s, normal = normalize(o + s * ray), material = vec2(i == 0 ? 0.8 : 0.0, 0.0);
            color = (i == 0 ? vec3(0.05) : vec3(0.8, 0.25, 0.1)) * (0.3 + 0.7 * max(dot(normal, normalize(vec3(1, 2, 2))), 0.0));
        }
    }
    if (t > 150.0)
        discard;
    // View z is -t: depth is a + b / t.
    gl_FragDepth = -view_to_clip[2][2] + view_to_clip[3][2] / t;
    out_normal = vec4(turn * normal, 0.0);
    out_material = vec4(material, 0.0, 0.0);
    out_color = vec4(color, 1.0);
}
