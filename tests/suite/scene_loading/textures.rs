//! Tests textures of glTF files: filters that samplers ask for, and texture coordinates that are missing.

use super::gltf::{picture, pictured, scene, sentences, square};
use serde_json::{Value, json};

/// Returns the square, whose base colour is an image, with a change.
fn textured(change: impl FnOnce(&mut Value)) -> Value {
    let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
    let mut document = pictured(material, &[picture(1, 1, |_, _| [9; 4])]);
    change(&mut document);
    document
}

/// A sampler that asks for the nearest texel gets a sentence if a texture uses it. A filter between levels of an image
/// is no such sampler.
#[test]
fn nearest_texels_are_said_to_be_filtered() {
    let said = |sampler: &Value, texture: Value| {
        let document = textured(|d| {
            d["samplers"] = json!([sampler]);
            d["textures"][0] = texture;
        });
        sentences(&scene(&document)).join("; ")
    };
    let sampled = json!({"source": 0, "sampler": 0});
    for sampler in [json!({"magFilter": 9728}), json!({"magFilter": 9729, "minFilter": 9728})] {
        assert_eq!(said(&sampler, sampled.clone()), "images that are not to be filtered (NEAREST) are filtered");
        assert_eq!(said(&sampler, json!({"source": 0})), "");
    }
    assert_eq!(said(&json!({"magFilter": 9729, "minFilter": 9986}), sampled), "");
}

/// A mesh without the texture coordinates that its images need gets a sentence. Without images, it needs none.
#[test]
fn missing_texture_coordinates_are_named() {
    let remove = |d: &mut Value| {
        d["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    };
    let other_set =
        |d: &mut Value| d["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1.into();
    for (document, set) in [(textured(remove), 0), (textured(other_set), 1)] {
        let said = format!("mesh square lacks the texture coordinates TEXCOORD_{set} of its images; they count as 0");
        assert_eq!(sentences(&scene(&document)), [said]);
    }
    assert_eq!(sentences(&scene(&square(json!({}), remove))), [""; 0]);
}
