//! Tests that nothing is judged that cannot be seen. If a method's reflection is black everywhere in the quoted
//! records, the page has no verdict and no row about it. No record against an older reference is quoted either.

use super::{pages, root};
use ssct::methods::{METHODS, MethodInfo};
use ssct_docs::pages::{definitions, outside_code, quotations};
use ssct_docs::records::{Row, read};
use ssct_docs::scenes::{lacks, scene_of_row};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the files in a folder and below it, or the path itself if it is a file.
fn files(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|entry| files(&entry)).collect()
}

/// Returns the rows of a file of records, or nothing if the file has another ending.
fn rows(path: &Path) -> Vec<Row> {
    let is_of_records = path.extension().is_some_and(|extension| extension == "json" || extension == "csv");
    if is_of_records { read(path, "").unwrap_or_default() } else { Vec::new() }
}

/// A method's quoted records: the scenes that they are of, and the shares of black pixels of those records that have
/// them.
#[derive(Default)]
struct Quoted {
    scenes: BTreeSet<String>,
    black: Vec<f64>,
}

/// Gathers the records of some folders, by method.
fn quoted(folders: &[PathBuf]) -> BTreeMap<String, Quoted> {
    let mut by_method = BTreeMap::<String, Quoted>::new();
    for row in folders.iter().flat_map(|folder| files(folder)).flat_map(|file| rows(&file)) {
        let text = |field: &str| row.get(field).map(String::as_str);
        let Some(method) = text("method") else { continue };
        let quoted = by_method.entry(method.to_owned()).or_default();
        quoted.scenes.extend(scene_of_row(text("scene"), text("case")).map(str::to_owned));
        quoted.black.extend(text("black").and_then(|share| share.parse::<f64>().ok()));
    }
    by_method
}

/// Returns why a method's records show nothing, or `None` if they show something or there are none.
fn nothing_shown(quoted: &Quoted, method: &str) -> Option<String> {
    if !quoted.black.is_empty() {
        let is_black = quoted.black.iter().all(|share| *share >= 1.0);
        return is_black.then(|| "every pixel of its records is black".to_owned());
    }
    let lacking: Vec<&String> = quoted.scenes.iter().filter(|name| lacks(name, method)).collect();
    let is_seen = quoted.scenes.is_empty() || lacking.len() < quoted.scenes.len();
    (!is_seen).then(|| format!("it lacks what it needs in {lacking:?}, so that it is black there"))
}

/// Returns the methods that a quoted table is about: those that its query names, and those in the first row or the
/// first column of the table.
fn methods_of(query: &str, answer: &str) -> Vec<&'static MethodInfo> {
    let words = query.split([' ', ',']);
    let firsts = answer.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let heads = answer.lines().next().unwrap_or_default().split('`').skip(1).step_by(2);
    let names: BTreeSet<&str> = words.chain(firsts).chain(heads).collect();
    METHODS.iter().filter(|method| names.contains(method.name)).collect()
}

/// No page quotes a time or an error of a method from records in which its reflection is black everywhere. A method
/// that shows nothing is fast and has an error like any other.
#[test]
fn nothing_is_judged_that_is_black_everywhere() {
    let (mut black, mut judged) = (Vec::new(), 0);
    // The records of folders that were read before.
    let mut known = BTreeMap::new();
    for (name, text) in pages() {
        for shown in quotations(&root(), &name, &text).unwrap().0 {
            let quoted = known.entry(shown.folders.clone()).or_insert_with(|| quoted(&shown.folders));
            for method in methods_of(shown.query, shown.says.trim()) {
                judged += 1;
                let why = quoted.get(method.name).and_then(|quoted| nothing_shown(quoted, method.name));
                black.extend(why.map(|why| format!("{name}: {}: {}: {why}", shown.query, method.name)));
            }
        }
    }
    assert!(black.is_empty(), "judged, but not seen:\n{}", black.join("\n"));
    assert!(judged > 200, "only {judged} methods are judged");
}

/// Records of a method without its impostors, or with a share of black pixels of 1, count as showing nothing; others do
/// not. The test above relies on this.
#[test]
fn what_is_black_everywhere_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let folders = vec![folder.path().to_owned()];
    let shows_nothing = |records: &str, method: &str| {
        fs::write(folder.path().join("error.json"), records).unwrap();
        nothing_shown(&quoted(&folders)[method], method).is_some()
    };
    let rooms = r#"[{"method": "billboard", "scene": "rooms"}, {"method": "ssct", "scene": "rooms"}]"#;
    assert!(shows_nothing(rooms, "billboard") && !shows_nothing(rooms, "ssct"), "the rooms have no impostors");
    let street = r#"[{"method": "billboard", "scene": "rooms"}, {"method": "billboard", "scene": "street"}]"#;
    assert!(!shows_nothing(street, "billboard"), "the street has impostors");
    let measured = |black: [f64; 2]| {
        let row = |black: f64| format!(r#"{{"method": "planar", "scene": "museum", "black": {black}}}"#);
        format!("[{}]", black.map(row).join(", "))
    };
    assert!(shows_nothing(&measured([1.0, 1.0]), "planar") && !shows_nothing(&measured([1.0, 0.9]), "planar"));
    let words = methods_of("claim-time billboard ssr 0", "| method | time |\n|---|---|\n| `ibr` | 1 |\n");
    assert_eq!(words.iter().map(|m| m.name).collect::<Vec<_>>(), ["ssr", "billboard", "ibr"]);
}

/// Returns the files and folders of `benches/runs` that a page names, by links or by their paths in code.
fn runs_named(name: &str, text: &str) -> Vec<PathBuf> {
    let folder = root().join(name).parent().unwrap().to_owned();
    let mut targets: Vec<PathBuf> = definitions(text).values().map(|target| folder.join(target)).collect();
    for line in outside_code(text) {
        targets.extend(line.split("](").skip(1).map(|link| folder.join(link.split(')').next().unwrap())));
        let code = line.split('`').skip(1).step_by(2).filter(|code| code.starts_with("20"));
        targets.extend(code.map(|code| root().join("benches/runs").join(code.trim_end_matches('…'))));
    }
    let is_run = |path: &PathBuf| path.components().any(|c| c.as_os_str() == "runs") && path.exists();
    targets.into_iter().filter(is_run).collect()
}

/// No page names a run whose records were judged by an older version of the references, since its errors cannot be
/// compared with today's.
#[test]
fn no_record_against_an_older_reference_is_quoted() {
    // The files of runs, each with a page that names it.
    let mut quoted = BTreeMap::new();
    for (name, text) in pages() {
        for path in runs_named(&name, &text) {
            // A picture shows the records in its folder.
            let folder = if path.is_dir() { path.clone() } else { path.parent().unwrap().to_owned() };
            quoted.extend(files(&folder).into_iter().map(|file| (file, name.clone())));
        }
    }
    let older = quoted.iter().filter_map(|(file, name)| {
        let failure = read(file, "").err().filter(|failure| failure.words.contains("older reference"))?;
        Some(format!("{name}: {failure}"))
    });
    let older: Vec<String> = older.collect();
    assert!(older.is_empty(), "quoted, but older than today's references:\n{}", older.join("\n"));
    assert!(quoted.len() > 100, "only {} files of runs are quoted", quoted.len());
}
