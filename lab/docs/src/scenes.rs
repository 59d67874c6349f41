//! Counts of the built-in scenes, and the methods that lack something in them.

use crate::records::Row;
use ssct::methods::METHODS;
use ssct_scenes::library;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

/// Facts about a built-in scene.
#[derive(Debug, Clone)]
struct SceneFacts {
    /// The counts, as the fields of a row.
    counts: Row,
    /// The names of the methods that lack something that they need.
    lacking: Vec<&'static str>,
}

/// The facts about the scenes that were asked for, by the scene's name.
static KNOWN: Mutex<BTreeMap<&'static str, SceneFacts>> = Mutex::new(BTreeMap::new());

/// Returns the facts about the scene of this name in the library; `None` if there is no such scene. The scene is made
/// only for the first question about it, since that takes long; [`KNOWN`] keeps the facts.
fn scene_facts(name: &str) -> Option<SceneFacts> {
    let name = library::names().iter().copied().find(|listed| *listed == name)?;
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(facts) = known.get(name) {
        return Some(facts.clone());
    }
    let scene = library::scene(name)?;
    // The number of different edges of a mesh.
    let edges = |indices: &[u32]| {
        let sides = indices.chunks_exact(3).flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        sides.map(|[a, b]| [a.min(b), a.max(b)]).collect::<BTreeSet<_>>().len()
    };
    let counts = [
        ("vertices", scene.meshes.iter().map(|m| m.vertices.len()).sum::<usize>()),
        ("edges", scene.meshes.iter().map(|m| edges(&m.indices)).sum::<usize>()),
        ("textures", scene.textures.len()),
        ("billboards", scene.impostors.len()),
    ];
    let counts = counts.map(|(what, count)| (what.to_owned(), count.to_string())).into();
    let lacking = METHODS.iter().filter(|m| !m.unmet_needs(&scene).is_empty()).map(|m| m.name).collect();
    Some(known.entry(name).or_insert(SceneFacts { counts, lacking }).clone())
}

/// Returns the counts of a built-in scene: vertices, edges, textures and billboards. An edge counts once for all
/// triangles of a mesh that share it.
pub(crate) fn counts(scene: &str) -> Option<Row> {
    scene_facts(scene).map(|facts| facts.counts)
}

/// Returns whether a method lacks something that it needs in a scene of the library.
pub fn lacks(scene: &str, method: &str) -> bool {
    scene_facts(scene).is_some_and(|facts| facts.lacking.contains(&method))
}

/// Returns the scene of a row from its fields `scene` and `case`. Without the field `scene`, it is the library's scene
/// that the case names before a colon, as in `rooms: camera on the floor`; `None` if it names none.
pub fn scene_of_row<'a>(scene: Option<&'a str>, case: Option<&'a str>) -> Option<&'a str> {
    scene.or_else(|| case?.split_once(": ").map(|(name, _)| name).filter(|name| library::names().contains(name)))
}
