//! Tests studies divided among machines: each shard is a run of its own, and the merged shards are the study that one
//! machine would have measured.

use crate::common::folder::boards;
use crate::common::hang::wait_until;
use serde_json::Value;
use ssct_lab::study::journal::scene_digest;
use ssct_scenes::library;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The program under test.
const SSCT: &str = env!("CARGO_BIN_EXE_ssct");
/// A small run of `ssct error`.
const ERROR: [&str; 11] =
    ["error", "--quick", "--method", "ssct,hzct", "--rays", "4", "--samples", "20", "--size", "96x54", "--scene=rooms"];

/// Runs a command to its end, without a panic. Returns its exit status, standard output and standard error.
fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(SSCT).args(arguments).output().unwrap();
    let [printed, errors] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(!errors.contains("panicked"), "{errors}");
    (output.status.code(), printed, errors)
}

/// Returns the output of a command, which must succeed and print nothing to standard error.
fn run_successfully(arguments: &[&str]) -> String {
    let (status, printed, errors) = run(arguments);
    assert_eq!((status, errors.as_str()), (Some(0), ""), "{arguments:?}");
    printed
}

/// Returns the single line that a command prints to standard error when it fails.
fn refused(arguments: &[&str]) -> String {
    let (status, _, errors) = run(arguments);
    assert_eq!((status, errors.lines().count()), (Some(1), 1), "{arguments:?}: {errors}");
    errors
}

/// Folders below a temporary one.
struct Folders(tempfile::TempDir);

impl Folders {
    /// Makes the temporary folder.
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Returns the path of a folder or file by its name.
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Returns the path of a folder as a text.
    fn name(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    /// Runs a shard into the folder that its number names.
    fn shard(&self, command: &[&str], index: u32, count: u32) {
        let (shard, folder) = (format!("{index}/{count}"), self.name(&index.to_string()));
        run_successfully(&[command, &["--shard", &shard, "-o", &folder]].concat());
    }

    /// Returns the content of a JSON file.
    fn json(&self, file: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path(file)).unwrap()).unwrap()
    }

    /// Returns the paths of all files below a folder.
    fn files(&self, folder: &str) -> BTreeSet<String> {
        let (top, mut to_visit, mut found) = (self.path(folder), vec![self.path(folder)], BTreeSet::new());
        while let Some(path) = to_visit.pop() {
            if path.is_dir() {
                to_visit.extend(std::fs::read_dir(path).unwrap().map(|e| e.unwrap().path()));
            } else {
                found.insert(path.strip_prefix(&top).unwrap().to_string_lossy().into_owned());
            }
        }
        found
    }
}

/// Fields of records that are times.
const TIMES: [&str; 13] = [
    "time_ms",
    "time_low_ms",
    "time_high_ms",
    "prepared",
    "effect_ms",
    "capture_ms",
    "passes",
    "total",
    "frame",
    "frame_ms",
    "noise_floor",
    "effect",
    "fps",
];

/// Returns a record without its times.
fn figures(mut value: Value) -> Value {
    match &mut value {
        Value::Object(fields) => {
            fields.retain(|name, _| !TIMES.contains(&name.as_str()));
            fields.values_mut().for_each(|v| *v = figures(v.take()));
        }
        Value::Array(items) => items.iter_mut().for_each(|v| *v = figures(v.take())),
        _ => {}
    }
    value
}

/// Returns the names of the cells that a shard owns, and those of all cells. `list` is the content of `cells.json`.
fn cells(list: &Value) -> (BTreeSet<String>, BTreeSet<String>) {
    let names = |is_own: &dyn Fn(&Value) -> bool| {
        let cells = list["cells"].as_array().unwrap().iter().filter(|c| is_own(c));
        cells.map(|c| c["name"].as_str().unwrap().to_owned()).collect()
    };
    (names(&|c| c["own"] == true), names(&|_| true))
}

/// Starts a run into a folder, and kills it once its journal there has at least `lines` lines.
fn start_and_kill(arguments: &[&str], folder: &Path, lines: usize) {
    let mut child = Command::new(SSCT).args(arguments).stdout(Stdio::null()).spawn().unwrap();
    let journal = || std::fs::read_to_string(folder.join("journal.jsonl")).unwrap_or_default();
    wait_until(|| format!("a run that should write {lines} lines"), || journal().lines().count() >= lines);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!journal().contains("finished"), "it was killed before its end");
}

/// A study is measured in three shards, one of which is killed and resumed. The merged run has the figures and images
/// of the whole study, to the bit. An incomplete merge names the missing cells.
#[test]
fn merged_shards_of_an_error_study_are_the_study() {
    let folders = Folders::new();
    let [whole, all, first] = ["whole", "all", "1"].map(|name| folders.name(name));
    run_successfully(&[&ERROR[..], &["-o", &whole]].concat());
    let first_shard = [&ERROR[..], &["--shard", "1/3", "-o", &first]].concat();
    start_and_kill(&first_shard, &folders.path("1"), 3);
    let (status, ..) = run(&first_shard);
    assert_eq!(status, Some(2), "a shard that was not finished is not begun anew");
    for n in [2, 3] {
        folders.shard(&ERROR, n, 3);
    }
    // The cells that the killed shard has not measured are named.
    let [second, third] = ["2", "3"].map(|name| folders.name(name));
    let merge = ["merge", &first, &second, &third, "-o", &all];
    let message = refused(&merge);
    let lists = ["1", "2", "3"].map(|n| cells(&folders.json(&format!("{n}/cells.json"))));
    let (first_own, everything) = &lists[0];
    assert!(everything.len() == 4 && lists.iter().all(|(_, all)| all == everything));
    let owned: Vec<&String> = lists.iter().flat_map(|(own, _)| own).collect();
    assert!(owned.len() == 4 && owned.iter().collect::<BTreeSet<_>>().len() == 4, "each cell is in one shard");
    let named = message.split("are missing: ").nth(1).and_then(|rest| rest.split(';').next()).unwrap();
    let missing: Vec<&str> = named.split(", ").collect();
    assert!(missing.iter().all(|name| first_own.contains(*name)), "{message}");
    assert!(message.contains(&format!("{} of the 4 cells are missing", missing.len())), "{message}");

    // The shards can be merged anyway, and the page names the missing cells.
    let partial = folders.name("partial");
    let printed = run_successfully(&["merge", &first, &second, &third, "-o", &partial, "--partial"]);
    let page = std::fs::read_to_string(folders.path("partial/index.html")).unwrap();
    for name in &missing {
        assert!(printed.contains(&format!("missing: {name}")) && page.contains(name), "{printed}");
    }
    run_successfully(&[&first_shard[..], &["--resume"]].concat());
    let printed = run_successfully(&[&merge[..], &["--json"]].concat());
    let summary: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((&summary["cells"], &summary["missing"]), (&4.into(), &Value::Array(vec![])));

    // The merged run has the figures of the whole study, to the bit.
    let [whole_records, merged_records] = ["whole", "all"].map(|f| folders.json(&format!("{f}/error.json")));
    assert_eq!(figures(whole_records), figures(merged_records));
    assert_eq!(folders.files("whole"), folders.files("all"));
    for file in folders.files("whole").iter().filter(|name| name.starts_with("images/")) {
        let [a, b] = ["whole", "all"].map(|f| std::fs::read(folders.path(f).join(file)).unwrap());
        assert!(a == b, "{file} differs");
    }
    // A merged run is a run like any other: --resume measures nothing, and an incomplete one merges with a further
    // shard.
    let entry_count = || std::fs::read_to_string(folders.path("all/journal.jsonl")).unwrap().lines().count();
    let (entries, records) = (entry_count(), folders.json("all/error.json"));
    run_successfully(&[&ERROR[..], &["--resume", "-o", &all]].concat());
    assert_eq!((entry_count(), folders.json("all/error.json")), (entries + 1, records), "but for the note of its end");
    let again = folders.name("again");
    run_successfully(&["merge", &partial, &first, "-o", &again]);
    assert_eq!(folders.json("again/error.json"), folders.json("all/error.json"));
}

/// Shards with other setups, cells, commits or figures, and folders that are no shards, are refused with the
/// difference. Merged, they would look like one study.
#[test]
fn what_does_not_belong_together_is_not_merged() {
    let folders = Folders::new();
    let study = ["error", "--scene", boards(), "--view", "ahead", "--no-sweep", "--size", "48x27", "--samples", "1"];
    let command = |more: &[&'static str]| [&study[..], more].concat();
    let base = command(&["--method", "ssct", "--rays", "4", "--roughness", "0,0.1"]);
    folders.shard(&base, 1, 2);
    folders.shard(&base, 2, 2);
    let [a, b, other, to] = ["1", "2", "other", "to"].map(|name| folders.name(name));
    let merge = |b: &str| refused(&["merge", &a, b, "-o", &to]);
    for (more, part) in [
        (["--method", "ssct", "--rays", "5", "--roughness", "0,0.1"], "the setup of its cell boards"),
        (["--method", "hzct", "--rays", "4", "--roughness", "0,0.1"], "the setup of its cell boards"),
        (["--method", "ssct", "--rays", "4", "--roughness", "0,0.2"], "it has no cell boards"),
    ] {
        let _ = std::fs::remove_dir_all(&other);
        run_successfully(&[&command(&more)[..], &["--shard", "2/2", "-o", &other]].concat());
        let message = merge(&other);
        assert!(message.contains("is not of the same study as") && message.contains(part), "{message}");
    }
    assert!(merge(&folders.name("nothing")).contains("cannot read"));
    std::fs::create_dir(folders.path("empty")).unwrap();
    assert!(merge(&folders.name("empty")).contains("does not say which cells it has"));
    let (status, _, message) = run(&["merge", &a, &b, "-o", &a]);
    assert!(status == Some(2) && message.contains("must lie beside"), "{message}");

    // A shard of another commit, and a shard with another value of an error.
    let changed = |file: &str, from: &str, to: &str| {
        let path = folders.path(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file} has no {from}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    };
    changed("2/cells.json", "\"kind\": \"error\"", "\"kind\": \"time\"");
    for runs in [[&a, &b], [&b, &a]] {
        // The kinds are compared before a run's results are read, which are none of the other kind.
        let message = refused(&["merge", runs[0], runs[1], "-o", &to]);
        let [first, second] = if runs[0] == &a { ["error", "time"] } else { ["time", "error"] };
        let expected = format!("{}: is of the kind {second}, and {} of the kind {first}", runs[1], runs[0]);
        assert!(message.contains(&expected), "{message}");
    }
    changed("2/cells.json", "\"kind\": \"time\"", "\"kind\": \"error\"");
    changed("2/cells.json", "\"commit\": \"", "\"commit\": \"other ");
    assert!(merge(&b).contains("its commit is other "), "{}", merge(&b));
    changed("1/cells.json", "\"commit\": \"", "\"commit\": \"other ");
    assert!(merge(&b).contains("was measured by version") && merge(&b).contains("this program is"), "{}", merge(&b));
    for n in ["1/cells.json", "2/cells.json"] {
        let text = std::fs::read_to_string(folders.path(n)).unwrap();
        std::fs::write(folders.path(n), text.replacen("\"commit\": \"other ", "\"commit\": \"", 1)).unwrap();
    }
    let copy = folders.name("copy");
    run_successfully(&["merge", &a, &b, "-o", &copy]);
    // A merge that cannot write one of its files is not finished.
    let blocked = folders.name("blocked");
    std::fs::create_dir_all(folders.path("blocked/error.csv")).unwrap();
    let (status, printed, message) = run(&["merge", &a, &b, "-o", &blocked]);
    assert!(status == Some(1) && message.contains("error.csv") && printed.is_empty(), "{printed}{message}");
    let journal = std::fs::read_to_string(folders.path("blocked/journal.jsonl")).unwrap();
    assert!(!journal.contains("finished"), "{journal}");
    let text = std::fs::read_to_string(folders.path("copy/journal.jsonl")).unwrap();
    let changed: Vec<String> = text.lines().map(|l| l.replacen("\"flip\":0.", "\"flip\":1.", 1)).collect();
    std::fs::write(folders.path("copy/journal.jsonl"), changed.join("\n") + "\n").unwrap();
    let message = merge(&copy);
    assert!(message.contains("is not as in") && message.contains("flip is 1."), "{message}");
    for wrong in ["0/2", "3/2", "1", "x/y"] {
        let (status, _, message) = run(&[&base[..], &["--shard", wrong, "-o", &other]].concat());
        assert!(status == Some(2) && message.contains("shard"), "{message}");
    }
    let (status, _, message) = run(&[&base[..], &["--shard", "1/2"]].concat());
    assert!(status == Some(2) && message.contains("--output"), "{message}");
}

/// Runs a study undivided and in two shards, merges the shards, and checks that both are equal but for times. `records`
/// is the file of the records. Returns the folders `whole`, `1`, `2` and, of the merged run, `all`.
fn check_shards(command: &[&str], records: &str) -> Folders {
    let folders = Folders::new();
    let [whole, all, first, second] = ["whole", "all", "1", "2"].map(|name| folders.name(name));
    run_successfully(&[command, &["-o", &whole]].concat());
    for n in [1, 2] {
        folders.shard(command, n, 2);
    }
    let owned = ["1", "2"].map(|n| {
        let (own, _) = cells(&folders.json(&format!("{n}/cells.json")));
        own.len()
    });
    assert!(owned.iter().all(|n| *n > 0), "{command:?}: {owned:?}");
    run_successfully(&["merge", &first, &second, "-o", &all]);
    let [undivided, merged] = ["whole", "all"].map(|f| figures(folders.json(&format!("{f}/{records}"))));
    let is_empty = undivided.as_array().is_none_or(Vec::is_empty);
    assert!(!is_empty && undivided == merged, "{command:?}:\n{undivided}\n{merged}");
    assert_eq!(folders.files("whole"), folders.files("all"), "{command:?}");
    folders
}

/// A study of times in two shards has all figures of the undivided one. Each shard measures both methods, so that they
/// are compared on one machine.
#[test]
fn times_are_divided_by_size_and_roughness() {
    let study = ["time", "--scene", boards(), "--size", "34x19,48x27", "--roughness", "0,0.1", "--samples", "3"];
    let folders = check_shards(&[&study[..], &["--method", "ssct,unified"]].concat(), "time.json");
    let samples = std::fs::read_to_string(folders.path("all/time-samples.csv")).unwrap();
    assert!(samples.lines().count() > 4 * 2 * 3 && folders.json("all/time.json").as_array().unwrap().len() == 8);
    // Each shard has both methods, since the methods are compared with each other.
    for n in ["1", "2"] {
        let records = folders.json(&format!("{n}/time.json"));
        let methods: BTreeSet<&str> = records.as_array().unwrap().iter().filter_map(|r| r["method"].as_str()).collect();
        assert_eq!(methods.len(), 2);
    }
    let [a, b] = ["whole", "all"].map(|name| folders.name(name));
    run_successfully(&["compare", &a, &b]);
}

/// Rewrites the folder of a shard as if another device had measured it.
fn rewrite_for_another_device(folder: &Path) {
    for file in ["cells.json", "journal.jsonl"] {
        let path = folder.join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        let text = text.replace("llvmpipe (", "another (").replace("\"name\":\"NVIDIA", "\"name\":\"another");
        std::fs::write(&path, text).unwrap();
    }
}

/// Shards of two devices merge into one run with a folder of times for each device and one table of errors. Times of
/// two devices cannot be compared, so a merge that mixed them would be wrong.
#[test]
fn times_of_two_devices_stay_apart() {
    let study = ["time", "--scene", boards(), "--size", "34x19,48x27", "--samples", "3", "--method", "ssct,unified"];
    let folders = Folders::new();
    for n in [1, 2] {
        folders.shard(&study, n, 2);
    }
    rewrite_for_another_device(&folders.path("2"));
    let [a, b, all] = ["1", "2", "all"].map(|name| folders.name(name));
    let printed = run_successfully(&["merge", &a, &b, "-o", &all]);
    assert!(printed.contains("2 devices, whose times stay apart"), "{printed}");
    assert_eq!(folders.json("all/time.json").as_array().unwrap().len(), 4);
    let page = std::fs::read_to_string(folders.path("all/index.html")).unwrap();
    assert!(page.contains("another (") && page.matches("total ms").count() == 2, "a table for each device");
    // The samples, which `ssct compare` reads, lie in the folder of their device.
    assert!(!folders.path("all/time-samples.csv").exists());
    let is_other = |folder: &str| {
        folders.json(&format!("{folder}/time.json"))[0]["device"]["name"].to_string().contains("another")
    };
    let mut apart = ["all/devices/1", "all/devices/2"];
    apart.sort_by_key(|folder| is_other(folder));
    assert!(!is_other(apart[0]) && is_other(apart[1]));
    run_successfully(&["compare", &folders.name(apart[0]), &a]);
    let (status, ..) = run(&["compare", &folders.name(apart[1]), &a]);
    assert_ne!(status, Some(0), "nothing is compared between devices");

    let error = ["error", "--scene", boards(), "--view", "ahead", "--no-sweep", "--size", "48x27", "--samples", "1"];
    let error = [&error[..], &["--method", "ssct", "--rays", "4", "--roughness", "0,0.1"]].concat();
    let folders = Folders::new();
    for n in [1, 2] {
        folders.shard(&error, n, 2);
    }
    rewrite_for_another_device(&folders.path("2"));
    let [a, b, all] = ["1", "2", "all"].map(|name| folders.name(name));
    run_successfully(&["merge", &a, &b, "-o", &all]);
    let page = std::fs::read_to_string(folders.path("all/index.html")).unwrap();
    assert_eq!(page.matches("<h2 id=\"device-").count(), 2, "a part for each device");
    assert_eq!(page.matches("<h2 id=\"sources\"").count(), 1, "and one for the errors");
    assert!(folders.path("all/devices/2/error-world.svg").exists());
}

/// Five other studies in two shards equal the undivided studies in figures and files. One engine divides all studies,
/// but stress, paths and figures each have code of their own that merges them.
#[test]
fn other_studies_are_divided_too() {
    check_shards(&["stress", "--quick", "--method", "ssct", "--case", "straight"], "stress.json");
    let small = ["--scene", boards(), "--view", "ahead", "--size", "17x9", "--rays", "2", "--method", "ssct"];
    let study = |kind: &[&'static str]| [kind, &small].concat();
    check_shards(&study(&["video", "--way", "rest", "--frames", "2", "--roughness", "0,0.1"]), "video.json");
    let age = ["age", "--scene", boards(), "--view", "ahead", "--size", "17x9", "--rays", "2", "--roughness", "0,0.1"];
    let moves = [
        "--moving",
        "wall",
        "--step",
        "0.1,0,0",
        "--frames",
        "2",
        "--faces",
        "0,1",
        "--captures",
        "1",
        "--capture-side",
        "128",
    ];
    check_shards(&[&age[..], &moves].concat(), "age.json");
    let path = ["path", "--scene", "corridor", "--size", "17x9,34x19", "--method", "ssct", "--frames", "3"];
    check_shards(&path, "path.json");

    let folders = Folders::new();
    let [whole, all, first, second] = ["whole", "all", "1", "2"].map(|name| folders.name(name));
    let figures = ["figures", "--only", "4.1,4.6,thesis-4.4", "--size", "48x27"];
    run_successfully(&[&figures[..], &["-o", &whole]].concat());
    for n in [1, 2] {
        folders.shard(&figures, n, 2);
    }
    run_successfully(&["merge", &first, &second, "-o", &all]);
    assert_eq!(folders.files("whole"), folders.files("all"));
    let [a, b] = ["whole", "all"].map(|f| std::fs::read_to_string(folders.path(f).join("index.html")).unwrap());
    assert_eq!(a, b, "one page");
    let printed = run_successfully(&[&figures[..], &["-o", &all, "--resume"]].concat());
    assert!(printed.contains("3 figures, 0 left out"), "{printed}");
}

/// A reference in three shards of rays merges into the samples of one run, to the bit. Missing samples are named, and
/// other methods refuse shards. Each shard must trace its own part of one sequence of rays.
#[test]
fn a_reference_is_divided_by_its_rays() {
    let folders = Folders::new();
    let [a, b, c, all, whole] = ["a", "b", "c", "all", "whole"].map(|name| folders.name(name));
    let scene = ["render", "--method", "reference", "--scene", boards(), "--size", "24x16", "--roughness", "0.3"];
    let render = [&scene[..], &["--max-rays", "200"]].concat();
    let image = |name: &str| folders.name(&format!("{name}.exr"));
    let (status, _, message) = run(&[&render[..], &["--shard", "1/3", "-o", &image("none")]].concat());
    assert!(status == Some(2) && message.contains("--cache"), "{message}");
    for (n, folder) in [&a, &b, &c].into_iter().enumerate() {
        let (shard, file) = (format!("{}/3", n + 1), image(&n.to_string()));
        run_successfully(&[&render[..], &["--shard", &shard, "-o", &file, "--cache", folder]].concat());
    }
    std::fs::create_dir(folders.path("study")).unwrap();
    std::fs::write(folders.path("study/cells.json"), "{}").unwrap();
    let study = folders.name("study");
    let message = refused(&["merge", &a, &study, "-o", &all]);
    assert!(message.contains(&format!("{a}: holds rays of a reference, and {study} a run")), "{message}");
    let message = refused(&["merge", &a, &c, "-o", &all]);
    assert!(message.contains("samples 64 to 127 of boards") && message.contains("are missing"), "{message}");
    let printed = run_successfully(&["merge", &c, &a, &b, "-o", &all]);
    assert!(printed.contains("200 of 200 rays") && printed.contains(&format!("--cache {all} -o FILE")), "{printed}");

    // The merged samples are those of one run, and the image is drawn without any more.
    let most = ["--standard-error", "0.000001"];
    run_successfully(&[&render[..], &most, &["-o", &image("whole"), "--cache", &whole]].concat());
    let state = |folder: &str| {
        let name = folders.files(folder).into_iter().find(|name| name.ends_with(".world")).unwrap();
        (name.clone(), std::fs::read(folders.path(folder).join(name)).unwrap())
    };
    assert!(state("all") == state("whole"));
    run_successfully(&[&render[..], &most, &["-o", &image("merged"), "--cache", &all]].concat());
    assert!(std::fs::read(image("merged")).unwrap() == std::fs::read(image("whole")).unwrap());
    // Where there are more shards than groups of rays, some shards have none. Images of other methods have no shards.
    let (status, _, message) = run(&[&render[..], &["--shard", "9/9", "-o", &image("x"), "--cache", &a]].concat());
    assert_eq!((status, message.as_str()), (Some(0), ""), "four groups of rays: the last shard has one");
    let (status, _, message) = run(&[&render[..], &["--shard", "1/9", "-o", &image("x"), "--cache", &a]].concat());
    assert!(status == Some(0) && message.contains("shard 1/9 has no rays"), "{message}");
    let ssct = ["render", "--scene", boards(), "--size", "24x16", "--shard", "1/2", "--cache", &a, "-o"];
    let (status, _, message) = run(&[&ssct[..], &[&image("x")]].concat());
    assert!(status == Some(2) && message.contains("--method reference"), "{message}");
}

/// The digest of each built-in scene, which decides the shard of a cell, is the known one. Every bit of a scene goes
/// into its digest, so that a difference in rounding between machines would change it. A change of a scene needs a new
/// digest here.
#[test]
fn the_shards_of_built_in_scenes_are_the_same_on_every_machine() {
    let known = [
        ("rooms", "59196a823d1125f3"),
        ("atrium", "2aca97f1d4a602ba"),
        ("street", "07a1284470d7d9fe"),
        ("museum", "1269090057d6c063"),
        ("cathedral", "9a5592a59d481c50"),
        ("corridor", "a7535898d1139f18"),
    ];
    let digest = |name: &&'static str| (*name, scene_digest(&crate::common::built_in(name)));
    let found: Vec<_> = library::names().iter().map(digest).collect();
    assert_eq!(found, known.map(|(name, digest)| (name, digest.to_owned())));
}
