//! The tables of what a second layer of depth gains, and a capture at the camera: a folder for each variant, with the records of
//! all scenes.

use super::figures::{Result, figures, json, mean, percent, ratio, table};
use serde_json::Value;
use std::path::Path;

const SCENES: [&str; 6] = ["rooms", "corridor", "atrium", "street", "museum", "cathedral"];

/// The method that stands in every run, by which times are told.
const TIMED_BY: &str = "ssct";

/// Means over a scene's views against the world; of the times, over those of [`TIMED_BY`] in the same run.
struct Run(Vec<Value>);

impl Run {
    fn read(folder: &Path, variant: &str, scene: &str) -> Result<Self> {
        let mut records = json(&folder.join(variant), "error.json")?;
        records.retain(|record| record["scene"] == scene);
        Ok(Self(records))
    }

    fn mean(&self, method: &str, roughness: &str, field: &str) -> Result<f64> {
        mean(&figures(&self.0, method, "world", roughness, field))
            .map_err(|e| format!("{method} at {roughness}, {field}: {e}"))
    }

    fn error(&self, method: &str, roughness: &str) -> Result<f64> {
        self.mean(method, roughness, "rmse")
    }

    fn places(&self, method: &str) -> Result<f64> {
        self.mean(method, "0", "place_agreement")
    }

    fn time(&self, method: &str, roughness: &str) -> Result<f64> {
        Ok(self.mean(method, roughness, "time_ms")? / self.mean(TIMED_BY, roughness, "time_ms")?)
    }
}

/// A row of the means of columns of some rows, each written by its column's function.
fn with_means(rows: Vec<(Vec<String>, Vec<f64>)>, write: &[fn(f64) -> String], last: &[&str]) -> Vec<Vec<String>> {
    let written = |values: &[f64]| values.iter().zip(write).map(|(v, w)| w(*v)).collect::<Vec<_>>();
    let count = rows.len() as f64;
    let means: Vec<f64> = (0..write.len()).map(|c| rows.iter().map(|(_, v)| v[c]).sum::<f64>() / count).collect();
    let mut all: Vec<Vec<String>> = rows.iter().map(|(head, v)| [head.clone(), written(v)].concat()).collect();
    all.push([last.iter().map(|l| (*l).to_owned()).collect(), written(&means)].concat());
    all
}

fn error(value: f64) -> String {
    format!("{value:.4}")
}

fn share(value: f64) -> String {
    percent(value, 1)
}

/// What a second layer gains mirrors: errors and right places with one layer, with a second one that is empty, and with
/// two; the time over that of one layer.
pub fn layers(folder: &Path) -> Result<String> {
    let mut all = Vec::new();
    for method in ["poster", "ssr", "dda"] {
        let mut rows = Vec::new();
        for scene in SCENES {
            let runs = ["one", "empty", "two"].map(|variant| Run::read(folder, variant, scene));
            let [one, empty, two] = runs;
            let (one, empty, two) = (one?, empty?, two?);
            let values = vec![
                one.error(method, "0")?,
                empty.error(method, "0")?,
                two.error(method, "0")?,
                one.places(method)?,
                empty.places(method)?,
                two.places(method)?,
                two.time(method, "0")? / one.time(method, "0")?,
            ];
            rows.push((vec![format!("`{method}`"), scene.to_owned()], values));
        }
        let write: [fn(f64) -> String; 7] = [error, error, error, share, share, share, ratio];
        all.extend(with_means(rows, &write, &[&format!("`{method}`"), "*all six*"]));
    }
    let head = [
        "method",
        "scene",
        "error, 1 layer",
        "2nd empty",
        "2 layers",
        "right places, 1 layer",
        "2nd empty",
        "2 layers",
        "time / that of 1 layer",
    ];
    table(&head, all)
}

/// Errors of the poster's gloss with one layer and with two.
pub fn layers_gloss(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for scene in SCENES {
        let (one, two) = (Run::read(folder, "1", scene)?, Run::read(folder, "2", scene)?);
        rows.push((vec![scene.to_owned()], vec![one.error("poster", "0.3")?, two.error("poster", "0.3")?]));
    }
    table(&["scene", "error, 1 layer", "2 layers"], with_means(rows, &[error, error], &["*all six*"]))
}

/// Captures of `unified`: their flags, and the folder of their runs.
const CAPTURES: [(&str, &str); 4] =
    [("none", "none"), ("camera", "camera"), ("camera, 256²", "camera-256"), ("auto", "auto")];

/// What a capture at the camera gains beside those that are placed: means over the views of all scenes of errors and right
/// places of `unified`, and its time over that without captures.
pub fn camera_capture(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for (name, variant) in CAPTURES {
        let over = |value: &dyn Fn(&Run, &Run) -> Result<f64>| {
            let scene_value =
                |scene: &&str| value(&Run::read(folder, variant, scene)?, &Run::read(folder, "none", scene)?);
            mean(&SCENES.iter().map(scene_value).collect::<Result<Vec<_>>>()?)
        };
        let time = |roughness: &'static str| {
            over(&move |run, none| Ok(run.time("unified", roughness)? / none.time("unified", roughness)?))
        };
        rows.push(vec![
            name.to_owned(),
            error(over(&|run, _| run.error("unified", "0"))?),
            share(over(&|run, _| run.places("unified"))?),
            error(over(&|run, _| run.error("unified", "0.3"))?),
            ratio(time("0")?),
            ratio(time("0.3")?),
        ]);
    }
    let head = ["captures", "error, ϱ 0", "right places", "error, ϱ 0.3", "time, ϱ 0", "time, ϱ 0.3"];
    table(&head, rows)
}

/// Errors and right places of mirrors by scene, for each kind of captures.
pub fn camera_by_scene(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for scene in SCENES {
        let runs = CAPTURES.map(|(_, variant)| Run::read(folder, variant, scene));
        let runs = runs.into_iter().collect::<Result<Vec<_>>>()?;
        let mut values = runs.iter().map(|run| run.error("unified", "0")).collect::<Result<Vec<_>>>()?;
        values.extend(runs.iter().map(|run| run.places("unified")).collect::<Result<Vec<_>>>()?);
        rows.push((vec![scene.to_owned()], values));
    }
    let write: [fn(f64) -> String; 8] = [error, error, error, error, share, share, share, share];
    let head: Vec<String> = ["error", "right places"]
        .iter()
        .flat_map(|what| CAPTURES.iter().map(move |(name, _)| format!("{what}, {name}")))
        .collect();
    let head: Vec<&str> = ["scene"].into_iter().chain(head.iter().map(String::as_str)).collect();
    table(&head, with_means(rows, &write, &["*all six*"]))
}

/// Errors and right places of mirrors with captures behind `ssct`.
pub fn camera_behind(folder: &Path) -> Result<String> {
    let mut rows = Vec::new();
    for scene in SCENES {
        let runs = ["none", "behind-camera", "behind-auto"].map(|variant| Run::read(folder, variant, scene));
        let errors = runs.into_iter().map(|run| run?.error("ssct", "0")).collect::<Result<Vec<_>>>()?;
        rows.push((vec![scene.to_owned()], errors));
    }
    let head = ["scene", "error of `ssct`, nothing behind", "`camera`", "`auto`"];
    table(&head, with_means(rows, &[error, error, error], &["*all six*"]))
}

/// What the size of the faces of four captures changes for mirrors, by scene: errors, right places, and times over `ssct`.
pub fn face_sizes(folder: &Path) -> Result<String> {
    const SIDES: [&str; 3] = ["128", "256", "512"];
    let mut rows = Vec::new();
    for scene in SCENES {
        let runs = SIDES.map(|side| Run::read(folder, side, scene)).into_iter().collect::<Result<Vec<_>>>()?;
        let mut values = runs.iter().map(|run| run.error("unified", "0")).collect::<Result<Vec<_>>>()?;
        values.extend(runs.iter().map(|run| run.places("unified")).collect::<Result<Vec<_>>>()?);
        values.extend(runs.iter().map(|run| run.time("unified", "0")).collect::<Result<Vec<_>>>()?);
        rows.push((vec![scene.to_owned()], values));
    }
    let write: [fn(f64) -> String; 9] = [error, error, error, share, share, share, ratio, ratio, ratio];
    let head: Vec<String> = ["error", "right places", "time"]
        .iter()
        .flat_map(|what| SIDES.iter().map(move |side| format!("{what}, {side}²")))
        .collect();
    let head: Vec<&str> = ["scene"].into_iter().chain(head.iter().map(String::as_str)).collect();
    table(&head, with_means(rows, &write, &["*all six*"]))
}
