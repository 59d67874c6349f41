//! Tests input of others that nobody vouches for: shards that somebody else measured, folders that somebody else made,
//! and names that somebody else gave. Impossible content is refused with its place, nothing is written outside of a
//! folder, and no command waits without end.

mod names;

use crate::common::folder::{Folder, boards};
use crate::common::hang::wait_until;
use crate::common::{expected_failures, gpu};
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Stdio};

/// The content of files beside the folders of runs, which no command may overwrite.
const PRECIOUS: &str = "nobody may write over this";

/// Runs a command that must fail with status 1 or 2, and returns its one sentence.
fn refused(folder: &Folder, args: &[&str]) -> String {
    let output = folder.run(args);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(1 | 2)), "{args:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{args:?}: {message}");
    message
}

/// Makes a small run of a study in the folder `part`, whose journal a test then changes, and four files outside of it
/// that must stay as they are.
fn run_of(study: &[&str]) -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("home")).unwrap();
    for file in ["x.svg", "home/x.svg", "escaped.svg", "home/escaped.svg"] {
        folder.write(file, PRECIOUS);
    }
    folder.succeed(&[study, &["-o", "part"]].concat());
    folder
}

/// Makes a run of `ssct figures` with one figure.
fn figures() -> Folder {
    run_of(&["figures", "--only", "4.1", "--size", "48x27"])
}

/// Makes a run of `ssct error` with one method.
fn errors() -> Folder {
    let place = ["--scene", boards(), "--view", "ahead", "--size", "48x27", "--no-sweep"];
    run_of(
        &[&["error"], &place[..], &["--samples", "1", "--rays", "4", "--method", "ssct", "--roughness", "0"]].concat(),
    )
}

/// Applies `change` to every entry of a journal that has a key.
fn change(folder: &Folder, file: &str, change: impl Fn(&mut Value)) {
    let lines = folder.text(file);
    let changed = lines.lines().map(|line| {
        let mut entry: Value = serde_json::from_str(line).unwrap();
        if entry.get("key").is_some() {
            change(&mut entry);
        }
        format!("{entry}\n")
    });
    folder.write(file, changed.collect::<String>());
}

/// Checks that the precious files are as before, and that the merge wrote no page.
fn assert_untouched(folder: &Folder) {
    for file in ["x.svg", "home/x.svg", "escaped.svg", "home/escaped.svg"] {
        assert_eq!(folder.text(file), PRECIOUS, "{file}");
    }
    assert!(!folder.path("home/all/index.html").exists(), "nothing is written");
}

/// A journal that names a picture outside its folder, a hidden file, a page or nothing is refused with its line and the
/// name. A merge copies pictures, and could copy or overwrite any file of the user.
#[test]
fn a_figure_that_is_no_picture_of_its_folder_is_refused() {
    for name in
        ["../x.svg", "../../escaped.svg", "/tmp/ssct-foreign.svg", "a/../../x.svg", "page.html", ".hidden.svg", ""]
    {
        let folder = figures();
        change(&folder, "part/journal.jsonl", |entry| entry["value"]["file"] = json!({ "Ok": name }));
        let message = refused(&folder, &["merge", "part", "-o", "home/all"]);
        assert!(
            message.contains("part/journal.jsonl:1") && message.contains(&format!("{name:?}")),
            "{name}: {message}"
        );
        assert_untouched(&folder);
    }
}

/// An SVG drawing with a script element is refused when runs are merged, since the page would run the script in a
/// reader's browser.
#[test]
fn a_drawing_with_a_script_is_not_copied() {
    let folder = figures();
    let drawing = folder.list("part").into_iter().find(|name| name.ends_with(".svg")).unwrap();
    folder
        .write(&format!("part/{drawing}"), "<svg xmlns=\"http://www.w3.org/2000/svg\"><script>alert(1)</script></svg>");
    let message = refused(&folder, &["merge", "part", "-o", "home/all"]);
    assert!(message.contains(&drawing) && message.contains("the element \"script\""), "{message}");
    assert_untouched(&folder);
}

/// A journal whose method is a path is refused with its line. Names of methods become names of files.
#[test]
fn a_method_that_is_a_path_is_refused() {
    let place = ["precision", "--scene", boards(), "--view", "ahead", "--size", "34x19", "--rays", "2"];
    let folder = run_of(&[&place[..], &["--method", "ssct", "--roughness", "0"]].concat());
    change(&folder, "part/journal.jsonl", |entry| {
        entry["value"].as_array_mut().unwrap().iter_mut().for_each(|r| r["method"] = json!("x/../../../escaped"));
    });
    let message = refused(&folder, &["merge", "part", "-o", "home/all"]);
    assert!(message.contains("part/journal.jsonl:1") && message.contains("no name of a method"), "{message}");
    assert_untouched(&folder);
}

/// A journal with a negative error, an image without width, no list of records, or an agreement above 1 is refused with
/// its line. Merged, such numbers would pass for measurements.
#[test]
fn figures_that_cannot_be_are_refused_with_their_line() {
    type Change = fn(&mut Value);
    let changes: [(Change, &str); 4] = [
        (|e| e["value"][0]["rmse"] = json!(-1.0), "has the rmse -1, which cannot be"),
        (|e| e["value"][0]["width"] = json!(0), "has the width 0, which cannot be"),
        (|e| e["value"] = json!({ "a": 1 }), "is no list of records of this study"),
        (|e| e["value"][0]["hit_agreement"] = json!(2.0), "has the hit_agreement 2, which cannot be"),
    ];
    let sound = errors();
    let journal = sound.text("part/journal.jsonl");
    for (bad, words) in changes {
        sound.write("part/journal.jsonl", &journal);
        let line = 1 + journal.lines().position(|line| line.contains("\"rmse\"")).unwrap();
        change(&sound, "part/journal.jsonl", |entry| {
            if entry["value"].to_string().contains("\"rmse\"") {
                bad(entry);
            }
        });
        let message = refused(&sound, &["merge", "part", "-o", "home/all"]);
        assert!(
            message.contains(&format!("part/journal.jsonl:{line}")) && message.contains(words),
            "{words}: {message}"
        );
        assert_untouched(&sound);
    }
}

/// With `--resume`, an entry of the journal that cannot be read is measured again, and the command says so. The errors
/// are those of before.
#[test]
fn what_a_journal_lost_is_measured_again_and_said() {
    let folder = errors();
    let before = folder.text("part/error.json");
    change(&folder, "part/journal.jsonl", |entry| {
        if entry["value"].is_array() {
            entry["value"] = json!({ "a": 1 });
        }
    });
    let place = ["--scene", boards(), "--view", "ahead", "--size", "48x27", "--no-sweep"];
    let what = ["--samples", "1", "--rays", "4", "--method", "ssct", "--roughness", "0", "--resume", "-o", "part"];
    let output = folder.run(&[&["error"], &place[..], &what].concat());
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(message.contains("1 result(s) of the journal cannot be read and are measured again"), "{message}");
    let [a, b] = [&before, &folder.text("part/error.json")].map(|text| serde_json::from_str::<Value>(text).unwrap());
    let rmse = |records: &Value| records.as_array().unwrap().iter().map(|r| r["rmse"].clone()).collect::<Vec<_>>();
    assert!(!rmse(&a).is_empty() && rmse(&a) == rmse(&b), "{b}");
}

/// A merge into a folder with a cut journal is completed. A merge into a folder that has results of another run is
/// refused, and their journal stays.
#[test]
fn a_broken_merge_goes_on_and_nothing_is_written_over_that_is_not_merged() {
    let folder = errors();
    folder.succeed(&["merge", "part", "-o", "all"]);
    let whole = folder.text("all/journal.jsonl");
    let cut = whole.trim_end().rfind('\n').unwrap() + 1;
    folder.write("all/journal.jsonl", &whole[..cut]);
    folder.succeed(&["merge", "part", "-o", "all"]);
    assert_eq!(folder.text("all/journal.jsonl"), whole);
    // Results of another run in that folder would be lost, whether that run was finished or not.
    for end in ["", "{\"finished\":true}\n"] {
        let other = format!("{{\"key\":\"error other\",\"value\":[]}}\n{end}");
        folder.write("all/journal.jsonl", &other);
        let message = refused(&folder, &["merge", "part", "-o", "all"]);
        assert!(message.contains("1 result(s)") && message.contains("remove all/journal.jsonl"), "{message}");
        assert!(!message.contains("--resume"), "merge has no such flag: {message}");
        assert_eq!(folder.text("all/journal.jsonl"), other);
    }
}

/// A list of cells that claims 10^18 samples is refused with a limit, before a merge allocates memory for them.
#[test]
fn samples_without_number_are_refused_before_memory_is_taken() {
    let folder = run_of(&["time", "--scene", boards(), "--size", "34x19", "--samples", "1", "--method", "ssct"]);
    let text = folder.text("part/cells.json").replace("\"samples\": 1", "\"samples\": 1000000000000000000");
    folder.write("part/cells.json", text);
    let message = refused(&folder, &["merge", "part", "-o", "home/all"]);
    assert!(message.contains("part/cells.json") && message.contains("at most"), "{message}");
}

/// A share of a reference whose fingerprint is a path out of its folder is refused, and no file is made there. The
/// fingerprint becomes a file's name.
#[test]
fn a_share_of_a_reference_names_no_other_file() {
    let folder = Folder::new();
    let render = ["render", "--method", "reference", "--scene", boards(), "--size", "17x9", "--roughness", "0.3"];
    folder.succeed(&[&render[..], &["--max-rays", "16", "--shard", "1/1", "--cache", "part", "-o", "a.exr"]].concat());
    let part = folder.list("part").into_iter().find(|name| name.ends_with(".part.json")).unwrap();
    let mut share: Value = serde_json::from_str(&folder.text(&format!("part/{part}"))).unwrap();
    share["fingerprint"] = json!("../../escaped");
    folder.write(&format!("part/{part}"), share.to_string());
    let message = refused(&folder, &["merge", "part", "-o", "all"]);
    assert!(message.contains(&part) && message.contains("../../escaped"), "{message}");
    assert!(!folder.path("escaped.world").exists() && !folder.path("all").exists());
}

/// Runs a command and returns all that it prints. A limit ends the test if the command waits without end.
#[cfg(unix)]
fn at_once(folder: &Folder, args: &[&str]) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_ssct"))
        .args(args)
        .current_dir(folder.root())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_until(|| format!("{args:?}"), || child.try_wait().unwrap().is_some());
    let output = child.wait_with_output().unwrap();
    let [printed, errors] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(!errors.contains("panicked"), "{errors}");
    format!("{printed}{errors}")
}

/// Makes a named pipe.
#[cfg(unix)]
fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// If a pipe or a link to `/dev/zero` stands in the place of a file, the command names it in a sentence at once.
/// Reading it would never end.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_no_files() {
    use std::os::unix::fs::symlink;
    let folder = errors();
    for (file, command) in [
        ("part/cells.json", &["merge", "part", "-o", "all"][..]),
        ("part/journal.jsonl", &["merge", "part", "-o", "all"]),
        ("part/error.json", &["index", "part", "-o", "page"]),
        ("part/time-samples.csv", &["compare", "part", "part"]),
        ("pictures/a.exr", &["compare", "pictures/a.exr", "pictures/a.exr"]),
        ("pictures/a.png", &["compare", "pictures/a.png", "pictures/a.png"]),
        ("part/time.json", &["compare", "part", "part"]),
        ("index.html", &["index", "."]),
    ] {
        let _ = std::fs::create_dir(folder.path("pictures"));
        let before = std::fs::read(folder.path(file)).ok();
        for is_pipe in [true, false] {
            let _ = std::fs::remove_file(folder.path(file));
            if is_pipe {
                pipe(&folder.path(file))
            } else {
                symlink("/dev/zero", folder.path(file)).unwrap()
            };
            let message = at_once(&folder, command);
            let named =
                ["is no file", "leads out of its folder", "is no picture"].iter().any(|why| message.contains(why));
            assert!(named && message.contains(file.rsplit('/').next().unwrap()), "{file}, {command:?}: {message}");
        }
        std::fs::remove_file(folder.path(file)).unwrap();
        if let Some(bytes) = before {
            std::fs::write(folder.path(file), bytes).unwrap()
        }
    }
    pipe(&folder.path("instead"));
    assert!(at_once(&folder, &["merge", "instead", "-o", "all"]).contains("is no folder"));
}

/// A link out of a run's folder is not read, and a link inside is. In the folder that is written, no link leads the
/// program to a file outside, which it would overwrite.
#[cfg(unix)]
#[test]
fn links_that_lead_out_are_neither_read_nor_written_through() {
    use std::os::unix::fs::symlink;
    let folder = errors();
    folder.write("secret.png", PRECIOUS);
    let picture = folder.list("part/images").into_iter().find(|name| name.ends_with(".png")).unwrap();
    let place = format!("part/images/{picture}");
    let own = std::fs::read(folder.path(&place)).unwrap();
    std::fs::remove_file(folder.path(&place)).unwrap();
    symlink("../../secret.png", folder.path(&place)).unwrap();
    let message = refused(&folder, &["merge", "part", "-o", "home/all"]);
    assert!(message.contains(&picture) && message.contains("leads out of its folder"), "{message}");
    assert_untouched(&folder);
    // A link that stays in the run's folder is read as the file itself.
    std::fs::remove_file(folder.path(&place)).unwrap();
    std::fs::write(folder.path("part/own.png"), own).unwrap();
    symlink("../own.png", folder.path(&place)).unwrap();
    folder.succeed(&["merge", "part", "-o", "good"]);

    // In the folder that is written, a link to a file is replaced, and one to a folder outside is refused.
    for (link, to) in [("home/linked/index.html", "../../x.svg"), ("home/linked/error.json", "../../escaped.svg")] {
        std::fs::create_dir_all(folder.path("home/linked")).unwrap();
        symlink(to, folder.path(link)).unwrap();
    }
    folder.succeed(&["merge", "part", "-o", "home/linked"]);
    assert!(folder.text("home/linked/index.html").contains("<html"));
    std::fs::create_dir_all(folder.path("home/away")).unwrap();
    symlink("../..", folder.path("home/away/images")).unwrap();
    let message = refused(&folder, &["merge", "part", "-o", "home/away"]);
    assert!(message.contains("leads out of its folder"), "{message}");
    assert!(!folder.path(&picture).exists());
    // A journal is appended to, and through a link the program would append to a file outside.
    std::fs::create_dir_all(folder.path("home/behind")).unwrap();
    symlink("../../x.svg", folder.path("home/behind/journal.jsonl")).unwrap();
    let message = refused(&folder, &["merge", "part", "-o", "home/behind"]);
    assert!(message.contains("journal.jsonl") && message.contains("link"), "{message}");
    assert_untouched(&folder);
}

/// `ssct index` leaves out a run whose records are a link to another folder, and says so. The page could otherwise
/// publish any file of the user.
#[cfg(unix)]
#[test]
fn a_page_over_runs_shows_no_file_that_a_link_brings() {
    use std::os::unix::fs::symlink;
    let folder = errors();
    std::fs::create_dir_all(folder.path("runs/a")).unwrap();
    symlink("../../part/error.json", folder.path("runs/a/error.json")).unwrap();
    folder.succeed(&["merge", "part", "-o", "runs/b"]);
    let printed = folder.succeed(&["index", "runs", "-o", "page"]);
    assert!(
        printed.contains("left out: a: ") && printed.contains("leads out of its folder") && printed.contains("1 run,"),
        "{printed}"
    );
}

/// If the device to which help, version or lists are printed is full, the command ends with status 1. A script would
/// otherwise go on with half a text.
#[cfg(target_os = "linux")]
#[test]
fn a_help_that_finds_no_room_fails() {
    for args in [&["--help"][..], &["--version"], &["time", "--help"], &["devices"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output =
            Command::new(env!("CARGO_BIN_EXE_ssct")).args(args).stdout(full).stderr(Stdio::piped()).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{args:?}: {message}");
        assert!(message.contains("cannot print"), "{args:?}: {message}");
    }
}

/// Under a limit of 200 000 KiB of address space, `render` says that memory is short, and names the limit. The driver's
/// own error names neither.
#[cfg(target_os = "linux")]
#[test]
fn little_memory_is_called_that() {
    let program = env!("CARGO_BIN_EXE_ssct");
    let run_limited = |kib: u32| {
        let command = format!("ulimit -v {kib}; exec \"{program}\" render --scene corridor --size 17x9 -o x.png");
        Command::new("bash").args(["-c", &command]).current_dir(std::env::temp_dir()).output().unwrap()
    };
    let output = run_limited(200_000);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("memory is short") && message.contains("195 MiB") && message.contains("ulimit -v"),
        "{message}"
    );
}

/// A study on a disk without room ends with a sentence, keeps what it measured, and continues once there is room.
#[cfg(target_os = "linux")]
#[test]
fn a_study_on_a_full_disk_keeps_what_it_measured() {
    if let [expected_failure, ..] = &expected_failures("file-limit", &gpu())[..] {
        println!("skipped: the driver does not live under {expected_failure} (tests/expected_failures.toml)");
        return;
    }
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_ssct");
    // A limit on the size of files makes writes fail as a full disk does.
    let study = "time --scene corridor --size 34x19 --samples 40 --method ssct -o t --resume";
    let run = |limit: &str| {
        let command = format!("trap '' XFSZ; {limit} exec \"{program}\" {study}");
        Command::new("bash").args(["-c", &command]).current_dir(folder.root()).output().unwrap()
    };
    let output = run("ulimit -f 8;");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("cannot write") && message.contains("journal.jsonl"), "{message}");
    let kept = folder.text("t/journal.jsonl");
    let whole = kept.lines().filter(|line| serde_json::from_str::<Value>(line).is_ok()).count();
    assert!(whole > 2, "{kept}");
    let output = run("");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let journal = folder.text("t/journal.jsonl");
    let keys: Vec<String> =
        journal.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()["key"].to_string()).collect();
    let first: Vec<&str> = kept.lines().take(whole).collect();
    assert!(journal.lines().zip(first).all(|(new_line, old_line)| new_line == old_line), "nothing is measured twice");
    assert!(keys.len() > 40);
}

/// An EXR file of less than 3 MB with 16000×4200 pixels is refused by its number of pixels. Decoded, it would take many
/// times its size.
#[test]
fn a_large_image_that_a_small_file_claims_is_refused_before_memory_is_taken() {
    use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage};
    let folder = Folder::new();
    let [width, height] = [16000, 4200];
    let channel = |name: &str| AnyChannel::new(name, FlatSamples::F16(vec![half::f16::ZERO; width * height]));
    let channels = AnyChannels::sort(["R", "G", "B"].map(channel).into_iter().collect());
    let layer = Layer::new((width, height), LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(folder.path("large.exr")).unwrap();
    assert!(std::fs::metadata(folder.path("large.exr")).unwrap().len() < 3_000_000);
    let message = refused(&folder, &["compare", "large.exr", "large.exr"]);
    assert!(
        message.contains("large.exr") && message.contains("16000x4200") && message.contains("67108864"),
        "{message}"
    );
}
