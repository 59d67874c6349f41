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

/// Returns true if a node hides itself and all nodes below it.
pub(super) fn is_hidden(node: &Node) -> bool {
    let visible = node.extension_value(VISIBILITY).and_then(|members| members.get("visible"));
    visible.and_then(Value::as_bool) == Some(false)
}

/// Returns the transforms of the copies of a node's mesh, in the space of the node; without the extension, a single
/// identity.
///
/// # Errors
/// [`Error::Malformed`](ssct_ground::Error::Malformed) for accessors that are missing, have elements of another kind,
/// or differ in their number of elements.
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
    let mut stated_lengths = lengths.into_iter().flatten();
    let Some(count) = stated_lengths.next() else { return Ok(vec![DMat4::IDENTITY]) };
    if stated_lengths.any(|length| length != count) {
        return Err(data.error(format!("node {}: the attributes of {INSTANCING} differ in length", node.index())));
    }
    let vector_or = |attribute: &Option<Vectors<3>>, copy: usize, default: DVec3| {
        attribute.as_ref().map_or(default, |vectors| DVec3::from_array(vectors.get(copy).map(f64::from)))
    };
    let transform_of_copy = |copy: usize| {
        let rotation = match &rotations {
            Some(rotations) => DQuat::from_array(rotations.get(copy).map(f64::from)),
            None => DQuat::IDENTITY,
        };
        let unit_rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
        DMat4::from_scale_rotation_translation(
            vector_or(&scales, copy, DVec3::ONE),
            unit_rotation,
            vector_or(&translations, copy, DVec3::ZERO),
        )
    };
    Ok((0..count).map(transform_of_copy).collect())
}

/// Returns the vectors of the attribute `name` of the extension [`INSTANCING`] of a node, or `None` if the node has no
/// such attribute. If the accessor is normalized, integers are converted to −1…1 or 0…1.
fn attribute<'a, const N: usize>(
    data: &'a Data,
    node: &Node,
    extension: &Value,
    name: &str,
) -> Result<Option<Vectors<'a, N>>> {
    let Some(index) = extension.get("attributes").and_then(|attributes| attributes.get(name)) else { return Ok(None) };
    let accessor = index.as_u64().and_then(|index| data.document.accessors().nth(usize::try_from(index).ok()?));
    let Some(accessor) = accessor else {
        let node = node.index();
        return Err(
            data.error(format!("nodes[{node}].extensions.{INSTANCING}.attributes.{name} refers to what is not there"))
        );
    };
    data.floats::<N>(&accessor).map(Some)
}
