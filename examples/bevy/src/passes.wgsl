// The passes before and after the reflections: `inputs` unpacks Bevy's deferred G-buffer, `face` draws the environment map
// as a cube in the layout of Vulkan, `add` adds the reflected light to the lit colour, and `depth` copies depth for the
// component `KeepImages`.

struct View {
    world_from_clip: mat4x4f,
    view_from_world: mat4x4f,
    eye: vec4f,         // the camera's place in the world and 0, or the direction towards an orthographic one and 1
    environment: vec4f, // rotation of the environment map, a quaternion
    fade: vec2f,        // perceptual roughness at which reflections begin to fade out, and at which they are gone
    exposure: f32,      // factor on the environment map; 0 without one
    levels: f32,        // the map's last level
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth_buffer: texture_depth_2d;
@group(0) @binding(2) var deferred_buffer: texture_2d<u32>;
@group(0) @binding(3) var lit_buffer: texture_2d<f32>;
@group(0) @binding(4) var reflection_buffer: texture_2d<f32>; // the reflected colour in rgb, its confidence in a
@group(0) @binding(5) var environment_map: texture_cube<f32>;
@group(0) @binding(6) var linear_sampler: sampler;

struct Corner { @builtin(position) position: vec4f, @location(0) @interpolate(flat) face: u32 }

// Draws a triangle that covers the whole image. The number of the instance is the face of the cube that is drawn.
@vertex
fn whole_image(@builtin(vertex_index) vertex: u32, @builtin(instance_index) face: u32) -> Corner {
    return Corner(vec4f(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0), face);
}

struct Surface {
    f0: vec3f, // reflectivity at normal incidence; 0 for a surface that does not reflect
    perceptual_roughness: f32,
    normal: vec3f, // world space
    depth: f32,    // reversed; 0 for the sky
}

// Unpacks the surface that Bevy's deferred pass stored for a pixel (`bevy_pbr/deferred/functions.wesl`). Unlit surfaces
// do not reflect.
fn surface_at(pixel: vec2i) -> Surface {
    let packed = textureLoad(deferred_buffer, pixel, 0);
    let depth = textureLoad(depth_buffer, pixel, 0);
    let base = unpack4x8unorm(packed.r);
    let more = unpack4x8unorm(packed.b); // reflectance, metallic, occlusion, clear coat
    let is_unlit = (packed.a >> 24u & 1u) != 0u;
    let f0 = mix(vec3f(0.16 * more.r * more.r), pow(base.rgb, vec3f(2.2)), more.g);
    let reflects = !is_unlit && depth > 0.0;
    // Two numbers of 12 bits are the normal's place on the octahedron.
    let place = vec2f(vec2u(packed.a, packed.a >> 12u) & vec2u(0xfffu)) / 4095.0;
    return Surface(select(vec3f(0.0), f0, reflects), base.a, from_octahedron(2.0 * place - 1.0), depth);
}

// Returns the unit vector for a place on the unfolded octahedron, whose coordinates are from -1 to 1.
fn from_octahedron(place: vec2f) -> vec3f {
    let up = 1.0 - abs(place.x) - abs(place.y);
    let folded = place - clamp(-up, 0.0, 1.0) * select(vec2f(-1.0), vec2f(1.0), place >= vec2f(0.0));
    return normalize(vec3f(folded, up));
}

// Returns the share of the traced reflection that is shown at a roughness: 1 below the range of the fade, 0 above it.
fn shown(perceptual_roughness: f32) -> f32 {
    return 1.0 - smoothstep(view.fade.x, max(view.fade.y, view.fade.x + 1e-4), perceptual_roughness);
}

// Converts the perceptual roughness of a GGX lobe to the roughness of `ssct`. Both lobes then send half of their light
// into a cone of the same width (docs/definitions.md, "glTF").
fn lobe_roughness(perceptual_roughness: f32) -> f32 {
    let squared = pow(perceptual_roughness, 4.0);
    let cosine = (1.0 - squared) / (1.0 + squared); // of twice the arc tangent
    let half_width = acos(pow(cosine, log(0.244) / log(0.5)));
    return clamp(2.0 * half_width, 0.0, 1.0);
}

struct Inputs {
    @location(0) normal: vec4f,   // view space
    @location(1) material: vec4f, // reflectivity, roughness
}

// Draws the two images that the reflections read of the G-buffer. A surface whose reflection is faded out gets
// reflectivity 0.
@fragment
fn inputs(@builtin(position) position: vec4f) -> Inputs {
    let surface = surface_at(vec2i(position.xy));
    let normal = (view.view_from_world * vec4f(surface.normal, 0.0)).xyz;
    let reflectivity = dot(surface.f0, vec3f(0.2126, 0.7152, 0.0722));
    let is_seen = shown(surface.perceptual_roughness) > 0.0;
    let roughness = lobe_roughness(surface.perceptual_roughness);
    return Inputs(vec4f(normal, 0.0), vec4f(select(0.0, reflectivity, is_seen), roughness, 0.0, 0.0));
}

// Returns a direction, rotated by a unit quaternion.
fn turned(direction: vec3f, quaternion: vec4f) -> vec3f {
    let across = 2.0 * cross(quaternion.xyz, direction);
    return direction + quaternion.w * across + cross(quaternion.xyz, across);
}

// Returns the light of the environment map from a direction of the world, at a mip level. Bevy looks cube maps up with z
// negated.
fn environment(direction: vec3f, level: f32) -> vec3f {
    let along = turned(direction, view.environment) * vec3f(1.0, 1.0, -1.0);
    return view.exposure * textureSampleLevel(environment_map, linear_sampler, along, level).rgb;
}

// Draws a face of the environment map, in the layout of a Vulkan cube map that is looked up by directions of the world.
@fragment
fn face(corner: Corner) -> @location(0) vec4f {
    let side = f32(textureDimensions(environment_map).x);
    let s = 2.0 * corner.position.x / side - 1.0;
    let t = 2.0 * corner.position.y / side - 1.0;
    var direction = vec3f(1.0, -t, -s);
    switch corner.face {
        case 1u: { direction = vec3f(-1.0, -t, s); }
        case 2u: { direction = vec3f(s, 1.0, t); }
        case 3u: { direction = vec3f(s, -1.0, -t); }
        case 4u: { direction = vec3f(s, -t, 1.0); }
        case 5u: { direction = vec3f(-s, -t, -1.0); }
        default: {}
    }
    return vec4f(environment(direction, 0.0), 1.0);
}

// Adds the reflected light to the lit colour. Where the rays found no light, or the surface is too rough, the environment
// map is reflected.
@fragment
fn add(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let lit = textureLoad(lit_buffer, pixel, 0);
    let surface = surface_at(pixel);
    if all(surface.f0 == vec3f(0.0)) {
        return lit;
    }
    let ndc = position.xy / vec2f(textureDimensions(depth_buffer)) * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    let world = view.world_from_clip * vec4f(ndc, surface.depth, 1.0);
    let to_eye = normalize(select(view.eye.xyz - world.xyz / world.w, view.eye.xyz, view.eye.w > 0.5));
    let facing = max(dot(surface.normal, to_eye), 1e-4);
    let mirrored = reflect(-to_eye, surface.normal);
    let found = textureLoad(reflection_buffer, pixel, 0);
    let around = environment(mirrored, surface.perceptual_roughness * view.levels);
    let light = mix(around, found.rgb, found.a * shown(surface.perceptual_roughness));
    return vec4f(lit.rgb + light * reflected_share(surface, facing), lit.a);
}

// Returns the share of light that a lobe reflects, by the fit that Bevy uses for environment maps (Karis, "Physically
// Based Shading on Mobile"). `facing` is the cosine between the normal and the direction to the eye.
fn reflected_share(surface: Surface, facing: f32) -> vec3f {
    let r = surface.perceptual_roughness * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let a = min(r.x * r.x, exp2(-9.28 * facing)) * r.x + r.y;
    let factors = max(vec2f(-1.04, 1.04) * a + r.zw, vec2f(0.0));
    return surface.f0 * factors.x + factors.y;
}

// Copies depth to a colour image, for the component `KeepImages`.
@fragment
fn depth(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(textureLoad(depth_buffer, vec2i(position.xy), 0), 0.0, 0.0, 0.0);
}
