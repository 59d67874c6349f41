//! Methods beside each other, and filters of the poster's: a folder of records for each scene.

use super::claims;
use super::figures::{Result, figures, greatest, json, least, mean, median, percent, ratio, shortest, table};
use serde_json::Value;
use std::path::Path;

/// The medians over a scene's views of the error against the world, and of the time over the last method's. Methods,
/// scenes and roughness values have commas between them.
pub fn beside(folder: &Path, methods: &str, scenes: &str, roughness: &str) -> Result<String> {
    let methods: Vec<&str> = methods.split(',').collect();
    let last = *methods.last().ok_or("no methods")?;
    let mut rows = Vec::new();
    for scene in scenes.split(',') {
        let records = json(&folder.join(scene), "error.json")?;
        for roughness in roughness.split(',') {
            let median_of = |method, field| median(&figures(&records, method, "world", roughness, field));
            let mut row = vec![format!("`{scene}`"), shortest(roughness)];
            for method in &methods {
                row.push(format!("{:.4}", median_of(method, "rmse")?));
            }
            for method in &methods[..methods.len() - 1] {
                row.push(ratio(median_of(method, "time_ms")? / median_of(last, "time_ms")?));
            }
            rows.push(row);
        }
    }
    let errors = methods.iter().map(|m| format!("error, `{m}`"));
    let times = methods[..methods.len() - 1].iter().map(|m| format!("`{m}`: time / `{last}`'s"));
    let head: Vec<String> = ["scene".to_owned(), "ϱ".to_owned()].into_iter().chain(errors).chain(times).collect();
    table(&head.iter().map(String::as_str).collect::<Vec<_>>(), rows)
}

/// The poster's filters: hits of mirrors, errors against the screen by roughness, and the time over that of `ssct`; means
/// over all views of three scenes.
pub fn poster_filters(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for filter in ["mip", "volume", "edge-aware"] {
        let scenes = ["rooms", "museum", "street"].map(|scene| json(&folder.join(filter).join(scene), "error.json"));
        let scenes = scenes.into_iter().collect::<Result<Vec<Vec<Value>>>>()?;
        let mean_of = |method, against, roughness, field| {
            let all = scenes.iter().flat_map(|records| figures(records, method, against, roughness, field));
            mean(&all.collect::<Vec<_>>())
        };
        let time = |method| mean_of(method, "world", "0.1", "time_ms");
        let mut row = vec![format!("`{filter}`"), ratio(time("poster")? / time("ssct")?)];
        row.push(percent(mean_of("poster", "oracle", "0", "hit_agreement")?, 1));
        for roughness in ["0", "0.1", "0.3"] {
            row.push(format!("{:.4}", mean_of("poster", "screen", roughness, "rmse")?));
        }
        rows.push(row);
    }
    table(&["filter", "time, ϱ 0.1", "right hits", "error, ϱ 0", "error, ϱ 0.1", "error, ϱ 0.3"], rows)
}

/// The poster's error against the screen with volumes over that with mip levels, at a roughness: of the means over all views of
/// three scenes, and of the views the least and the greatest.
pub fn poster_gain(folder: &Path, roughness: &str) -> Result<String> {
    let errors = |filter: &str| {
        let scenes = ["rooms", "museum", "street"].map(|scene| json(&folder.join(filter).join(scene), "error.json"));
        let records = scenes.into_iter().collect::<Result<Vec<_>>>()?.concat();
        Ok::<_, String>(figures(&records, "poster", "screen", roughness, "rmse"))
    };
    let (volume, mip) = (errors("volume")?, errors("mip")?);
    let views = claims::ratios(&volume, &mip)?;
    Ok(format!("{} ({} to {})", ratio(mean(&volume)? / mean(&mip)?), ratio(least(&views)), ratio(greatest(&views))))
}

/// The blurs of `billboard`: errors against the world by roughness, medians over the views of two scenes.
pub fn billboard_blurs(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for blur in ["none", "roughness", "distance"] {
        let mut row = vec![format!("`{blur}`")];
        for scene in ["street", "museum"] {
            let mut records = json(&folder.join(blur), "error.json")?;
            records.retain(|record| record["scene"] == scene);
            for roughness in ["0.1", "0.3"] {
                row.push(format!("{:.4}", median(&figures(&records, "billboard", "world", roughness, "rmse"))?));
            }
        }
        rows.push(row);
    }
    table(&["blur", "`street`, ϱ 0.1", "`street`, ϱ 0.3", "`museum`, ϱ 0.1", "`museum`, ϱ 0.3"], rows)
}

/// Rays reflected at other normals than those of shading, and bumps after the tracing: right hits of mirrors, and errors
/// against the screen and the world, medians over the views.
pub fn trace_normals(folder: &Path) -> Result<String> {
    let variants = [
        ("shading", "of shading", "–"),
        ("geometric", "geometric", "–"),
        ("bump-0.05", "geometric", "0.05"),
        ("bump-0.2", "geometric", "0.2"),
        ("up", "up", "–"),
    ];
    let mut rows = Vec::new();
    for (run, normals, bump) in variants {
        let records = json(&folder.join(run), "error.json")?;
        for method in ["ssct", "unified"] {
            let median_of = |against, roughness, field| median(&figures(&records, method, against, roughness, field));
            let mut row = vec![normals.to_owned(), bump.to_owned(), format!("`{method}`")];
            row.push(percent(median_of("oracle", "0", "hit_agreement")?, 1));
            for (against, roughness) in [("screen", "0"), ("screen", "0.3"), ("world", "0"), ("world", "0.3")] {
                row.push(format!("{:.4}", median_of(against, roughness, "rmse")?));
            }
            rows.push(row);
        }
    }
    let head =
        ["normals", "bump", "method", "right hits", "screen, ϱ 0", "screen, ϱ 0.3", "world, ϱ 0", "world, ϱ 0.3"];
    table(&head, rows)
}
