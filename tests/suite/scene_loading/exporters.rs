//! Tests one scene as each exporter writes it: glTF, OBJ, and OBJ with PBR keys give the same material
//! (docs/definitions.md, "Exporters of MTL").

use super::gltf::square as gltf_square;
use super::*;
use serde_json::{Value, json};
use ssct_geometry::texture as sampling;
use ssct_scenes::Encoding;
use ssct_scenes::material_terms::roughness_of_perceptual;

/// The header that Blender gives its MTL files.
const BLENDER: &str = "# Blender 5.2.3 LTS MTL File: 'None'\n# www.blender.org\n\n";

/// The lines that Blender writes after every material with PBR extensions. They say that there is no coat.
const NO_COATS: &str = "Ps 0.000000\nPc 0.000000\nPcr 0.030000\naniso 0.000000\nanisor 0.000000\n";

/// Makes a folder with a textured square in the material `m` of an MTL library, and with the pictures of [`pictures`].
fn with_library(text: &str) -> Folder {
    let folder = super::square("mtllib a.mtl\nusemtl m\nf 1/1 2/2 3/3 4/4\n");
    folder.write("a.mtl", text.as_bytes());
    pictures(&folder);
    folder
}

/// Writes the pictures that the libraries name.
fn pictures(folder: &Folder) {
    folder.image("base.png", 2, 2, |x, _| if x == 0 { [200, 120, 60, 255] } else { [90, 200, 220, 255] });
    let grey = |value: u32| [value as u8, value as u8, value as u8, 255];
    folder.image("rough.png", 2, 2, |x, _| grey(60 + 30 * x));
    folder.image("metal.png", 2, 2, |_, y| grey(200 * y));
    folder.image("level.png", 2, 2, |x, _| grey(40 + 60 * x));
    folder.image("emitted.png", 2, 2, |_, y| if y == 0 { [0, 0, 0, 255] } else { [90, 40, 20, 255] });
}

/// Returns the values of the first material in the middle of each of the four texels: albedo (three channels),
/// emission, reflectivity, roughness.
fn texels(scene: &Scene) -> Vec<[f32; 6]> {
    let material = &scene.materials[0];
    let image = |map: Option<usize>, x: usize, y: usize| {
        let uv = glam::DVec2::new((x as f64 + 0.5) / 2.0, (y as f64 + 0.5) / 2.0);
        map.map_or(glam::DVec4::ONE, |i| sampling::bilinear(&scene.textures[i], uv)).as_vec4()
    };
    let texel = |(x, y)| {
        let colour = image(material.albedo_map, x, y);
        let albedo = material.albedo * colour.truncate();
        let emission = if material.emission > 0.0 { material.emission * colour.w } else { 0.0 };
        let reflectivity = material.reflectivity * image(material.reflectivity_map, x, y).x;
        let roughness = material.roughness * image(material.roughness_map, x, y).y;
        [albedo.x, albedo.y, albedo.z, emission, reflectivity, roughness]
    };
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(texel).to_vec()
}

/// One material in three files of Blender's: OBJ, OBJ with PBR keys, and glTF.
struct Exported {
    name: &'static str,
    obj: &'static str,
    pbr: &'static str,
    gltf: Value,
}

/// Returns materials as Blender 5.2.3 writes them: as OBJ, as OBJ with PBR extensions, and as glTF.
fn exported() -> Vec<Exported> {
    let materials = [
        (
            "default",
            "Ns 250.0\nKa 1 1 1\nKd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.5\nd 1\nillum 2\n",
            "Kd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.5\nd 1\nillum 2\nPr 0.5\nPm 0.0\n",
            json!({"pbrMetallicRoughness":
                {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 0.5}}),
        ),
        (
            "metal",
            "Ns 562.5\nKa 1 1 1\nKd 0.9 0.7 0.3\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.5\nd 1\nillum 3\n",
            "Kd 0.9 0.7 0.3\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.5\nd 1\nillum 3\nPr 0.25\nPm 1.0\n",
            json!({"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.7, 0.3, 1], "roughnessFactor": 0.25}}),
        ),
        (
            "half metal",
            "Ns 640.0\nKa 0.5 0.5 0.5\nKd 0.9 0.7 0.3\nKs 0.5 0.5 0.5\nNi 1.5\nd 1\nillum 3\n",
            "Kd 0.9 0.7 0.3\nKs 0.5 0.5 0.5\nNi 1.5\nd 1\nillum 3\nPr 0.2\nPm 0.5\n",
            json!({"pbrMetallicRoughness":
                {"baseColorFactor": [0.9, 0.7, 0.3, 1], "metallicFactor": 0.5, "roughnessFactor": 0.2}}),
        ),
        (
            "level and index",
            "Ns 810.0\nKa 1 1 1\nKd 0.8 0.8 0.8\nKs 0.25 0.25 0.25\nNi 1.8\nd 1\nillum 2\n",
            "Kd 0.8 0.8 0.8\nKs 0.25 0.25 0.25\nNi 1.8\nd 1\nillum 2\nPr 0.1\nPm 0.0\n",
            json!({
                "extensions": {"KHR_materials_specular": {"specularFactor": 0.5}, "KHR_materials_ior": {"ior": 1.8}},
                "pbrMetallicRoughness":
                    {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 0.1},
            }),
        ),
        (
            "no specular",
            "Ns 810.0\nKa 1 1 1\nKd 0.8 0.8 0.8\nKs 0 0 0\nNi 1.5\nd 1\nillum 1\n",
            "Kd 0.8 0.8 0.8\nKs 0 0 0\nNi 1.5\nd 1\nillum 1\nPr 0.1\nPm 0\n",
            json!({
                "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
                "pbrMetallicRoughness":
                    {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 0.1},
            }),
        ),
        (
            "lamp",
            "Ns 810.0\nKa 1 1 1\nKd 0.2 0.2 0.2\nKs 0.5 0.5 0.5\nKe 0.5 0.4 0.3\nNi 1.5\nd 1\nillum 2\n",
            "Kd 0.2 0.2 0.2\nKs 0.5 0.5 0.5\nKe 0.5 0.4 0.3\nNi 1.5\nd 1\nillum 2\nPr 0.1\nPm 0\n",
            json!({
                "emissiveFactor": [0.5, 0.4, 0.3],
                "pbrMetallicRoughness":
                    {"baseColorFactor": [0.2, 0.2, 0.2, 1], "metallicFactor": 0, "roughnessFactor": 0.1},
            }),
        ),
        (
            "images",
            "Ka 1 1 1\nKs 0.5 0.5 0.5\nNi 1.5\nd 1\nillum 2\nmap_Kd base.png\nmap_Ns rough.png\nmap_refl metal.png\n\
             map_Ke emitted.png\n",
            "Ks 0.5 0.5 0.5\nNi 1.5\nd 1\nillum 2\nmap_Kd base.png\nmap_Pm metal.png\nmap_Pr rough.png\n\
             map_Ke emitted.png\n",
            json!({
                "emissiveTexture": {"index": 2}, "emissiveFactor": [1, 1, 1],
                "pbrMetallicRoughness": {
                    "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}, "roughnessFactor": 1,
                },
            }),
        ),
    ];
    materials.into_iter().map(|(name, obj, pbr, gltf)| Exported { name, obj, pbr, gltf }).collect()
}

/// Loads a glTF file with a material, with its images as Blender combines them.
fn gltf_scene(material: Value) -> Scene {
    let folder = Folder::new(&[]);
    pictures(&folder);
    folder.image("both.png", 2, 2, |x, y| [0, 60 + 30 * x as u8, 200 * y as u8, 255]);
    let document = gltf_square(material, |d| {
        d["images"] = json!([{"uri": "base.png"}, {"uri": "both.png"}, {"uri": "emitted.png"}]);
        d["textures"] = json!([{"source": 0}, {"source": 1}, {"source": 2}]);
    });
    folder.write("a.gltf", document.to_string().as_bytes());
    ssct_scenes::gltf::load(&folder.path("a.gltf"), &LoadOptions::default()).unwrap()
}

/// Seven materials from Blender have the same texels from each of the three files, within a step of 8 bits. Each format
/// says roughness and reflectivity in other terms.
#[test]
fn obj_and_gltf_of_one_exporter_are_one_material() {
    for Exported { name, obj, pbr, gltf } in exported() {
        let expected = texels(&gltf_scene(gltf));
        for (text, coats) in [(obj, ""), (pbr, NO_COATS)] {
            let scene = with_library(&format!("{BLENDER}newmtl m\n{text}{coats}")).scene();
            assert_sound(&scene);
            for (texel, expected) in texels(&scene).iter().zip(&expected) {
                let near = texel.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.004);
                assert!(near, "{name}: {texel:?} {expected:?}");
            }
            let other_warnings = scene.warnings.iter().filter(|w| !w.contains("wider than the widest lobe"));
            assert_eq!(other_warnings.count(), 0, "{name}: {:?}", scene.warnings);
        }
    }
}

/// An image of the specular level gives a reflectivity of 0.08 times the level in each texel.
#[test]
fn the_level_of_specular_may_be_an_image() {
    let keys = "Kd 0.8 0.8 0.8\nNi 1.5\nillum 2\nmap_Ks level.png\n";
    for text in [format!("Ns 810\n{keys}"), format!("{keys}Pr 0.1\nPm 0\n")] {
        let scene = with_library(&format!("{BLENDER}newmtl m\n{text}")).scene();
        let expected = [40.0, 100.0].map(|level| 0.08 * level / 255.0);
        for (texel, expected) in texels(&scene).into_iter().zip(expected) {
            let [.., reflectivity, _] = texel;
            assert!((reflectivity - expected).abs() < 0.003, "{text}: {reflectivity} {expected}");
        }
    }
}

/// The version in Blender's header decides what `Ks` means: newer versions count the index of refraction, version 3
/// only the level, and other headers are read as a reflectivity.
#[test]
fn older_versions_of_blender_have_the_level_alone() {
    let reflectivity = |header: &str| {
        let text = format!("{header}\nnewmtl m\nNs 640\nKs 0.5 0.5 0.5\nNi 2.0\nillum 2\n");
        with_library(&text).scene().materials[0].reflectivity
    };
    let assert_near = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} {b}");
    assert_near(reflectivity("# Blender 4.1.0 MTL File: 'x.blend'"), 1.0 / 9.0);
    assert_near(reflectivity("# Blender 3.6.5 MTL File: 'x.blend'"), 0.04);
    // Without a version number in the right form, `Ks` is the reflectivity itself.
    assert_near(reflectivity("# Blender MTL File: 'x.blend'"), 0.5);
    assert_near(reflectivity("# Blender 4.1.0 made the scene"), 0.5);
}

/// The keys `Pr`, `Pm` and `Ni` of any exporter mean what glTF means by roughness, metalness and index of refraction.
#[test]
fn pbr_keys_of_other_exporters_are_those_of_gltf() {
    let folder =
        with_library("# Somebody's exporter\nnewmtl m\nKd 0.9 0.7 0.3\nKs 1 1 1\nPm 1\nPr 0.2\nmap_Ks level.png\n");
    let scene = folder.scene();
    let material = &scene.materials[0];
    assert_eq!((material.albedo, material.roughness), (Vec3::ZERO, roughness_of_perceptual(0.2)));
    assert!((material.reflectivity - sampling::luminance(Vec3::new(0.9, 0.7, 0.3))).abs() < 1e-6);
    let warning = "a.mtl:7: images of specular colour (map_Ks) do not count beside metalness and roughness";
    assert_eq!(folder.warnings(&scene), [warning]);
    let plastic = with_library("newmtl m\nKd 0.9 0.7 0.3\nPr 0.2\n").scene();
    assert!((plastic.materials[0].reflectivity - 0.04).abs() < 1e-6);
    // With a roughness and a specular colour but no metalness, both count.
    let stated = with_library("newmtl m\nKd 0.9 0.7 0.3\nKs 0.5 0.5 0.5\nPr 0.2\nNs 10\n").scene();
    let material = &stated.materials[0];
    assert!((material.reflectivity - 0.5).abs() < 1e-6 && material.roughness == roughness_of_perceptual(0.2));
    let glossy = with_library("newmtl m\nPm 0\nNi 2\nNs 100\n").scene();
    assert!((glossy.materials[0].reflectivity - 1.0 / 9.0).abs() < 1e-6);
    assert!((glossy.materials[0].roughness - 0.334).abs() < 1e-3);
}

/// Values of the images of roughness and metalness are multiplied by the factors beside them.
#[test]
fn images_of_roughness_and_metalness_have_factors() {
    let scene = with_library("newmtl m\nKd 1 1 1\nPr 0.5\nmap_Pr rough.png\nPm 0.5\nmap_Pm metal.png\n").scene();
    assert_sound(&scene);
    let found = texels(&scene);
    let [.., dielectric, left] = found[0];
    let [.., right] = found[1];
    let [albedo, .., metallic, _] = found[2];
    let rough = |byte: f32| roughness_of_perceptual(0.5 * byte / 255.0);
    assert!((left - rough(60.0)).abs() < 0.004 && (right - rough(90.0)).abs() < 0.004, "{found:?}");
    let metal = 0.5 * 200.0 / 255.0;
    assert!((metallic - (0.04 + 0.96 * metal)).abs() < 0.004 && (dielectric - 0.04).abs() < 0.004, "{found:?}");
    assert!((albedo - (1.0 - metal)).abs() < 0.01, "{found:?}");
}

/// Emission as a colour and as an image becomes albedo and the emitted share, since a material of this program has one
/// colour for both.
#[test]
fn emission_is_read_by_every_law() {
    let scene = with_library("newmtl m\nKd 0 0 0\nKs 0 0 0\nKe 0.5 0.25 0\n").scene();
    let material = &scene.materials[0];
    assert_eq!((material.albedo, material.emission, scene.warnings.len()), (Vec3::new(0.5, 0.25, 0.0), 1.0, 0));
    let image = with_library("newmtl m\nKd 0 0 0\nKe 0 0 0\nmap_Ke emitted.png\n").scene();
    let found = texels(&image);
    let ([dark, ..], [red, _, _, emission, ..]) = (found[0], found[2]);
    assert!(dark == 0.0 && (red - 0.1022).abs() < 0.01 && emission > 0.99, "{found:?}");
    assert_eq!(image.textures[image.materials[0].albedo_map.unwrap()].encoding, Encoding::Srgb);
}

/// A coat of strength 0 gets no warning, and other coats and transparency get one each. Blender writes keys of coats
/// for every material, so that a warning for each would hide the true ones.
#[test]
fn only_coats_that_are_there_are_lost() {
    let warnings = |keys: &str| {
        let folder = with_library(&format!("{BLENDER}newmtl m\nKd 1 1 1\nPr 0.1\nPm 0\n{keys}"));
        folder.warnings(&folder.scene())
    };
    assert_eq!(warnings(NO_COATS), [""; 0]);
    let lost = "a.mtl:8: sheen, clear coats and anisotropy are not supported and were ignored";
    assert_eq!(warnings("Pc 0.5\nPcr 0.03\n"), [lost]);
    let glass = warnings("Tf 1 1 1\n");
    assert!(glass.len() == 1 && glass[0].starts_with("a.mtl:8: transparency"), "{glass:?}");
}
