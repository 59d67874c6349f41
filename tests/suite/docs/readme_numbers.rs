//! The README's numbers by view, for `ssct gpu-study`, which holds a device against them (`lab/src/study/readme.csv`).

use super::beyond::triangles_of_view;
use super::devices;
use super::figures::{ROUGHNESS, Result, median_and_greatest, shortest};
use super::records::{self, bars_errors, bars_times, errors_over, times_over};
use ssct_lab::study::readme::{Figure, ON_SCREEN, QuotedNumber, SCREEN_SCENES, VIEWS};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Who measures what the study does not: words of a query, where it stands, and the command.
const ELSEWHERE: [(&str, &str, &str); 4] = [
    ("bevy", "in Bevy", "scripts/bevy.sh"),
    ("league", "among other engines", "make league"),
    ("beaten", "against every method", "ssct error of 31 views"),
    ("time-range", "against every method", "ssct time of 31 views"),
];

/// The columns of the table of triangles: what each is, of which variant, and over which.
const TRIANGLES: [(Figure, &str, &str); 5] = [
    (Figure::Error, "unified", "ssct"),
    (Figure::Error, "traced", "ssct"),
    (Figure::Ends, "unified", ""),
    (Figure::Time, "unified", "ssct"),
    (Figure::Time, "traced", "ssct"),
];

/// The file, from the README's text and the folders that it names.
pub fn csv(readme: &str, folders: &BTreeMap<String, PathBuf>) -> Result<String> {
    let folder = |name: &str| folders.get(name).ok_or_else(|| format!("the README has no link [{name}]"));
    let mut all = triangles(folder("triangles")?)?;
    all.extend(screen(folder("bars")?, folder("bars-errors")?)?);
    all.extend(hits(folder("bars-errors")?)?);
    all.extend(elsewhere(readme, folders)?);
    let mut writer = csv::Writer::from_writer(Vec::new());
    all.iter().try_for_each(|quoted| writer.serialize(quoted)).map_err(|e| e.to_string())?;
    String::from_utf8(writer.into_inner().map_err(|e| e.to_string())?).map_err(|e| e.to_string())
}

/// What a number is called: `unified: time / ssct's`.
fn column(figure: Figure, variant: &str, over: &str) -> String {
    match figure {
        Figure::Time => format!("{variant}: time / {over}'s"),
        Figure::Error => format!("{variant}: error / {over}'s"),
        Figure::Hits => format!("{variant}: rays that end where the oracle says"),
        Figure::Ends | Figure::Elsewhere => format!("{variant}: rays that end right"),
    }
}

/// The table of mirrors among the triangles: the scenes that have a view of [`VIEWS`], and by name those that have none.
fn triangles(folder: &Path) -> Result<Vec<QuotedNumber>> {
    let table = records::show("triangles 0", &[folder.to_owned()])?;
    let mut all = Vec::new();
    for line in table.lines().skip(2) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let scene = cells[1];
        let view = VIEWS.iter().find(|[name, _]| *name == scene).map(|[_, view]| *view);
        let values = view.map(|view| triangles_of_view(folder, scene, view)).transpose()?;
        for (n, (figure, variant, over)) in TRIANGLES.into_iter().enumerate().filter(|(n, _)| cells[n + 2] != "–") {
            all.push(QuotedNumber {
                place: "among the triangles, mirrors".to_owned(),
                row: scene.trim_matches('*').to_owned(),
                column: column(figure, variant, over),
                says: cells[n + 2].to_owned(),
                measured_on: devices::kind(folder)?.to_owned(),
                figure: if values.is_some() { figure } else { Figure::Elsewhere },
                variant: if values.is_some() { variant } else { "" }.to_owned(),
                over: if values.is_some() { over } else { "" }.to_owned(),
                command: if values.is_some() { "" } else { "ssct error and ssct time of its views" }.to_owned(),
                roughness: Some(0.0),
                scene: view.map_or("", |_| scene).to_owned(),
                view: view.unwrap_or_default().to_owned(),
                value: values.map(|values| values[n]),
            });
        }
    }
    Ok(all)
}

/// The table of the screen, at each roughness and on each view that its records and [`VIEWS`] share.
fn screen(timed: &Path, judged: &Path) -> Result<Vec<QuotedNumber>> {
    let (times, errors) = (bars_times(timed, "960x540")?, bars_errors(judged)?);
    let mut all = Vec::new();
    for roughness in ROUGHNESS {
        for (figure, over) in [(Figure::Time, "ssct"), (Figure::Time, "hzct"), (Figure::Error, "ssct")] {
            let over_all = match figure {
                Figure::Time => times_over(timed, "960x540", roughness, over)?,
                _ => errors_over(judged, roughness, ("unified", "screen"), (over, "screen"))?,
            };
            for [scene, view] in VIEWS.iter().filter(|[scene, _]| SCREEN_SCENES.contains(scene)) {
                let cell = ((*scene).to_owned(), (*view).to_owned(), roughness.to_owned());
                let one = |method: &str| match figure {
                    Figure::Time => times.get(&cell).and_then(|t| t.get(method)),
                    _ => errors.get(&cell).and_then(|e| e.get(&(method.to_owned(), "screen".to_owned()))),
                };
                let value = one("unified").zip(one(over)).map(|(own, other)| own / other);
                all.push(QuotedNumber {
                    place: "against the screen".to_owned(),
                    row: format!("roughness {}", shortest(roughness)),
                    column: column(figure, ON_SCREEN, over),
                    says: median_and_greatest(&over_all)?,
                    measured_on: devices::kind(if figure == Figure::Time { timed } else { judged })?.to_owned(),
                    figure,
                    variant: ON_SCREEN.to_owned(),
                    over: over.to_owned(),
                    command: String::new(),
                    roughness: Some(roughness.parse().map_err(|_| format!("{roughness} is no number"))?),
                    scene: (*scene).to_owned(),
                    view: (*view).to_owned(),
                    value: Some(value.ok_or_else(|| format!("no {figure:?} of {scene} {view}"))?),
                });
            }
        }
    }
    Ok(all)
}

/// The share of mirror rays that the README names, on the views that its records and [`VIEWS`] share.
fn hits(folder: &Path) -> Result<Vec<QuotedNumber>> {
    let mut all = Vec::new();
    for [scene, view] in VIEWS.iter().filter(|[scene, _]| SCREEN_SCENES.contains(scene)) {
        all.push(QuotedNumber {
            place: "against the screen".to_owned(),
            row: "at least".to_owned(),
            column: column(Figure::Hits, ON_SCREEN, ""),
            says: records::show("least-agreement", &[folder.to_owned()])?,
            measured_on: devices::kind(folder)?.to_owned(),
            figure: Figure::Hits,
            variant: ON_SCREEN.to_owned(),
            over: String::new(),
            command: String::new(),
            roughness: Some(0.0),
            scene: (*scene).to_owned(),
            view: (*view).to_owned(),
            value: Some(records::agreement(folder, scene, view)?),
        });
    }
    Ok(all)
}

/// What stands in the README's text.
fn elsewhere(readme: &str, folders: &BTreeMap<String, PathBuf>) -> Result<Vec<QuotedNumber>> {
    let mut all = Vec::new();
    for after in readme.split("<!-- show: ").skip(1) {
        let (marker, after) = after.split_once(" -->").ok_or("a marker without an end")?;
        let (query, records) = marker.split_once(" of ").ok_or_else(|| format!("{marker}: of which records?"))?;
        let first = query.split(' ').next().unwrap_or_default();
        let Some((_, place, command)) = ELSEWHERE.iter().find(|(word, ..)| *word == first) else { continue };
        let folder = folders.get(records).ok_or_else(|| format!("the README has no link [{records}]"))?;
        all.push(QuotedNumber {
            place: (*place).to_owned(),
            row: String::new(),
            column: query.to_owned(),
            says: after.split("<!--").next().unwrap_or_default().trim().to_owned(),
            measured_on: devices::kind(folder)?.to_owned(),
            figure: Figure::Elsewhere,
            variant: String::new(),
            over: String::new(),
            command: (*command).to_owned(),
            roughness: None,
            scene: String::new(),
            view: String::new(),
            value: None,
        });
    }
    Ok(all)
}
