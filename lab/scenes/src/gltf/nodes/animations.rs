//! Converts animations of nodes (translation, rotation and scale) to motions of the scene. A faulty animation is left
//! out with a note, since the scene is complete without it.

use super::Nodes;
use crate::Mesh;
use crate::gltf::Notes;
use crate::gltf::data::Data;
use crate::motion::{Changes, Interpolation, Keys, Motion, Mover, MovingNode, Rest};
use glam::{DMat4, DQuat, DVec3};
use gltf::accessor::Dimensions;
use gltf::scene::Transform;
use gltf::{Accessor, Node};
use serde::Deserialize;
use serde_json::Value;
use ssct_geometry::bounded;
use std::collections::HashMap;
use std::sync::Arc;

/// Greatest number of nodes in a motion. For each moving node, all nodes from it up to its root are counted.
const MAX_NODES: usize = 1 << 20;

/// An animation, as the JSON of glTF states it.
#[derive(Deserialize)]
struct AnimationJson {
    name: Option<String>,
    #[serde(default)]
    channels: Vec<ChannelJson>,
    #[serde(default)]
    samplers: Vec<SamplerJson>,
}

/// A channel of an animation: the index of a sampler, and what the sampler's values change.
#[derive(Deserialize)]
struct ChannelJson {
    sampler: usize,
    target: TargetJson,
}

/// The target of a channel.
#[derive(Deserialize)]
struct TargetJson {
    /// Node of the target; the target of an extension has none.
    node: Option<usize>,
    /// The changed property: `translation`, `rotation`, `scale` or `weights`.
    path: String,
}

/// A sampler: the indices of the accessors of its times (`input`) and of its values (`output`).
#[derive(Deserialize)]
struct SamplerJson {
    input: usize,
    output: usize,
    interpolation: Option<String>,
}

/// Converts the animations of a file to motions. `names` has the names of the nodes' meshes, by the nodes' indices, and
/// `meshes` are the meshes of the scene. `origin`, in metres, is subtracted from every position in the world.
pub(super) fn motions(
    data: &Data,
    animations: &Value,
    nodes: &Nodes,
    origin: DVec3,
    names: &HashMap<usize, String>,
    meshes: &[Mesh],
    notes: &mut Notes,
) -> Vec<Motion> {
    let accessors: Vec<Accessor> = data.document.accessors().collect();
    let mut motions = Vec::new();
    for (number, animation) in animations.as_array().into_iter().flatten().enumerate() {
        let Ok(json) = AnimationJson::deserialize(animation) else {
            notes
                .add(&format!("animation {number}"), format!("animation {number} is not one of glTF and was left out"));
            continue;
        };
        let name = json.name.clone().unwrap_or_else(|| number.to_string());
        match changes(data, &accessors, &json, notes) {
            Ok(changes) => {
                let movers = movers(data, nodes, origin, &changes, names, meshes, notes);
                if !movers.is_empty() {
                    motions.push(Motion { name, movers });
                }
            }
            Err(clause) => {
                let name = bounded::printable_name(&name);
                notes.add(&format!("animation {number}"), format!("animation {name} was left out: {clause}"));
            }
        }
    }
    motions
}

/// Reads how an animation changes nodes. The result has the changes of each node, by the index of the node.
///
/// # Errors
/// A clause that says what is wrong with the animation.
fn changes(
    data: &Data,
    accessors: &[Accessor],
    json: &AnimationJson,
    notes: &mut Notes,
) -> Result<HashMap<usize, Changes>, String> {
    let mut changed: HashMap<usize, Changes> = HashMap::new();
    for (number, channel) in json.channels.iter().enumerate() {
        let Some(node) = channel.target.node else { continue };
        let message_about = |clause: &str| format!("its channel {number} {clause}");
        let sampler = json.samplers.get(channel.sampler).ok_or_else(|| message_about("has no sampler"))?;
        let input_and_output = [sampler.input, sampler.output].map(|index| accessors.get(index));
        let [Some(input), Some(output)] = input_and_output else { return Err(message_about("has no accessor")) };
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            Some(_) => return Err(message_about("has an interpolation that is not one of glTF")),
        };
        if channel.target.path == "weights" {
            notes.add("weights", "animations of morph targets are not played".to_owned());
            continue;
        }
        let node_changes = changed.entry(node).or_default();
        let sampled = (data, input, output, interpolation);
        match channel.target.path.as_str() {
            "translation" => {
                node_changes.offset = Some(keys(sampled, Dimensions::Vec3).map_err(|clause| message_about(&clause))?)
            }
            "rotation" => {
                node_changes.turn = Some(keys(sampled, Dimensions::Vec4).map_err(|clause| message_about(&clause))?)
            }
            "scale" => {
                node_changes.size = Some(keys(sampled, Dimensions::Vec3).map_err(|clause| message_about(&clause))?)
            }
            _ => return Err(message_about("changes what is not one of glTF")),
        }
    }
    Ok(changed)
}

/// Reads the keys of a channel: times from the accessor `input`, and values of `N` numbers from the accessor `output`,
/// whose shape must be `dimensions`.
///
/// # Errors
/// A clause that says what is wrong with the channel.
fn keys<const N: usize>(
    (data, input, output, interpolation): (&Data, &Accessor, &Accessor, Interpolation),
    dimensions: Dimensions,
) -> Result<Arc<Keys<N>>, String> {
    if input.dimensions() != Dimensions::Scalar || output.dimensions() != dimensions {
        return Err("has accessors of another kind".to_owned());
    }
    let (times, values) = (data.floats::<1>(input), data.floats::<N>(output));
    let (Ok(times), Ok(values)) = (times, values) else {
        return Err("has accessors that cannot be read".to_owned());
    };
    let times = (0..times.len()).map(|index| times.get(index)[0]).collect();
    let values = (0..values.len()).map(|index| values.get(index)).collect();
    Keys::new(times, values, interpolation).map(Arc::new).map_err(str::to_owned)
}

/// Finds the nodes with meshes that an animation moves. `changes` are the changes of nodes by their indices; the other
/// parameters are those of [`motions`]. A note tells of cameras and lights that would move, since motions have none.
fn movers(
    data: &Data,
    nodes: &Nodes,
    origin: DVec3,
    changes: &HashMap<usize, Changes>,
    names: &HashMap<usize, String>,
    meshes: &[Mesh],
    notes: &mut Notes,
) -> Vec<Mover> {
    let all_nodes: Vec<Node> = data.document.nodes().collect();
    let parents = nodes.parents(data);
    let subtract_origin = DMat4::from_translation(-origin);
    let mut movers = Vec::new();
    let mut chain_nodes = 0;
    for (node, to_world) in &nodes.shown {
        let is_camera_or_light = node.camera().is_some() || node.light().is_some();
        let name = names.get(&node.index());
        if name.is_none() && !is_camera_or_light {
            continue;
        }
        // Indices of the node, its parent and so on up to the root. The limit ends the chain in a file with a cycle.
        let upwards = std::iter::successors(Some(node.index()), |index| parents[*index]);
        let node_and_ancestors: Vec<usize> = upwards.take(all_nodes.len()).collect();
        let is_moved = node_and_ancestors.iter().any(|index| changes.contains_key(index));
        if is_moved && is_camera_or_light {
            let sentence = "animations of cameras and lights are not played; they stay where they stand at rest";
            notes.add("cameras move", sentence.to_owned());
        }
        let Some(name) = name else { continue };
        if node.skin().is_some() {
            notes.add("skins move", "animations of skins are not played".to_owned());
            continue;
        }
        if !is_moved {
            continue;
        }
        if [to_world.x_axis, to_world.y_axis, to_world.z_axis].iter().all(|axis| axis.truncate() == DVec3::ZERO) {
            let name = bounded::printable_name(name);
            notes.add("no size", format!("{name} is never drawn, since its size is 0 while no animation plays"));
            continue;
        }
        let chain = moving_chain(node_and_ancestors.iter().rev().map(|index| (&all_nodes[*index], changes.get(index))));
        chain_nodes += node_and_ancestors.len();
        if chain_nodes > MAX_NODES {
            notes.add(
                "many move",
                "more things move in an animation than are played; the others stand still".to_owned(),
            );
            break;
        }
        let mover = Mover {
            meshes: mesh_names_of_node(name, meshes),
            root: subtract_origin * nodes.file_to_world(),
            nodes: chain,
            rest: subtract_origin * *to_world,
        };
        if mover.is_placed() {
            movers.push(mover);
        } else {
            let name = bounded::printable_name(name);
            notes.add(
                "uneven",
                format!("{name} stands still: a size that changes along one axis alone is not supported"),
            );
        }
    }
    movers
}

/// Makes the chain of moving nodes from the root down to a node. `path` has each node on this way with its changes, if
/// it has any. Successive nodes that do not change are combined.
fn moving_chain<'a>(path: impl Iterator<Item = (&'a Node<'a>, Option<&'a Changes>)>) -> Vec<MovingNode> {
    let mut chain: Vec<MovingNode> = Vec::new();
    for (node, changes) in path {
        let rest = rest_transform(node);
        match (changes, chain.last_mut()) {
            (Some(changes), _) => chain.push(MovingNode { rest, changes: changes.clone() }),
            (None, Some(MovingNode { rest: Rest::Matrix(matrix), .. })) => *matrix *= rest.matrix(),
            (None, _) => chain.push(MovingNode::still(Rest::Matrix(rest.matrix()))),
        }
    }
    chain
}

/// Returns the transform of a node, to its parent's space, while no animation plays.
fn rest_transform(node: &Node) -> Rest {
    match node.transform() {
        Transform::Matrix { matrix } => {
            Rest::Matrix(DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))))
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let [offset, size] = [translation, scale].map(|vector| DVec3::from_array(vector.map(f64::from)));
            Rest::Parts(offset, DQuat::from_array(rotation.map(f64::from)), size)
        }
    }
}

/// Returns the names of the meshes of a node. A mesh has the name of its node. A large mesh that was split has it with
/// a number and the count of parts, as in "wall 1/3".
fn mesh_names_of_node(name: &str, meshes: &[Mesh]) -> Vec<String> {
    let is_part = |rest: &str| {
        let number_and_count = rest.strip_prefix(' ').and_then(|rest| rest.split_once('/'));
        number_and_count.is_some_and(|(number, count)| number.parse::<u32>().is_ok() && count.parse::<u32>().is_ok())
    };
    let mut names: Vec<String> = Vec::new();
    for mesh in meshes {
        let is_of_node = mesh.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || is_part(rest));
        if is_of_node && !names.contains(&mesh.name) {
            names.push(mesh.name.clone());
        }
    }
    names
}
