//! Tests the page that says where everything of the three documents is (`docs/coverage.md`). Nothing that the documents
//! number is left out, and every method, option, command, figure and erratum that the page names exists.

use super::errata::kinds;
use super::root;
use crate::common::folder::Folder;
use ssct::methods::{METHODS, parameters};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// A row of a document's table: the place in print, where it is in this repository, and its state.
struct Row {
    place: String,
    here: String,
    state: String,
}

/// The things that a document numbers. Each entry has a kind of thing, and its ranges of numbers: the prefix of the
/// chapter, the first number and the last.
type Numbered = &'static [(&'static str, &'static [(&'static str, u32, u32)])];

/// The numbered things of the thesis.
const THESIS: Numbered = &[
    ("figure", &[("1.", 1, 1), ("2.", 1, 7), ("3.", 1, 8), ("4.", 1, 10), ("5.", 1, 9)]),
    ("algorithm", &[("", 1, 6)]),
    ("equation", &[("2.", 1, 6), ("4.", 1, 8)]),
    ("table", &[("5.", 8, 8)]),
    ("section", &[("3.1.", 1, 7), ("4.2.", 1, 11), ("4.3.", 1, 3)]),
];

/// The numbered things of the poster.
const POSTER: Numbered = &[("figure", &[("", 1, 2)])];

/// The numbered things of Schmidt's document.
const SCHMIDT: Numbered = &[
    ("figure", &[("", 1, 52)]),
    ("algorithm", &[("", 1, 4)]),
    ("equation", &[("", 1, 28)]),
    ("listing", &[("", 1, 5)]),
    ("table", &[("", 1, 1)]),
    ("section", &[("5.2.", 1, 2), ("5.3.", 1, 2), ("5.4.", 1, 2)]),
];

/// The words with which a state may begin.
const STATES: [&str; 7] =
    ["faithful", "stand-in: ", "erratum: ", "departure: ", "measured outlook: ", "missing", "background"];

/// Returns the rows of each document's table, in the page's order.
fn documents() -> Vec<Vec<Row>> {
    let page = fs::read_to_string(root().join("docs/coverage.md")).unwrap();
    let rows = |section: &str| {
        let lines = section.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| where |"));
        lines.map(row).collect()
    };
    page.split("\n## ").skip(1).map(rows).collect()
}

/// Reads a row of the page's table, of four cells. The second cell, which describes the thing, is left out.
fn row(line: &str) -> Row {
    let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
    let [place, _, here, state] = cells[..] else { panic!("a row of {} cells: {line}", cells.len()) };
    Row { place: place.to_owned(), here: here.to_owned(), state: state.to_owned() }
}

/// Returns the kind and the number of everything that a place names, such as `§4.2.2, Eq. 6 to 14, listing 3`. A range
/// names all numbers in it.
fn named(place: &str) -> BTreeSet<(String, String)> {
    // The kind and the number that the words before gave, and all names so far.
    let (mut kind, mut before, mut names) = ("", None, BTreeSet::new());
    for word in place.split_whitespace() {
        let word = word.trim_end_matches(',');
        kind = match word {
            "figure" | "figures" => "figure",
            "algorithm" | "Alg." => "algorithm",
            "listing" => "listing",
            "table" => "table",
            "Eq." | "Ineq." => "equation",
            _ => kind,
        };
        let number = word.strip_prefix('§').unwrap_or(word);
        if !number.starts_with(|c: char| c.is_ascii_digit()) {
            continue;
        }
        let category = if word.starts_with('§') { "section" } else { kind };
        let (chapter, last) = number.rfind('.').map_or(("", number), |dot| number.split_at(dot + 1));
        let Ok(last) = last.parse::<u32>() else { continue };
        let is_range = place.contains(&format!(" to {number}"));
        let first = before.filter(|_| is_range && category != "section").map_or(last, |first| first);
        names.extend((first..=last).map(|n| (category.to_owned(), format!("{chapter}{n}"))));
        before = Some(last);
    }
    names
}

/// Places in print give the sections, equations, figures and listings that they name, with all numbers of a range. If
/// the reading missed some, the tests below would find nothing left out.
#[test]
fn a_place_is_read_as_it_is_meant() {
    let names = |place| {
        named(place).into_iter().map(|(kind, number)| format!("{kind} {number}")).collect::<Vec<_>>().join("; ")
    };
    assert_eq!(names("§5.3.1, Eq. 6 to 8, listing 3"), "equation 6; equation 7; equation 8; listing 3; section 5.3.1");
    assert_eq!(names("figures 4.1, 4.2"), "figure 4.1; figure 4.2");
    assert_eq!(names("figures 5.1 to 5.3"), "figure 5.1; figure 5.2; figure 5.3");
    assert_eq!(names("§2.4, Ineq. 2.5"), "equation 2.5; section 2.4");
    assert_eq!(names("§4.2.4, Alg. 3, Eq. 4.1"), "algorithm 3; equation 4.1; section 4.2.4");
}

/// Each figure, algorithm, equation, listing, table and section that a document numbers has a row in its table.
#[test]
fn nothing_that_the_documents_number_is_left_out() {
    let documents = documents();
    assert_eq!(documents.len(), 3, "one section for each document");
    for (rows, numbered) in documents.iter().zip([THESIS, POSTER, SCHMIDT]) {
        let listed: BTreeSet<_> = rows.iter().flat_map(|r| named(&r.place)).collect();
        for (kind, ranges) in numbered {
            for (chapter, first, last) in *ranges {
                for n in *first..=*last {
                    let number = format!("{chapter}{n}");
                    assert!(listed.contains(&((*kind).to_owned(), number.clone())), "no row of {kind} {number}");
                }
            }
        }
    }
}

/// Each row has a known state. Only a missing thing or background has no place here, and each erratum that a row links
/// to is a row of that page.
#[test]
fn every_row_says_where_it_is_and_its_erratum_exists() {
    let mut errata = 0;
    for row in documents().into_iter().flatten() {
        let Row { place, here, state } = row;
        assert!(STATES.iter().any(|s| state.starts_with(s)), "{place}: {state} is no state");
        assert_eq!(state.starts_with("missing"), here == "–" && state != "background", "{place}: {here}, {state}");
        if ["erratum: ", "departure: ", "measured outlook: "].iter().any(|word| state.starts_with(word)) {
            assert!(state.contains("]("), "{place}: {state} leads nowhere");
        }
        for link in state.split('[').skip(1) {
            let (words, target) = link.split_once("](").unwrap_or_else(|| panic!("{place}: {link}"));
            let target = target.split(')').next().unwrap();
            if target.ends_with("ERRATA.md") {
                let page = fs::read_to_string(root().join("docs").join(target)).unwrap();
                errata += 1;
                assert!(page.lines().any(|l| l.starts_with(&format!("| {words} |"))), "{target} has no row {words:?}");
            }
        }
    }
    assert!(errata > 40, "only {errata} errata");
}

/// Returns the text and the target of each link in the part of a state that begins with a word. For the word `erratum`,
/// `erratum: [a](b); departure: [c](d)` gives `a`, `b`.
fn linked<'a>(state: &'a str, word: &str) -> Vec<(&'a str, &'a str)> {
    let parts = state.split("; ").filter_map(|part| part.strip_prefix(&format!("{word}: ")[..]));
    let links = parts.flat_map(|part| part.split('[').skip(1)).filter_map(|link| link.split_once("]("));
    links.map(|(words, target)| (words, target.split(')').next().unwrap())).collect()
}

/// Each row that links to a page of errata calls the thing an erratum or a departure, as that page does. The two pages
/// are written apart.
#[test]
fn an_erratum_and_a_departure_are_called_what_their_page_calls_them() {
    let words = ["erratum", "departure"];
    let mut found = BTreeMap::<&str, usize>::new();
    for Row { place, state, .. } in documents().into_iter().flatten() {
        let links: Vec<_> =
            words.iter().flat_map(|word| linked(&state, word).into_iter().map(move |link| (*word, link))).collect();
        for (word, (name, target)) in &links {
            let page = root().join("docs").join(target);
            let page_kinds: BTreeSet<String> =
                kinds(&page).into_iter().filter(|(place, _)| place == name).map(|(_, kind)| kind).collect();
            assert!(page_kinds.contains(*word), "{place}: {target}, {name:?}, is {page_kinds:?} and no {word}");
            for kind in &page_kinds {
                let is_said = links.iter().any(|(word, link)| word == kind && *link == (*name, *target));
                assert!(is_said, "{place}: {target}, {name:?}, is {page_kinds:?}, and the row says {word} alone");
            }
            *found.entry(*word).or_default() += 1;
        }
    }
    assert!(found.values().all(|n| *n > 15) && found.len() == 2, "{found:?}");
}

/// Returns the scenes in which `ssct figures` draws each figure, both by the figure's number and by its name with the
/// document, as in `thesis-4.1`.
fn scenes_of_figures() -> BTreeMap<String, BTreeSet<String>> {
    let mut scenes: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in ["thesis", "schmidt"] {
        let plates = fs::read_to_string(root().join(format!("lab/src/app/figures/plates/{file}.rs"))).unwrap();
        for plate in plates.split("source: Document::").skip(1) {
            let document = plate.split(',').next().unwrap().to_lowercase();
            let number = plate.split("number: \"").nth(1).unwrap().split('"').next().unwrap();
            let named = plate.split("--scene ").skip(1).map(|after| after.split(' ').next().unwrap().to_owned());
            let named: BTreeSet<String> = named.collect();
            assert!(!named.is_empty(), "figure {number} of {document} is drawn in no scene");
            scenes.insert(format!("{document}-{number}"), named.clone());
            // No other document has a figure with the number of the poster's one figure.
            scenes.insert(number.to_owned(), named);
        }
    }
    assert!(scenes.len() > 60, "only {} figures", scenes.len() / 2);
    scenes
}

/// Returns the figures that a cell of the page names, as in `ssct figures --only 4.1,4.2`.
fn figures_named(here: &str) -> Vec<&str> {
    let after = here.split("figures --only ").skip(1);
    after.flat_map(|rest| rest.split(['`', ' ']).next().unwrap().split(',')).collect()
}

/// A figure that is drawn in a generated scene is called a stand-in, and its row names the scene. All drawn figures
/// have a row. A reader must not take such a picture for the printed one.
#[test]
fn a_figure_in_a_generated_scene_is_a_stand_in_and_names_the_scene() {
    let scenes = scenes_of_figures();
    let mut drawn = BTreeSet::new();
    for Row { place, here, state } in documents().into_iter().flatten() {
        for figure in figures_named(&here) {
            // A sketch in print is background: its row names the figure that is drawn in its place.
            if state == "background" {
                continue;
            }
            drawn.insert(figure.to_owned());
            assert!(
                state.starts_with("stand-in: "),
                "{place}: figure {figure} is drawn in {:?}: {state}",
                scenes[figure]
            );
            for scene in &scenes[figure] {
                assert!(state.contains(&format!("`{scene}`")), "{place}: figure {figure} is drawn in {scene}: {state}");
            }
        }
        let is_measured = here.contains("ssct time --table") || here.contains("ssct path");
        assert!(
            !is_measured || state.starts_with("stand-in: "),
            "{place}: its numbers are of another machine: {state}"
        );
    }
    let figures = scenes.keys().filter(|name| !name.contains('-') || name.starts_with("poster"));
    // The page names the poster's only figure by its document, "poster-2", and not "2".
    let missing: Vec<_> = figures.filter(|name| !drawn.contains(*name) && *name != "2").collect();
    assert!(missing.is_empty(), "drawn, and in no row: {missing:?}");
}

/// No row in the state "faithful" is about a figure, algorithm, equation or listing that a page of errata lists.
#[test]
fn what_an_erratum_is_about_is_not_called_faithful() {
    let mut errata_count = 0;
    for (rows, folder) in documents().into_iter().zip(["thesis", "poster", "schmidt"]) {
        let page = fs::read_to_string(root().join("shaders-glsl").join(folder).join("ERRATA.md")).unwrap();
        let places = page.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next());
        let errata: BTreeSet<_> = places.flat_map(named).filter(|(kind, _)| kind != "section").collect();
        errata_count += errata.len();
        for Row { place, state, .. } in rows.iter().filter(|r| r.state == "faithful") {
            let wrong: Vec<_> = named(place).intersection(&errata).cloned().collect();
            assert!(wrong.is_empty(), "{place} is {state}, and errata are about {wrong:?}");
        }
    }
    assert!(errata_count > 15, "errata are about {errata_count} figures, algorithms, equations and listings");
}

/// Returns the pieces of text between backquotes on the page.
fn code() -> Vec<String> {
    let page = fs::read_to_string(root().join("docs/coverage.md")).unwrap();
    page.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Each command, option, method, figure and value of a parameter that the page names exists in the command. A renamed
/// option would leave a line on the page that fails when a reader runs it.
#[test]
fn methods_options_and_figures_that_the_page_names_exist() {
    let folder = Folder::new();
    let help: BTreeMap<&str, String> = ["render", "time", "error", "precision", "path", "figures", "view"]
        .map(|command| (command, folder.succeed(&[command, "--help"])))
        .into();
    let refused = folder.run(&["figures", "--only", "none"]);
    let message = String::from_utf8(refused.stderr).unwrap();
    let figures: BTreeSet<&str> = message.split_once("available are: ").unwrap().1.trim().split(", ").collect();
    let rows = parameters();
    let (mut options, mut drawn) = (0, 0);
    for code in code() {
        let words: Vec<&str> = code.split(' ').collect();
        let command = (words[0] == "ssct").then(|| *words.get(1).unwrap_or(&"")).filter(|w| !w.is_empty());
        if let Some(command) = command {
            assert!(help.contains_key(command), "{code}: there is no such command in this test");
        }
        for (n, word) in words.iter().enumerate().filter(|(_, w)| w.starts_with("--")) {
            options += 1;
            let value = words.get(n + 1).filter(|w| !w.starts_with("--"));
            // A switch stands there as `--split [<…>]`.
            let known = |help: &String| help.split([' ', '\n', ',', '[']).any(|w| w == *word);
            let exists = command.map_or_else(|| help.values().any(known), |command| known(&help[command]));
            assert!(exists, "{code}: there is no option {word}");
            match (word.trim_start_matches("--"), value) {
                ("method", Some(names)) => {
                    for name in names.split(',') {
                        let exists = name == "reference" || METHODS.iter().any(|m| m.name == name);
                        assert!(exists, "{code}: there is no method {name}");
                    }
                }
                ("only", Some(numbers)) => {
                    for number in numbers.split(',') {
                        drawn += 1;
                        let is_meant = |f: &&str| number == *f || number.ends_with(&format!("-{f}"));
                        assert!(figures.iter().any(is_meant), "{code}: there is no figure {number}");
                    }
                }
                (name, Some(value)) => {
                    if let Some((row, _)) = rows.iter().find(|(p, _)| p.typed_name() == name) {
                        row.parse(value).unwrap_or_else(|e| panic!("{code}: {e}"));
                    }
                }
                (_, None) => {}
            }
        }
    }
    assert!(options > 40 && drawn > 20, "only {options} options and {drawn} figures are named");
}

/// The README links to the page with words that say what the page is for.
#[test]
fn the_readme_leads_to_the_page_by_what_it_is_for() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.contains("[which file holds which algorithm](docs/coverage.md)"));
}
