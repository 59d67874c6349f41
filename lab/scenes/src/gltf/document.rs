//! Reads the JSON of a glTF file: takes it out of its container, repairs faults where the meaning is obvious, and
//! checks it.
//!
//! The crate `gltf` refuses some documents that the specification allows, and others whose meaning is clear. [`mend`]
//! rewrites values of such documents to the form that the crate parses. The crate's validation then finds faults, of
//! which [`is_harmless`] ignores those that do not matter to this loader.

use super::typed::parse_typed;
use super::{Notes, READ_EXTENSIONS};
use crate::encoding;
use gltf::Document;
use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::json::{Path as JsonPath, Root, texture::WrappingMode};
use serde_json::{Map, Value};
use ssct_ground::{Error, Result};
use std::collections::BTreeSet;
use std::path::Path;

/// The extension for WebP images.
pub(super) const WEBP: &str = "EXT_texture_webp";

/// The extension for an older kind of material, which is not read.
const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";

/// The contents of a file: the checked document, the JSON list of its animations, and the binary chunk.
pub(super) type Content = (Document, Value, Option<Vec<u8>>);

/// Reads the contents of a file.
///
/// # Errors
/// [`Error::Malformed`] for other versions of glTF, other encodings of text, truncated files and wrong documents, each
/// with its own message.
pub(super) fn read(path: &Path, bytes: &[u8], notes: &mut Notes) -> Result<Content> {
    let malformed = |message: String| Error::malformed(path, None, message);
    let (text, binary_chunk) = unpack(bytes).map_err(malformed)?;
    let mut value = parse(text).map_err(malformed)?;
    check_version(&value).map_err(malformed)?;
    let mut extensions = BTreeSet::new();
    collect_extensions(&value, &mut extensions);
    // Animations are taken out and read separately, so that a fault in them does not make the document malformed.
    let animations = value.as_object_mut().and_then(|document| document.remove("animations")).unwrap_or_default();
    mend(&mut value, notes);
    check_lights(&value).map_err(|message| malformed(format!("is not glTF 2.0: {message}")))?;
    let draco_message = draco_only_message(&value);
    let mut json: Root = parse_typed(value).map_err(|e| malformed(format!("is not glTF 2.0: {e}")))?;
    extensions.extend(std::mem::take(&mut json.extensions_used));
    json.extensions_used = extensions.into_iter().collect();
    check_extensions(&mut json, notes).map_err(malformed)?;
    if let Some(message) = draco_message {
        return Err(malformed(message));
    }
    mend_samplers(&mut json, notes);
    validate(&json, notes).map_err(malformed)?;
    Ok((Document::from_json_without_validation(json), animations, binary_chunk))
}

/// Returns the JSON text of a `.gltf` or `.glb` file, and the binary chunk if a `.glb` has one. The error is a message.
fn unpack(bytes: &[u8]) -> std::result::Result<(&[u8], Option<Vec<u8>>), String> {
    let Some(rest) = bytes.strip_prefix(b"glTF") else { return Ok((bytes, None)) };
    let number_at = |offset: usize| {
        rest.get(offset..offset + 4).map(|bytes| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    };
    let (Some(version), Some(stated_bytes)) = (number_at(0), number_at(4)) else {
        return Err(format!("is a truncated .glb: it ends within its header, after {} bytes", bytes.len()));
    };
    if version != 2 {
        return Err(format!("is glTF {version}.0; version 2 is supported"));
    }
    let stated_bytes = stated_bytes as usize;
    if stated_bytes < 12 {
        return Err(format!(
            "is not glTF 2.0: it states a length of {stated_bytes} bytes, which its header alone exceeds"
        ));
    }
    if stated_bytes > bytes.len() {
        return Err(format!("is a truncated .glb: it has {} bytes and states {stated_bytes}", bytes.len()));
    }
    split_chunks(&bytes[12..stated_bytes])
}

/// Splits the chunks of a `.glb`, without its header. Returns the first chunk, which must be JSON, and the first binary
/// chunk; other chunks are ignored, as the specification demands. The error is a message.
fn split_chunks(mut rest: &[u8]) -> std::result::Result<(&[u8], Option<Vec<u8>>), String> {
    let (mut json, mut binary) = (None, None);
    // A chunk is its length (4 bytes), its kind (4 bytes), and its content.
    while let [a, b, c, d, after_length @ ..] = rest
        && after_length.len() >= 4
    {
        let length = u32::from_le_bytes([*a, *b, *c, *d]) as usize;
        let (kind, content) = after_length.split_at(4);
        let Some((content, next_chunk)) = content.split_at_checked(length) else {
            return Err(format!("is a truncated .glb: a chunk states {length} bytes, and {} follow", content.len()));
        };
        match (kind, json) {
            (b"JSON", None) => json = Some(content),
            (_, None) => return Err("is not glTF 2.0: its first chunk is not JSON".to_owned()),
            (b"BIN\0", Some(_)) if binary.is_none() => binary = Some(content.to_vec()),
            _ => {}
        }
        rest = next_chunk;
    }
    json.map(|json| (json, binary)).ok_or_else(|| "is a truncated .glb: it has no JSON".to_owned())
}

/// Parses the JSON text of a document, which may begin with a byte-order mark. The error is a message.
fn parse(text: &[u8]) -> std::result::Result<Value, String> {
    if let Some(name) = encoding::wide_encoding(text) {
        return Err(format!("is {name} text; save it as UTF-8"));
    }
    let text = encoding::without_mark(text);
    serde_json::from_slice(text).map_err(|e| {
        if text.trim_ascii().is_empty() {
            "is empty".to_owned()
        } else if e.is_eof() {
            format!("is a truncated glTF file: its JSON ends too early, in line {}", e.line())
        } else if std::str::from_utf8(text).is_err() {
            format!("is not UTF-8 text, as glTF must be ({e})")
        } else {
            format!("is not JSON, as glTF must be: {e}")
        }
    })
}

/// Checks that a document is of version 2. Without a stated version, it is of version 1 if its lists are objects with
/// names.
///
/// # Errors
/// A message for a document of another version, or without one.
fn check_version(value: &Value) -> std::result::Result<(), String> {
    let Some(document) = value.as_object() else {
        return Err("is not glTF 2.0: its JSON is no object".to_owned());
    };
    let version = match document.get("asset").and_then(|asset| asset.get("version")) {
        Some(Value::String(version)) => Some(version.clone()),
        Some(Value::Number(version)) => version.as_f64().map(|number| format!("{number:.1}")),
        _ => None,
    };
    let list_names = ["nodes", "meshes", "accessors", "buffers", "scenes"];
    let is_version_1 = list_names.iter().any(|name| document.get(*name).is_some_and(Value::is_object));
    match version {
        Some(version) if !version.starts_with("2.") && version != "2" => {
            Err(format!("is glTF {version}; version 2 is supported"))
        }
        None if is_version_1 => Err("is glTF 1.0; version 2 is supported".to_owned()),
        None => Err("is not glTF 2.0: it has no asset with a version".to_owned()),
        Some(_) => Ok(()),
    }
}

/// Rewrites values whose meaning is obvious to the form that the crate parses, and notes attributes that are dropped.
fn mend(document: &mut Value, notes: &mut Notes) {
    mend_values(document);
    if let Some(version) = document.pointer_mut("/asset/version")
        && version.is_number()
    {
        *version = Value::from("2.0");
    }
    for scene in items(document, "scenes") {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    for view in items(document, "bufferViews") {
        // Some exporters write a stride of zero for elements without gaps.
        if let Some(members) = view.as_object_mut().filter(|view| view.get("byteStride") == Some(&Value::from(0))) {
            members.remove("byteStride");
        }
    }
    for texture in items(document, "textures") {
        let webp_source = texture.get("extensions").and_then(|extensions| extensions.get(WEBP)?.get("source").cloned());
        if let (Some(source), Some(texture)) = (webp_source, texture.as_object_mut()) {
            // A file that also has the image as PNG or JPEG keeps that as its source.
            texture.entry("source").or_insert(source);
        }
    }
    for primitive in items(document, "meshes").flat_map(|mesh| items(mesh, "primitives")) {
        if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
            drop_unknown_attributes(attributes, notes);
        }
    }
}

/// Drops attributes that the specification does not define, and notes each of them. Names that begin with an underscore
/// are for applications; they are dropped without a note.
fn drop_unknown_attributes(attributes: &mut Map<String, Value>, notes: &mut Notes) {
    let is_numbered =
        |name: &str, prefix: &str| name.strip_prefix(prefix).is_some_and(|number| number.parse::<u32>().is_ok());
    let is_known = |name: &str| {
        ["POSITION", "NORMAL", "TANGENT"].contains(&name)
            || ["TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"].iter().any(|prefix| is_numbered(name, prefix))
    };
    attributes.retain(|name, _| {
        if !is_known(name) && !name.starts_with('_') {
            notes.add("attributes", format!("the attribute {name} of a mesh is not one of glTF and was ignored"));
        }
        is_known(name)
    });
}

/// Turns numbers without a fraction into integers, since the crate does not accept 4.0 as a count. Drops members that
/// are null, which have no meaning, and the members `extras`, which are for applications.
fn mend_values(value: &mut Value) {
    match value {
        Value::Number(number) => {
            // Below 9e15, which is less than 2⁵³, a 64-bit float holds every whole number.
            let is_whole = |float: &f64| number.is_f64() && float.fract() == 0.0 && float.abs() < 9e15;
            let whole = number.as_f64().filter(is_whole);
            if let Some(whole) = whole {
                *value = Value::from(whole as i64);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(mend_values),
        Value::Object(members) => {
            // Extras may be any value in any object, and this loader does not read them.
            members.retain(|name, member| !member.is_null() && name != "extras");
            members.values_mut().for_each(mend_values);
        }
        _ => {}
    }
}

/// Returns the items of the list `name` of an object; none if it has no such list.
fn items<'a>(object: &'a mut Value, name: &str) -> impl Iterator<Item = &'a mut Value> + use<'a> {
    object.get_mut(name).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Adds the names of all extensions in a document to `names`, whether or not the document declares them.
fn collect_extensions(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| collect_extensions(item, names)),
        Value::Object(members) => {
            // Extras are for applications, and may have any content.
            for (name, member) in members.iter().filter(|(name, _)| *name != "extras") {
                let extensions = member.as_object().filter(|_| name == "extensions");
                names.extend(extensions.into_iter().flat_map(|extensions| extensions.keys().cloned()));
                collect_extensions(member, names);
            }
        }
        _ => {}
    }
}

/// Checks the extensions that a file requires, and notes the ones that it uses and this loader ignores.
///
/// # Errors
/// A message for an extension that the file requires and this loader lacks.
fn check_extensions(json: &mut Root, notes: &mut Notes) -> std::result::Result<(), String> {
    let is_read = |name: &String| READ_EXTENSIONS.contains(&name.as_str());
    if let Some(name) = json.extensions_required.iter().find(|name| !is_read(name)) {
        return Err(format!("requires the extension {name}, which is not supported; {}", remedy(name)));
    }
    // The crate would refuse required extensions that it does not know, even those that this loader reads itself.
    json.extensions_required.clear();
    for name in json.extensions_used.iter().filter(|name| !is_read(name)) {
        if name == SPECULAR_GLOSSINESS {
            let sentence = format!("materials of {name} are not read and look metallic or rough; {}", remedy(name));
            notes.add(name, sentence);
            continue;
        }
        let sentence = match geometry_loss(name) {
            Some(loss) => format!("{loss}, since the extension {name} is not supported"),
            None => format!("the extension {name} is not supported and was ignored"),
        };
        notes.add(name, sentence);
    }
    Ok(())
}

/// Says what is misplaced or missing without an extension that changes geometry; `None` for other extensions.
fn geometry_loss(extension: &str) -> Option<&'static str> {
    Some(match extension {
        "MSFT_lod" => "only the finest level of detail of each thing is drawn",
        "CESIUM_RTC" => "the scene stands at the origin and not around its centre",
        "AGI_articulations" => "parts that the file lets others move stand as the nodes say",
        "KHR_draco_mesh_compression" => "meshes are drawn from their uncompressed copies",
        "KHR_gaussian_splatting" | "KHR_gaussian_splatting_compression_spz_2" => "splats are missing",
        "KHR_materials_displacement" => "surfaces are flat where images should displace them",
        _ => return None,
    })
}

/// Returns advice for a user whose file needs this extension.
pub(super) fn remedy(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" => "`npx @gltf-transform/cli copy IN.glb OUT.glb` writes the meshes without it",
        "KHR_texture_basisu" => "export the images as PNG, JPEG or WebP instead of KTX2",
        "EXT_texture_avif" => "`npx @gltf-transform/cli webp IN.glb OUT.glb` writes the images as WebP",
        "MSFT_texture_dds" => "export the images as PNG, JPEG or WebP",
        SPECULAR_GLOSSINESS => "`npx @gltf-transform/cli metalrough IN.glb OUT.glb` writes materials that are read",
        _ => "export without it",
    }
}

/// Checks that the light of each node exists.
///
/// # Errors
/// A message about the first node whose light does not exist.
fn check_lights(document: &Value) -> std::result::Result<(), String> {
    let light_count =
        document.pointer("/extensions/KHR_lights_punctual/lights").and_then(Value::as_array).map_or(0, Vec::len);
    let nodes = document.get("nodes").and_then(Value::as_array).into_iter().flatten();
    for (index, node) in nodes.enumerate() {
        let light = node.pointer("/extensions/KHR_lights_punctual/light").and_then(Value::as_u64);
        if light.is_some_and(|light| light >= light_count as u64) {
            return Err(format!("nodes[{index}].extensions.KHR_lights_punctual.light refers to what is not there"));
        }
    }
    Ok(())
}

/// Returns the message about the first mesh whose bytes exist only in Draco's format; `None` if there is no such mesh.
fn draco_only_message(document: &Value) -> Option<String> {
    const DRACO: &str = "KHR_draco_mesh_compression";
    let has_plain_bytes = |primitive: &Value| {
        let position = primitive.pointer("/attributes/POSITION").and_then(Value::as_u64);
        let accessor = position.and_then(|index| document.get("accessors")?.get(usize::try_from(index).ok()?));
        accessor.is_none_or(|accessor| accessor.get("bufferView").is_some())
    };
    let is_draco_only = |mesh: &Value| {
        let primitives = mesh.get("primitives").and_then(Value::as_array).into_iter().flatten();
        let is_compressed =
            |primitive: &&Value| primitive.get("extensions").is_some_and(|extensions| extensions.get(DRACO).is_some());
        primitives.filter(is_compressed).any(|primitive| !has_plain_bytes(primitive))
    };
    let index = document.get("meshes")?.as_array()?.iter().position(is_draco_only)?;
    Some(format!("meshes[{index}] has no bytes but those of {DRACO}; {}", remedy(DRACO)))
}

/// Replaces each invalid wrapping mode of an image by the default, which repeats the image, and drops invalid filters.
fn mend_samplers(json: &mut Root, notes: &mut Notes) {
    for sampler in &mut json.samplers {
        sampler.mag_filter = sampler.mag_filter.take().filter(|filter| *filter != Checked::Invalid);
        sampler.min_filter = sampler.min_filter.take().filter(|filter| *filter != Checked::Invalid);
        for wrap in [&mut sampler.wrap_s, &mut sampler.wrap_t] {
            if *wrap == Checked::Invalid {
                *wrap = Checked::Valid(WrappingMode::Repeat);
                notes.add("wrapping", "a way in which an image repeats is unknown; it repeats plainly".to_owned());
            }
        }
    }
}

/// Checks the document by the crate's validation, apart from harmless faults.
///
/// # Errors
/// A message for the first fault of the document that matters to this loader.
fn validate(json: &Root, notes: &mut Notes) -> std::result::Result<(), String> {
    // The crate's own check of positions reads the accessor without checking that it exists.
    let position = Checked::Valid(gltf::Semantic::Positions);
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let positions = primitives.filter_map(|primitive| primitive.attributes.get(&position));
    if positions.map(|index| index.value()).any(|index| index >= json.accessors.len()) {
        return Err("is not glTF 2.0: positions are in an accessor that is not there".to_owned());
    }
    let mut first_fault = None;
    json.validate(json, JsonPath::new, &mut |path, fault| {
        let path = path_in_json(&path());
        if !is_harmless(&path, fault, notes) && first_fault.is_none() {
            let problem = match fault {
                Fault::IndexOutOfBounds => "refers to what is not there",
                Fault::Invalid => "has a value that it cannot have",
                Fault::Missing => "is missing",
                Fault::Oversize => "is too large",
                Fault::Unsupported => "is not supported",
            };
            first_fault = Some(format!("is not glTF 2.0: {path} {problem}"));
        }
    });
    first_fault.map_or(Ok(()), Err)
}

/// Returns the place of a fault with the names of the JSON. The crate names extensions by its own fields, such as
/// `khrMaterialsIor`, which becomes `KHR_materials_ior`.
fn path_in_json(path: &JsonPath) -> String {
    let is_extension_field =
        |part: &str| part.strip_prefix("khr").is_some_and(|rest| rest.starts_with(char::is_uppercase));
    let parts = path.as_str().split('.').map(|part| {
        if !is_extension_field(part) {
            return part.to_owned();
        }
        let mut name = String::from("KHR");
        for letter in part["khr".len()..].chars() {
            name.extend(letter.is_uppercase().then_some('_'));
            name.extend(letter.to_lowercase());
        }
        name
    });
    parts.collect::<Vec<_>>().join(".")
}

/// Returns true if a fault at `path` does not matter to this loader. Bounds of positions are computed, an accessor
/// without a view has zeros, and a primitive without positions is not drawn. Strides are checked elsewhere, and the
/// target of a view is not used.
fn is_harmless(path: &str, fault: Fault, notes: &mut Notes) -> bool {
    let ends_with = |end: &str| path.ends_with(end);
    if ends_with(".attributes[\"POSITION\"].min") || ends_with(".attributes[\"POSITION\"].max") {
        notes.add("bounds", "positions lack their bounds (min and max), which were computed".to_owned());
        return true;
    }
    match fault {
        Fault::Missing if ends_with(".attributes[\"POSITION\"]") => {
            notes.add("positions", "primitives without positions are not drawn".to_owned());
            true
        }
        Fault::Missing => path.starts_with("accessors[") && ends_with("].bufferView"),
        Fault::Invalid => path.starts_with("bufferViews[") && (ends_with("].byteStride") || ends_with("].target")),
        _ => false,
    }
}
