//! Comments and names that a stranger understands. A comment begins with its subject or with what its item does: beginnings that
//! point at something else ("The same", "Those", "Of") are kept out of code, shaders and tests. A variable has a noun for its name. A
//! sentence of the pages has few words.

use crate::common::repository;
use proc_macro2::{TokenStream, TokenTree};
use std::path::{Path, PathBuf};

/// Folders and files with comments.
const PLACES: &[&str] =
    &["benches", "build.rs", "c", "examples", "fuzz", "lab", "scripts", "shaders-glsl", "src", "tests"];

/// Folders in them with what nobody wrote.
const SKIPPED: &[&str] = &["target", "corpus", "runs", "golden"];

/// Files of these kinds have comments after slashes.
const EXTENSIONS: &[&str] = &["rs", "c", "h", "glsl", "frag", "vert", "comp"];

/// Beginnings that leave open what a comment is about.
const UNCLEAR: &[&str] = &["What of ", "Of ", "Those ", "That of ", "As ", "The same", "What there ", "Whether there "];

/// Pages whose sentences are short, and folders of pages.
const PAGES: &[&str] = &["CONTRIBUTING.md", "README.md", "SECURITY.md", "docs", "src/ARCHITECTURE.md"];

/// Words that a sentence has at most.
const MOST_WORDS: usize = 35;

/// Words that no variable is called: they say nothing of what it is.
const NO_NAMES: [&str; 2] = ["of", "at"];

/// Words of Rust before which a name is that of a variable.
const BEFORE_A_VARIABLE: [&str; 12] =
    ["else", "for", "if", "in", "let", "match", "move", "mut", "ref", "return", "unsafe", "while"];

/// The text of the comment on a line, and whether code stands before it.
fn comment(line: &str) -> Option<(&str, bool)> {
    let offset = line.find("//")?;
    let (before, marked) = line.split_at(offset);
    // Two slashes in a string or in an address are no comment.
    let is_code = before.contains('"') || before.ends_with(':');
    (!is_code).then(|| (marked.trim_start_matches(['/', '!']).trim(), !before.trim().is_empty()))
}

/// The lines on which a comment, or a paragraph of one, begins in an unclear way, counted from 1.
fn unclear(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    let mut goes_on = false;
    for (n, line) in text.lines().enumerate() {
        let Some((said, is_behind_code)) = comment(line) else {
            goes_on = false;
            continue;
        };
        if (!goes_on || is_behind_code) && UNCLEAR.iter().any(|words| said.starts_with(words)) {
            found.push(n + 1);
        }
        goes_on = !said.is_empty() && !said.starts_with('#');
    }
    found
}

fn add(path: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    if path.is_dir() {
        if path.file_name().is_some_and(|name| SKIPPED.iter().any(|skipped| name == *skipped)) {
            return;
        }
        for entry in std::fs::read_dir(path).unwrap() {
            add(&entry.unwrap().path(), extensions, found);
        }
    } else if path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted)) {
        found.push(path.to_owned());
    }
}

/// A page without what stands between two marks; its lines keep their numbers.
fn without(page: &str, [open, close]: [&str; 2]) -> String {
    let (mut kept, mut rest) = (String::new(), page);
    while let Some((before, marked)) = rest.split_once(open) {
        let (inside, after) = marked.split_once(close).unwrap_or((marked, ""));
        kept.push_str(before);
        kept.extend(inside.matches('\n'));
        rest = after;
    }
    kept + rest
}

/// The paragraphs and the items of lists of a page, with their lines counted from 1. Code, tables, headings and addresses are no prose.
fn paragraphs(page: &str) -> Vec<(usize, String)> {
    let page = without(&without(page, ["```", "```"]), ["<!--", "-->"]);
    let mut all: Vec<(usize, String)> = Vec::new();
    let mut is_open = false;
    for (n, line) in page.lines().enumerate() {
        let text = line.trim();
        let is_number = text.split_once(". ").is_some_and(|(number, _)| number.parse::<u32>().is_ok());
        if text.is_empty() || text.starts_with(['|', '#']) || text.starts_with('[') && text.contains("]: ") {
            is_open = false;
        } else if is_open && !text.starts_with("- ") && !text.starts_with("* ") && !is_number {
            let (_, paragraph) = all.last_mut().unwrap();
            paragraph.push(' ');
            paragraph.push_str(text);
        } else {
            all.push((n + 1, text.to_owned()));
            is_open = true;
        }
    }
    all
}

/// The numbers of words of a paragraph's sentences. A colon ends one if what follows it begins as a sentence does.
fn lengths(paragraph: &str) -> Vec<usize> {
    let text = without(paragraph, ["](", ")"]);
    let words: Vec<&str> = text.split_whitespace().collect();
    let (mut all, mut count) = (Vec::new(), 0);
    for (n, word) in words.iter().enumerate() {
        count += usize::from(word.contains(char::is_alphanumeric));
        let begins = |next: &&str| next.starts_with(|c: char| c.is_uppercase() || "`*[(".contains(c));
        if word.ends_with(['.', '!', '?', ':']) && words.get(n + 1).is_none_or(begins) {
            all.push(std::mem::take(&mut count));
        }
    }
    all.push(count);
    all
}

/// The lines of the paragraphs of a page that have too long a sentence.
fn wordy(page: &str) -> Vec<usize> {
    let is_wordy = |(_, paragraph): &(usize, String)| lengths(paragraph).iter().any(|words| *words > MOST_WORDS);
    paragraphs(page).into_iter().filter(is_wordy).map(|(line, _)| line).collect()
}

/// The lines of Rust on which a variable has one of the names. Methods may have them, and so may the words of a macro, which follow
/// another word.
fn variables(tokens: TokenStream, found: &mut Vec<usize>) {
    let mut before: Option<TokenTree> = None;
    for token in tokens {
        match &token {
            TokenTree::Group(group) => variables(group.stream(), found),
            TokenTree::Ident(name) if NO_NAMES.iter().any(|word| name == word) => {
                let is_variable = match &before {
                    Some(TokenTree::Ident(word)) => BEFORE_A_VARIABLE.iter().any(|keyword| word == keyword),
                    Some(TokenTree::Punct(mark)) => !['.', ':', '@'].contains(&mark.as_char()),
                    _ => true,
                };
                found.extend(is_variable.then(|| name.span().start().line));
            }
            TokenTree::Literal(text) => {
                let text = text.to_string();
                let is_captured =
                    |word: &str| text.contains(&format!("{{{word}}}")) || text.contains(&format!("{{{word}:"));
                found.extend(NO_NAMES.iter().any(|word| is_captured(word)).then(|| token.span().start().line));
            }
            _ => {}
        }
        before = Some(token);
    }
}

/// The lines of a shader, or of C, on which one of the names stands outside comments.
fn names_in_shader(text: &str) -> Vec<usize> {
    let code = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
    let is_name = |word: &str| NO_NAMES.contains(&word);
    let has_name = |line: &str| code(line).split(|c: char| !c.is_alphanumeric() && c != '_').any(is_name);
    text.lines().enumerate().filter(|(_, line)| !line.starts_with('#') && has_name(line)).map(|(n, _)| n + 1).collect()
}

/// Fails with the places that a check finds in files, if it finds any.
fn check(what: &str, (places, extensions): (&[&str], &[&str]), lines: impl Fn(&Path, &str) -> Vec<usize>) {
    let mut files = Vec::new();
    places.iter().for_each(|place| add(&repository().join(place), extensions, &mut files));
    assert!(files.len() > 20, "only {} files", files.len());
    let mut wrong = Vec::new();
    for path in files {
        let name = path.strip_prefix(repository()).unwrap().to_string_lossy().replace('\\', "/");
        let text = std::fs::read_to_string(&path).unwrap();
        wrong.extend(lines(&path, &text).iter().map(|line| format!("{name}:{line}")));
    }
    assert!(wrong.is_empty(), "{what}:\n{}", wrong.join("\n"));
}

#[test]
fn comments_begin_with_their_subject() {
    check(&format!("comments begin with {UNCLEAR:?}"), (PLACES, EXTENSIONS), |_, text| unclear(text));
}

#[test]
fn sentences_have_few_words() {
    check(&format!("sentences of more than {MOST_WORDS} words"), (PAGES, &["md"]), |_, text| wordy(text));
}

#[test]
fn words_are_counted_as_readers_count_them() {
    let thirty = "word ".repeat(30);
    assert_eq!(wordy(&format!("# Heading\n\n{thirty}one two three four [five](a/b.md)\n")), [0; 0]);
    assert_eq!(wordy(&format!("First.\n\n{thirty}\none two three four five six\n")), [3]);
    assert_eq!(wordy(&format!("{thirty}. A sentence {thirty}.\n- An item: {thirty}")), [0; 0]);
    assert_eq!(
        wordy(&format!("```\n{thirty}{thirty}\n```\n| {thirty}{thirty} |\n<!-- {thirty}{thirty} -->\n")),
        [0; 0]
    );
}

#[test]
fn variables_have_nouns_for_names() {
    let what = format!("variables are called {NO_NAMES:?}");
    check(&what, (PLACES, EXTENSIONS), |path, text| match path.extension().and_then(|e| e.to_str()) {
        Some("rs") => {
            let mut found = Vec::new();
            variables(text.parse().unwrap_or_else(|e| panic!("{}: {e}", path.display())), &mut found);
            found
        }
        Some("glsl" | "frag" | "vert" | "comp") => names_in_shader(text),
        _ => Vec::new(),
    });
}

#[test]
fn variables_are_told_from_methods_and_words_of_macros() {
    for (text, lines) in [
        ("let of = 1;", &[1][..]),
        ("fn show(\n  at: Vec2) {}", &[2]),
        ("all.map(|of| of + 1)", &[1, 1]),
        ("let Some(at) = x.find('a') else { return };", &[1]),
        ("Share::of(ray.at(0.5))", &[]),
        ("fn of(self) -> u32 { 1 }", &[]),
        ("reading! { Constants of reading, whole }", &[]),
        // The braces are apart, so that this file has no such text itself.
        (concat!("println!(\"{", "at:?} of all\")"), &[1]),
        ("// let of = 1;\nlet name = \"of\";", &[]),
    ] {
        let mut found = Vec::new();
        variables(text.parse().unwrap(), &mut found);
        assert_eq!(found, lines, "{text}");
    }
    assert_eq!(names_in_shader("#include \"at.glsl\"\nivec2 at = p; // of it\nint state = look(at);\n"), [2, 3]);
}

#[test]
fn beginnings_are_told_from_continuations() {
    for (text, lines) in [
        ("/// Those of the device.", &[1][..]),
        ("/// # Errors\n/// Those of the device.", &[2]),
        ("//! Draws an image.\n//!\n//! The same without sky.", &[3]),
        ("const A: i32 = 1; // As it is.", &[1]),
        ("// The value is kept.\n// Of course it may change.", &[]),
        ("let a = \"// Of strings\";", &[]),
        ("/// Offset in bytes.\n// Assumed thickness.", &[]),
    ] {
        assert_eq!(unclear(text), lines, "{text}");
    }
}
