//! Tests `ssct index`, the page of a library of runs. The runs are made of known figures, or are those of the
//! repository. A headless Chromium shows the page if it is installed.

use crate::common::folder::Folder;
use crate::common::html::{attributes, dom, probe};
use crate::common::repository;
use serde_json::{Value, json};

/// The figures of a run: the device, the times of `ssct` and of `unified`, and the error of `unified`.
struct Measured<'a> {
    device: &'a str,
    ssct_ms: f64,
    unified_ms: f64,
    rmse: f64,
    /// The nine times of the pass `trace` differ by steps of this share of their median.
    noise: f64,
}

/// Returns a device as records name it.
fn device(name: &str) -> Value {
    json!({ "name": name, "driver": "1", "api": "1.3", "type": "other" })
}

/// Writes the records and raw samples of a run, as the studies do.
fn write(folder: &Folder, name: &str, run: &Measured) {
    std::fs::create_dir_all(folder.path(&format!("{name}/error"))).unwrap();
    let record = |kind: &str, method: &str, more: Value| {
        let mut record = json!({
            "kind": kind, "definitions": 2, "version": "0.1.0", "commit": format!("commit of {name}"),
            "device": device(run.device), "scene": "rooms", "view": "hall", "method": method, "preset": "published",
            "width": 64, "height": 36, "roughness": 0.1, "setup": { "roughness": 0.1 },
        });
        record.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        record
    };
    let methods = [("ssct", run.ssct_ms), ("unified", run.unified_ms)];
    let times = methods.map(|(method, ms)| record("time", method, json!({ "total": { "median_ms": ms } })));
    folder.write(&format!("{name}/time.json"), json!(times).to_string());
    let error = record("error", "unified", json!({ "against": "world", "rmse": run.rmse, "time_ms": run.unified_ms }));
    folder.write(&format!("{name}/error/error.json"), json!([error]).to_string());
    let mut rows = "scene,view,method,preset,width,height,roughness,sample,pass,counted,ms\n".to_owned();
    for (method, ms) in methods {
        for n in 0..9 {
            // The nine times are spread evenly around their median.
            let trace = ms * 0.8 * (1.0 + run.noise * f64::from((n * 5) % 9 - 4));
            for (pass, counted, ms) in
                [("lighting", false, 30.0), ("trace", true, trace), ("composite", true, ms * 0.2)]
            {
                rows += &format!("rooms,hall,{method},published,64,36,0.1,{n},{pass},{counted},{ms:.6}\n");
            }
        }
    }
    folder.write(&format!("{name}/time-samples.csv"), rows);
}

/// Makes three runs: two on one device, between which `unified` became slower and `ssct` stayed the same, and one on
/// another device.
fn library() -> Folder {
    let folder = Folder::new();
    let (ssct_ms, noise) = (10.0, 0.01);
    let runs = [
        ("all/2026-11-20-a", Measured { device: "One", ssct_ms, unified_ms: 5.0, rmse: 0.02, noise }),
        ("all/2026-11-21-b", Measured { device: "Two </script>", ssct_ms: 1.0, unified_ms: 0.4, rmse: 0.02, noise }),
        ("all/2026-11-22-c", Measured { device: "One", ssct_ms, unified_ms: 7.5, rmse: 0.03, noise: 0.02 }),
    ];
    for (name, measured) in &runs {
        write(&folder, name, measured);
    }
    folder
}

/// The page has a row for each run, trends of quotients and errors, and verdicts between runs of one device alone.
/// Equal runs make an equal page. A verdict between two devices would say nothing about the program.
#[test]
fn the_page_has_runs_changes_and_trends_within_a_device() {
    let folder = library();
    let printed = folder.succeed(&["index", "all"]);
    assert!(printed.contains("3 runs, 2 figures over runs, 0 folders left out"), "{printed}");
    let page = folder.text("all/index.html");
    // A study's errors, in a folder of their own, belong to the run of its times: there are three rows.
    assert_eq!(page.matches("<tr id=\"run-").count(), 3);
    for link in ["2026-11-20-a/time.json", "2026-11-20-a/error/error.json"] {
        assert!(attributes(&page, "href").contains(&link) && folder.path("all").join(link).exists(), "{link}");
    }
    assert!(page.contains("0.1.0, commit commit of all/2026-11-20-a"));
    // On the first device, `unified` took half of the time of `ssct`, and then three quarters. The second device has
    // one run.
    for cells in [["unified", "0.5000", "0.7500"], ["unified", "0.02000", "0.03000"]] {
        let row = format!("<th scope=\"row\">{}</th><td>{}</td><td>{}</td>", cells[0], cells[1], cells[2]);
        assert!(page.contains(&row), "{row}");
    }
    assert!(page.contains("3. 2026-11-22-c after 1. 2026-11-20-a") && !page.contains("2. 2026-11-21-b after"));
    assert!(page.contains("0 FASTER, 1 SLOWER, 1 SAME, 0 UNDECIDED."));
    // A name cannot end the script that holds the data.
    assert!(page.contains("Two &lt;/script&gt;") && page.matches("</script>").count() == 2);
    for word in ["http:", "https:", "url(", "@import", "<iframe", "<object", " src="] {
        assert!(!page.contains(word), "{word}");
    }
    let printed = folder.succeed(&["index", "all/2026-11-21-b", "-o", "one"]);
    assert!(printed.contains("1 run, 0 figures over runs, 0 folders left out"), "{printed}");
    // Equal runs make an equal page. The command may write over its own page.
    folder.succeed(&["index", "all"]);
    assert_eq!(folder.text("all/index.html"), page);
    // A page in another folder does not link to records that do not lie beside it.
    folder.succeed(&["index", "all", "-o", "site"]);
    assert!(!folder.text("site/index.html").contains("href=\"2026"));
    folder.succeed(&["index", "all", "-o", "."]);
    assert!(attributes(&folder.text("index.html"), "href").contains(&"all/2026-11-20-a/time.json"));
    // With another base method, quotients are of its time.
    folder.succeed(&["index", "all", "--base", "unified"]);
    assert!(folder.text("all/index.html").contains("<th scope=\"row\">ssct</th><td>2.000</td><td>1.333</td>"));
}

/// Folders with broken, foreign or unfinished records, incomplete records and broken samples are named on the page with
/// their reason. If they were dropped in silence, a trend would miss runs.
#[test]
fn what_cannot_be_read_is_named_with_its_reason() {
    let folder = library();
    for name in ["torn", "foreign", "unfinished", "notes", "other"] {
        std::fs::create_dir_all(folder.path(&format!("all/{name}"))).unwrap();
    }
    folder.write("all/torn/error.json", "[{\"kind\": \"err");
    folder.write("all/foreign/time.json", "{\"times\": 3}");
    folder.write("all/unfinished/journal.jsonl", "{\"key\":\"a\",\"value\":1}\n");
    folder.write("all/notes/notes.txt", "nothing");
    folder.write("all/other/package.json", "{}");
    // One incomplete record among whole ones, and samples that are no numbers.
    let mut records: Vec<Value> = serde_json::from_str(&folder.text("all/2026-11-20-a/time.json")).unwrap();
    records.push(json!({ "kind": "time", "device": device("One"), "total": { "median_ms": 1.0 }, "scene": "s" }));
    folder.write("all/2026-11-20-a/time.json", json!(records).to_string());
    folder.write("all/2026-11-20-a/time-samples.csv", "pass,ms\ntrace,fast\n");
    let printed = folder.succeed(&["index", "all"]);
    let page = folder.text("all/index.html");
    for (folder_name, reason) in [
        ("torn", "error.json: EOF while parsing"),
        ("foreign", "time.json holds no records of the studies"),
        ("unfinished", "the run was not finished: there is a journal.jsonl, and no records"),
    ] {
        assert!(page.contains(&format!("<li>{folder_name}: {reason}")), "{folder_name}");
        assert!(printed.contains(&format!("left out: {folder_name}: {reason}")), "{printed}");
    }
    assert!(page.contains("<li>notes</li>") && page.contains("<li>other</li>"));
    assert!(page.contains("1 of 3 records of time.json are left out; the first has no view"));
    assert!(page.contains("time-samples.csv:2: no sample of a time"));
    assert!(!page.contains("after 1. 2026-11-20-a"), "without samples nothing is judged");
}

/// Folders without runs, a page of another kind and wrong options are refused, and no file is written or lost.
#[test]
fn wrong_folders_get_a_sentence_and_lose_nothing() {
    let folder = library();
    std::fs::create_dir(folder.path("empty")).unwrap();
    folder.write("all/2026-11-20-a/index.html", "<title>ssct study</title>");
    for (args, status, words) in [
        (&["index", "nowhere"][..], 1, "cannot read nowhere"),
        (&["index", "empty"], 1, "empty: no folder in it holds records of the studies"),
        (&["index", "all/2026-11-20-a"], 2, "all/2026-11-20-a/index.html is no page of a library"),
        (&["index", "all", "--threshold", "1"], 2, "--threshold 1: must be at least 0 and below 1"),
        (&["index", "all", "--base", "best"], 2, "best"),
    ] {
        let output = folder.run(args);
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(status), "{args:?}: {text}");
        assert!(text.contains(words), "{args:?}: {text}");
    }
    assert_eq!(folder.text("all/2026-11-20-a/index.html"), "<title>ssct study</title>");
    assert!(!folder.path("all/index.html").exists() && folder.list("empty").is_empty());
}

/// All folders under `benches/runs` are read, with a row for each, and no record is left out. Records of every older
/// version must stay readable.
#[test]
fn every_run_of_the_repository_is_read() {
    let folder = Folder::new();
    let runs = repository().join("benches/runs");
    let printed = folder.succeed(&["index", runs.to_str().unwrap(), "-o", "site"]);
    assert!(printed.contains(" 0 folders left out"), "{printed}");
    let page = folder.text("site/index.html");
    // Each row has the date of its run.
    let rows: Vec<_> = page.split("<tr id=\"run-").skip(1).map(|row| row.split("</tr>").next().unwrap()).collect();
    assert!(rows.iter().all(|row| row.contains("<td class=\"whole\">2026-11-2")));
    // Each folder of an error study has a row with its name.
    let (mut folders, mut studies) = (vec![runs.clone()], 0);
    while let Some(folder) = folders.pop() {
        folders.extend(std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).filter(|path| path.is_dir()));
        if folder.join("error.json").exists() {
            let name = folder.strip_prefix(&runs).unwrap().to_str().unwrap();
            assert!(rows.iter().any(|row| row.contains(&format!(". {name}</th>"))), "{name}");
            studies += 1;
        }
    }
    assert!(studies > 100 && rows.len() > studies, "{studies} of {}", rows.len());
    assert!(!page.contains("are left out; the first"), "no record lacks what is needed");
    assert!(page.contains("RMSE against the world reference") && page.contains("time in the error study over ssct"));
}

/// Returns the cells of each row of the table with an id, which the page's script made.
fn table_rows(dom: &str, id: &str) -> Vec<Vec<String>> {
    let table = dom.split(&format!("id=\"{id}\"")).nth(1).and_then(|s| s.split("</tbody>").next()).unwrap_or_default();
    let body = table.split("<tbody>").nth(1).unwrap_or_default();
    let cells = |row: &str| {
        let plain = row.replace("</th>", "</td>").replace("<th>", "<td>");
        plain.split("<td>").skip(1).map(|c| c.split("</td>").next().unwrap().to_owned()).collect()
    };
    body.split("<tr>").skip(1).map(cells).collect()
}

/// In a browser, the page's comparison of two runs has the figures of `ssct compare`. The page computes them in
/// JavaScript, the command in Rust.
#[test]
fn the_page_says_of_two_runs_what_compare_says() {
    let folder = library();
    folder.succeed(&["index", "all"]);
    let Some(dom) = dom(&folder, "all/index.html") else { return };
    let rows = table_rows(&dom, "compared-times");
    let records: Vec<Value> =
        serde_json::from_str(&folder.succeed(&["compare", "all/2026-11-20-a", "all/2026-11-22-c", "--json"])).unwrap();
    let is_total = |r: &&Value| r["pass"] == "total";
    let expected: Vec<Vec<String>> = records
        .iter()
        .filter(is_total)
        .map(|r| {
            let figures = ["median_a_ms", "median_b_ms", "ratio", "low", "high"];
            let mut row: Vec<String> = figures.map(|f| format!("{:.3}", r[f].as_f64().unwrap())).to_vec();
            row.extend(["9/9".to_owned(), r["verdict"].as_str().unwrap().to_owned()]);
            row
        })
        .collect();
    assert_eq!(expected.len(), 2);
    // The first six cells of a row say what was timed, from the view to the pass.
    assert_eq!(rows.iter().map(|row| row[6..].to_vec()).collect::<Vec<_>>(), expected, "{dom}");
    assert_eq!(rows[1][..5], ["rooms hall", "64x36", "0.1", "own", "unified"]);
    let [error] = &table_rows(&dom, "compared-errors")[..] else { panic!("one error: {dom}") };
    assert_eq!(error[1..], ["unified", "RMSE against the world reference", "0.020000", "0.030000", "1.5000"]);
}

/// A script that chooses two runs of different devices in frames of two widths, and then shows the page without the
/// page's script.
const PROBE: &str = r##"
  for (const width of [390, 1280]) {
    const d = (await show("all/index.html", width, false)).contentDocument, root = d.documentElement;
    const a = d.getElementById("run-a");
    const overflow = root.scrollWidth - root.clientWidth;
    lines.push(`${width} overflow ${overflow} first ${a.value} ${d.getElementById("run-b").value}`);
    a.value = 1;
    a.dispatchEvent(new Event("change"));
    lines.push(d.getElementById("compared-times").textContent);
    lines.push(d.querySelectorAll("#compared-errors tbody tr").length);
  }
  const d = (await show("all/index.html", 390, true)).contentDocument;
  const shown = d.getElementById("choose-runs").getClientRects().length;
  lines.push(`no-script ${shown} ${d.querySelectorAll(".plot svg").length}`);
"##;

/// In a browser, times of two devices are not compared, errors are, and nothing is wider than the frame.
#[test]
fn times_of_two_devices_are_not_compared_and_the_page_fits_a_phone() {
    let folder = library();
    folder.succeed(&["index", "all"]);
    let Some(found) = probe(&folder, PROBE) else { return };
    let report =
        |width: u32| format!("{width} overflow 0 first 0 2\nNot compared: times compare only on one device.\n1\n");
    assert_eq!(found, report(390) + &report(1280) + "no-script 0 2");
}
