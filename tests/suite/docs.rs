//! Tests the pages that people read: they are what `make docs` makes of records and tables, their links lead somewhere,
//! and their citations name sections that exist.

mod coverage;
mod errata;
mod published;
mod sentences;
mod visible;

use crate::common::repository;
use ssct_docs::pages::{definitions, outside_code};
use std::fs;
use std::path::PathBuf;

/// The greatest number of lines of the README, so that it fits on a few screens.
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

/// How the paths below `CITING` begin whose files are made by programs. Folders of runs begin with their year.
const NOT_TEXT: &[&str] = &["benches/runs/2", "fuzz/corpus", "fuzz/target", "tests/golden"];

/// Returns the root of the repository.
fn root() -> PathBuf {
    repository().to_owned()
}

/// Returns the path from the root and the content of every text file that may cite a page.
fn texts() -> Vec<(String, String)> {
    let root = root();
    let mut to_visit: Vec<PathBuf> = CITING.iter().map(|name| root.join(name)).collect();
    let mut found = Vec::new();
    while let Some(path) = to_visit.pop() {
        let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
        if NOT_TEXT.iter().any(|n| name.starts_with(n)) {
            continue;
        }
        if path.is_dir() {
            to_visit.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        } else if let Ok(text) = String::from_utf8(fs::read(path).unwrap()) {
            found.push((name, text));
        }
    }
    assert!(found.len() > 200, "only {} texts found", found.len());
    found
}

/// Returns the names and texts of the pages in Markdown that link to each other and to the records.
fn pages() -> Vec<(String, String)> {
    let is_page = |name: &str| name.ends_with(".md") && name != "src/ARCHITECTURE.md";
    texts().into_iter().filter(|(name, _)| is_page(name)).collect()
}

/// Returns a page's headings, without the marks of emphasis and code.
fn headings(text: &str) -> Vec<String> {
    let lines = outside_code(text);
    let titles = lines.iter().filter_map(|l| l.strip_prefix('#')).map(|l| l.trim_start_matches('#').trim());
    titles.map(|t| t.replace(['`', '*'], "")).collect()
}

/// Returns the anchor that GitHub makes of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().chars().filter(|c| c.is_alphanumeric() || "- _".contains(*c)).collect::<String>();
    kept.replace(' ', "-")
}

/// The README has at most `README_LINES` lines. It is the page that most readers see alone, and it grows with every
/// feature.
#[test]
fn the_readme_is_short() {
    let lines = fs::read_to_string(root().join("README.md")).unwrap().lines().count();
    assert!(lines <= README_LINES, "README.md has {lines} lines; what is longer belongs into docs/");
}

/// Each link of a page leads to a file and a heading in the repository, and each label has a definition. Renamed files
/// and headings leave links behind that nothing else checks.
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

/// Returns whether a piece of code in a page is the path of a file of the repository.
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

/// Returns a text as one line, without the marks that begin comment lines.
fn flowing(text: &str) -> String {
    let unmarked = |line: &str| {
        let line = line.trim();
        let line = ["//!", "///", "//", "#", "*"].iter().find_map(|mark| line.strip_prefix(mark)).unwrap_or(line);
        line.trim().to_owned()
    };
    text.lines().map(unmarked).collect::<Vec<_>>().join(" ")
}

/// Returns the sections, each with the numbers of its items, that follow a citation of a page. Forms that it reads are
/// `, "Oracle", items 1 and 2`, `, "Oracle" and "Image error"` and ` ("Hits", "Gloss")`.
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

/// Returns the numbers of the items below a heading.
fn items(page: &str, heading: &str) -> Vec<usize> {
    let lines = page.lines().skip_while(|l| l.trim_start_matches('#').trim() != heading || !l.starts_with('#'));
    let below = lines.skip(1).take_while(|l| !l.starts_with('#'));
    below.filter_map(|l| l.split_once(". ")?.0.parse().ok()).collect()
}

/// Examples of citations give the sections and items that their author means. If too little were read, a wrong citation
/// would pass.
#[test]
fn a_citation_is_read_as_its_author_means_it() {
    let section = |name: &str, items: &[usize]| (name.to_owned(), items.to_vec());
    assert_eq!(cited(r#", "Oracle", item 3; docs"#), [section("Oracle", &[3])]);
    assert_eq!(cited(r#", "Oracle", items 2 to 4). It"#), [section("Oracle", &[2, 4])]);
    assert_eq!(
        cited(r#", "Oracle" and "Image error") and more"#),
        [section("Oracle", &[]), section("Image error", &[])]
    );
    assert_eq!(cited(r#" ("Hits", "Gloss") says"#), [section("Hits", &[]), section("Gloss", &[])]);
    assert_eq!(cited(" as a whole"), []);
    assert_eq!(flowing("    /// a (docs/x.md,\n    /// \"B\")"), "a (docs/x.md, \"B\")");
    assert_eq!(items("## A\n1. x\n2. y\n## B\n3. z\n", "A"), [1, 2]);
}

/// Each section and numbered item of `docs/definitions.md` and `docs/numerics.md` that a text cites exists. Comments
/// cite them, and renaming a section changes no code.
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
                    let existing = items(&text, &section);
                    let missing = numbers.iter().filter(|n| !existing.contains(n));
                    wrong.extend(missing.map(|n| format!("{name}: {page}, \"{section}\", has no item {n}")));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "wrong citations:\n{}", wrong.join("\n"));
    assert!(citations > 0);
}

/// No text names three pages that exist only outside of the repository, where a reader cannot look them up.
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
            // The second word occurs nowhere in the code, so that the whole line must be without it.
            if cites || line.contains(outside[1]) {
                wrong.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    assert!(wrong.is_empty(), "cited, but not in the repository:\n{}", wrong.join("\n"));
}

/// Each file that `make docs` writes has the content that it would write now. A changed record or table otherwise
/// leaves old numbers on the pages.
#[test]
fn pages_are_current() {
    let files = ssct_docs::files(repository()).unwrap();
    let old: Vec<_> = files.iter().filter_map(|(name, text)| ssct_docs::difference(repository(), name, text)).collect();
    assert!(old.is_empty(), "`make docs` writes these anew, from what is there to what should be:\n{}", old.join("\n"));
    assert!(files.len() > 20, "only {} files are made", files.len());
}
