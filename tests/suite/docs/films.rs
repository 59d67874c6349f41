//! The tables of films: quality and time of `unified` beside `stochastic` with a history, and what a history leaves behind.

use super::figures::{Result, Row, csv, json, mean, number, ratio, table};
use serde_json::Value;
use std::path::Path;

/// A film by its method, what is behind it, its captures and its history.
type Variant = (&'static str, &'static str, &'static str, &'static str);

const UNIFIED: Variant = ("unified", "none", "auto", "off");
const UNIFIED_HISTORY: Variant = ("unified", "none", "auto", "on");
const STOCHASTIC: Variant = ("stochastic", "captures", "none", "off");
const STOCHASTIC_HISTORY: Variant = ("stochastic", "captures", "none", "on");
const ON_SCREEN: [Variant; 3] =
    [("ssct", "none", "none", "off"), ("unified", "none", "none", "off"), ("stochastic", "none", "none", "on")];

/// Which a record is.
fn is(record: &Value, (method, fallback, captures, history): Variant) -> bool {
    let setup = &record["setup"];
    record["method"] == method
        && setup["fallback"] == fallback
        && (setup["captures"] == captures || captures == "none" && setup["captures"].is_null())
        && setup["history"] == history
}

fn film<'a>(records: &'a [Value], roughness: &Value, variant: Variant) -> Result<&'a Value> {
    let found = records.iter().find(|r| r["roughness"] == *roughness && is(r, variant));
    found.ok_or_else(|| format!("no film of {variant:?} at {roughness}"))
}

fn figure(record: &Value, field: &str) -> Result<f64> {
    record[field].as_f64().ok_or_else(|| format!("a film without {field}"))
}

fn roughness_values(records: &[Value]) -> Vec<Value> {
    let mut values: Vec<Value> = Vec::new();
    for record in records {
        if !values.contains(&record["roughness"]) {
            values.push(record["roughness"].clone());
        }
    }
    values
}

/// The folders of walks, with what they show.
const WALKS: [(&str, &str); 3] = [
    ("rooms", "`rooms`, `corridor`"),
    ("museum", "`museum`, `exit-sign`"),
    ("rooms-256", "`rooms`, `corridor`, 256 rays"),
];

/// `unified` with captures beside `stochastic` with a history and captures behind it.
pub fn walks(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (name, shown) in WALKS {
        let records = json(&folder.join(name), "video.json")?;
        for roughness in roughness_values(&records) {
            let [ours, theirs] = [UNIFIED, STOCHASTIC_HISTORY].map(|v| film(&records, &roughness, v));
            let (ours, theirs) = (ours?, theirs?);
            let mut row = vec![shown.to_owned(), roughness.to_string()];
            for field in ["jod", "jod_reflection"] {
                let (a, b) = (figure(ours, field)?, figure(theirs, field)?);
                row.extend([format!("{a:.2}"), format!("{b:.2}"), format!("{:+.2}", a - b)]);
            }
            row.push(ratio(figure(ours, "time_ms")? / figure(theirs, "time_ms")?));
            row.extend([ours, theirs].map(|r| figure(r, "flip").map_or_else(|e| e, |v| format!("{v:.3}"))));
            rows.push(row);
        }
    }
    let head = [
        "walk",
        "ϱ",
        "JOD, `unified`",
        "`stochastic`",
        "difference",
        "JOD of reflections, `unified`",
        "`stochastic`",
        "difference",
        "time, `unified` over `stochastic`",
        "FLIP, `unified`",
        "`stochastic`",
    ];
    table(&head, rows)
}

/// The table of variants without captures: what the screen lacks outweighs all else.
pub fn on_screen(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (name, shown) in WALKS.into_iter().take(2) {
        let records = json(&folder.join(name), "video.json")?;
        for roughness in roughness_values(&records) {
            let mut row = vec![shown.to_owned(), roughness.to_string()];
            let films = ON_SCREEN.map(|v| film(&records, &roughness, v));
            let films = films.into_iter().collect::<Result<Vec<_>>>()?;
            for field in ["jod", "jod_reflection"] {
                row.extend(films.iter().map(|r| figure(r, field).map_or_else(|e| e, |v| format!("{v:.2}"))));
            }
            let time = figure(films[2], "time_ms")?;
            row.extend([films[0], films[1]].map(|r| figure(r, "time_ms").map_or_else(|e| e, |v| ratio(v / time))));
            rows.push(row);
        }
    }
    let head = [
        "walk",
        "ϱ",
        "JOD, `ssct`",
        "`unified`",
        "`stochastic`, history",
        "JOD of reflections, `ssct`",
        "`unified`",
        "`stochastic`, history",
        "time over that of `stochastic`, `ssct`",
        "`unified`",
    ];
    table(&head, rows)
}

/// Films in which a history may leave something behind, and the parts of them: the first frame, and the one after the last.
const GHOSTS: [(&str, &str, usize, usize); 4] = [
    ("turn", "at rest, before", 0, 20),
    ("turn", "in the turn", 20, 27),
    ("turn", "ten frames after it", 27, 37),
    ("moving", "at rest, while a ball moves", 0, 60),
];

/// What a history costs and gains: FLIP with it and without.
pub fn ghosts(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (name, part, first, end) in GHOSTS {
        let records = json(&folder.join(name), "video.json")?;
        let roughness = &roughness_values(&records)[0];
        let mut row = vec![part.to_owned()];
        for variant in [UNIFIED, UNIFIED_HISTORY, STOCHASTIC, STOCHASTIC_HISTORY] {
            let record = film(&records, roughness, variant)?;
            let frames = record["frames"].as_array().into_iter().flatten().skip(first).take(end - first);
            row.push(format!("{:.4}", mean(&frames.filter_map(|f| f["flip"].as_f64()).collect::<Vec<_>>())?));
        }
        rows.push(row);
    }
    table(&["frames", "`unified`", "with a history", "`stochastic`", "with a history"], rows)
}

/// Films without a history and with one, by their folders. Two were also made with the history that looked where the surface
/// was.
const HISTORIES: [(&str, &str); 4] = [
    ("ball", "a ball moves, the camera rests"),
    ("turn", "a turn of 45° in six frames, and a rest"),
    ("walk", "a walk"),
    ("walk-0.3", "a walk"),
];

/// The error of changes of each film over the world's own changes, FLIP, and the changes themselves over the world's, of `unified`
/// without a history and with one.
pub fn histories(folder: &Path) -> Result<String> {
    let films = |name: &str| -> Result<[Row; 2]> {
        let rows = csv(&folder.join(name), "video.csv")?;
        let of = |variant: &str| {
            let found = rows.iter().find(|r| r["variant"] == variant);
            found.cloned().ok_or_else(|| format!("{name} has no film of {variant:?}"))
        };
        Ok([of("unified")?, of("unified history on")?])
    };
    let over = |row: &Row, field: &str| Ok::<_, String>(number(row, field)? / number(row, "reference_flicker")?);
    let mut rows = Vec::new();
    for (name, shown) in HISTORIES {
        let [none, now] = films(name)?;
        let before = format!("{name}-before");
        let before = if folder.join(&before).exists() {
            ratio(over(&films(&before)?[1], "change_error")?)
        } else {
            "–".to_owned()
        };
        let flip = |row: &Row| Ok::<_, String>(format!("{:.4}", number(row, "flip")?));
        rows.push(vec![
            shown.to_owned(),
            none["roughness"].clone(),
            ratio(over(&none, "change_error")?),
            before,
            ratio(over(&now, "change_error")?),
            flip(&none)?,
            flip(&now)?,
            ratio(over(&none, "flicker")?),
            ratio(over(&now, "flicker")?),
        ]);
    }
    let head = ["film", "ϱ", "change: none", "before", "now", "FLIP: none", "now", "flicker: none", "now"];
    table(&head, rows)
}

/// FLIP of each frame of a variant's film, from the table of frames.
fn flips(folder: &Path, variant: &str) -> Result<Vec<f64>> {
    let variant = variant.replace('_', " ");
    let rows = csv(folder, "video-frames.csv")?;
    let found: Vec<f64> =
        rows.iter().filter(|r| r["variant"] == variant).map(|r| number(r, "flip")).collect::<Result<_>>()?;
    if found.is_empty() { Err(format!("no film of {variant:?}")) } else { Ok(found) }
}

/// FLIP of a frame, by its number or `end`.
pub fn flip(folder: &Path, variant: &str, frame: &str) -> Result<String> {
    Ok(format!("{:.4}", at(&flips(folder, variant)?, frame)?))
}

/// FLIP of a frame over that of the last.
pub fn flip_over_end(folder: &Path, variant: &str, frame: &str) -> Result<String> {
    let all = flips(folder, variant)?;
    Ok(ratio(at(&all, frame)? / at(&all, "end")?))
}

/// The least and the greatest FLIP from a frame on.
pub fn flip_from(folder: &Path, variant: &str, first: &str) -> Result<String> {
    let first: usize = first.parse().map_err(|_| format!("{first:?} is no frame"))?;
    let all = flips(folder, variant)?;
    let later = all.get(first..).filter(|later| !later.is_empty()).ok_or_else(|| format!("no frame {first}"))?;
    let [least, greatest] = [f64::min, f64::max].map(|of| later.iter().copied().reduce(of).unwrap_or_default());
    Ok(format!("{least:.4} to {greatest:.4}"))
}

fn at(all: &[f64], frame: &str) -> Result<f64> {
    let frame = if frame == "end" { Ok(all.len() - 1) } else { frame.parse() };
    let frame: usize = frame.map_err(|_| "a frame is a number or `end`".to_owned())?;
    all.get(frame).copied().ok_or_else(|| format!("no frame {frame}"))
}

/// The error of changes of a variant's film over the world's own changes.
pub fn changes(folder: &Path, variant: &str) -> Result<String> {
    let variant = variant.replace('_', " ");
    let rows = csv(folder, "video.csv")?;
    let row = rows.iter().find(|r| r["variant"] == variant).ok_or_else(|| format!("no film of {variant:?}"))?;
    Ok(ratio(number(row, "change_error")? / number(row, "reference_flicker")?))
}

/// What a mesh that moves costs: building all of the tree anew, and the small one alone.
pub fn movers(folder: &Path) -> Result<String> {
    let row = |row: &Row| -> Result<Vec<String>> {
        let ms = |field| Ok::<_, String>(format!("{:.1}", number(row, field)?));
        let [scene, mesh] = ["scene", "mesh"].map(|field| format!("`{}`", row[field]));
        let (all, moving) = (row["triangles"].clone(), row["moving_triangles"].clone());
        Ok(vec![scene, mesh, all, moving, ms("whole_ms")?, ms("moving_ms")?])
    };
    let rows = csv(folder, "movers.csv")?.iter().map(row).collect::<Result<_>>()?;
    table(&["scene", "what moves", "triangles", "of which move", "the whole tree, ms", "the small tree, ms"], rows)
}
