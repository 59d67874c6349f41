//! Times under the thesis's figures beside those measured, and what Schmidt says of his scenes and frame rates beside the
//! built-in scenes that stand for them.

use super::figures::{Result, greatest, grouped, json, least, median, ratio, table, text};
use serde_json::Value;
use ssct_scenes::library;
use std::collections::BTreeSet;
use std::path::Path;

/// Rows of times under the figures 5.2 to 5.9, as `ssct time --table captions` sets them: figure, view, size, roughness,
/// SSCT's time, the other method, its time, the ratio in print, and the one measured.
pub fn rows(folder: &Path) -> Result<Vec<Vec<String>>> {
    let text = text(&folder.join("times"), "time.txt")?;
    let mut rows = Vec::new();
    for line in text.lines().filter(|l| l.starts_with("5.")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [figure, view, width, "x", height, roughness, other, ssct, theirs, .., before, here] = words[..] else {
            return Err(format!("a row of other columns: {line}"));
        };
        let size = format!("{width}×{height}");
        rows.push([figure, view, &size, roughness, ssct, other, theirs, before, here].map(str::to_owned).to_vec());
    }
    Ok(rows)
}

/// The times under the figures as a table.
pub fn captions(folder: &Path) -> Result<String> {
    let head = [
        "figure",
        "view",
        "size",
        "ϱ",
        "SSCT, thesis, ms",
        "beside it",
        "its time, thesis, ms",
        "its time / SSCT's, thesis",
        "its time / SSCT's, here",
    ];
    table(&head, rows(folder)?)
}

/// His scenes, of table 1: vertices, edges, textures, billboards.
const TABLE_1: [(&str, [u64; 4]); 3] = [
    ("street", [60_226, 160_590, 22, 5]),
    ("museum", [147_725, 282_318, 25, 3]),
    ("cathedral", [55_020, 149_719, 17, 0]),
];

/// Counts for a built-in scene; an edge counts once for all triangles of a mesh that share it.
fn counts(scene: &str) -> Result<[u64; 4]> {
    let scene = library::scene(scene).ok_or(format!("there is no built-in scene {scene}"))?;
    let edges = |indices: &[u32]| {
        let sides = indices.chunks_exact(3).flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        sides.map(|[a, b]| [a.min(b), a.max(b)]).collect::<BTreeSet<_>>().len()
    };
    let vertices = scene.meshes.iter().map(|m| m.vertices.len()).sum();
    let edges = scene.meshes.iter().map(|m| edges(&m.indices)).sum();
    Ok([vertices, edges, scene.textures.len(), scene.impostors.len()].map(|n: usize| n as u64))
}

/// Table 1 beside the built-in scenes.
pub fn scenes() -> Result<String> {
    let mut rows = Vec::new();
    for (scene, his) in TABLE_1 {
        let ours = counts(scene)?;
        let cells = his.iter().zip(ours).flat_map(|(his, ours)| [grouped(*his), grouped(ours)]);
        rows.push([format!("`{scene}`")].into_iter().chain(cells).collect());
    }
    let what = ["vertices", "edges", "textures", "billboards"];
    let heads = what.iter().flat_map(|w| [format!("{w}, his"), format!("{w}, here")]);
    let heads: Vec<String> = ["scene".to_owned()].into_iter().chain(heads).collect();
    table(&heads.iter().map(String::as_str).collect::<Vec<_>>(), rows)
}

/// The sizes of his figure 52.
const SIZES: [[u64; 2]; 3] = [[1024, 768], [1280, 720], [1600, 900]];

/// The record of a method on the path through a scene.
fn of_path<'a>(records: &'a [Value], method: &str, [width, height]: [u64; 2]) -> Option<&'a Value> {
    records.iter().find(|r| r["method"] == method && r["width"] == width && r["height"] == height)
}

/// Milliseconds of each frame.
fn frames(record: &Value, field: &str) -> Vec<f64> {
    record["frames"].as_array().into_iter().flatten().filter_map(|f| f[field].as_f64()).collect()
}

/// The time of `ssr` over another method's, frame by frame, since methods take turns on each frame; the median.
pub fn over(records: &[Value], method: &str, size: [u64; 2], field: &str) -> Result<Option<f64>> {
    let Some(other) = of_path(records, method, size) else { return Ok(None) };
    let ssr = of_path(records, "ssr", size).ok_or("no times of ssr")?;
    let pairs = frames(ssr, field).into_iter().zip(frames(other, field));
    Ok(Some(median(&pairs.map(|(ssr, other)| ssr / other).collect::<Vec<_>>())?))
}

/// How many times as fast as `ssr` the other methods are: whole frames, and the effect alone.
pub fn frame_rates(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (scene, _) in TABLE_1 {
        let records = json(&folder.join(scene), "path.json")?;
        for size in SIZES {
            let mut row = vec![format!("`{scene}`"), format!("{}×{}", size[0], size[1])];
            for field in ["frame_ms", "effect_ms"] {
                for method in ["pccm", "billboard", "ssr-fast"] {
                    row.push(over(&records, method, size, field)?.map_or("–".to_owned(), ratio));
                }
            }
            rows.push(row);
        }
    }
    let head = [
        "scene",
        "size",
        "frames, `pccm`",
        "frames, `billboard`",
        "frames, `ssr-fast`",
        "effect, `pccm`",
        "effect, `billboard`",
        "effect, `ssr-fast`",
    ];
    table(&head, rows)
}

/// Width and height, as in `1024x768`.
pub fn size(text: &str) -> Result<[u64; 2]> {
    let sides: Vec<u64> = text.split('x').filter_map(|n| n.parse().ok()).collect();
    sides.try_into().map_err(|_| format!("{text} is no size"))
}

/// Least and greatest of the scenes' median frames a second of a method at a size.
pub fn fps(folder: &Path, method: &str, size: &str) -> Result<String> {
    let size = self::size(size)?;
    let mut all = Vec::new();
    for (scene, _) in TABLE_1 {
        let records = json(&folder.join(scene), "path.json")?;
        let record = of_path(&records, method, size).ok_or(format!("no path of {method} in {scene}"))?;
        all.push(record["fps"]["median"].as_f64().ok_or("a record without frames a second")?);
    }
    Ok(format!("{:.2} to {:.2}", least(&all), greatest(&all)))
}
