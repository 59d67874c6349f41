//! Other readings of a map, each with one change: one convention, the kind of depth, or the way to give the lens.

use super::GBufferMap;
use super::axes::MapConventions;
use ssct_ground::conventions::{Axes, MatrixOrder};

/// A map with one change.
pub(super) struct Reading {
    /// The change, as it would be written in the map.
    pub(super) words: String,
    pub(super) map: GBufferMap,
}

/// Returns all readings that differ from a map in one convention, in the kind of depth, or in how the lens or the place
/// is given.
pub(super) fn other_readings(map: &GBufferMap) -> Vec<Reading> {
    let mut readings = Vec::new();
    // Adds the map after `change`, which `words` describe.
    let mut add = |words: String, change: &dyn Fn(&mut GBufferMap)| {
        let mut changed = map.clone();
        change(&mut changed);
        readings.push(Reading { words, map: changed });
    };
    // The check takes the first of equally good readings. The order of rows comes before axes that mirror the image in
    // the same way, since it is wrong more often.
    let word = if map.bottom_up { "top-left" } else { "bottom-left" };
    add(format!("origin = {word:?}"), &|map| map.bottom_up = !map.bottom_up);
    for (word, kind) in map.depth.other_kinds() {
        add(format!("kind = {word:?} in [depth]"), &|map| map.depth = map.depth.with_kind(kind));
    }
    let axes_of =
        |map: &GBufferMap, is_world: bool| if is_world { map.conventions.world } else { map.conventions.view };
    for (key, is_world) in [("view", false), ("world", true)] {
        for (word, axes) in Axes::NAMES {
            if axes.to_ours() != axes_of(map, is_world) {
                add(format!("{key} = {word:?} in [conventions]"), &|map| {
                    let MapConventions { view, world, .. } = map.conventions;
                    let (view, world) = if is_world { (view, axes.to_ours()) } else { (axes.to_ours(), world) };
                    map.conventions = MapConventions { view, world, ..map.conventions };
                });
            }
        }
    }
    if map.camera.has_place() {
        let word = if map.normals.are_in_world() { "view" } else { "world" };
        add(format!("space = {word:?} in [normal]"), &|map| map.normals = map.normals.in_other_space());
    }
    let (word, order) = match map.conventions.matrices {
        MatrixOrder::Columns => ("rows", MatrixOrder::Rows),
        MatrixOrder::Rows => ("columns", MatrixOrder::Columns),
    };
    add(format!("matrices = {word:?} in [conventions]"), &|map| map.conventions.matrices = order);
    for (words, camera) in map.camera.other_readings() {
        add(words.to_owned(), &|map| map.camera = camera.clone());
    }
    readings
}
