//! Takes one bad name through every command that prints: as the name of a scene, of a view, of a folder and of a
//! device.

use crate::common::folder::Folder;
use serde_json::Value;

/// A name with characters that a terminal, a table, a page and a spreadsheet would each obey.
const BAD: &str = "=1+1\u{1b}[31m\u{7}|<img src=x onerror=alert(1)>\r\nforged: line\u{9b}2J\u{202e}";

/// Returns whether a terminal obeys a character instead of showing it. That holds for control characters, and for
/// U+202E, which reverses the direction of text.
fn is_obeyed(c: char) -> bool {
    (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}'
}

/// Makes a folder with a scene, a floor before a wall, whose own name and whose view's name are bad.
fn scene() -> Folder {
    let folder = Folder::new();
    let room = "o floor\nv -4 0 -8\nv 4 0 -8\nv 4 0 0\nv -4 0 0\nf 1 4 3 2\n\
                o wall\nv -4 0 -6\nv 4 0 -6\nv 4 4 -6\nv -4 4 -6\nf 5 6 7 8\n";
    folder.write("room.obj", room);
    let name = serde_json::to_string(BAD).unwrap();
    // A basic string of TOML has the escapes of JSON.
    let text = format!(
        "name = {name}\n\n[[mesh]]\nfile = \"room.obj\"\n\n[view.{name}]\neye = [0, 1.5, 0]\nlook_at = [0, 1, -6]\n"
    );
    folder.write("bad.scene.toml", text);
    folder
}

/// Returns the text that a command prints on both streams. The command may fail, but not crash.
fn printed(folder: &Folder, args: &[&str]) -> String {
    let output = folder.run(args);
    let [text, errors] = [&output.stdout, &output.stderr].map(|text| String::from_utf8(text.clone()).unwrap());
    text + &errors
}

/// Checks that a text has no character that a terminal obeys, and no line that begins with `forged`. `what` names the
/// text in messages.
fn assert_safe(what: &str, text: &str) {
    let found = text.chars().find(|c| is_obeyed(*c));
    assert!(found.is_none(), "{what} has {found:?}: {text:?}");
    // In a page, the end of a line counts as a blank, so that no reader sees a forged line.
    let is_page = text.starts_with("<!DOCTYPE html>") || text.starts_with("<svg");
    let forged = !is_page && text.lines().any(|line| line.starts_with("forged"));
    assert!(!forged, "{what} has a line of its own: {text}");
}

/// A scene with a bad name goes through every command that prints. No printed text and no written file has a character
/// that a terminal, a page or a spreadsheet would obey. Each kind of file escapes names in its own way.
#[test]
fn a_bad_name_is_obeyed_by_nobody() {
    let folder = scene();
    let scene = ["--scene", "bad.scene.toml", "--size", "17x9", "--roughness", "0", "--method", "linear"];
    let scene_command = |command: &[&'static str], more: &[&'static str]| [command, &scene[..], more].concat();
    let size = ["--size", "17x9"];
    let commands: Vec<Vec<&str>> = vec![
        scene_command(&["render"], &["-o", "a.png", "--json"]),
        scene_command(&["render"], &["--explain", "-o", "a.png"]),
        scene_command(&["render"], &["--view", "no such view"]),
        scene_command(&["time"], &["--samples", "2", "-o", "runs/time"]),
        scene_command(&["time"], &["--samples", "2", "--json"]),
        scene_command(&["error"], &["--samples", "1", "--rays", "2", "--no-sweep", "-o", "runs/error"]),
        scene_command(&["video"], &["--way", "rest", "--frames", "2", "--rays", "2", "-o", "runs/video"]),
        scene_command(&["motion"], &["--frames", "2", "--rays", "2", "-o", "runs/motion"]),
        scene_command(&["precision"], &["--rays", "2", "-o", "runs/precision"]),
        scene_command(&["path"], &["--frames", "2", "-o", "runs/path"]),
        vec!["captures", "bad.scene.toml", "--captures", "1"],
        vec!["captures", "bad.scene.toml", "--captures", "1", "--json"],
        [&["gbuffer", "export", "g.exr", "--scene", "bad.scene.toml"], &size[..]].concat(),
        [&["truth", "export", "--scene", "bad.scene.toml", "--samples", "2", "-o", "t"], &size[..]].concat(),
        vec!["merge", "runs/time", "-o", "merged"],
        vec!["merge", "runs/precision", "-o", "merged-precision"],
        vec!["compare", "runs/time", "merged"],
        vec!["compare", "runs/time", "merged", "--json"],
        vec!["index", "runs", "-o", "page"],
        vec!["compare", BAD, "a.png"],
        vec!["render", "--scene", BAD, "-o", "a.png"],
        vec!["render", "--method", BAD, "-o", "a.png"],
        vec!["merge", BAD, "-o", "m"],
        vec!["index", BAD],
    ];
    for command in &commands {
        assert_safe(&format!("{command:?}"), &printed(&folder, command));
    }
    // All files with text that the commands wrote.
    let mut to_visit = vec![folder.root().to_owned()];
    let (mut seen, mut is_in_tables) = (Vec::new(), false);
    while let Some(path) = to_visit.pop() {
        if path.is_dir() {
            to_visit.extend(std::fs::read_dir(path).unwrap().map(|e| e.unwrap().path()));
            continue;
        }
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        assert!(!name.contains(is_obeyed) && !name.contains(['<', '|', '\n']), "{name:?}");
        let ending = name.rsplit('.').next().unwrap().to_owned();
        if !["txt", "md", "csv", "html", "svg", "json", "jsonl"].contains(&ending.as_str()) {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        seen.push(ending.clone());
        match ending.as_str() {
            "csv" => {
                let rows = text.lines().skip(1).collect::<Vec<_>>();
                assert!(rows.iter().all(|row| row.trim_matches('"').starts_with("'=1")), "{name}: {rows:?}");
            }
            // Records keep the name as it is, with escapes for its control characters.
            "json" => drop(serde_json::from_str::<Value>(&text).unwrap_or_else(|e| panic!("{name}: {e}"))),
            "jsonl" => continue,
            "md" => {
                assert!(!text.contains("<img"), "{text}");
                is_in_tables |= text.contains("\\|&lt;img");
            }
            "html" => assert!(!text.contains("<img src=x"), "{name}"),
            _ => {}
        }
        assert_safe(&name, &text);
    }
    assert!(is_in_tables, "no table names the scene");
    for ending in ["txt", "md", "csv", "html", "json"] {
        assert!(seen.iter().any(|seen| seen == ending), "no .{ending} is written");
    }
}

/// Bad names of a command, a cell and a device in a shard's list of cells are printed without characters that a
/// terminal or a page obeys. A merge prints what other machines wrote.
#[test]
fn what_a_command_is_told_by_a_shard_is_printed_as_text() {
    let folder = scene();
    let what = ["time", "--scene", "corridor", "--size", "17x9", "--samples", "1", "--method", "linear", "-o", "part"];
    folder.succeed(&what);
    let text = folder.text("part/cells.json");
    let mut cells: Value = serde_json::from_str(&text).unwrap();
    cells["command"] = BAD.into();
    cells["cells"][0]["name"] = BAD.into();
    cells["devices"][0]["name"] = BAD.into();
    folder.write("part/cells.json", cells.to_string());
    assert_safe("merge", &printed(&folder, &["merge", "part", "-o", "all", "--partial"]));
    assert_safe("the page", &folder.text("all/index.html"));
    // The journal's device is another, so that the cell is measured by nobody.
    cells["cells"][0]["results"] = Value::Array(Vec::new());
    folder.write("part/cells.json", cells.to_string());
    assert_safe("merge", &printed(&folder, &["merge", "part", "-o", "none"]));
    assert_safe("merge", &printed(&folder, &["merge", "part", "-o", "partial", "--partial"]));
    assert!(!folder.text("partial/index.html").contains("<img src=x"));
}
