//! Makes the tables and numbers of the pages from records of measurements. A query names the table or number, and the folders whose
//! records it reads.

use super::figures::{
    ROUGHNESS, Result, Row, commit, csv, figures, greatest, json, least, mean, median, median_and_greatest,
    median_and_range, number, percent, ratio, shortest, table,
};
use super::{
    beside, beyond, captions, claims, complaints, coverage, dda, devices, embedding, ends, errata, films, follow, gpu,
    large_gltf, layers, league, measured, motion, outlook, stochastic, stress, thesis, waits,
};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The answer to a query about some folders: a table in Markdown, which has several lines, or a number.
pub fn show(query: &str, folders: &[PathBuf]) -> Result<String> {
    let words: Vec<&str> = query.split(' ').collect();
    let [first, ..] = folders else { return Err("no records are named".to_owned()) };
    let text = match words[..] {
        ["headline"] => headline(folders)?,
        ["times", size] => times(first, size)?,
        ["errors"] => errors(first)?,
        ["slowest", method] => slowest(first, method)?,
        ["least-agreement"] => least_agreement(first)?,
        ["versions"] => versions(folders)?,
        ["version-error", roughness] => median_and_range(&version_errors(first, roughness)?)?,
        ["beyond", roughness] => beyond::beyond(folders, roughness)?,
        ["search"] => thesis::search(first)?,
        ["cone-angle"] => thesis::cone_angle(first)?,
        ["unneeded"] => thesis::unneeded(first)?,
        ["erratum", variant] => errata::erratum(first, variant)?,
        ["rows", kind] => errata::rows(first, kind)?,
        ["coverage-rows", word] => coverage::rows(first, word)?,
        ["times-beyond"] => beyond::times_beyond(folders)?,
        ["gain"] => beyond::gain(folders)?,
        ["fallbacks"] => beyond::fallbacks(folders)?,
        ["views-above", limit, behind, roughness] => beyond::views_above(folders, limit, behind, roughness)?,
        ["seen", scene, captures] => beyond::seen(first, scene, captures)?,
        ["captures-headline"] => beyond::captures_headline(folders)?,
        ["triangles"] => beyond::triangles_by_roughness(first)?,
        ["triangles", roughness] => beyond::triangles(first, roughness)?,
        ["triangle-times", roughness] => gpu::triangle_times(folders, roughness)?,
        ["time-range", method, roughness] => gpu::time_range(first, method, roughness)?,
        ["over-ssct", method, roughness] => gpu::over_ssct(first, method, roughness)?,
        ["stages-on"] => gpu::stages_on(first)?,
        ["capture-steps"] => follow::steps(first)?,
        ["ends"] => ends::ends(first)?,
        ["motion-most", roughness] => motion::most(first, roughness)?,
        ["prepared", scene] => beyond::prepared(first, scene)?,
        ["motion-rays"] => motion::by_rays(folders)?,
        ["capture-sides"] => follow::sides(first)?,
        ["range", scene, size, method, over] => range(first, scene, size, method, over)?,
        ["methods"] => methods(folders)?,
        ["by-roughness"] => by_roughness(first)?,
        ["hits"] => hits(first)?,
        ["better-than", method] => better_than(first, method)?,
        ["beside", methods, scenes, roughness] => beside::beside(first, methods, scenes, roughness)?,
        ["poster-filters"] => beside::poster_filters(first)?,
        ["poster-gain", roughness] => beside::poster_gain(first, roughness)?,
        ["billboard-blurs"] => beside::billboard_blurs(first)?,
        ["trace-normals"] => beside::trace_normals(first)?,
        ["bounces"] => outlook::bounces(first)?,
        ["bounce-times"] => outlook::bounce_times(first)?,
        ["billboard-glow"] => outlook::billboard_glow(first)?,
        ["chain-masks"] => outlook::chain_masks(first)?,
        ["captions"] => captions::captions(first)?,
        ["claim-time", method, over, roughness] => claims::time(first, [method, over, roughness])?,
        ["claim-error", method, over, against, roughness] => claims::error(first, [method, over, against, roughness])?,
        ["claim-error-of", method, against, roughness] => claims::error_between(folders, [method, against, roughness])?,
        ["claim-hits", share, method] => claims::hits(first, [share, method])?,
        ["claim-caption", figure] => claims::caption(first, figure)?,
        ["claim-5.8", method, roughness] => claims::table_5_8(first, [method, roughness])?,
        ["claim-5.8-at", method, roughness, size] => claims::table_5_8_at(first, [method, roughness, size])?,
        ["claim-pixels", method, roughness] => claims::pixels(first, [method, roughness])?,
        ["claim-rougher", method] => claims::rougher(first, method)?,
        ["claim-motion", field, method, roughness] => claims::motion(first, [field, method, roughness])?,
        ["claim-scaling", method, size] => claims::scaling(first, [method, size])?,
        ["schmidt-scenes"] => captions::scenes()?,
        ["frame-rates"] => captions::frame_rates(first)?,
        ["fps", method, size] => captions::fps(first, method, size)?,
        ["table-5.8"] => thesis::table_5_8(first)?,
        ["sslr"] => thesis::sslr(first)?,
        ["table-5.8-range"] => thesis::table_5_8_range(first)?,
        ["wrong-rays"] => wrong_rays(folders)?,
        ["why-wrong", scene, view, size] => why_wrong(first, scene, view, size)?,
        ["need"] => need(first)?,
        ["dda-tuning"] => dda::tuning(first)?,
        ["dda-beside"] => dda::beside(first)?,
        ["stochastic-tuning"] => stochastic::tuning(first)?,
        ["stochastic-history"] => stochastic::history(first)?,
        ["stochastic-history-tuning"] => stochastic::history_tuning(first)?,
        ["films"] => films::walks(first, true)?,
        ["films", "untimed"] => films::walks(first, false)?,
        ["films-on-screen"] => films::on_screen(first)?,
        ["films-history"] => films::ghosts(first)?,
        ["films-stops"] => films::stops(first)?,
        ["films-own-rays"] => films::own_rays(first)?,
        ["films-with-history"] => films::with_history(first)?,
        ["histories"] => films::histories(folders)?,
        ["changes", variant] => films::changes(first, variant)?,
        ["movers"] => films::movers(first)?,
        ["history-loops", "turning"] => films::history_loops(first, true)?,
        ["history-loops", "settled"] => films::history_loops(first, false)?,
        ["history-lag"] => films::history_lag(first)?,
        ["history-hill"] => films::history_hill(first)?,
        ["filters", filter, average] => gpu::filters(first, filter, average)?,
        ["programs-again", program, kept, width] => gpu::programs_again(first, [program, kept, width])?,
        ["registers"] => gpu::registers(first)?,
        ["registers-needed", stage] => gpu::most_needed(first, stage)?,
        ["history-times"] => films::history_times(first)?,
        ["layers"] => layers::layers(first)?,
        ["layers-gloss"] => layers::layers_gloss(first)?,
        ["camera-capture"] => layers::camera_capture(first)?,
        ["camera-by-scene"] => layers::camera_by_scene(first)?,
        ["face-sizes"] => layers::face_sizes(first)?,
        ["camera-behind"] => layers::camera_behind(first)?,
        ["door"] => door(first)?,
        ["hit-colors"] => embedding::hit_colors(first)?,
        ["bevy"] => embedding::bevy(first, false)?,
        ["bevy", "lit"] => embedding::bevy(first, true)?,
        ["bevy", with, figure] => embedding::bevy_figure(first, with, figure)?,
        ["league", scene] => league::scene(first, scene)?,
        ["league-scenes", setting] => league::scenes(first, setting)?,
        ["league", contestant, setting, scene, figure] => league::figure(first, [contestant, setting, scene, figure])?,
        ["stress"] => stress::stress(first)?,
        ["complaints"] => complaints::complaints(first)?,
        ["complaint", case, method] => complaints::complaint(first, case, method)?,
        ["stress-cases", method] => stress::cases(first, method)?,
        ["stress-compared", method] => stress::hits(first, method)?.0,
        ["stress-wrong", method] => stress::hits(first, method)?.1,
        ["precision", scene] => precision(first, scene)?,
        ["large-gltf", figure, side] => large_gltf::large_gltf(first, figure, side)?,
        ["waits"] => waits::waits(first)?,
        ["commit"] => commit(first)?,
        _ => measured::show(query, first)?,
    };
    Ok(text)
}

/// A view at a roughness, of the records of `scripts/bars.sh`.
pub type Cell = (String, String, String);

fn cell(row: &Row) -> Cell {
    (row["scene"].clone(), row["view"].clone(), row["roughness"].clone())
}

/// Median times by cell and method, of a size.
pub fn bars_times(folder: &Path, size: &str) -> Result<BTreeMap<Cell, BTreeMap<String, f64>>> {
    let mut times: BTreeMap<Cell, BTreeMap<String, f64>> = BTreeMap::new();
    for row in csv(folder, "times.csv")?.iter().filter(|r| format!("{}x{}", r["width"], r["height"]) == size) {
        times.entry(cell(row)).or_default().insert(row["method"].clone(), number(row, "median_ms")?);
    }
    if times.is_empty() { Err(format!("no times at {size}")) } else { Ok(times) }
}

/// An error for each method and reference.
pub type Errors = BTreeMap<(String, String), f64>;

/// RMSE by cell, method and reference; against the screen with the reference's own variance taken off.
pub fn bars_errors(folder: &Path) -> Result<BTreeMap<Cell, Errors>> {
    let mut errors: BTreeMap<Cell, Errors> = BTreeMap::new();
    for row in csv(folder, "errors.csv")?.iter().filter(|r| r["against"] != "oracle") {
        let (rmse, noise) = (number(row, "rmse")?, number(row, "standard_error")?);
        let rmse = if row["against"] == "screen" { (rmse * rmse - noise * noise).max(0.0).sqrt() } else { rmse };
        errors.entry(cell(row)).or_default().insert((row["method"].clone(), row["against"].clone()), rmse);
    }
    Ok(errors)
}

/// Time of `unified` over that of a method, at a roughness, for each view.
pub fn times_over(folder: &Path, size: &str, roughness: &str, method: &str) -> Result<Vec<f64>> {
    let times = bars_times(folder, size)?;
    let here = times.iter().filter(|((.., r), _)| r == roughness);
    here.map(|(_, t)| {
        let time = |m: &str| t.get(m).copied().ok_or_else(|| format!("no time of {m}"));
        Ok(time("unified")? / time(method)?)
    })
    .collect()
}

/// Error of a method over that of another, each against a reference, at a roughness, for each view.
pub fn errors_over(folder: &Path, roughness: &str, subject: (&str, &str), over: (&str, &str)) -> Result<Vec<f64>> {
    let errors = bars_errors(folder)?;
    let here = errors.iter().filter(|((.., r), _)| r == roughness);
    here.map(|(_, e)| {
        let one = |(method, against): (&str, &str)| {
            e.get(&(method.to_owned(), against.to_owned())).copied().ok_or_else(|| format!("no {method}, {against}"))
        };
        Ok(one(subject)? / one(over)?)
    })
    .collect()
}

/// Times of the first folder, and errors of the second.
fn headline(folders: &[PathBuf]) -> Result<String> {
    let [timed, judged] = folders else { return Err("times are of one folder, and errors of another".to_owned()) };
    let row = |roughness: &&str| {
        let time = |method| median_and_greatest(&times_over(timed, "960x540", roughness, method)?);
        let rmse = errors_over(judged, roughness, ("unified", "screen"), ("ssct", "screen"))?;
        Ok(vec![shortest(roughness), time("ssct")?, time("hzct")?, median_and_greatest(&rmse)?])
    };
    let rows = ROUGHNESS.iter().map(row).collect::<Result<_>>()?;
    let name =
        |what, over, folder: &Path| Ok::<_, String>(format!("{what} / `{over}`'s, on {}", devices::kind(folder)?));
    let head = [name("time", "ssct", timed)?, name("time", "hzct", timed)?, name("error", "ssct", judged)?];
    table(&["roughness", &head[0], &head[1], &head[2]], rows)
}

fn times(folder: &Path, size: &str) -> Result<String> {
    let row = |roughness: &&str| {
        let time = |method| median_and_range(&times_over(folder, size, roughness, method)?);
        Ok(vec![shortest(roughness), time("ssct")?, time("hzct")?])
    };
    table(&["roughness", "time / `ssct`'s", "time / `hzct`'s"], ROUGHNESS.iter().map(row).collect::<Result<_>>()?)
}

fn errors(folder: &Path) -> Result<String> {
    let row = |roughness: &&str| {
        let screen = errors_over(folder, roughness, ("unified", "screen"), ("ssct", "screen"))?;
        let world = errors_over(folder, roughness, ("unified", "world"), ("ssct", "world"))?;
        let reach = errors_over(folder, roughness, ("unified", "world"), ("screen-reference", "world"))?;
        let range = |v: &[f64]| {
            Ok::<_, String>(format!("{} ({} to {})", ratio(median(v)?), ratio(least(v)), ratio(greatest(v))))
        };
        Ok(vec![shortest(roughness), range(&screen)?, range(&world)?, range(&reach)?])
    };
    let head = [
        "roughness",
        "error against the screen / `ssct`'s",
        "error against the world / `ssct`'s",
        "error against the world / the screen reference's",
    ];
    table(&head, ROUGHNESS.iter().map(row).collect::<Result<_>>()?)
}

/// The greatest time of `unified` over a method's, of all sizes, views and roughness values.
fn slowest(folder: &Path, method: &str) -> Result<String> {
    let mut all = Vec::new();
    for size in ["960x540", "641x479"] {
        for roughness in ROUGHNESS {
            all.extend(times_over(folder, size, roughness, method)?);
        }
    }
    Ok(ratio(greatest(&all)))
}

/// The share of a view's mirror rays that `unified` ends where the oracle says.
pub fn agreement(folder: &Path, scene: &str, view: &str) -> Result<f64> {
    let rows = csv(folder, "errors.csv")?;
    let is_it =
        |r: &&Row| r["method"] == "unified" && r["against"] == "oracle" && r["scene"] == scene && r["view"] == view;
    number(rows.iter().find(is_it).ok_or_else(|| format!("no hits of {scene} {view}"))?, "hit_agreement")
}

fn least_agreement(folder: &Path) -> Result<String> {
    let rows = csv(folder, "errors.csv")?;
    let of_unified = rows.iter().filter(|r| r["method"] == "unified" && r["against"] == "oracle");
    let agreement = of_unified.map(|r| number(r, "hit_agreement")).collect::<Result<Vec<_>>>()?;
    median(&agreement)?;
    // Rounded down, so that it holds.
    Ok(format!("{:.4} %", (1e6 * least(&agreement)).floor() / 1e4))
}

/// The error of `unified` against the world by version 2 of the oracle over that by version 1, of each view at a roughness.
fn version_errors(folder: &Path, roughness: &str) -> Result<Vec<f64>> {
    let rows = csv(folder, "errors.csv")?;
    let find = |row: &Row, oracle: &str| {
        let is_it = |r: &&Row| r["oracle"] == oracle && cell(r) == cell(row);
        rows.iter().find(is_it).ok_or(format!("no version {oracle} of {:?}", cell(row)))
    };
    let first = rows.iter().filter(|r| r["oracle"] == "1" && shortest(&r["roughness"]) == shortest(roughness));
    first.map(|row| Ok(number(find(row, "2")?, "rmse")? / number(row, "rmse")?)).collect()
}

/// `unified` by version 2 of the oracle over version 1: times (over `ssct`'s, medians) of the first two folders, and the error
/// against the world of the third.
fn versions(folders: &[PathBuf]) -> Result<String> {
    let [first, second, judged] = folders else { return Err("times of two versions, and errors of both".to_owned()) };
    let row = |roughness: &&str| {
        let time = |size| {
            let over = |folder| median(&times_over(folder, size, roughness, "ssct")?);
            Ok::<_, String>(ratio(over(second)? / over(first)?))
        };
        let error = version_errors(judged, roughness)?;
        Ok(vec![shortest(roughness), time("960x540")?, time("641x479")?, median_and_range(&error)?])
    };
    let head = ["roughness", "time, 960×540", "time, 641×479", "error against the world"];
    table(&head, ROUGHNESS.iter().map(row).collect::<Result<_>>()?)
}

/// Least and greatest time of a method over another's, of the views of a scene: medians over the roughness values.
fn range(folder: &Path, scene: &str, size: &str, method: &str, over: &str) -> Result<String> {
    let mut views: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for ((_, view, _), t) in bars_times(folder, size)?.into_iter().filter(|((s, ..), _)| s == scene) {
        let time = |m: &str| t.get(m).copied().ok_or_else(|| format!("no time of {m}"));
        views.entry(view).or_default().push(time(method)? / time(over)?);
    }
    let medians = views.values().map(|v| median(v)).collect::<Result<Vec<_>>>()?;
    median(&medians)?;
    Ok(format!("{:.2} to {:.2}", least(&medians), greatest(&medians)))
}

/// Records of `ssct error` of methods as they are without a flag: at full resolution, by version 1 of the oracle.
pub fn plain_errors(folder: &Path) -> Result<Vec<Value>> {
    let all = json(folder, "error.json")?;
    let usual = all.first().map(|r| r["params"].clone()).ok_or("no records")?;
    let is_plain = |r: &Value| {
        let is_full = r["resolution_scale"].as_f64().is_none_or(|s| s == 1.0);
        is_full && r["preset"] == "published" && r["oracle"].is_null() && r["params"] == usual
    };
    Ok(all.into_iter().filter(is_plain).collect())
}

/// Median RMSE, or a dash where there is none.
fn rmse(records: &[Value], method: &str, against: &str, roughness: &str, decimals: usize) -> String {
    let values = figures(records, method, against, roughness, "rmse");
    median(&values).map_or("–".to_owned(), |m| format!("{m:.decimals$}"))
}

/// The names of a field in the order in which they first appear.
fn names(records: &[Value], field: &str) -> Vec<String> {
    let mut seen = BTreeSet::new();
    let all = records.iter().filter_map(|r| r[field].as_str());
    all.filter(|n| seen.insert((*n).to_owned())).map(str::to_owned).collect()
}

/// Every method of some folders. Its time is over that of `ssct` on the same frames: median over the cells, and the least and the
/// greatest of them.
fn methods(folders: &[PathBuf]) -> Result<String> {
    let records = folders.iter().map(|folder| plain_errors(folder)).collect::<Result<Vec<_>>>()?.concat();
    let cell = |r: &Value| [&r["scene"], &r["view"], &r["roughness"]].map(ToString::to_string);
    let timed = |method: &str| -> Vec<(_, f64)> {
        let timed = records.iter().filter(|r| r["method"] == method && r["against"] == "world");
        timed.filter_map(|r| Some((cell(r), r["time_ms"].as_f64()?))).collect()
    };
    let ssct: BTreeMap<_, f64> = timed("ssct").into_iter().collect();
    let mut rows = Vec::new();
    for method in names(&records, "method") {
        let over: Vec<f64> = timed(&method).iter().filter_map(|(cell, ms)| Some(ms / ssct.get(cell)?)).collect();
        let Ok(time) = median_and_range(&over) else { continue };
        let agreement = mean(&figures(&records, &method, "oracle", "0", "hit_agreement"));
        let mut row = vec![format!("`{method}`"), time, agreement.map_or("–".to_owned(), |a| percent(a, 1))];
        for against in ["screen", "world"] {
            row.extend(["0", "0.1"].map(|r| rmse(&records, &method, against, r, 3)));
        }
        rows.push(row);
    }
    let head =
        ["method", "time / `ssct`'s", "right hits", "screen, ϱ 0", "screen, ϱ 0.1", "world, ϱ 0", "world, ϱ 0.1"];
    table(&head, rows)
}

fn by_roughness(folder: &Path) -> Result<String> {
    let records = plain_errors(folder)?;
    let row = |method: &str, against: &str| {
        let errors = ROUGHNESS.map(|r| rmse(&records, method, against, r, 4));
        [format!("`{method}`"), against.to_owned()].into_iter().chain(errors).collect::<Vec<_>>()
    };
    let mut rows = Vec::new();
    for method in ["ssct", "hzct", "exact-hits+cone", "unified", "screen-reference"] {
        let method_rows = ["screen", "world"].map(|against| row(method, against));
        rows.extend(method_rows.into_iter().filter(|row| row.iter().any(|c| c.contains('.'))));
    }
    table(&["what", "against the", "ϱ 0", "0.05", "0.1", "0.3", "0.6"], rows)
}

/// How hits of mirrors compare with the oracle's, mean over the views.
fn hits(folder: &Path) -> Result<String> {
    let records = plain_errors(folder)?;
    let mut rows = Vec::new();
    for method in names(&records, "method") {
        let share = |field| mean(&figures(&records, &method, "oracle", "0", field)).map(|s| percent(s, 1));
        let Ok(agree) = share("hit_agreement") else { continue };
        rows.push(vec![format!("`{method}`"), agree, share("false")?, share("missed")?, share("displaced")?]);
    }
    table(&["method", "right", "false", "missed", "displaced"], rows)
}

/// In how many cells of how many another method, at any setting, is both faster and nearer to the screen reference.
fn better_than(folder: &Path, method: &str) -> Result<String> {
    let all = json(folder, "error.json")?;
    let plain = plain_errors(folder)?;
    let point = |r: &Value| Some((r["time_ms"].as_f64()?, r["rmse"].as_f64()?));
    let (mut cells, mut beaten) = (0, 0);
    for own in plain.iter().filter(|r| r["method"] == method && r["against"] == "screen") {
        let (ms, rmse) = point(own).ok_or("a record without a time or an error")?;
        let same = |r: &&Value| ["against", "view", "roughness", "width"].iter().all(|f| r[f] == own[f]);
        let others = all.iter().filter(same).filter(|r| r["method"] != method).filter_map(point);
        cells += 1;
        beaten += u32::from(others.into_iter().any(|(t, e)| t < ms && e < rmse));
    }
    if cells == 0 { Err(format!("no {method}")) } else { Ok(format!("{beaten} of {cells}")) }
}

/// The mirror rays that `unified` shows wrongly over those that `ssct` does, median and greatest over the views that
/// the second folder has times of.
fn wrong_rays(folders: &[PathBuf]) -> Result<String> {
    let [truth, bars] = folders else { return Err("views of the one folder are chosen by the other".to_owned()) };
    let times = bars_times(bars, "960x540")?;
    let views: BTreeSet<_> = times.keys().map(|(scene, view, _)| (scene.clone(), view.clone())).collect();
    let all = csv(truth, "truth.csv")?;
    let mut rows = Vec::new();
    for size in ["960x540", "641x479"] {
        for oracle in ["1", "2"] {
            let here = all.iter().filter(|r| r["size"] == size && r["oracle"] == oracle);
            let chosen = here.filter(|r| views.contains(&(r["scene"].clone(), r["view"].clone())));
            let over = chosen.map(|r| Ok(number(r, "wrong")? / number(r, "ssct")?)).collect::<Result<Vec<_>>>()?;
            rows.push(vec![size.replace('x', "×"), oracle.to_owned(), median_and_greatest(&over)?]);
        }
    }
    table(&["size", "version of the oracle", "wrong rays / those of `ssct`"], rows)
}

fn why_wrong(folder: &Path, scene: &str, view: &str, size: &str) -> Result<String> {
    let all = csv(folder, "truth.csv")?;
    let here = all.iter().filter(|r| r["scene"] == scene && r["view"] == view && r["size"] == size);
    let fields = ["wrong", "false_side", "false_front", "displaced", "missed", "least"];
    let row = |r: &Row| {
        let shares = fields.iter().map(|f| Ok(percent(number(r, f)?, 1))).collect::<Result<Vec<_>>>()?;
        let over = ratio(number(r, "wrong")? / number(r, "ssct")?);
        Ok([r["oracle"].clone(), over].into_iter().chain(shares).collect())
    };
    let head = [
        "version",
        "wrong / `ssct`'s",
        "wrong",
        "false, on a side",
        "false, on a front",
        "displaced",
        "missed",
        "wrong at best",
    ];
    table(&head, here.map(row).collect::<Result<_>>()?)
}

fn need(folder: &Path) -> Result<String> {
    let all = csv(folder, "need.csv")?;
    let fields = ["need", "fixed", "covered", "growth", "cells", "block_cells"];
    let row = |r: &Row| {
        let ratios = fields.iter().map(|f| Ok(format!("{:.2}", number(r, f)?))).collect::<Result<Vec<_>>>()?;
        Ok([r["roughness"].clone()].into_iter().chain(ratios).collect())
    };
    let medians = all.iter().filter(|r| r["view"] == "median");
    let head = [
        "roughness",
        "time of a tenth",
        "of it the same for any share",
        "pixels covered",
        "growth of time",
        "growth of cells",
        "growth of cells in step",
    ];
    table(&head, medians.map(row).collect::<Result<_>>()?)
}

/// What the door for other renderers costs: its time over the command's, the pass that takes images over, and memory.
fn door(folder: &Path) -> Result<String> {
    let all = csv(folder, "door.csv")?;
    let row = |method: &&str| {
        let method_rows: Vec<&Row> = all.iter().filter(|r| r["method"] == *method).collect();
        let figure =
            |field| method_rows.iter().map(|r| number(r, field)).collect::<Result<Vec<_>>>().and_then(|v| median(&v));
        let bytes = figure("bytes")? / 1e6;
        Ok(vec![
            format!("`{method}`"),
            ratio(figure("ratio")?),
            format!("{:.1}", figure("import_ms")?),
            format!("{bytes:.1}"),
        ])
    };
    let head = ["method", "effect / the command's", "`import` in ms", "MB on the device"];
    table(&head, ["unified", "ssct", "hzct"].iter().map(row).collect::<Result<_>>()?)
}

/// Errors by the formats of a G-buffer, mean over the views of a scene.
fn precision(folder: &Path, scene: &str) -> Result<String> {
    let all = csv(folder, &format!("{scene}.csv"))?;
    let mut order: Vec<&str> = all.iter().map(|row| row["storage"].as_str()).collect();
    let mut known = BTreeSet::new();
    order.retain(|storage| known.insert(*storage));
    let mut rows = Vec::new();
    for storage in order {
        let here: Vec<&Row> = all.iter().filter(|r| r["storage"] == storage && r["roughness"] == "0").collect();
        let bytes = &here.first().ok_or("no mirror")?["bytes_per_pixel"];
        let mut row = vec![storage.to_owned(), bytes.clone()];
        for method in ["oracle", "unified", "ssct"] {
            let method_rows = here.iter().filter(|r| r["method"] == method);
            let wrong = method_rows.map(|r| Ok(1.0 - number(r, "hit_agreement")?)).collect::<Result<Vec<_>>>()?;
            let wrong = mean(&wrong)?;
            let decimals = [(0.01, 1), (1e-4, 2)].iter().find(|(above, _)| wrong > *above).map_or(4, |(_, d)| *d);
            row.push(percent(wrong, decimals));
        }
        rows.push(row);
    }
    table(&["formats", "bytes", "oracle, wrong", "`unified`, wrong", "`ssct`, wrong"], rows)
}
