//! What the built-in scenes have, and what methods lack in them.

use crate::records::Row;
use ssct::methods::METHODS;
use ssct_scenes::library;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// The methods that lack what they need, by the built-in scene.
static LACKING: LazyLock<BTreeMap<&'static str, Vec<&'static str>>> = LazyLock::new(|| {
    let lacking = |name: &'static str| {
        let scene = library::scene(name)?;
        Some((name, METHODS.iter().filter(|m| !m.lacks(&scene).is_empty()).map(|m| m.name).collect()))
    };
    library::names().iter().copied().filter_map(lacking).collect()
});

/// Whether a method lacks what it needs in a scene of the library.
pub fn lacks(scene: &str, method: &str) -> bool {
    LACKING.get(scene).is_some_and(|methods| methods.contains(&method))
}

/// The scene of a row: its own field, or the library's scene whose name its case begins with.
pub fn of_row<'a>(scene: Option<&'a str>, case: Option<&'a str>) -> Option<&'a str> {
    scene.or_else(|| case?.split_once(": ").map(|(name, _)| name).filter(|name| LACKING.contains_key(name)))
}

/// Counts for each built-in scene: vertices, edges, textures and billboards. An edge counts once for all triangles of a mesh that
/// share it.
pub(crate) fn counts() -> Vec<Row> {
    let edges = |indices: &[u32]| {
        let sides = indices.chunks_exact(3).flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        sides.map(|[a, b]| [a.min(b), a.max(b)]).collect::<BTreeSet<_>>().len()
    };
    let row = |name: &&str| {
        let scene = library::scene(name)?;
        let vertices = scene.meshes.iter().map(|m| m.vertices.len()).sum::<usize>();
        let edges = scene.meshes.iter().map(|m| edges(&m.indices)).sum::<usize>();
        let counts = [
            ("vertices", vertices),
            ("edges", edges),
            ("textures", scene.textures.len()),
            ("billboards", scene.impostors.len()),
        ];
        let counts = counts.map(|(what, count)| (what.to_owned(), count.to_string()));
        Some(counts.into_iter().chain([("scene".to_owned(), (*name).to_owned())]).collect())
    };
    library::names().iter().filter_map(row).collect()
}
