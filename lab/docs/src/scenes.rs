//! What the built-in scenes have, and what methods lack in them.

use crate::records::Row;
use ssct::methods::METHODS;
use ssct_scenes::library;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

/// What is known of a scene: counts, and the methods that lack what they need.
#[derive(Debug, Clone)]
struct Known {
    counts: Row,
    lacking: Vec<&'static str>,
}

/// The scenes that were made already.
static KNOWN: Mutex<BTreeMap<&'static str, Known>> = Mutex::new(BTreeMap::new());

/// What is known of a scene of the library, if there is one of the name.
fn known(name: &str) -> Option<Known> {
    let name = library::names().iter().copied().find(|known| *known == name)?;
    let mut all = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = all.get(name) {
        return Some(known.clone());
    }
    let scene = library::scene(name)?;
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
    let lacking = METHODS.iter().filter(|m| !m.lacks(&scene).is_empty()).map(|m| m.name).collect();
    Some(all.entry(name).or_insert(Known { counts, lacking }).clone())
}

/// Counts of a built-in scene: vertices, edges, textures and billboards. An edge counts once for all triangles of a mesh that share it.
pub(crate) fn counts(scene: &str) -> Option<Row> {
    known(scene).map(|known| known.counts)
}

/// Whether a method lacks what it needs in a scene of the library.
pub fn lacks(scene: &str, method: &str) -> bool {
    known(scene).is_some_and(|known| known.lacking.contains(&method))
}

/// The scene of a row: its own field, or the library's scene whose name its case begins with.
pub fn of_row<'a>(scene: Option<&'a str>, case: Option<&'a str>) -> Option<&'a str> {
    scene.or_else(|| case?.split_once(": ").map(|(name, _)| name).filter(|name| library::names().contains(name)))
}
