//! Animations of nodes: translation, rotation and scale, as motions of the scene. A faulty animation is left out with a note,
//! since the scene is complete without it.

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

/// Greatest number of nodes that a motion may have, counted on the way from each moving thing up to its root.
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

/// A channel of an animation: the index of a sampler, and the thing that the sampler's values change.
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

/// A sampler: the accessors of its times and of its values.
#[derive(Deserialize)]
struct SamplerJson {
    input: usize,
    output: usize,
    interpolation: Option<String>,
}

/// The motions of a file's animations. `names` has the names of the nodes' meshes, by the nodes' indices; `origin` is
/// subtracted from every place in the world, in metres.
pub(super) fn motions(
    (data, animations): (&Data, &Value),
    (nodes, origin): (&Nodes, DVec3),
    (names, meshes): (&HashMap<usize, String>, &[Mesh]),
    notes: &mut Notes,
) -> Vec<Motion> {
    let accessors: Vec<Accessor> = data.document.accessors().collect();
    let mut motions = Vec::new();
    for (number, value) in animations.as_array().into_iter().flatten().enumerate() {
        let Ok(json) = AnimationJson::deserialize(value) else {
            notes
                .add(&format!("animation {number}"), format!("animation {number} is not one of glTF and was left out"));
            continue;
        };
        let name = json.name.clone().unwrap_or_else(|| number.to_string());
        match changes(data, &accessors, &json, notes) {
            Ok(changes) => {
                let movers = movers(data, nodes, origin, &changes, (names, meshes), notes);
                if !movers.is_empty() {
                    motions.push(Motion { name, movers });
                }
            }
            Err(why) => {
                let name = bounded::printable_name(&name);
                notes.add(&format!("animation {number}"), format!("animation {name} was left out: {why}"));
            }
        }
    }
    motions
}

/// The changes of each node by an animation; the keys of the result are indices of nodes.
///
/// # Errors
/// A clause that says what is wrong.
fn changes(
    data: &Data,
    accessors: &[Accessor],
    json: &AnimationJson,
    notes: &mut Notes,
) -> Result<HashMap<usize, Changes>, String> {
    let mut changed: HashMap<usize, Changes> = HashMap::new();
    for (number, channel) in json.channels.iter().enumerate() {
        let Some(node) = channel.target.node else { continue };
        let refused = |why: &str| format!("its channel {number} {why}");
        let sampler = json.samplers.get(channel.sampler).ok_or_else(|| refused("has no sampler"))?;
        let pair = [sampler.input, sampler.output].map(|i| accessors.get(i));
        let [Some(input), Some(output)] = pair else { return Err(refused("has no accessor")) };
        let between = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            Some(_) => return Err(refused("has an interpolation that is not one of glTF")),
        };
        if channel.target.path == "weights" {
            notes.add("weights", "animations of morph targets are not played".to_owned());
            continue;
        }
        let node_changes = changed.entry(node).or_default();
        let sampled = (data, input, output, between);
        match channel.target.path.as_str() {
            "translation" => node_changes.offset = Some(keys(sampled, Dimensions::Vec3).map_err(|why| refused(&why))?),
            "rotation" => node_changes.turn = Some(keys(sampled, Dimensions::Vec4).map_err(|why| refused(&why))?),
            "scale" => node_changes.size = Some(keys(sampled, Dimensions::Vec3).map_err(|why| refused(&why))?),
            _ => return Err(refused("changes what is not one of glTF")),
        }
    }
    Ok(changed)
}

/// The keys of a channel: times from the accessor `input`, and values of `N` numbers from the accessor `output`.
///
/// # Errors
/// A clause that says what is wrong.
fn keys<const N: usize>(
    (data, input, output, between): (&Data, &Accessor, &Accessor, Interpolation),
    dimensions: Dimensions,
) -> Result<Arc<Keys<N>>, String> {
    if input.dimensions() != Dimensions::Scalar || output.dimensions() != dimensions {
        return Err("has accessors of another kind".to_owned());
    }
    let (times, values) = (data.floats::<1>(input), data.floats::<N>(output));
    let (Ok(times), Ok(values)) = (times, values) else {
        return Err("has accessors that cannot be read".to_owned());
    };
    let times = (0..times.len()).map(|k| times.get(k)[0]).collect();
    let values = (0..values.len()).map(|k| values.get(k)).collect();
    Keys::new(times, values, between).map(Arc::new).map_err(str::to_owned)
}

/// The nodes with meshes that an animation moves.
fn movers(
    data: &Data,
    nodes: &Nodes,
    origin: DVec3,
    changes: &HashMap<usize, Changes>,
    (names, meshes): (&HashMap<usize, String>, &[Mesh]),
    notes: &mut Notes,
) -> Vec<Mover> {
    let all: Vec<Node> = data.document.nodes().collect();
    let parents = nodes.parents(data);
    let to_here = DMat4::from_translation(-origin);
    let mut movers = Vec::new();
    let mut count = 0;
    for (node, to_world) in &nodes.shown {
        let Some(name) = names.get(&node.index()) else { continue };
        let way = std::iter::successors(Some(node.index()), |i| parents[*i]);
        let way: Vec<usize> = way.take(all.len()).collect();
        if node.skin().is_some() {
            notes.add("skins move", "animations of skins are not played".to_owned());
            continue;
        }
        if !way.iter().any(|i| changes.contains_key(i)) {
            continue;
        }
        let chain = chain(way.iter().rev().map(|i| (&all[*i], changes.get(i))));
        count += way.len();
        if count > MAX_NODES {
            notes.add(
                "many move",
                "more things move in an animation than are played; the others stand still".to_owned(),
            );
            break;
        }
        let mover = Mover {
            meshes: meshes_of(name, meshes),
            root: to_here * nodes.root(),
            nodes: chain,
            rest: to_here * *to_world,
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

/// The nodes on the way from the root to a node; successive nodes that do not change are combined.
fn chain<'a>(way: impl Iterator<Item = (&'a Node<'a>, Option<&'a Changes>)>) -> Vec<MovingNode> {
    let mut chain: Vec<MovingNode> = Vec::new();
    for (node, changes) in way {
        let rest = rest(node);
        match (changes, chain.last_mut()) {
            (Some(changes), _) => chain.push(MovingNode { rest, changes: changes.clone() }),
            (None, Some(MovingNode { rest: Rest::Matrix(matrix), .. })) => *matrix *= rest.matrix(),
            (None, _) => chain.push(MovingNode::still(Rest::Matrix(rest.matrix()))),
        }
    }
    chain
}

/// The transform of a node, to its parent's space, while no animation plays.
fn rest(node: &Node) -> Rest {
    match node.transform() {
        Transform::Matrix { matrix } => Rest::Matrix(DMat4::from_cols_array_2d(&matrix.map(|c| c.map(f64::from)))),
        Transform::Decomposed { translation, rotation, scale } => {
            let [offset, size] = [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
            Rest::Parts(offset, DQuat::from_array(rotation.map(f64::from)), size)
        }
    }
}

/// The names of the meshes of a node: its own name or, for a large mesh that was split into `n` parts, the name with `
/// k/n`.
fn meshes_of(name: &str, meshes: &[Mesh]) -> Vec<String> {
    let is_part = |rest: &str| {
        let part = rest.strip_prefix(' ').and_then(|rest| rest.split_once('/'));
        part.is_some_and(|(k, n)| k.parse::<u32>().is_ok() && n.parse::<u32>().is_ok())
    };
    let mut found: Vec<String> = Vec::new();
    for mesh in meshes {
        let is_its = mesh.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || is_part(rest));
        if is_its && !found.contains(&mesh.name) {
            found.push(mesh.name.clone());
        }
    }
    found
}
