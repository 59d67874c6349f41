//! Copies of a mesh that a node places by `EXT_mesh_gpu_instancing`, and nodes that `KHR_node_visibility` hides.

use crate::gltf::data::{Data, Vectors};
use glam::{DMat4, DQuat, DVec3};
use gltf::Node;
use serde_json::Value;
use ssct_ground::Result;

/// The extension that places copies.
pub(in crate::gltf) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// The extension that hides nodes.
pub(in crate::gltf) const VISIBILITY: &str = "KHR_node_visibility";

/// Whether a node hides itself and all nodes below it.
pub(super) fn is_hidden(node: &Node) -> bool {
    let visible = node.extension_value(VISIBILITY).and_then(|v| v.get("visible"));
    visible.and_then(Value::as_bool) == Some(false)
}

/// The transforms of the copies of a node's mesh, in the space of the node; without the extension, a single identity.
///
/// # Errors
/// [`Error::Malformed`](ssct_ground::Error::Malformed) for accessors that are missing, have other elements, or differ in their
/// number of elements.
pub(super) fn instances(data: &Data, node: &Node) -> Result<Vec<DMat4>> {
    let Some(extension) = node.extension_value(INSTANCING) else { return Ok(vec![DMat4::IDENTITY]) };
    let translations = attribute::<3>(data, node, extension, "TRANSLATION")?;
    let rotations = attribute::<4>(data, node, extension, "ROTATION")?;
    let scales = attribute::<3>(data, node, extension, "SCALE")?;
    let lengths = [
        translations.as_ref().map(Vectors::len),
        rotations.as_ref().map(Vectors::len),
        scales.as_ref().map(Vectors::len),
    ];
    let mut lengths = lengths.into_iter().flatten();
    let Some(count) = lengths.next() else { return Ok(vec![DMat4::IDENTITY]) };
    if lengths.any(|other| other != count) {
        return Err(data.error(format!("node {}: the attributes of {INSTANCING} differ in length", node.index())));
    }
    let vector = |all: &Option<Vectors<3>>, k: usize, default: DVec3| {
        all.as_ref().map_or(default, |all| DVec3::from_array(all.get(k).map(f64::from)))
    };
    let matrix = |k: usize| {
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |all| DQuat::from_array(all.get(k).map(f64::from)));
        let unit = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
        DMat4::from_scale_rotation_translation(
            vector(&scales, k, DVec3::ONE),
            unit,
            vector(&translations, k, DVec3::ZERO),
        )
    };
    Ok((0..count).map(matrix).collect())
}

/// The vectors of an attribute of [`INSTANCING`], or `None` if the node has no such attribute. Integers are converted
/// to −1…1 if the accessor is normalized.
fn attribute<'a, const N: usize>(
    data: &'a Data,
    node: &Node,
    extension: &Value,
    name: &str,
) -> Result<Option<Vectors<'a, N>>> {
    let Some(index) = extension.get("attributes").and_then(|all| all.get(name)) else { return Ok(None) };
    let accessor = index.as_u64().and_then(|index| data.document.accessors().nth(usize::try_from(index).ok()?));
    let Some(accessor) = accessor else {
        let node = node.index();
        return Err(
            data.error(format!("nodes[{node}].extensions.{INSTANCING}.attributes.{name} refers to what is not there"))
        );
    };
    data.floats::<N>(&accessor).map(Some)
}
