//! The inputs from which fuzzing starts: small files of every kind that the loaders read.

use crate::entry;
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::*;
use image::{DynamicImage, ImageFormat, RgbaImage};
use ssct_scenes::{Camera, GBufferData, Lens, Surface, gbuffer_file};

use std::io::Cursor;
use std::path::Path;

/// A scene file with meshes, materials, lights and a view.
const SCENE: &str = "name = \"n\"\nhandedness = \"left\"\nscale = 0.5\n[[mesh]]\nfile = \"m.obj\"\nsurface = \"sky\"\n\
    [material.m]\nroughness = 0.5\nreflectivity = 0.25\nnormal_deviation = 1\n[material.default]\nroughness = 0.1\n\
    [camera]\nnear = 0.1\nfar = 10.0\nfov_y_deg = 60\n[[light]]\nkind = \"point\"\nposition = [1.0, 2.0, 3.0]\n\
    energy = 1.0\n[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nenergy = 0.5\n[view.a]\n\
    eye = [0.0, 0.0, 1.0]\nlook_at = [0.0, 0.0, 0.0]\nfov_y_deg = 40.0\nmaterials = { n = { reflectivity = 1.0 } }\n";

/// A scene file with a probe, an impostor, area lights, a camera path and a capture.
const PROXIES: &str = "[[mesh]]\nfile = \"m.obj\"\n[[probe]]\nname = \"p\"\nposition = [0, 0, 0]\nmin = [-1, -1, -1]\n\
    max = [1.0, 1.0, 1.0]\n[[impostor]]\nname = \"i\"\nfile = \"x.png\"\ncentre = [0, 0, 0]\nhalf_u = [1, 0, 0]\n\
    half_v = [0, -1, 0]\n[[area_light]]\nkind = \"sphere\"\nradiance = [1, 1, 1]\ncentre = [0, 0, 0]\nradius = 1.0\n\
    [[area_light]]\nkind = \"capsule\"\nradiance = [1, 1, 1]\na = [0, 0, 0]\nb = [0, 1, 0]\nradius = 1.0\n\
    [[area_light]]\nkind = \"rectangle\"\nradiance = [1, 1, 1]\ncentre = [0, 0, 0]\nhalf_u = [1, 0, 0]\n\
    half_v = [0, 1, 0]\n[[path.p.key]]\neye = [0, 0, 0]\nlook_at = [0, 0, 1]\n[[path.p.key]]\neye = [1, 0, 0]\n\
    look_at = [1, 0, 1]\n[[capture]]\nplace = [0, 1.5, 0]\nresolution = 64\nnear = 0.1\n";

/// A file of a camera path whose keys have times.
const PATH: &str = "name = \"p\"\n[[key]]\neye = [0, 0, 0]\nlook_at = [0, 0, 1]\ntime = 0\n[[key]]\neye = [1, 0, 0]\n\
    look_at = [1.5, 0, 1]\ntime = 1.5\n[[key]]\neye = [1, 2, 0]\nlook_at = [1, 0, 1]\ntime = 3.0\n";

/// A glTF file with most of the features that the loader reads: the square of [`entry::square`], an image, a camera and
/// a light.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"children":[2],
"rotation":[0,0.7,0,0.7],"translation":[0,1,0],"scale":[1,-2,1]},{"camera":0,"translation":[0,0,4],
"extensions":{"KHR_lights_punctual":{"light":0}}},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,3,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":3,"material":0},
{"attributes":{"POSITION":0},"mode":6}]}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0,
"extensions":{"KHR_texture_transform":{"rotation":1,"scale":[2,2],"offset":[0.5,0]}}},"metallicRoughnessTexture":{"index":0}},
"normalTexture":{"index":0,"scale":0.5},"emissiveFactor":[1,0.5,0],"emissiveTexture":{"index":0},"alphaMode":"MASK",
"alphaCutoff":0.4,"doubleSided":true,"extensions":{"KHR_materials_ior":{"ior":1.4},
"KHR_materials_emissive_strength":{"emissiveStrength":2}}}],"textures":[{"source":0,"sampler":0}],"samplers":[{"wrapS":33071}],
"images":[{"uri":"x.png"}],"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.2}}],
"extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":64,
"color":[1,1,0],"spot":{}}]}},"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],
"max":[2,1,0]},{"bufferView":0,"byteOffset":48,"componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,
"componentType":5126,"count":4,"type":"VEC2"},{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":96,"byteStride":12},{"buffer":0,"byteOffset":96,"byteLength":32},{"buffer":0,
"byteOffset":128,"byteLength":12}],"buffers":[{"byteLength":140,"uri":"b.bin"}]}"#;

/// Writes the seeds of all targets, as files `seed-*` in a folder of the target's name below `root`.
pub fn write_all(root: &Path) {
    let obj_and_mtl = [entry::OBJ, b"\0", entry::MTL].concat();
    let obj_alone =
        b"o a\rv 0 0 0 1\rv 1 0 0 .5 .5 .5\rv 0 1 0\rv 2 2 0\rvt 0.5\rf 1/1 2/1 3/1 4\rg\rfo 1 2 3 # c\rl 1 2\rp 1\r";
    write(root, "obj", &[obj_and_mtl, obj_alone.to_vec()]);
    write(root, "scene", &[SCENE, PROXIES].map(|scene| scene.as_bytes().to_vec()));
    let untimed_path = PATH.lines().filter(|line| !line.starts_with("time")).collect::<Vec<_>>().join("\n");
    write(root, "gltf", &[GLTF.as_bytes().to_vec(), glb()]);
    write(root, "camera_path", &[PATH.as_bytes().to_vec(), untimed_path.into_bytes()]);
    write(root, "texture", &textures());
    write(root, "method", &[example_march(), two_passes()]);
    write(root, "includes", &includes());
    write(root, "run", &[include_bytes!("../seeds/run").to_vec()]);
    let gbuffers = gbuffers();
    write(root, "gbuffer_map", &maps(&gbuffers));
    write(root, "gbuffer", &gbuffers);
}

/// Returns the example method `march`, whose fragment shader is written for OpenGL, as an input of [`entry::method`].
fn example_march() -> Vec<u8> {
    let manifest = include_str!("../../examples/methods/march/method.toml").replace("march.frag", "a.frag");
    [manifest.as_bytes(), b"\0", include_bytes!("../../examples/methods/march/march.frag")].concat()
}

/// Returns a method of a compute pass and a fragment pass, as an input of [`entry::method`]. The passes have a buffer,
/// a storage image, an image of the previous frame, a uniform block and a constant.
fn two_passes() -> Vec<u8> {
    let manifest = "name = \"two\"\nsummary = \"two passes\"\npatience-s = 2.5\n[conventions]\nclip-depth = \"reversed\"\n\
        [parameter.steps]\nhelp = \"Steps\"\ndefault = 16\nrange = [1, 64]\n[image.ends]\nformat = \"rgba32f\"\nscale = 0.5\n\
        clear = true\n[image.result]\nformat = \"rgba16f\"\nhistory = true\n[buffer.list]\nbytes = 16\nbytes-per-pixel = 4\n\
        fill = 0\n[[pass]]\nname = \"first\"\nshader = \"a.comp\"\ngroups = \"ends\"\n[pass.inputs]\nends = \"ends\"\n\
        list = \"list\"\n[[pass]]\nname = \"second\"\nshader = \"a.frag\"\ntargets = [\"result\"]\n[pass.inputs]\n\
        before = \"previous:result\"\nends = \"ends\"\n[pass.values]\nwide = \"parameter:steps\"\n[output]\n\
        reflection = \"result\"\nhits = \"ends\"\n";
    let compute = "#version 460\nlayout(local_size_x = 8, local_size_y = 8) in;\n\
        layout(binding = 0, rgba32f) uniform writeonly image2D ends;\n\
        layout(std430, binding = 1) buffer List { uint count; uint items[]; } list;\nvoid main() {\n\
        ivec2 at = ivec2(gl_GlobalInvocationID.xy);\nlist.items[atomicAdd(list.count, 1u)] = 1u;\n\
        imageStore(ends, at, vec4(0.0));\n}\n";
    let fragment = "#version 460\nlayout(binding = 0) uniform sampler2D before;\nlayout(binding = 1) uniform sampler2D ends;\n\
        layout(std140, binding = 2) uniform Block { int wide; float gain[2]; } block;\nconst float HALF = 0.5;\n\
        layout(location = 0) out vec4 made;\nvoid main() {\n\
        made = HALF * texture(before, gl_FragCoord.xy / 8.0) + texelFetch(ends, ivec2(block.wide), 0);\n}\n";
    [manifest, fragment, compute].join("\0").into_bytes()
}

/// Returns three methods as inputs of [`entry::includes`]. Their shaders include each other without a cycle, in a cycle
/// that a guard ends, and in an endless cycle.
fn includes() -> Vec<Vec<u8>> {
    let fragment =
        "#version 460\n#include \"b.glsl\"\nlayout(location = 0) out vec4 made;\nvoid main() { made = b(); }\n";
    let acyclic = [fragment, "#include \"c.glsl\"\nvec4 b() { return c(); }\n", "vec4 c() { return vec4(1.0); }\n"];
    let guard = "#ifndef G\n#define G\n#include \"b.glsl\"\nvec4 b() { return vec4(1.0); }\n#endif\n";
    let endless = "#include \"c.glsl\"\n";
    let methods = [acyclic, [fragment, guard, ""], [fragment, endless, "#include \"b.glsl\"\n"]];
    methods.iter().map(|files| files.join("\0").into_bytes()).collect()
}

/// Returns [`GLTF`] as a binary file, which contains its buffer.
fn glb() -> Vec<u8> {
    let mut text = GLTF.replace(",\"uri\":\"b.bin\"", "").into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    // A chunk of a binary glTF file: its length, its kind and its bytes.
    let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), kind, bytes].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", &entry::square())].concat();
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

/// Writes the seeds of a target, as files `seed-*` in a folder of the target's name below `root`.
fn write(root: &Path, target: &str, seeds: &[Vec<u8>]) {
    let folder = root.join(target);
    std::fs::create_dir_all(&folder).expect("a folder");
    for (number, seed) in seeds.iter().enumerate() {
        std::fs::write(folder.join(format!("seed-{number:02}")), seed).expect("a file");
    }
}

/// Returns images of several formats, as inputs of [`entry::texture`]: each follows the byte that chooses the file's
/// name and the use.
fn textures() -> Vec<Vec<u8>> {
    let image = RgbaImage::from_fn(5, 4, |x, y| image::Rgba([x as u8 * 50, y as u8 * 60, 200, 255 - x as u8]));
    let image = DynamicImage::from(image);
    let images = [
        image.clone(),
        image.to_rgb8().into(),
        image.to_luma8().into(),
        image.to_luma_alpha8().into(),
        image.to_rgba16().into(),
        image.to_luma16().into(),
    ];
    let formats = [(ImageFormat::Tga, 0), (ImageFormat::Png, 1), (ImageFormat::Jpeg, 2), (ImageFormat::Bmp, 3)];
    let mut seeds = Vec::new();
    for (number, image) in images.iter().enumerate() {
        for (format, choice) in formats {
            // The first byte chooses the extension of the file's name (bits 0 and 1) and the use (bits 2 and 3).
            let mut bytes = Cursor::new(vec![choice | (number as u8 & 3) << 2]);
            bytes.set_position(1);
            if image.write_to(&mut bytes, format).is_ok() {
                seeds.push(bytes.into_inner());
            }
        }
    }
    // TGA variants that the encoder does not write: colour maps, and both plain and run-length encoded data of several
    // depths. Each has the image type of the header, the bits of a pixel, and its bytes.
    for (image_type, pixel_bits, pixel_bytes) in
        [(1, 8, 1), (2, 16, 2), (2, 24, 3), (2, 32, 4), (3, 8, 1), (9, 8, 1), (10, 16, 2), (11, 8, 1)]
    {
        // 1 with a colour map, else 0, and the map's fields in the header: first entry, number of entries and bits of
        // an entry.
        let (has_map, map_fields) = if image_type % 8 == 1 { (1, [0, 0, 4, 0, 24]) } else { (0, [0; 5]) };
        let mut bytes = vec![0, 0, has_map, image_type];
        bytes.extend(map_fields);
        // The origin, the size of 4 × 3 texels, the bits of a pixel, and the flag of rows from the top.
        bytes.extend([0, 0, 0, 0, 4, 0, 3, 0, pixel_bits, 0x20]);
        bytes.extend((0..12 * has_map).map(|i| i * 20));
        for row in 0..3_u8 {
            let texel = |column: usize| vec![(row + column as u8) % 4; pixel_bytes];
            // Run-length encoded rows have a run of two equal pixels, and then two single ones.
            if image_type > 8 {
                bytes.push(0x81);
                bytes.extend(texel(0));
                bytes.push(0x01);
                bytes.extend((1..3).flat_map(texel));
            } else {
                bytes.extend((0..4).flat_map(texel));
            }
        }
        seeds.push(bytes);
    }
    seeds
}

/// A map of the program's own G-buffers, with the usual keys of most sections.
const MAP: &str = "origin = \"bottom-left\"\n[camera]\nfov-y-rad = { attribute = \"fovYRadians\" }\nnear = 0.25\n\
    far = 50.0\n\
    world-to-view = { attribute = \"worldToCamera\" }\n[depth]\nchannel = \"depth\"\nkind = \"reversed\"\n[normal]\n\
    channels = [\"N.X\", \"N.Y\", \"N.Z\"]\nspace = \"view\"\n[roughness]\nchannel = \"roughness\"\nkind = \"lobe\"\n\
    [reflectivity]\nchannel = \"reflectivity\"\n[[color]]\nchannels = [\"R\", \"G\", \"B\"]\nscale = 0.5\n";

/// A map with most of the keys that [`MAP`] lacks. It takes channels from `a.exr`, `m.exr` and `x.png`.
const OTHER_MAP: &str = "[conventions]\nworld = \"right-z-up\"\nview = \"right\"\nmatrices = \"rows\"\n\
    clip-y = \"down\"\nmetres-per-unit = 0.5\n[camera]\nfocal-length-mm = 50\nsensor-width-mm = 36.0\naspect = 1.5\n\
    shift-px = [0.5, -0.25]\nnear = 0.1\nfar = 1000\neye = [0, 1, 2]\nforward = [1, 0, 0]\nup = [0, 0, 1]\n[depth]\nchannel = \"Z\"\n\
    kind = \"distance\"\nscale = 2.0\noffset = 1.0\nsky-beyond = 1e9\nsky-value = 0\n[normal]\nfile = \"x.png\"\n\
    channels = [\"R\", \"G\"]\nspace = \"world\"\nencoding = \"octahedral-unorm\"\n[roughness]\nvalue = 0.5\n\
    kind = \"smoothness\"\n[metallic]\nfile = \"m.exr\"\nchannel = \"reflectivity\"\n[base-color]\n\
    value = [1, 0.5, 0]\nencoding = \"srgb\"\n[f0]\nvalue = 0.04\n[[color]]\nvalue = 1.0\n[[color]]\nfile = \"x.png\"\nchannel = \"B\"\n\
    times = { file = \"m.exr\", channels = [\"R\", \"G\", \"B\"] }\n[sky]\nchannel = \"N.X\"\n";

/// A map with a projection matrix of OpenGL, and with a depth buffer whose near and far plane are not those of the
/// camera.
const MATRIX_MAP: &str = "[conventions]\nview = \"right\"\n[camera]\n\
    projection = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.002, -1, 0, 0, -0.2, 0]\n\
    view-to-world = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]\n[depth]\nfile = \"x.png\"\nchannel = \"R\"\n\
    kind = \"minus-one-to-one\"\nnear = 0.2\nfar = inf\n[normal]\nfile = \"x.png\"\nchannels = [\"R\", \"G\", \"B\"]\n\
    space = \"view\"\nencoding = \"octahedral-888\"\n[roughness]\nchannel = \"roughness\"\nkind = \"phong-exponent\"\n\
    [reflectivity]\nvalue = [1, 0.5, 0]\n[[color]]\nfile = \"m.exr\"\nchannel = \"R\"\n";

/// Returns inputs of [`entry::gbuffer_map`]: the three maps alone, and [`MAP`] followed by each G-buffer of one part
/// and of two parts.
fn maps(gbuffers: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let map_with_image = |image: &Vec<u8>| [MAP.as_bytes(), b"\0", image.as_slice()].concat();
    let maps_alone = [MAP, OTHER_MAP, MATRIX_MAP].map(|map| map.as_bytes().to_vec());
    maps_alone.into_iter().chain(gbuffers.iter().chain(&parts()).map(map_with_image)).collect()
}

/// Returns OpenEXR files with the channels of [`MAP`] in two parts. The part of the colours has a lossy compression.
fn parts() -> Vec<Vec<u8>> {
    // A channel of 3 × 2 numbers.
    let flat_channel = |name: &str| AnyChannel::new(name, FlatSamples::F32((0..6).map(|i| i as f32 / 8.0).collect()));
    let layer = |part: &str, names: &[&str], compression, blocks| {
        let channels = AnyChannels::sort(names.iter().map(|name| flat_channel(name)).collect());
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let mut attributes = LayerAttributes::named(part);
        attributes.other.insert("fovYRadians".into(), AttributeValue::F32(1.2));
        attributes.world_to_camera = Some(glam::Mat4::IDENTITY.to_cols_array());
        Layer::new((3, 2), attributes, encoding, channels)
    };
    let data_channels = ["depth", "N.X", "N.Y", "N.Z", "roughness", "reflectivity"];
    let encode = |compression, blocks| {
        let layers = vec![
            layer("data", &data_channels, Compression::ZIP1, Blocks::ScanLines),
            layer("light", &["R", "G", "B"], compression, blocks),
        ];
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((3, 2)));
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layers(attributes, layers).write().non_parallel().to_buffered(&mut bytes).expect("encodes");
        bytes.into_inner()
    };
    vec![
        encode(Compression::DWAA(None), Blocks::ScanLines),
        encode(Compression::DWAB(Some(10.0)), Blocks::Tiles(Vec2(2, 2))),
        encode(Compression::PXR24, Blocks::ScanLines),
    ]
}

/// Returns OpenEXR files of G-buffers in eight compressions, as scan lines and as tiles, with channels of 32 bits and
/// of 16 bits. One has the channel `Z` instead of `depth`, and few attributes.
fn gbuffers() -> Vec<Vec<u8>> {
    let pixels = 6;
    let gbuffer = GBufferData {
        width: 3,
        height: 2,
        camera: Camera::new(glam::Vec3::new(1.0, 2.0, 3.0), glam::Vec3::ZERO, Lens::perspective(1.2, 0.25, 50.0), 1.5),
        depth: (0..pixels).map(|i| i as f32 * 0.15).collect(),
        normal: vec![glam::Vec3::new(0.0, 0.6, -0.8); pixels],
        reflectivity: vec![0.25; pixels],
        roughness: vec![0.1; pixels],
        color: (0..pixels).map(|i| glam::Vec3::splat(i as f32 / 7.0)).collect(),
        surface: vec![Surface::Lit; pixels],
    };
    let first = gbuffer_file::encode(&gbuffer, Path::new("a.exr")).expect("encodes");
    let reader =
        || read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = reader().from_buffered(Cursor::new(&first)).expect("reads");
    let mut seeds = vec![first];
    let encode = |image: &Image<Layer<AnyChannels<FlatSamples>>>| {
        let mut bytes = Cursor::new(Vec::new());
        image.write().non_parallel().to_buffered(&mut bytes).expect("encodes");
        bytes.into_inner()
    };
    use Compression::*;
    for (index, compression) in [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, B44, B44A].into_iter().enumerate() {
        let mut seed = image.clone();
        let blocks = if index % 2 == 1 { Blocks::Tiles(Vec2(2, 2)) } else { Blocks::ScanLines };
        seed.layer_data.encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        // The last four have channels of 16 bits.
        if index > 3 {
            for channel in &mut seed.layer_data.channel_data.list {
                let halves = channel.sample_data.values_as_f32().map(f16::from_f32).collect();
                channel.sample_data = FlatSamples::F16(halves);
            }
        }
        // The third one has the channel `Z` in place of `depth`.
        if index == 2 {
            seed.layer_data.attributes.other.retain(|name, _| name.to_string() == "viewToClip");
            seed.layer_data.channel_data.list.retain(|c| c.name.to_string() != "depth");
        }
        seeds.push(encode(&seed));
    }
    seeds
}
