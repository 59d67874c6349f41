//! The tables of films: quality and time of `unified` beside `stochastic` with a history, and what a history leaves behind.

use super::figures::{Result, Row, csv, json, mean, median, median_and_range, number, ratio, table};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The variants of films, as their tables call them: `unified` with the world's triangles behind the screen, `stochastic` with
/// captures behind it, and what each shows of the screen alone.
const UNIFIED: &str = "unified";
const UNIFIED_HISTORY: &str = "unified history on";
const STOCHASTIC: &str = "stochastic + captures";
const STOCHASTIC_HISTORY: &str = "stochastic + captures history on";
const ON_SCREEN: [&str; 3] = ["ssct", "unified none", "stochastic history on"];

fn film<'a>(rows: &'a [Row], roughness: &str, variant: &str) -> Result<&'a Row> {
    let found = rows.iter().find(|r| r["roughness"] == roughness && r["variant"] == variant);
    found.ok_or_else(|| format!("no film of {variant:?} at {roughness}"))
}

/// The error of a film's changes over the world's own changes.
fn error_of_changes(row: &Row) -> Result<String> {
    Ok(ratio(number(row, "change_error")? / number(row, "reference_flicker")?))
}

/// The folders of walks, with what they show.
const WALKS: [(&str, &str); 2] = [("rooms", "`rooms`, `corridor`"), ("museum", "`museum`, `exit-sign`")];

/// A row for each walk at each roughness, of what some variants' films there have.
fn of_walks<const N: usize>(
    folder: &Path,
    variants: [&str; N],
    cells: impl Fn([&Row; N]) -> Result<Vec<String>>,
) -> Result<Vec<Vec<String>>> {
    let mut rows = Vec::new();
    for (name, shown) in WALKS {
        let films = csv(&folder.join(name), "video.csv")?;
        for roughness in films.iter().map(|film| film["roughness"].as_str()).collect::<BTreeSet<_>>() {
            let own: Vec<&Row> = variants.iter().map(|v| film(&films, roughness, v)).collect::<Result<_>>()?;
            let own: [&Row; N] = own.try_into().map_err(|_| "a film for each variant")?;
            rows.push([vec![shown.to_owned(), roughness.to_owned()], cells(own)?].concat());
        }
    }
    Ok(rows)
}

/// Both qualities of two films, each with a difference.
fn qualities([a, b]: [&Row; 2], difference: impl Fn(f64, f64) -> f64) -> Result<Vec<String>> {
    let mut cells = Vec::new();
    for field in ["jod", "jod_reflection"] {
        let (a, b) = (number(a, field)?, number(b, field)?);
        cells.extend([format!("{a:.2}"), format!("{b:.2}"), format!("{:+.2}", difference(a, b))]);
    }
    Ok(cells)
}

/// `unified` beside `stochastic` with a history and captures behind it; with their times if both were traced in one shader stage.
pub fn walks(folder: &Path, is_timed: bool) -> Result<String> {
    let rows = of_walks(folder, [UNIFIED, STOCHASTIC_HISTORY], |both| {
        let [ours, theirs] = both;
        let mut cells = qualities(both, |ours, theirs| ours - theirs)?;
        for row in both {
            cells.push(format!("{:.3}", number(row, "flip")?));
        }
        cells.extend([error_of_changes(ours)?, error_of_changes(theirs)?]);
        if is_timed {
            cells.push(ratio(number(ours, "time_ms")? / number(theirs, "time_ms")?));
        }
        Ok(cells)
    })?;
    let head = [
        "walk",
        "ϱ",
        "JOD, `unified`",
        "`stochastic`",
        "difference",
        "JOD of reflections, `unified`",
        "`stochastic`",
        "difference",
        "FLIP, `unified`",
        "`stochastic`",
        "error of changes, `unified`",
        "`stochastic`",
        "time, `unified` / `stochastic`",
    ];
    table(&head[..head.len() - usize::from(!is_timed)], rows)
}

/// What a history of `unified` changes in the walks.
pub fn with_history(folder: &Path) -> Result<String> {
    let rows = of_walks(folder, [UNIFIED, UNIFIED_HISTORY], |both| {
        let [without, with] = both;
        let changes = [error_of_changes(without)?, error_of_changes(with)?];
        Ok([qualities(both, |without, with| with - without)?, changes.to_vec()].concat())
    })?;
    let head = [
        "walk",
        "ϱ",
        "JOD, without",
        "with a history",
        "difference",
        "JOD of reflections, without",
        "with a history",
        "difference",
        "error of changes, without",
        "with a history",
    ];
    table(&head, rows)
}

/// `unified` with rays of a pixel's own beside `stochastic` with a history and captures behind it.
pub fn own_rays(folder: &Path) -> Result<String> {
    let variants = [
        (STOCHASTIC_HISTORY, "`stochastic`, history"),
        ("unified own-rays 4", "`unified`, 4 rays"),
        ("unified history on own-rays 4", "`unified`, 4 rays, history"),
        ("unified own-rays 8", "`unified`, 8 rays"),
        ("unified history on own-rays 8", "`unified`, 8 rays, history"),
    ];
    let mut rows = Vec::new();
    for (name, walk) in WALKS {
        let films = csv(&folder.join(name), "video.csv")?;
        for roughness in films.iter().map(|film| film["roughness"].as_str()).collect::<BTreeSet<_>>() {
            let theirs = number(film(&films, roughness, STOCHASTIC_HISTORY)?, "time_ms")?;
            for (variant, shown) in variants {
                let own = film(&films, roughness, variant)?;
                let [jod, of_reflections] = ["jod", "jod_reflection"].map(|field| number(own, field));
                let time = ratio(number(own, "time_ms")? / theirs);
                let quality = [format!("{:.2}", jod?), format!("{:.2}", of_reflections?), error_of_changes(own)?, time];
                rows.push([[walk, roughness, shown].map(str::to_owned).to_vec(), quality.to_vec()].concat());
            }
        }
    }
    let head = ["walk", "ϱ", "method", "JOD", "of reflections", "error of changes", "time / `stochastic`'s"];
    table(&head, rows)
}

/// The table of variants of the screen alone: what it lacks outweighs all else.
pub fn on_screen(folder: &Path) -> Result<String> {
    let rows = of_walks(folder, ON_SCREEN, |films| {
        let mut cells = Vec::new();
        for field in ["jod", "jod_reflection"] {
            for row in films {
                cells.push(format!("{:.2}", number(row, field)?));
            }
        }
        Ok(cells)
    })?;
    let head = [
        "walk",
        "ϱ",
        "JOD, `ssct`",
        "`unified`",
        "`stochastic`, history",
        "JOD of reflections, `ssct`",
        "`unified`",
        "`stochastic`, history",
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
        let mut row = vec![part.to_owned()];
        for variant in [UNIFIED, UNIFIED_HISTORY, STOCHASTIC, STOCHASTIC_HISTORY] {
            let frames = flips(&folder.join(name), variant)?;
            row.push(format!("{:.4}", mean(frames.get(first..end).ok_or("a film that ends before")?)?));
        }
        rows.push(row);
    }
    table(&["frames", "`unified`", "with a history", "`stochastic`", "with a history"], rows)
}

/// Films in which something stops in frame [`STOPPED`], by their folders, with what stops.
const STOPS: [(&str, &str); 5] = [
    ("stop", "the camera"),
    ("thing-stops", "a ball"),
    ("held", "the camera, with a ball in hand"),
    ("near-held", "the camera, with a near ball in hand"),
    ("jitter", "the camera, with jitter"),
];
const STOPPED: usize = 32;
/// Frames after the stop that the table shows.
const AFTER: [usize; 6] = [0, 1, 2, 4, 8, 16];
/// Frames at the end of a film of which the mean is taken: jitter repeats after so many.
const AT_END: usize = 8;

/// FLIP after a stop, frame by frame.
pub fn stops(folder: &Path) -> Result<String> {
    let methods = [
        (UNIFIED, "`unified`"),
        (UNIFIED_HISTORY, "`unified`, history"),
        (STOCHASTIC_HISTORY, "`stochastic`, history"),
    ];
    let mut rows = Vec::new();
    for (name, shown) in STOPS {
        for (variant, method) in methods {
            let flips = flips(&folder.join(name), variant)?;
            let after = |n: usize| flips.get(STOPPED + n).copied().ok_or_else(|| format!("{name} ends before {n}"));
            let end = mean(&flips[flips.len().saturating_sub(AT_END)..])?;
            let shown_after = AFTER.iter().map(|n| Ok(format!("{:.4}", after(*n)?))).collect::<Result<Vec<_>>>()?;
            // A frame of a jittered film compares with the last one that is shifted alike.
            let alike = flips.iter().skip(STOPPED + 4).step_by(AT_END).next_back().ok_or("a film without an end")?;
            let ends = vec![format!("{end:.4}"), ratio(after(4)? / alike)];
            let names = vec![shown.to_owned(), method.to_owned()];
            rows.push([names, shown_after, ends].concat());
        }
    }
    let head = ["what stops", "method", "0", "1", "2", "4", "8", "16", "the end", "4 / the end"];
    table(&head, rows)
}

/// Films without a history and with one, by their folders.
const HISTORIES: [(&str, &str); 4] = [
    ("ball", "a ball moves, the camera rests"),
    ("turn", "a turn of 45° in six frames, and a rest"),
    ("walk", "a walk"),
    ("walk-0.3", "a walk"),
];

/// The error of changes of each film over the world's own changes, FLIP, and the changes themselves over the world's, of `unified`
/// without a history and with one. The second folder has two of the films by the history that looked where the surface was.
pub fn histories(folders: &[PathBuf]) -> Result<String> {
    let [folder, earlier] = folders else {
        return Err("films of now are of one folder, earlier ones of another".to_owned());
    };
    let films = |folder: &Path, name: &str| -> Result<[Row; 2]> {
        let rows = csv(&folder.join(name), "video.csv")?;
        let row_of = |variant: &str| {
            let found = rows.iter().find(|r| r["variant"] == variant);
            found.cloned().ok_or_else(|| format!("{name} has no film of {variant:?}"))
        };
        Ok([row_of("unified")?, row_of("unified history on")?])
    };
    let over = |row: &Row, field: &str| Ok::<_, String>(number(row, field)? / number(row, "reference_flicker")?);
    let mut rows = Vec::new();
    for (name, shown) in HISTORIES {
        let [none, now] = films(folder, name)?;
        let before = format!("{name}-before");
        let before = if earlier.join(&before).exists() {
            ratio(over(&films(earlier, &before)?[1], "change_error")?)
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

/// FLIP of each frame of a variant's film, from the table of frames. Those of older records have two columns of the name.
fn flips(folder: &Path, variant: &str) -> Result<Vec<f64>> {
    let variant = variant.replace('_', " ");
    let rows = csv(folder, "video-frames.csv")?;
    let flip = |row: &Row| number(row, if row.contains_key("frame_flip") { "frame_flip" } else { "flip" });
    let found: Vec<f64> = rows.iter().filter(|r| r["variant"] == variant).map(flip).collect::<Result<_>>()?;
    if found.is_empty() { Err(format!("no film of {variant:?}")) } else { Ok(found) }
}

/// A variant's film, of those of one roughness.
fn only(folder: &Path, variant: &str) -> Result<Row> {
    let variant = variant.replace('_', " ");
    let rows = csv(folder, "video.csv")?;
    rows.into_iter().find(|r| r["variant"] == variant).ok_or_else(|| format!("no film of {variant:?}"))
}

/// The error of changes of a variant's film over the world's own changes.
pub fn changes(folder: &Path, variant: &str) -> Result<String> {
    error_of_changes(&only(folder, variant)?)
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

/// What a history costs on a device: medians over the views.
pub fn history_times(folder: &Path) -> Result<String> {
    let records = json(folder, "times.json")?;
    let size = |r: &Value| format!("{}×{}", r["width"], r["height"]);
    let total = |r: &Value| r["total"]["median_ms"].as_f64().ok_or_else(|| "no time".to_owned());
    let pass = |r: &Value| {
        let own = r["passes"].as_array().into_iter().flatten().find(|p| p["name"] == "history");
        own.and_then(|p| p["median_ms"].as_f64()).ok_or_else(|| "no history".to_owned())
    };
    let key = |r: &Value| (size(r), r["roughness"].to_string(), r["scene"].to_string());
    let records_with = |history: &'static str| records.iter().filter(move |r| r["setup"]["history"] == history);
    let mut found = BTreeMap::<(String, String), [Vec<f64>; 3]>::new();
    for with in records_with("on") {
        let without = records_with("off").find(|r| key(r) == key(with)).ok_or("a time without its pair")?;
        let [alone, both] = [total(without)?, total(with)?];
        let all = found.entry((size(with), with["roughness"].to_string())).or_default();
        all.iter_mut().zip([alone, pass(with)?, both / alone]).for_each(|(all, one)| all.push(one));
    }
    let row = |((size, roughness), all): (&(String, String), &[Vec<f64>; 3])| {
        let [alone, pass, over] = [median(&all[0])?, median(&all[1])?, median(&all[2])?];
        Ok(vec![size.clone(), roughness.clone(), format!("{alone:.2}"), format!("{pass:.2}"), ratio(over)])
    };
    // By their lengths first, so that the smaller size is the first.
    let mut rows = found.iter().map(row).collect::<Result<Vec<_>>>()?;
    rows.sort_by_key(|row| (row[0].len(), row[1].clone()));
    table(&["size", "ϱ", "`unified`, ms", "the history's pass, ms", "with it / without"], rows)
}

/// So many samples at the beginning of a run have other directions of rays each, and from this one on all have those of before.
const TURNING: usize = 12;
const SETTLED: usize = 20;

/// The time of the history's pass with loops in place of branches, over that with branches, in pairs of runs: of the first samples,
/// in which the directions of rays turn, or of those in which nothing changes any more.
pub fn history_loops(folder: &Path, turning: bool) -> Result<String> {
    let rows = csv(folder, "samples.csv")?;
    let pass = |program: &str, run: &str| {
        let samples = rows.iter().filter(|r| r["program"] == program && r["run"] == run);
        let all = samples.map(|r| number(r, "history_ms")).collect::<Result<Vec<_>>>()?;
        let part = if turning { all.get(..TURNING) } else { all.get(SETTLED..) };
        median(part.ok_or("a run of too few samples")?)
    };
    let runs: BTreeSet<&str> = rows.iter().map(|r| r["run"].as_str()).collect();
    let over = |run: &&str| Ok(pass("loops", run)? / pass("branches", run)?);
    median_and_range(&runs.iter().map(over).collect::<Result<Vec<_>>>()?)
}

/// Bounds of the lag of a history, by their names in the record and in the table.
const BOUNDS: [(&str, &str); 6] = [
    ("no-history", "no history"),
    ("none", "no bound"),
    ("frame-0.5", "of a frame"),
    ("mean-0.35", "0.35"),
    ("mean-0.6-square-1", "0.6, 1"),
    ("mean-0.35-square-0.5", "0.35, 0.5"),
];

/// FLIP of films, and the error of changes over the world's own changes, by the bound of the lag of a history.
pub fn history_lag(folder: &Path) -> Result<String> {
    let rows = csv(folder, "films.csv")?;
    let shown = rows.iter().filter(|row| row["bound"] == BOUNDS[0].0).map(|film| -> Result<Vec<String>> {
        let mut cells = vec![film["film"].clone(), film["roughness"].clone()];
        for (field, digits) in [("flip", 4), ("change_error_over_world", 2)] {
            for (bound, _) in BOUNDS {
                let is = |r: &&Row| ["film", "roughness"].iter().all(|f| r[*f] == film[*f]) && r["bound"] == bound;
                let row = rows.iter().find(is).ok_or_else(|| format!("a film has no bound {bound}"))?;
                cells.push(format!("{:.digits$}", number(row, field)?));
            }
        }
        Ok(cells)
    });
    let heads = |what: &'static str| {
        BOUNDS
            .iter()
            .enumerate()
            .map(move |(n, (_, bound))| if n == 0 { format!("{what}: {bound}") } else { (*bound).to_owned() })
    };
    let head: Vec<String> =
        ["film", "ϱ"].map(str::to_owned).into_iter().chain(heads("FLIP")).chain(heads("change")).collect();
    table(&head.iter().map(String::as_str).collect::<Vec<_>>(), shown.collect::<Result<_>>()?)
}

/// Error on a curved mirror under a moving camera with a history over that without, by the bounds of the history's lag.
pub fn history_hill(folder: &Path) -> Result<String> {
    let rows = csv(folder, "hill.csv")?;
    let over =
        |row: &Row| -> Result<String> { Ok(format!("{:.2}", number(row, "with_history")? / number(row, "alone")?)) };
    let bounds = |row: &Row| ["mean", "square"].map(|field| row[field].clone());
    let of_first = rows.iter().take_while(|row| bounds(row) == bounds(&rows[0]));
    let roughness: Vec<&str> = of_first.map(|row| row["roughness"].as_str()).collect();
    let shown = rows.chunks(roughness.len()).map(|of_bounds| -> Result<Vec<String>> {
        Ok(bounds(&of_bounds[0]).into_iter().chain(of_bounds.iter().map(over).collect::<Result<Vec<_>>>()?).collect())
    });
    let shown = shown.collect::<Result<_>>()?;
    let head: Vec<&str> = ["mean at most", "mean square at most"].into_iter().chain(roughness).collect();
    table(&head, shown)
}
