//! Makes the page that sets each printed step of the documents beside the lines of the shaders that follow it
//! (`docs/listings.md`).
//!
//! The page is made from marks in the shaders. `// Print: §4.2.7, Alg. 4.` names a printed item: a listing, an
//! algorithm or an equation. A comment that begins with numbers of printed lines, as `// 8, 9: …` or `// 10-13: …`,
//! begins a step. The code below the comment follows these lines, up to the next mark, a blank line or the end of a
//! function. Comments that begin with "Erratum" or "Departure" stand between print and code.

use crate::pages::{read_page, renew_quotations};
use crate::queries::Queries;
use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// A part of the page, or a sentence about why there is none.
type Result<T> = std::result::Result<T, String>;

/// A printed item: its name in the marks, and its number of lines.
type Item = (&'static str, u32);

/// For each document: its title, the folder of its shaders, and its printed items.
const DOCUMENTS: &[(&str, &str, &[Item])] = &[
    (
        "Hermanns 2015, the thesis",
        "thesis",
        &[
            ("§4.2.2, first listing", 17),
            ("§4.2.2, second listing", 54),
            ("§4.2.2, Alg. 2", 17),
            ("§4.2.4, Alg. 3", 7),
            ("§4.2.5, Eq. 4.2", 1),
            ("§4.2.5, listing", 26),
            ("§4.2.7, Eq. 4.4", 2),
            ("§4.2.7, Alg. 4", 12),
            ("§4.2.7, listing", 49),
            ("§4.2.8, Eq. 4.5", 3),
            ("§4.2.8, Eq. 4.6", 2),
            ("§4.2.8, Alg. 5", 12),
            ("§4.2.9, Eq. 4.7", 4),
            ("§4.2.10, Alg. 6", 5),
            ("§4.3.2, listing", 8),
            ("§4.3.3, listing", 10),
        ],
    ),
    ("Hermanns and Franke 2014, the poster", "poster", &[("Technical Approach", 10)]),
    (
        "Schmidt 2013",
        "schmidt",
        &[
            ("listing 1", 23),
            ("listing 2", 53),
            ("listing 3", 43),
            ("§5.4.1, Eq. 28", 1),
            ("listing 4", 93),
            ("listing 5", 81),
        ],
    ),
];

/// A shader: its path, and its steps, each with the name of the printed item that it belongs to.
type Shader = (String, Vec<(String, Step)>);

/// A step of a shader.
#[derive(Debug, Default, PartialEq)]
struct Step {
    /// The printed lines that the step follows.
    lines: Vec<RangeInclusive<u32>>,
    /// The words of the print at these lines.
    print: String,
    /// The errata and departures.
    differs: Vec<String>,
    /// The lines of code.
    code: Vec<String>,
}

/// Reads a comment such as `8, 9-11: words`. Returns the printed lines at its beginning, and the words after them;
/// `None` for any other comment.
fn parse_mark(comment: &str) -> Option<(Vec<RangeInclusive<u32>>, &str)> {
    let (lines, words) = comment.split_once(": ")?;
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    Some((lines.split(", ").map(range).collect::<Option<_>>()?, words))
}

/// Reads the steps of a shader from the marks in its text. Returns each step with the name of the printed item that it
/// belongs to.
fn read_steps(shader: &str) -> Vec<(String, Step)> {
    let mut reader = StepReader::default();
    shader.lines().for_each(|line| reader.read_line(line));
    reader.end_step();
    reader.steps
}

/// Reads the steps of a shader line by line.
#[derive(Default)]
struct StepReader {
    /// The steps that are read to their ends, each with the name of its printed item.
    steps: Vec<(String, Step)>,
    /// The printed item that the last mark named.
    item: Option<String>,
    /// The step that is being read.
    open: Option<Step>,
    /// The text of the step that the next line of the same comment continues.
    continued: Continued,
}

/// A text of a step that goes on in the next line of a comment.
#[derive(Default)]
enum Continued {
    #[default]
    Nothing,
    Print,
    Differences,
}

impl StepReader {
    /// Reads the next line of the shader.
    fn read_line(&mut self, line: &str) {
        let comment = line.trim_start().strip_prefix("// ");
        let in_item = comment.filter(|_| self.item.is_some());
        let is_difference = |c: &&str| ["Departure", "Erratum", "Errata"].iter().any(|word| c.starts_with(word));
        if let Some(item) = comment.and_then(|c| c.strip_prefix("Print: ")) {
            self.end_step();
            self.item = Some(item.trim_end_matches('.').to_owned());
        } else if let Some((lines, words)) = in_item.and_then(parse_mark) {
            self.end_step();
            self.open = Some(Step { lines, print: words.to_owned(), ..Step::default() });
            self.continued = Continued::Print;
        } else if let Some(difference) = in_item.filter(is_difference) {
            self.open.get_or_insert_default().differs.push(difference.to_owned());
            self.continued = Continued::Differences;
        } else if let (Some(words), Some(text)) = (comment, self.continued_text()) {
            *text += &format!(" {words}");
        } else if line.trim().is_empty() {
            self.end_step();
            self.continued = Continued::Nothing;
        } else if let Some(step) = &mut self.open {
            step.code.push(line.to_owned());
            self.continued = Continued::Nothing;
            if line == "}" {
                self.end_step();
            }
        }
    }

    /// The text that a further line of the same comment continues.
    fn continued_text(&mut self) -> Option<&mut String> {
        let step = self.open.as_mut()?;
        match self.continued {
            Continued::Nothing => None,
            Continued::Print => Some(&mut step.print),
            Continued::Differences => step.differs.last_mut(),
        }
    }

    /// Ends the step that is being read, if there is one.
    fn end_step(&mut self) {
        if let (Some(step), Some(item)) = (self.open.take(), &self.item) {
            self.steps.push((item.clone(), step));
        }
    }
}

/// Returns the shaders of a folder that have steps, in the order of their names.
fn shaders_with_steps(root: &Path, folder: &str) -> Result<Vec<Shader>> {
    let folder = format!("shaders-glsl/{folder}");
    let entries = fs::read_dir(root.join(&folder)).map_err(|e| format!("{folder}: {e}"))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    paths.retain(|path| !path.ends_with("ERRATA.md"));
    paths.sort();
    let mut shaders = Vec::new();
    for path in paths {
        let name = format!("{folder}/{}", path.file_name().unwrap_or_default().to_string_lossy());
        let steps = read_steps(&read_page(root, &name)?);
        if !steps.is_empty() {
            shaders.push((name, steps));
        }
    }
    Ok(shaders)
}

/// Returns the rows about a printed item, such as "§4.2.7, Alg. 4", from the text of the page of the thesis's errata.
/// Their links are made right for a page in `docs/`. A row about "both listings" of a section is about each of them.
fn errata_rows(page: &str, item: &str) -> Vec<String> {
    let (section, name) = item.split_once(", ").unwrap_or((item, ""));
    let is_about_item = |place: &str| {
        let mut parts = place.split(", ");
        let is_of_both_listings = name.ends_with("listing") && place.ends_with("both listings");
        parts.next() == Some(section) && (is_of_both_listings || parts.any(|part| part == name))
    };
    let link = |text: String| text.replace("](../../docs/", "](").replace("](../", "](../shaders-glsl/");
    let row = |line: &str| {
        let (place, rest) = line.strip_prefix("| ")?.split_once(" | ")?;
        is_about_item(place).then(|| link(format!("| {}\n", without_comments(rest))))
    };
    page.lines().filter_map(row).collect()
}

/// Returns a text without its HTML comments, which are the marks of quotations.
fn without_comments(text: &str) -> String {
    let mut parts = text.split("<!-- ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + part.split_once("-->").map_or("", |(_, after)| after))
}

/// The greatest number of columns of a comment line.
const COLUMNS: usize = 140;

/// Returns a text as lines of a GLSL comment, each with the indentation before it.
fn glsl_comment(text: &str, indentation: &str) -> String {
    let mut lines = vec![format!("{indentation}//")];
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= COLUMNS => *line += &format!(" {word}"),
            _ => lines.push(format!("{indentation}// {word}")),
        }
    }
    lines.join("\n") + "\n"
}

/// Returns the text of a step on the page: a comment with the printed lines and their words, a comment for each
/// departure or erratum, and the code. The first `margin` bytes of each line of code are left out.
fn step_text(step: &Step, margin: usize) -> String {
    let code: Vec<&str> = step.code.iter().map(|line| &line[margin..]).collect();
    let indentation: String = code.first().map_or("", |line| line).chars().take_while(|c| *c == ' ').collect();
    let range = |r: &RangeInclusive<u32>| match (r.start(), r.end()) {
        (a, b) if a == b => a.to_string(),
        (a, b) => format!("{a} to {b}"),
    };
    let lines: Vec<String> = step.lines.iter().map(range).collect();
    let print = match lines.is_empty() {
        true => "not printed".to_owned(),
        false => format!("[{}] {}", lines.join(", "), step.print),
    };
    let comments = [&print].into_iter().chain(&step.differs).map(|text| glsl_comment(text, &indentation));
    comments.chain(code.iter().map(|line| format!("{line}\n"))).collect()
}

/// Returns the section of the page about a printed item: its steps in the order of the printed lines, and its errata.
fn section(item: &str, shaders: &[Shader], errata: &[String]) -> String {
    let mut files: Vec<String> = Vec::new();
    let mut steps: Vec<&Step> = Vec::new();
    for (file, all_steps) in shaders {
        let item_steps: Vec<&Step> = all_steps.iter().filter(|(name, _)| name == item).map(|(_, step)| step).collect();
        if !item_steps.is_empty() {
            files.push(format!("`{file}`"));
            steps.extend(item_steps);
        }
    }
    let code = steps.iter().flat_map(|step| &step.code);
    let margin = code.map(|line| line.len() - line.trim_start().len()).min().unwrap_or(0);
    // Steps are ordered by their first printed line. A step without printed lines stays after the one before it.
    let mut last = 0;
    let mut keyed: Vec<(u32, &Step)> = Vec::new();
    for step in steps {
        last = step.lines.first().map_or(last, |range| *range.start());
        keyed.push((last, step));
    }
    keyed.sort_by_key(|(line, _)| *line);
    let steps: String = keyed.iter().map(|(_, step)| step_text(step, margin)).collect();
    let mut text = format!("### {item}\n\nIn {}.\n\n```glsl\n{steps}```\n\n", files.join(", "));
    if !errata.is_empty() {
        text += &format!("| kind | printed | here | effect |\n|---|---|---|---|\n{}\n", errata.concat());
    }
    text
}

/// Refuses marks that name no known printed item, and items with printed lines that no mark names. Of a listing up to
/// two lines in a row may lack a mark, since listings have blank lines.
fn check_marks(folder: &str, items: &[Item], shaders: &[Shader]) -> Result<()> {
    let all_steps: Vec<&(String, Step)> = shaders.iter().flat_map(|(_, steps)| steps).collect();
    if let Some((name, _)) = all_steps.iter().find(|(name, _)| !items.iter().any(|(item, _)| item == name)) {
        return Err(format!("shaders-glsl/{folder}: {name} is not known to be printed"));
    }
    for (item, count) in items {
        let steps = all_steps.iter().filter(|(name, _)| name == item);
        let mut lines: Vec<u32> = steps.flat_map(|(_, step)| step.lines.iter().cloned().flatten()).collect();
        lines.sort_unstable();
        lines.dedup();
        let most_apart = if item.contains("listing") { 3 } else { 1 };
        let is_whole = lines.windows(2).all(|pair| pair[1] - pair[0] <= most_apart);
        if !is_whole || lines.first().zip(lines.last()) != Some((&1, count)) {
            return Err(format!("shaders-glsl/{folder}: marks of {item} lack some of its {count} lines: {lines:?}"));
        }
    }
    Ok(())
}

/// The text above the sections of the documents.
const HEAD: &str = "# Print and shader, step by step\n\nThis page sets each step of the printed listings, algorithms and equations \
    beside the lines of the shaders that follow it. A comment with numbers in brackets names the printed lines that the code below it \
    follows, and says what the print has there, often shortened. The comments behind it say what differs. Below each item of the \
    thesis stand the rows of its [errata](../shaders-glsl/thesis/ERRATA.md); those of the others are \
    [here](../shaders-glsl/schmidt/ERRATA.md) and [here](../shaders-glsl/poster/ERRATA.md). The poster has no listing: its numbers \
    count the steps of its text. The page is made from marks in the shaders (`make docs`).\n\n";

/// Returns the text of `docs/listings.md`: for each document, a section for each of its printed items.
pub(crate) fn page(queries: &Queries, root: &Path) -> Result<String> {
    let mut page = HEAD.to_owned();
    for (title, folder, items) in DOCUMENTS {
        let name = format!("shaders-glsl/{folder}/ERRATA.md");
        let shaders = shaders_with_steps(root, folder)?;
        check_marks(folder, items, &shaders)?;
        page += &format!("## {title}\n\n");
        let errata = match *folder {
            "thesis" => renew_quotations(queries, root, &name, &read_page(root, &name)?)?,
            _ => String::new(),
        };
        page += &items.iter().map(|(item, _)| section(item, &shaders, &errata_rows(&errata, item))).collect::<String>();
    }
    Ok(format!("{}\n", page.trim_end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_has_the_lines_the_words_and_the_code_of_its_mark() {
        let shader = "// Print: Alg. 1.\n// 1, 2: begin\n// and more\nvoid f() {\n    // 3-5: loop\n    // Departure: none\n    \
            // at all.\n    for (;;);\n\n    // Departure: alone.\n    g();\n}\nint unmarked;\n";
        let found = read_steps(shader);
        let [(item, begin), (_, looped), (_, unprinted)] = &found[..] else { panic!("{found:?}") };
        assert_eq!((item.as_str(), begin.print.as_str()), ("Alg. 1", "begin and more"));
        assert_eq!((&begin.lines[..], &begin.code[..]), (&[1..=1, 2..=2][..], &["void f() {".to_owned()][..]));
        let departure = ["Departure: none at all.".to_owned()];
        assert_eq!((&looped.lines[..], &looped.differs[..]), (&[3..=5][..], &departure[..]));
        assert_eq!((&unprinted.lines[..], unprinted.code.len()), (&[][..], 2));
        assert_eq!(parse_mark("Eq. 4.4: direction"), None);
        assert_eq!(step_text(looped, 0), "    // [3 to 5] loop\n    // Departure: none at all.\n    for (;;);\n");
    }
}
