//! The pages that people read: their links lead somewhere, their citations name sections that exist, and their quoted
//! measurements are those of the records under `benches/runs/`. `make docs` writes the quotations anew.

mod against_world;
mod beside;
mod beyond;
mod captions;
mod claims;
mod complaints;
mod coverage;
mod dda;
mod devices;
mod embedding;
mod ends;
mod errata;
mod figures;
mod films;
mod follow;
mod gpu;
mod headline;
mod large_gltf;
mod layers;
mod league;
mod listings;
mod measured;
mod motion;
mod outlook;
mod own_rays;
mod published;
mod readme_numbers;
mod records;
mod sentences;
mod stochastic;
mod stress;
mod thesis;
mod visible;
mod waits;
mod world;

use crate::common::repository;
use ssct::methods::METHODS;
use ssct::methods::exclusions::EXCLUSIONS;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The greatest number of lines of the README, which fits on a few screens.
const README_LINES: usize = 150;

/// Files and folders with text that cites the pages.
const CITING: &[&str] = &[
    "CONTRIBUTING.md",
    "README.md",
    "SECURITY.md",
    "CHANGELOG.md",
    "Makefile",
    "build.rs",
    "benches",
    "docs",
    "fuzz",
    "lab",
    "scripts",
    "shaders-glsl",
    "src",
    "tests",
];

/// Folders among `CITING` that no person wrote or reads.
const NOT_TEXT: &[&str] = &["benches/runs/2", "fuzz/corpus", "fuzz/target", "tests/golden"];

/// The root of the repository.
fn root() -> PathBuf {
    repository().to_owned()
}

/// Path below the root and content of every text file that may cite a page.
fn texts() -> Vec<(String, String)> {
    let root = root();
    let mut left: Vec<PathBuf> = CITING.iter().map(|name| root.join(name)).collect();
    let mut found = Vec::new();
    while let Some(path) = left.pop() {
        let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
        if NOT_TEXT.iter().any(|n| name.starts_with(n)) {
            continue;
        }
        if path.is_dir() {
            left.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        } else if let Ok(text) = String::from_utf8(fs::read(path).unwrap()) {
            found.push((name, text));
        }
    }
    assert!(found.len() > 200, "only {} texts found", found.len());
    found
}

/// The pages in Markdown that link to each other and to the records.
fn pages() -> Vec<(String, String)> {
    let is_page = |name: &str| name.ends_with(".md") && name != "src/ARCHITECTURE.md";
    let mut pages: Vec<_> = texts().into_iter().filter(|(name, _)| is_page(name)).collect();
    let runs = root().join("benches/runs/README.md");
    if !pages.iter().any(|(name, _)| name == "benches/runs/README.md") {
        pages.push(("benches/runs/README.md".to_owned(), fs::read_to_string(runs).unwrap()));
    }
    pages
}

/// A page's headings, without the marks of emphasis and code.
fn headings(text: &str) -> Vec<String> {
    let lines = outside_code(text);
    let titles = lines.iter().filter_map(|l| l.strip_prefix('#')).map(|l| l.trim_start_matches('#').trim());
    titles.map(|t| t.replace(['`', '*'], "")).collect()
}

/// Lines that do not stand in a fenced block.
fn outside_code(text: &str) -> Vec<&str> {
    let mut inside = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if !inside {
            lines.push(line);
        }
    }
    lines
}

/// The anchor that GitHub makes of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || "- _".contains(*c)).collect::<String>();
    kept.replace(' ', "-")
}

/// A page's link definitions: `[name]: target`.
fn definitions(text: &str) -> BTreeMap<String, String> {
    let definition = |line: &str| {
        let (name, target) = line.strip_prefix('[')?.split_once("]: ")?;
        Some((name.to_owned(), target.trim().to_owned()))
    };
    outside_code(text).into_iter().filter_map(definition).collect()
}

#[test]
fn the_readme_is_short() {
    let lines = fs::read_to_string(root().join("README.md")).unwrap().lines().count();
    assert!(lines <= README_LINES, "README.md has {lines} lines; what is longer belongs into docs/");
}

/// Each link of a page leads to a file and a heading in the repository, and each label has a definition.
#[test]
fn links_lead_to_files_and_headings_that_exist() {
    let (mut links, mut broken) = (0, Vec::new());
    for (name, text) in pages() {
        let folder = root().join(&name).parent().unwrap().to_owned();
        let defined = definitions(&text);
        let mut targets: Vec<String> = defined.values().cloned().collect();
        for line in outside_code(&text) {
            for (offset, _) in line.match_indices("](") {
                targets.push(line[offset + 2..].split(')').next().unwrap().to_owned());
            }
            for (offset, _) in line.match_indices("][") {
                let label = line[offset + 2..].split(']').next().unwrap();
                if !defined.contains_key(label) {
                    broken.push(format!("{name}: no definition of the link [{label}]"));
                }
            }
        }
        for target in targets.iter().filter(|t| !t.contains("://") && !t.starts_with("mailto:")) {
            links += 1;
            let (path, heading) = target.split_once('#').unwrap_or((target, ""));
            let file = if path.is_empty() { root().join(&name) } else { folder.join(path) };
            if !file.exists() {
                broken.push(format!("{name}: there is no {path}"));
            } else if !heading.is_empty() {
                let page = fs::read_to_string(&file).unwrap();
                if !headings(&page).iter().any(|h| anchor(h) == heading) {
                    broken.push(format!("{name}: {path} has no heading for #{heading}"));
                }
            }
        }
    }
    assert!(broken.is_empty(), "broken links:\n{}", broken.join("\n"));
    assert!(links > 40, "only {links} links found");
}

/// Whether a piece of code in a page is the path of a file of the repository.
fn is_path(code: &str) -> bool {
    let folders = [
        "benches/",
        "c/",
        "docs/",
        "examples/",
        "findings/",
        "fuzz/",
        "lab/",
        "scripts/",
        "shaders-glsl/",
        "src/",
        "tests/",
    ];
    folders.iter().any(|f| code.starts_with(f)) && code.contains('.') && !code.contains([' ', '*', '<', '{'])
}

/// Each path between backquotes on a page, except in the changelog, is a file of the repository.
#[test]
fn files_that_pages_name_exist() {
    let (mut named, mut missing) = (0, Vec::new());
    let map = ("src/ARCHITECTURE.md".to_owned(), fs::read_to_string(root().join("src/ARCHITECTURE.md")).unwrap());
    // The changelog also names files of the past.
    for (name, text) in pages().into_iter().chain([map]).filter(|(name, _)| name != "CHANGELOG.md") {
        for line in outside_code(&text) {
            for code in line.split('`').skip(1).step_by(2).filter(|code| is_path(code)) {
                named += 1;
                if !root().join(code).exists() {
                    missing.push(format!("{name}: there is no {code}"));
                }
            }
        }
    }
    assert!(missing.is_empty(), "named, but not there:\n{}", missing.join("\n"));
    assert!(named > 5, "only {named} files are named");
}

/// A text as one line, without the marks that begin comment lines.
fn flowing(text: &str) -> String {
    let bare = |line: &str| {
        let line = line.trim();
        let line = ["//!", "///", "//", "#", "*"].iter().find_map(|mark| line.strip_prefix(mark)).unwrap_or(line);
        line.trim().to_owned()
    };
    text.lines().map(bare).collect::<Vec<_>>().join(" ")
}

/// The sections, each with the numbers of its items, that follow a citation of a page: `, "Oracle", items 1 and 2`,
/// `, "Oracle" and "Image error"`, ` ("Hits", "Gloss")`.
fn cited(after: &str) -> Vec<(String, Vec<usize>)> {
    let mut found: Vec<(String, Vec<usize>)> = Vec::new();
    let mut rest = after;
    loop {
        rest = rest.trim_start_matches([',', ' ', '(', ':', '`']);
        rest = rest.strip_prefix("and ").unwrap_or(rest).trim_start();
        if let Some(quoted) = rest.strip_prefix('"') {
            let Some((section, after)) = quoted.split_once('"') else { return found };
            found.push((section.to_owned(), Vec::new()));
            rest = after;
        } else if let Some(items) = rest.strip_prefix("item") {
            let numbers = items.trim_start_matches(['s', ' ']);
            let end = numbers.find(|c: char| !(c.is_ascii_digit() || " toand,".contains(c))).unwrap_or(numbers.len());
            let Some((_, item_numbers)) = found.last_mut() else { return found };
            item_numbers
                .extend(numbers[..end].split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse::<usize>().ok()));
            rest = &numbers[end..];
        } else {
            return found;
        }
    }
}

/// The numbered items below a heading.
fn items(page: &str, heading: &str) -> Vec<usize> {
    let lines = page.lines().skip_while(|l| l.trim_start_matches('#').trim() != heading || !l.starts_with('#'));
    let below = lines.skip(1).take_while(|l| !l.starts_with('#'));
    below.filter_map(|l| l.split_once(". ")?.0.parse().ok()).collect()
}

/// Examples of citations with the sections and items that are read from them.
#[test]
fn a_citation_is_read_as_its_author_means_it() {
    let one = |name: &str, items: &[usize]| (name.to_owned(), items.to_vec());
    assert_eq!(cited(r#", "Oracle", item 3; docs"#), [one("Oracle", &[3])]);
    assert_eq!(cited(r#", "Oracle", items 2 to 4). It"#), [one("Oracle", &[2, 4])]);
    assert_eq!(cited(r#", "Oracle" and "Image error") and more"#), [one("Oracle", &[]), one("Image error", &[])]);
    assert_eq!(cited(r#" ("Hits", "Gloss") says"#), [one("Hits", &[]), one("Gloss", &[])]);
    assert_eq!(cited(" as a whole"), []);
    assert_eq!(flowing("    /// a (docs/x.md,\n    /// \"B\")"), "a (docs/x.md, \"B\")");
    assert_eq!(items("## A\n1. x\n2. y\n## B\n3. z\n", "A"), [1, 2]);
}

/// Each section and numbered item of `docs/definitions.md` and `docs/numerics.md` that a text cites is there.
#[test]
fn cited_sections_exist() {
    let (mut citations, mut wrong) = (0, Vec::new());
    for page in ["docs/definitions.md", "docs/numerics.md"] {
        let text = fs::read_to_string(root().join(page)).unwrap();
        let headings = headings(&text);
        for (name, citing) in texts().into_iter().filter(|(name, _)| name != "tests/suite/docs.rs") {
            let citing = flowing(&citing);
            for (offset, _) in citing.match_indices(page) {
                citations += 1;
                for (section, numbers) in cited(&citing[offset + page.len()..]) {
                    if !headings.contains(&section) {
                        wrong.push(format!("{name}: {page} has no section \"{section}\""));
                    }
                    let there = items(&text, &section);
                    let missing = numbers.iter().filter(|n| !there.contains(n));
                    wrong.extend(missing.map(|n| format!("{name}: {page}, \"{section}\", has no item {n}")));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "wrong citations:\n{}", wrong.join("\n"));
    assert!(citations > 0);
}

/// No text names three pages that exist only outside of the repository.
#[test]
fn nothing_cites_a_page_that_is_not_in_the_repository() {
    // The words are written in pieces, so that this file does not contain them.
    let outside = [concat!("DEFINI", "TIONS"), concat!("NUMER", "ICS"), concat!("DE", "SIGN,")];
    let mut wrong = Vec::new();
    for (name, text) in texts() {
        for (number, line) in text.lines().enumerate() {
            // The first word is also a constant of the code. In Rust, only comments can cite a page, and code in
            // comments stands between backquotes.
            let comment = if name.ends_with(".rs") { line.split_once("//").map_or("", |(_, c)| c) } else { line };
            let cites = comment.split('`').step_by(2).any(|prose| outside.iter().any(|word| prose.contains(word)));
            let in_text = line.contains(outside[1]);
            if cites || in_text {
                wrong.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    assert!(wrong.is_empty(), "cited, but not in the repository:\n{}", wrong.join("\n"));
}

/// Whether the pages are to be written instead of checked.
fn writes() -> bool {
    std::env::var_os("SSCT_WRITE_DOCS").is_some_and(|v| v == "1")
}

/// Compares a generated text with its file, or writes it.
fn keep(path: &Path, text: &str) {
    let old = fs::read_to_string(path).unwrap_or_default();
    if old == text {
        return;
    }
    if writes() {
        fs::write(path, text).unwrap();
        return;
    }
    let line = old.lines().zip(text.lines()).position(|(a, b)| a != b).unwrap_or(0);
    let [is, should] = [&old, text].map(|t| t.lines().nth(line).unwrap_or(""));
    panic!(
        "{}, line {}, is not what the records say (`make docs` writes it anew):\n{is}\n{should}",
        path.display(),
        line + 1
    );
}

/// A page as it should be, and the number of its markers. Between `<!-- show: QUERY of RECORDS -->` and `<!-- end -->`
/// stands the answer of the records, a table or a number. RECORDS are link definitions of the page, with commas between
/// them.
fn shown(name: &str, text: &str) -> (String, usize) {
    const BEGIN: &str = "<!-- show: ";
    const END: &str = "<!-- end -->";
    let folder = root().join(name).parent().unwrap().to_owned();
    let defined = definitions(text);
    let (mut result, mut rest, mut count) = (String::new(), text, 0);
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (marker, after) = after.split_once(" -->").unwrap_or_else(|| panic!("{name}: a marker without an end"));
        let (_, after) = after.split_once(END).unwrap_or_else(|| panic!("{name}: no end of what is shown of {marker}"));
        let (query, labels) = marker.split_once(" of ").unwrap_or_else(|| panic!("{name}: {marker} of which records?"));
        let folders = labels.split(", ").map(|label| {
            let target = defined.get(label).unwrap_or_else(|| panic!("{name}: no link definition [{label}]"));
            folder.join(target)
        });
        let folders: Vec<_> = folders.collect();
        let answer = records::show(query, &folders).unwrap_or_else(|e| panic!("{name}: {marker}: {e}"));
        let is_table = answer.contains('\n');
        // Markdown does not format a line that begins with an HTML comment, so that a number may not begin a line.
        assert_eq!(is_table, before.ends_with('\n'), "{name}: {marker}: a table begins a line, and a number does not");
        let measured = || devices::line(query, &folders, &answer).unwrap_or_else(|e| panic!("{name}: {marker}: {e}"));
        let answer = if is_table { format!("\n{answer}\n{}\n", measured()) } else { answer };
        result += &format!("{before}{BEGIN}{marker} -->{answer}{END}");
        (rest, count) = (after, count + 1);
    }
    (result + rest, count)
}

/// On each page, the text behind each `show` marker is what the records answer.
#[test]
fn pages_say_what_the_records_say() {
    let mut shows = 0;
    // The page of options has no markers; another test writes it.
    for (name, text) in pages().into_iter().filter(|(_, text)| text.contains("<!-- show:")) {
        let (should, count) = shown(&name, &text);
        keep(&root().join(&name), &should);
        shows += count;
    }
    assert!(shows > 10, "only {shows} tables and numbers");
}

#[test]
fn the_headline_plot_shows_what_the_records_say() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let links = definitions(&readme);
    let [timed, judged] = ["bars", "bars-errors"].map(|name| root().join(&links[name]));
    keep(&root().join("docs/headline.svg"), &headline::plot(&timed, &judged).unwrap());
}

#[test]
fn the_world_plot_shows_what_the_records_say() {
    let links = definitions(&fs::read_to_string(root().join("README.md")).unwrap());
    keep(&root().join("docs/world.svg"), &world::plot(&root().join(&links["world"])).unwrap());
}

/// The options of all methods, as the methods' own tables declare them.
fn options() -> String {
    let mut page =
        "# Parameters of the methods\n\nEvery parameter is an option of the commands that run methods, such as `render`, \
                    `error` and `view` (`--cone-samples 3`), a row of the window's panel, and a value in the \
                    `setup` of every record (`cone_samples`). A method that is not named does not read it. \
                    A switch takes `on` or `off` (`--split on`, `--fade off`), and alone it means on (`--split`). \
                    `--captures` of `gbuffer reflect` takes a folder instead \
                    ([what is in it](definitions.md#captures)). `--preset` \
                    chooses between the published values and those of the author's own program. This page is made from \
                    the tables in the code (`make docs`).\n\n\
                    | parameter | methods | what it does | values | published | author | source |\n\
                    |---|---|---|---|---|---|---|\n"
            .to_owned();
    for (parameter, methods) in ssct::methods::parameters() {
        let screen: Vec<_> = METHODS.iter().filter(|m| m.is_screen_space()).map(|m| m.name).collect();
        let names: Vec<_> = methods.iter().map(|m| m.name).collect();
        let names = match names.len() {
            n if n == METHODS.len() => "every method".to_owned(),
            _ if names == screen => "every screen-space method".to_owned(),
            _ => names.join(", "),
        };
        let unit = if parameter.unit.is_empty() { String::new() } else { format!(" ({})", parameter.unit) };
        page += &format!(
            "| `{}` | {names} | {} | {}{unit} | {} | {} | {} |\n",
            parameter.typed_name(),
            parameter.help,
            parameter.domain,
            parameter.published,
            parameter.author,
            parameter.source
        );
    }
    page += "\n## What is refused\n\nAn effect refuses these requests with a sentence that names what was asked for.\n\n\
             | parameter | is refused |\n|---|---|\n";
    for exclusion in EXCLUSIONS {
        page += &format!("| `{}` | {} |\n", exclusion.parameter.replace('_', "-"), exclusion.refused);
    }
    page
}

#[test]
fn the_page_of_options_is_what_the_tables_declare() {
    keep(&root().join("docs/options.md"), &options());
}

#[test]
fn the_readme_s_numbers_stand_in_the_program() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let (readme, _) = shown("README.md", &readme);
    let folders = definitions(&readme).into_iter().map(|(name, target)| (name, root().join(target))).collect();
    keep(&root().join("lab/src/study/readme.csv"), &readme_numbers::csv(&readme, &folders).unwrap());
}
