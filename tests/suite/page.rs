//! Tests the page of a study. It is made from small records and pictures in a temporary folder, read as text, and shown
//! by a headless Chromium if it is installed.

use crate::common::folder::Folder;
use crate::common::html::{attributes, chromium, probe};
use ssct::gpu::DeviceInfo;
use ssct::methods::{Prepared, Setup, find};
use ssct::passes::gbuffer::DrawnCounts;
use ssct_ground::parameter::Preset;
use ssct_lab::report::html::{Errors, Gallery, Page, Picture, PictureFolder, Strip, Times};
use ssct_lab::report::images::Rgb;
use ssct_lab::report::{plot, tables};
use ssct_lab::stage::Globals;
use ssct_lab::study::engine::Row;
use ssct_lab::study::error::{ErrorRecord, ErrorReference, ImageError, source_table};
use ssct_lab::study::record::{Head, PassRecord, Provenance, recorded_setup};
use ssct_lab::study::table::{cells, compare};
use ssct_lab::study::timing::chart;
use ssct_lab::study::{Stats, TimeRecord};
use ssct_scenes::Lens;
use ssct_truth::metrics::HitAgreement;
use std::path::Path;

/// Widths of a phone and a desktop, in CSS pixels.
const WIDTHS: [u32; 2] = [390, 1280];

/// Returns a device whose name has characters that HTML must escape.
fn device() -> DeviceInfo {
    let [name, driver, api, kind] = ["A <GPU> & more", "driver 1", "1.3.0", "CPU"].map(str::to_owned);
    DeviceInfo { name, driver, api, kind }
}

/// Returns the fields that all records begin with.
fn head(kind: &str, method: &str, roughness: f32) -> Head {
    let globals = Globals { roughness: Some(roughness), reflectivity: 1.0, normal_deviation: Some(roughness) };
    Head {
        kind: kind.into(),
        program: Provenance { definitions: 1, version: "0".into(), commit: "c".into(), device: device() },
        scene: "rooms".into(),
        view: "two-cylinders".into(),
        method: method.into(),
        preset: Preset::Published,
        width: 640,
        height: 480,
        roughness: Some(roughness),
        setup: recorded_setup(&Setup::new([640, 480]), find(method).ok(), &Lens::default(), &globals),
    }
}

/// Returns a record of times whose seven passes share the time evenly.
fn time_record(method: &str, roughness: f32, ms: f64) -> TimeRecord {
    let passes = ["depth", "hi-z/1", "hi-z/2", "visibility/1", "color/1", "trace+cone", "composite"];
    let pass = |name: &&str| PassRecord {
        name: (*name).to_owned(),
        counted: true,
        stats: Stats::from_samples(&[ms / 7.0]),
        noise_floor: None,
        work: None,
    };
    TimeRecord {
        head: head("time", method, roughness),
        passes: passes.iter().map(pass).collect(),
        total: Stats::from_samples(&[ms]),
        noise_floor: None,
        frame: Stats::from_samples(&[ms]),
        drawn: DrawnCounts::default(),
        recorded: passes.map(str::to_owned).to_vec(),
        skipped: Vec::new(),
        samples: vec![vec![ms / 7.0; 7]],
    }
}

/// Returns a record of an error against a reference, with the time of the method.
fn error_record(method: &str, against: ErrorReference, ms: f64, error: f64) -> ErrorRecord {
    ErrorRecord {
        head: head("error", method, 0.0),
        time_ms: Some(ms),
        time_low_ms: Some(0.9 * ms),
        time_high_ms: Some(1.1 * ms),
        against,
        hits: HitAgreement { hit_agreement: Some(1.0 - error), ..HitAgreement::default() },
        image: ImageError { rmse: (against != ErrorReference::Oracle).then_some(error), ..ImageError::default() },
        place_agreement: None,
        floor: None,
        prepared: None,
    }
}

/// A star marks a method that no other beats in time and error. Differences of time within the noise do not count, so
/// that two copies of a method have both a star or none.
#[test]
fn two_copies_of_a_method_have_two_stars_or_none() {
    let stars = |records: &[ErrorRecord]| {
        let tables = ErrorRecord::tables(records, &serde_json::Value::Null);
        let rows = tables[0].cells[1..].iter().map(|row| (row[0].clone(), row[3].clone()));
        rows.filter(|(_, star)| star == "*").map(|(name, _)| name).collect::<Vec<_>>()
    };
    let record = |method: &str, ms, error| error_record(method, ErrorReference::Screen, ms, error);
    // The times of copies differ by less than the noise, which is a tenth.
    let copies = [record("ssct", 10.0, 0.5), record("copy", 10.5, 0.5)];
    assert_eq!(stars(&copies), ["ssct", "copy"]);
    assert_eq!(stars(&[&copies[..], &[record("hzct", 5.0, 0.5)]].concat()), ["hzct"]);
    // A time that is better by noise alone does not outweigh a greater error.
    assert_eq!(stars(&[record("ssct", 10.0, 0.5), record("worse", 9.5, 0.6)]), ["ssct"]);
    assert_eq!(stars(&[record("ssct", 10.0, 0.5), record("faster", 5.0, 0.6)]), ["faster", "ssct"]);
    // Records of few frames do not say their noise.
    let silent = |r: &ErrorRecord| ErrorRecord { time_low_ms: None, time_high_ms: None, ..r.clone() };
    assert_eq!(stars(&[silent(&record("ssct", 10.0, 0.5)), silent(&record("copy", 10.2, 0.5))]), ["ssct", "copy"]);
}

/// Each table says how many cells it averages. The oracle's table has mirrors alone, so that one number for all tables
/// would be wrong.
#[test]
fn each_table_of_errors_says_how_many_cells_it_averages() {
    let rough = |roughness| ErrorRecord {
        head: head("error", "ssct", roughness),
        ..error_record("ssct", ErrorReference::World, 10.0, 0.1)
    };
    let untimed = ErrorRecord { time_ms: None, ..rough(0.5) };
    let mirror = |against| error_record("ssct", against, 10.0, 0.1);
    let records = [mirror(ErrorReference::Oracle), mirror(ErrorReference::World), rough(0.1), rough(0.3), untimed];
    let abouts: Vec<String> =
        ErrorRecord::tables(&records, &serde_json::Value::Null).into_iter().map(|table| table.about).collect();
    assert_eq!(abouts.len(), 2);
    assert!(abouts[0].starts_with("One cell. ") && abouts[1].starts_with("3 cells. "), "{abouts:?}");
}

/// The column `drift` says by how much the scene passes of a row took longer or shorter than those of the first row.
/// Rows that were timed in turn have no such column. Without it, a busy machine would pass for a slow method.
#[test]
fn rows_of_table_5_8_carry_the_drift_between_them() {
    let record_with_scene = |method: &str, roughness, ms: f64, scene_ms: f64| {
        let mut record = time_record(method, roughness, ms);
        let stats = Stats::from_samples(&[scene_ms]);
        record
            .passes
            .insert(0, PassRecord { name: "g-buffer".into(), counted: false, stats, ..record.passes[0].clone() });
        record
    };
    // Roughness 0 was slower by the load alone: the scene passes say so.
    let records = [
        record_with_scene("ssct", 0.0, 20.0, 40.0),
        record_with_scene("hzct", 0.0, 18.0, 40.0),
        record_with_scene("ssct", 0.1, 10.0, 20.0),
        record_with_scene("hzct", 0.1, 9.0, 20.0),
    ];
    let column = |cells: &[Vec<String>], title: &str| {
        let column = cells[0].iter().position(|cell| cell == title)?;
        Some(cells[1..].iter().map(|row| row[column].clone()).collect::<Vec<_>>())
    };
    let drifts = |records: &[TimeRecord]| column(&cells(&compare(records)), "drift");
    assert_eq!(drifts(&records), Some(vec!["+0 %".to_owned(), "-50 %".to_owned()]));
    assert_eq!(drifts(&records[..2]), None, "what was timed in turn has none");
}

/// The quotient of two methods is the median of the quotients of each turn, so that a slower machine does not change
/// it. With few turns there is no interval.
#[test]
fn quotients_of_table_5_8_are_medians_over_turns_with_their_interval() {
    let timed = |method: &str, turns: &[f64]| {
        let record = time_record(method, 0.1, 1.0);
        TimeRecord { samples: turns.iter().map(|ms| vec![ms / 7.0; 7]).collect(), ..record }
    };
    let shown = |turns: [&[f64]; 2]| {
        let cells = cells(&compare(&[timed("ssct", turns[0]), timed("hzct", turns[1])]));
        let column = cells[0].iter().position(|cell| cell == "HZCT/SSCT here").unwrap();
        cells[1][column].clone()
    };
    // The machine became slower by half on the way, and the quotient of each turn is a half all the same.
    assert_eq!(shown([&[10.0, 10.0, 15.0, 15.0, 15.0], &[5.0, 5.0, 7.5, 7.5, 7.5]]), "0.50 [0.50, 0.50]");
    assert_eq!(shown([&[10.0, 10.0, 10.0], &[9.0, 8.0, 7.0]]), "0.80", "too few turns for an interval");
}

/// The median time of a group of passes is the median of the sums of each frame. The sum of the medians would be
/// another number.
#[test]
fn the_median_of_a_group_is_that_of_its_sums() {
    let mut record = time_record("ssct", 0.1, 7.0);
    // Two levels of the Hi-Z, the second and third pass: one is slow where the other is fast.
    record.samples = [[1.0, 9.0], [9.0, 1.0], [2.0, 2.0]].map(|[a, b]| vec![1.0, a, b, 1.0, 1.0, 1.0, 1.0]).to_vec();
    let stages = record.stages();
    assert_eq!(stages[1], ("hi-z".to_owned(), 10.0), "not 2 + 2: {stages:?}");
    assert_eq!(record.totals(), [15.0, 15.0, 9.0]);
}

/// Memory that methods prepare has a plot if two of them prepare different amounts, and a column if any prepares some.
#[test]
fn what_is_prepared_is_plotted_where_it_differs() {
    let prepared =
        |bytes| Prepared { time_ms: 1.0, device_bytes: bytes, captures: vec![[0.0; 3]], ..Prepared::default() };
    let record = |method: &str, bytes, error| ErrorRecord {
        prepared: Some(prepared(bytes)),
        ..error_record(method, ErrorReference::World, 10.0, error)
    };
    let names = |records: &[ErrorRecord]| {
        let charts = ErrorRecord::charts(records);
        charts.into_iter().map(|chart| chart.stem).collect::<Vec<_>>()
    };
    let text = |records: &[ErrorRecord]| tables::text(&ErrorRecord::tables(records, &serde_json::Value::Null));
    let one_size = [record("unified", 1 << 20, 0.02), record("ssct", 0, 0.08)];
    assert_eq!(names(&one_size), ["error-world"], "one size is no plot");
    assert!(text(&one_size).contains("prepared MiB"));
    let two_sizes = [record("unified", 1 << 20, 0.02), record("captures", 1 << 22, 0.01), record("ssct", 0, 0.08)];
    assert_eq!(names(&two_sizes), ["error-world", "error-world-bytes"]);
    assert!(!text(&[record("ssct", 0, 0.08)]).contains("prepared MiB"));
}

/// Writes a PNG of one colour with some noise into the folder `images`. The noise makes its JPEG smaller than its PNG.
fn picture(folder: &Path, name: &str, color: [u8; 3]) -> Picture {
    let noise = |n: u32| (n.wrapping_mul(2_654_435_761) >> 28) as u8;
    let bytes = (0..64 * 36 * 3).map(|n| color[n as usize % 3].saturating_add(noise(n))).collect();
    let file = format!("images/{}.png", name.replace(' ', "-"));
    Rgb { width: 64, height: 36, bytes }.write_png(&folder.join(&file)).unwrap();
    Picture { file, name: name.into(), caption: format!("{name}, \"quoted\" <caption>") }
}

/// A study's page in a folder, with all files that it links to.
struct StudyPage {
    folder: Folder,
    html: String,
}

impl StudyPage {
    /// Makes the page from small records and pictures, and writes it to a new folder.
    fn new() -> Self {
        let folder = Folder::new();
        let path = folder.root();
        let times: Vec<_> = [0.0, 0.1]
            .into_iter()
            .flat_map(|r| [time_record("ssct", r, 10.0), time_record("hzct", r, 8.0), time_record("sslr", r, 12.0)])
            .collect();
        let errors: Vec<_> = [ErrorReference::Oracle, ErrorReference::Screen, ErrorReference::World]
            .into_iter()
            .flat_map(|a| [error_record("ssct", a, 10.0, 0.03), error_record("hzct", a, 8.0, 0.05)])
            .collect();
        let device = device();
        let new_picture = |name: &str, color| picture(path, name, color);
        let (lit, ssct, reference) =
            (new_picture("lit", [200, 0, 0]), new_picture("ssct", [0, 200, 0]), new_picture("reference", [0, 0, 200]));
        let gallery = |title: &str, strip, compared: [&str; 2]| Gallery {
            title: title.into(),
            strips: vec![strip],
            compared: compared.map(str::to_owned),
        };
        // A strip with two pairs of pictures beside a reference.
        let [ssct_map, lit_map] = [new_picture("ssct map", [90, 0, 0]), new_picture("lit map", [0, 90, 0])];
        let pairs = vec![[ssct.clone(), ssct_map], [lit.clone(), lit_map]];
        let beside = Strip::Beside { title: "held against".into(), reference, pairs };
        std::fs::write(path.join("time.json"), "[]").unwrap();
        let page = Page {
            device: &device,
            command: "ssct study".into(),
            to_come: Vec::new(),
            times: Times {
                settings: "Timed.".into(),
                table: &compare(&times),
                table_records: &times,
                view_records: &times,
                plot: plot::draw(&chart(&times).drawing).unwrap(),
            },
            errors: Errors {
                settings: "Small.".into(),
                records: &errors,
                plots: plot::draw_charts(&errors).unwrap(),
                pictures: vec![gallery("cell", beside, ["ssct", "reference"])],
            },
            views: &[gallery("view", Strip::Plain(vec![lit.clone(), ssct]), ["lit", "ssct"])],
            figures: &[lit],
            agreement: &[],
            records: vec![("time.json".into(), "times".into()), ("images/".into(), "pictures".into())],
        };
        let html = page.render(&PictureFolder::new(path)).unwrap();
        assert_eq!(html, page.render(&PictureFolder::new(path)).unwrap(), "the same data make the same page");
        folder.write("index.html", &html);
        Self { folder, html }
    }
}

/// The page loads nothing from other places: pictures are embedded as JPEG, and the script stands in the page. A page
/// that is sent by mail would otherwise lack them.
#[test]
fn the_page_needs_nothing_from_elsewhere() {
    let page = StudyPage::new();
    for word in ["http:", "https:", "url(", "@import", "<iframe", "<object"] {
        assert!(!page.html.contains(word), "{word}");
    }
    let sources = attributes(&page.html, "src");
    // Two pictures of the view, five of the cell, and one figure.
    assert_eq!(sources.len(), 8);
    assert!(sources.iter().all(|s| s.starts_with("data:image/jpeg;base64,/9j/")), "JPEG begins with ff d8 ff");
    assert!(!page.html.contains("<script src") && page.html.contains("<script>"));
}

/// The page's ids are unique, each picture has a text, each link leads to a file or an id, names are escaped, and tags
/// are closed. Browsers repair such faults in silence.
#[test]
fn ids_are_unique_pictures_have_words_and_links_lead_somewhere() {
    let page = StudyPage::new();
    let ids = attributes(&page.html, "id");
    let mut unique = ids.clone();
    unique.sort();
    unique.dedup();
    assert_eq!(unique.len(), ids.len(), "{ids:?}");
    let images = page.html.split("<img").skip(1).map(|tag| tag.split('>').next().unwrap());
    assert!(images.map(|tag| assert!(tag.contains(" alt=\""), "{tag}")).count() > 8);
    let links = attributes(&page.html, "href");
    assert!(links.contains(&"time.json") && links.contains(&"images/"));
    for link in links.iter().filter(|l| !l.starts_with("data:")) {
        match link.strip_prefix('#') {
            Some(id) => assert!(ids.contains(&id), "{link}"),
            None => assert!(page.folder.path(link).exists(), "{link}"),
        }
    }
    assert!(page.html.contains("A &lt;GPU&gt; &amp; more") && !page.html.contains("<GPU>"), "text is escaped");
    for tag in ["section", "div", "table", "tr", "figure", "a", "details", "svg", "template", "select"] {
        let open = page.html.matches(&format!("<{tag} ")).count() + page.html.matches(&format!("<{tag}>")).count();
        assert_eq!(open, page.html.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

/// A page without records says so, and a page with a picture that does not exist is refused with the picture's name.
#[test]
fn a_missing_picture_is_named() {
    let page = StudyPage::new();
    let device = device();
    let missing = Picture { file: "images/none.png".into(), name: "none".into(), caption: String::new() };
    let empty = Page {
        device: &device,
        command: String::new(),
        to_come: vec!["table 5.8".into(), "times".into()],
        times: Times {
            settings: String::new(),
            table: &[],
            table_records: &[],
            view_records: &[],
            plot: "<svg></svg>".into(),
        },
        errors: Errors { settings: String::new(), records: &[], plots: Vec::new(), pictures: Vec::new() },
        views: &[],
        figures: &[],
        agreement: &[],
        records: Vec::new(),
    };
    let folder = PictureFolder::new(page.folder.root());
    let html = empty.render(&folder).unwrap();
    assert!(html.contains("Not measured.") && html.contains("no other device"));
    assert!(html.contains("Still to come: table 5.8; times.") && !page.html.contains("Still to come"));
    let wrong = Page { figures: &[missing], ..empty };
    assert!(wrong.render(&folder).unwrap_err().to_string().contains("none.png"));
}

/// A script that shows the page in frames of some widths, with and without the page's script, and records what it finds
/// there.
const PROBE: &str = r#"
const visible = (e) => e.getClientRects().length > 0;
function probe(frame, what) {
  const d = frame.contentDocument, root = d.documentElement;
  lines.push(`${what} overflow ${root.scrollWidth - root.clientWidth}`);
  lines.push(`${what} pictures ${[...d.images].filter(i => i.naturalWidth == 64 && i.clientWidth >= 100).length > 7}`);
  lines.push(`${what} dividers ${[...d.querySelectorAll("section .compare")].filter(visible).length}`);
  const strip = d.querySelector(".strip.beside");
  lines.push(`${what} columns ${getComputedStyle(strip).gridTemplateColumns.split(" ").length}`);
  // The reference stands between the first pair, and beside the second too.
  const at = [...strip.children].map(f => f.getBoundingClientRect());
  const [reference, first, map, second] = at;
  lines.push(`${what} between ${first.right < reference.left && reference.right < map.left && first.top == reference.top}`);
  lines.push(`${what} above ${reference.bottom < first.top && first.bottom < map.top && map.bottom < second.top}`);
  const section = strip.closest("section"), range = section.querySelector("input");
  if (!range) return;
  const right = range.parentElement.querySelector(".right"), select = section.querySelectorAll("select")[1];
  range.value = 25;
  range.dispatchEvent(new Event("input"));
  lines.push(`${what} clip ${getComputedStyle(right).clipPath}`);
  lines.push(`${what} choices ${[...select.options].map(o => o.value)}`);
  const before = right.src;
  select.value = "lit";
  select.dispatchEvent(new Event("change"));
  lines.push(`${what} chosen ${right.src != before} ${range.getAttribute("aria-valuetext")}`);
}
for (const width of [390, 1280]) probe(await show("index.html", width, false), `${width}`);
probe(await show("index.html", 390, true), "no-script");
"#;

/// In a browser, nothing is wider than the frame at two widths, strips have one or three columns, and the divider of
/// two pictures moves. Without its script, the page has no dividers.
#[test]
fn it_fits_a_phone_and_a_desktop_and_its_divider_moves() {
    let page = StudyPage::new();
    let Some(found) = probe(&page.folder, PROBE) else { return };
    let lines_of = |what: &str, columns: u32| {
        let wide = columns > 1;
        format!(
            "{what} overflow 0\n{what} pictures true\n{what} dividers 2\n{what} columns {columns}\n\
             {what} between {wide}\n{what} above {}\n\
             {what} clip inset(0px 0px 0px 25%)\n{what} choices reference,ssct,ssct map,lit,lit map\n\
             {what} chosen true 25 % ssct, then lit\n",
            !wide
        )
    };
    let without = "no-script overflow 0\nno-script pictures true\nno-script dividers 0\nno-script columns 1\n\
                   no-script between false\nno-script above true";
    let expected = lines_of("390", 1) + &lines_of("1280", 3) + without;
    assert_eq!(found, expected);
}

/// Screenshots at both widths have enough pixels in the colours of words, bars and pictures. A style sheet can hide a
/// part that the text has.
#[test]
fn a_screenshot_shows_words_plots_and_pictures() {
    let page = StudyPage::new();
    for width in WIDTHS {
        let profile = tempfile::tempdir().unwrap();
        let Some(mut command) = chromium(profile.path()) else { return };
        let file = page.folder.path(&format!("{width}.png"));
        let url = format!("file://{}", page.folder.path("index.html").display());
        command
            .arg("--hide-scrollbars")
            .arg(format!("--screenshot={}", file.display()))
            .arg(format!("--window-size={width},9000"));
        assert!(command.arg(url).output().unwrap().status.success());
        let image = image::open(&file).unwrap().into_rgb8();
        assert_eq!(image.width(), width);
        let near = |a: [u8; 3], b: [u8; 3]| (0..3).all(|c| a[c].abs_diff(b[c]) < 24);
        let count = |color| image.pixels().filter(|p| near(p.0, color)).count();
        // Words are dark, and the bars of the first plot and the three pictures have colours of their own.
        for (part, color, least) in [
            ("words", [0, 0, 0], 2000),
            ("bars", [0x4c, 0x78, 0xa8], 200),
            ("lit", [207, 7, 7], 10_000),
            ("ssct", [7, 207, 7], 10_000),
            ("reference", [7, 7, 207], 10_000),
        ] {
            assert!(count(color) >= least, "{part} at {width}: {} pixels", count(color));
        }
    }
}

/// The table of medians by roughness takes the record of a method's first setup and leaves out its other variants,
/// whose errors belong to other settings.
#[test]
fn medians_by_roughness_are_of_a_method_s_first_variant() {
    let base = error_record("unified", ErrorReference::Screen, 4.0, 0.02);
    let other = |change: fn(&mut Head)| {
        let mut record = error_record("unified", ErrorReference::Screen, 4.0, 0.08);
        change(&mut record.head);
        record
    };
    let by_oracle_2 = other(|head| drop(head.setup.insert("oracle".into(), 2.into())));
    let records = [
        base,
        by_oracle_2.clone(),
        by_oracle_2.clone(),
        other(|head| drop(head.setup.insert("resolution_scale".into(), 0.5.into()))),
    ];
    assert_eq!(source_table(&records).cells[1], ["unified, screen", "0.0200"]);
    assert_eq!(source_table(&[by_oracle_2]).cells[1], ["unified, screen", "0.0800"]);
}
