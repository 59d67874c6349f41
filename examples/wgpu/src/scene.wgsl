// `scene` is `examples/embed/scene.frag` in WGSL, with y up in clip space. It traces a ray through each pixel against a
// floor, a wall and two spheres. `show` draws a linear image to the screen image.

struct Camera { view_to_clip: mat4x4f, world_to_view: mat4x4f }
@group(0) @binding(0) var<uniform> camera: Camera;
@group(0) @binding(1) var linear: texture_2d<f32>;

// Draws a triangle that covers the whole image.
@vertex
fn whole_image(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0);
}

struct Drawn {
    @builtin(frag_depth) depth: f32,
    @location(0) normal: vec4f,   // view space
    @location(1) material: vec4f, // reflectivity, roughness
    @location(2) color: vec4f,    // lit, linear
}

// Traces the ray of a pixel, and returns the surface that it hits.
@fragment
fn scene(@builtin(position) pixel: vec4f) -> Drawn {
    let ndc = vec2f(pixel.x / 320.0 - 1.0, 1.0 - pixel.y / 180.0);
    let turn = mat3x3f(camera.world_to_view[0].xyz, camera.world_to_view[1].xyz, camera.world_to_view[2].xyz);
    let to_world = transpose(turn);
    let ray = to_world * vec3f(ndc.x / camera.view_to_clip[0].x, ndc.y / camera.view_to_clip[1].y, -1.0);
    let eye = -(to_world * camera.world_to_view[3].xyz);
    var t = 1e30;
    var normal = vec3f(0.0);
    var color = vec3f(0.0);
    var material = vec2f(0.0);
    if ray.y < 0.0 {
        t = -eye.y / ray.y;
        let point = eye + t * ray;
        let square = floor(point.x) + floor(point.z);
        let checker = square - 2.0 * floor(0.5 * square);
        normal = vec3f(0.0, 1.0, 0.0);
        color = mix(vec3f(0.05), vec3f(0.3, 0.28, 0.25), checker);
        material = vec2f(0.6, select(0.15, 0.0, point.x < 0.0));
    }
    let wall = (-8.0 - eye.z) / ray.z;
    if wall > 0.0 && wall < t {
        let point = eye + wall * ray;
        t = wall;
        normal = vec3f(0.0, 0.0, 1.0);
        material = vec2f(0.0);
        color = 0.5 + 0.4 * cos(vec3f(0.0, 2.0, 4.0) + 0.9 * point.x + 0.4 * point.y);
    }
    for (var i = 0; i < 2; i++) {
        let is_mirror = i == 0;
        let centre = select(vec3f(1.6, 1.2, -2.0), vec3f(-1.8, 1.0, -1.0), is_mirror);
        let o = eye - centre;
        let b = dot(o, ray);
        let a = dot(ray, ray);
        let d = b * b - a * (dot(o, o) - centre.y * centre.y);
        let s = (-b - sqrt(max(d, 0.0))) / a;
        if d > 0.0 && s > 0.0 && s < t {
            t = s;
            normal = normalize(o + s * ray);
            material = vec2f(select(0.0, 0.8, is_mirror), 0.0);
            let light = 0.3 + 0.7 * max(dot(normal, normalize(vec3f(1.0, 2.0, 2.0))), 0.0);
            color = light * select(vec3f(0.8, 0.25, 0.1), vec3f(0.05), is_mirror);
        }
    }
    if t > 150.0 {
        discard;
    }
    // View z is -t: depth is a + b / t.
    let depth = -camera.view_to_clip[2].z + camera.view_to_clip[3].z / t;
    return Drawn(depth, vec4f(turn * normal, 0.0), vec4f(material, 0.0, 0.0), vec4f(color, 1.0));
}

// Copies a linear image; the format of the target encodes it as sRGB.
@fragment
fn show(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return vec4f(textureLoad(linear, vec2i(pixel.xy), 0).rgb, 1.0);
}
