//! Tests extensions of glTF that place geometry, hide it, or store it in another form.

use super::gltf::{Square, close, error, picture, pictured, scene, sentences, square};
use super::*;
use glam::Quat;
use serde_json::{Value, json};

/// The name of the extension that places copies of a mesh.
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Returns the square, placed by the attributes of the instancing extension, which the document uses and does not
/// require.
fn copies(mut square: Square, attributes: Value) -> Value {
    // The accessors of the copies have no bounds, as real files have none there.
    square.accessors.iter_mut().skip(4).for_each(|a| {
        a.as_object_mut().unwrap().retain(|key, _| key != "min" && key != "max");
    });
    let mut document = square.document(json!({}));
    document["extensionsUsed"] = json!([INSTANCING]);
    document["nodes"][0]["translation"] = json!([10, 0, 0]);
    document["nodes"][0]["extensions"] = json!({INSTANCING: {"attributes": attributes}});
    document
}

/// Returns the bounds of the scene's meshes, in order.
fn bounds(scene: &Scene) -> Vec<[Vec3; 2]> {
    scene.meshes.iter().map(|m| [m.bounds.min, m.bounds.max]).collect()
}

/// Three copies of the square stand where translation, rotation and scale of the extension place them below their node.
/// A copy's transformation applies before that of its node.
#[test]
fn copies_stand_where_their_node_places_them() {
    let mut square = Square::new();
    square.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, -7.0]);
    let quarter = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2).to_array();
    square.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0], quarter, [0.0, 0.0, 0.0, 0.0]].concat());
    square.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 3.0, 1.0]);
    let scene = scene(&copies(square, json!({"TRANSLATION": 4, "ROTATION": 5, "SCALE": 6})));
    assert_eq!((sentences(&scene).len(), scene.triangle_count()), (0, 6));
    let expected = [
        [Vec3::new(10.0, 0.0, 0.0), Vec3::new(12.0, 1.0, 0.0)],
        [Vec3::new(8.0, 5.0, 0.0), Vec3::new(10.0, 9.0, 0.0)],
        // The third lies at z = -7 of a right-handed file, and a rotation without a length turns nothing.
        [Vec3::new(10.0, 0.0, 7.0), Vec3::new(12.0, 3.0, 7.0)],
    ];
    for (found, expected) in bounds(&scene).iter().zip(&expected) {
        assert!(found.iter().zip(expected).all(|(a, b)| a.distance(*b) < 1e-5), "{found:?} {expected:?}");
    }
}

/// Rotations of copies in normalised 16-bit integers place the copies as rotations in floats do.
#[test]
fn rotations_of_copies_may_be_quantised() {
    let mut square = Square::new();
    let half = (32767.0 * std::f32::consts::FRAC_1_SQRT_2).round() as i16;
    let turns: Vec<u8> = [0_i16, 0, 0, 32767, 0, 0, half, half].into_iter().flat_map(i16::to_le_bytes).collect();
    square.accessor("VEC4", 5122, 2, &turns);
    square.accessors[4]["normalized"] = true.into();
    let scene = scene(&copies(square, json!({"ROTATION": 4})));
    let [first, second] = bounds(&scene)[..] else { panic!("{}", scene.meshes.len()) };
    assert!(
        first[1].distance(Vec3::new(12.0, 1.0, 0.0)) < 1e-3 && second[1].distance(Vec3::new(10.0, 2.0, 0.0)) < 1e-3
    );
}

/// Attributes of copies that differ in length, are missing, or have a wrong kind are refused with a sentence. Without
/// attributes, the mesh is drawn once.
#[test]
fn copies_that_cannot_be_placed_are_refused() {
    let mut square = Square::new();
    square.floats("VEC3", &[0.0; 6]);
    square.floats("VEC3", &[1.0; 9]);
    let differ = error(&copies(square, json!({"TRANSLATION": 4, "SCALE": 5})));
    assert_eq!(differ, "node 0: the attributes of EXT_mesh_gpu_instancing differ in length");
    let absent = error(&copies(Square::new(), json!({"TRANSLATION": 9})));
    assert_eq!(
        absent,
        "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.TRANSLATION refers to what is not there"
    );
    let wrong = error(&copies(Square::new(), json!({"TRANSLATION": 2})));
    assert!(wrong.contains("must have 3 components"), "{wrong}");
    // Without attributes, the node places its mesh once, as any node does.
    assert_eq!(scene(&copies(Square::new(), json!({}))).triangle_count(), 2);
}

/// A node that is not visible hides the nodes below it as well.
#[test]
fn hidden_nodes_and_what_hangs_from_them_are_not_drawn() {
    let document = square(json!({}), |d| {
        d["extensionsUsed"] = json!(["KHR_node_visibility"]);
        let hides = json!({"KHR_node_visibility": {"visible": false}});
        d["nodes"] = json!([
            {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}},
            {"children": [2], "extensions": hides},
            {"mesh": 0, "translation": [50, 0, 0]},
        ]);
        d["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let scene = scene(&document);
    assert_eq!((scene.triangle_count(), sentences(&scene).len()), (2, 0));
    assert!(close(scene.bounds().max.x, 2.0));
}

/// The warning about an unsupported extension says what is lost by it, if the extension places geometry. A general
/// sentence would not explain why things stand elsewhere.
#[test]
fn an_extension_that_places_geometry_has_a_sentence_of_its_own() {
    for (name, warning) in [
        (
            "MSFT_lod",
            "only the finest level of detail of each thing is drawn, since the extension MSFT_lod is not supported",
        ),
        (
            "CESIUM_RTC",
            "the scene stands at the origin and not around its centre, since the extension CESIUM_RTC is not supported",
        ),
        ("KHR_materials_sheen", "the extension KHR_materials_sheen is not supported and was ignored"),
    ] {
        let scene = scene(&square(json!({}), |d| d["extensionsUsed"] = json!([name])));
        assert_eq!(sentences(&scene), [warning]);
    }
}

/// An extension that an object has and the file does not declare gets the sentence of a declared one. Extensions that
/// are read need no declaration, and the content of extras is no extension.
#[test]
fn undeclared_extensions_have_a_sentence() {
    let said = |change: fn(&mut Value)| sentences(&scene(&square(json!({}), change))).join("; ");
    let undeclared = said(|d| {
        d["materials"][0]["extensions"] = json!({"KHR_materials_sheen": {}, "KHR_materials_ior": {"ior": 1.4}});
    });
    assert_eq!(undeclared, "the extension KHR_materials_sheen is not supported and was ignored");
    assert_eq!(said(|d| d["nodes"][0]["extras"] = json!({"extensions": {"KHR_materials_sheen": {}}})), "");
}

/// A texture transform of any image turns counter-clockwise, scales and moves; maps with different ones get a warning.
#[test]
fn texture_transforms_turn_as_their_words_say() {
    let turned = |transform: Value| {
        let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
        let [base, specular] = [
            json!({"pbrMetallicRoughness": {"baseColorTexture": info}}),
            json!({"extensions": {"KHR_materials_specular": {"specularColorTexture": info}}}),
        ]
        .map(|material| {
            let scene = scene(&pictured(material, &[picture(1, 1, |_, _| [9; 4])]));
            scene.meshes[0].vertices.iter().find(|v| position(v) == Vec3::new(2.0, 1.0, 0.0)).unwrap().uv
        });
        assert_eq!(base, specular);
        Vec2::from(base)
    };
    // The corner has (1, 0). Counter-clockwise, with v downwards, a quarter turn takes it to (0, −1).
    let quarter = json!({"rotation": std::f32::consts::FRAC_PI_2});
    assert!(turned(quarter).abs_diff_eq(Vec2::new(0.0, -1.0), 1e-6));
    let whole = json!({"rotation": std::f32::consts::FRAC_PI_2, "scale": [3, 1], "offset": [0.5, 0.25]});
    assert!(turned(whole).abs_diff_eq(Vec2::new(0.5, -2.75), 1e-6));
    let other = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        "normalTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}});
    let scene = scene(&pictured(other, &[picture(1, 1, |_, _| [128, 128, 255, 255])]));
    assert_eq!(sentences(&scene).len(), 1);
    assert!(sentences(&scene)[0].contains("share one set of texture coordinates"));
}
