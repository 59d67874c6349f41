//! Tests that strangers can understand comments and names. A comment begins with its subject or with the action of its
//! item, so that beginnings which point at something else ("The same", "Those", "Of") are refused in code, shaders and
//! tests. Variables and functions have nouns or verbs for names.

use crate::common::sources::{GLSL, texts};
use proc_macro2::{TokenStream, TokenTree};

/// Folders and files with comments.
const PLACES: &[&str] =
    &["benches", "build.rs", "c", "examples", "fuzz", "lab", "scripts", "shaders-glsl", "src", "tests"];

/// The extensions of files whose comments follow slashes.
const EXTENSIONS: &[&str] = &["rs", "c", "h", "glsl", "frag", "vert", "comp"];

/// Beginnings that leave open what a comment is about.
const UNCLEAR: &[&str] = &["What of ", "Of ", "Those ", "That of ", "As ", "The same", "What there ", "Whether there "];

/// Words that may not name a variable or a function, since they say nothing about it.
const NO_NAMES: [&str; 2] = ["of", "at"];

/// Words of Rust after which a name is that of a variable or a function.
const BEFORE_A_NAME: [&str; 13] =
    ["else", "fn", "for", "if", "in", "let", "match", "move", "mut", "ref", "return", "unsafe", "while"];

/// Returns the text of the comment on a line, and whether code stands before the comment.
fn comment(line: &str) -> Option<(&str, bool)> {
    let offset = line.find("//")?;
    let (before, marked) = line.split_at(offset);
    // Two slashes in a string or in an address are no comment.
    let is_code = before.contains('"') || before.ends_with(':');
    (!is_code).then(|| (marked.trim_start_matches(['/', '!']).trim(), !before.trim().is_empty()))
}

/// Returns the lines on which a comment, or a paragraph of one, begins in an unclear way, counted from 1.
fn unclear(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    let mut is_in_paragraph = false;
    for (n, line) in text.lines().enumerate() {
        let Some((words_of_comment, is_behind_code)) = comment(line) else {
            is_in_paragraph = false;
            continue;
        };
        if (!is_in_paragraph || is_behind_code) && UNCLEAR.iter().any(|words| words_of_comment.starts_with(words)) {
            found.push(n + 1);
        }
        is_in_paragraph = !words_of_comment.is_empty() && !words_of_comment.starts_with('#');
    }
    found
}

/// Adds to `found` the lines of Rust on which a variable or a function has one of the names in `NO_NAMES`. Calls are
/// left out, since functions of other crates may have such names, and so are words of macros, which follow another
/// word.
fn named(tokens: TokenStream, found: &mut Vec<usize>) {
    let mut before: Option<TokenTree> = None;
    for token in tokens {
        match &token {
            TokenTree::Group(group) => named(group.stream(), found),
            TokenTree::Ident(name) if NO_NAMES.iter().any(|word| name == word) => {
                let is_name = match &before {
                    Some(TokenTree::Ident(word)) => BEFORE_A_NAME.iter().any(|keyword| word == keyword),
                    Some(TokenTree::Punct(mark)) => !['.', ':', '@'].contains(&mark.as_char()),
                    _ => true,
                };
                found.extend(is_name.then(|| name.span().start().line));
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

/// Returns the lines of a shader on which one of the names occurs outside comments.
fn names_in_shader(text: &str) -> Vec<usize> {
    let code = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
    let is_name = |word: &str| NO_NAMES.contains(&word);
    let has_name = |line: &str| code(line).split(|c: char| !c.is_alphanumeric() && c != '_').any(is_name);
    text.lines().enumerate().filter(|(_, line)| !line.starts_with('#') && has_name(line)).map(|(n, _)| n + 1).collect()
}

/// Fails with the places that `lines` finds in files of some kinds, if it finds any. `what` says what is wrong with
/// them.
fn check(what: &str, extensions: &[&str], lines: impl Fn(&str) -> Vec<usize>) {
    let files = texts(PLACES, extensions);
    assert!(files.len() > 100, "only {} files", files.len());
    let places =
        |(name, text): &(String, String)| lines(text).iter().map(|line| format!("{name}:{line}")).collect::<Vec<_>>();
    let wrong: Vec<String> = files.iter().flat_map(places).collect();
    assert!(wrong.is_empty(), "{what}:\n{}", wrong.join("\n"));
}

/// No comment in the repository begins with one of the words in `UNCLEAR`. A comment is often read alone, beside its
/// item.
#[test]
fn comments_begin_with_their_subject() {
    check(&format!("comments begin with {UNCLEAR:?}"), EXTENSIONS, unclear);
}

/// No variable and no function of Rust or GLSL is called by a word of `NO_NAMES`.
#[test]
fn variables_and_functions_have_names_that_say_something() {
    let what = format!("variables or functions are called {NO_NAMES:?}");
    check(&what, &["rs"], |text| {
        let mut found = Vec::new();
        named(text.parse().unwrap(), &mut found);
        found
    });
    check(&what, &GLSL, names_in_shader);
}

/// Examples of Rust give the lines on which a name is found: declarations and captured arguments count; paths, strings,
/// comments and words of macros do not. The test above relies on this.
#[test]
fn names_are_told_from_words_of_macros() {
    for (text, lines) in [
        ("let of = 1;", &[1][..]),
        ("fn show(\n  at: Vec2) {}", &[2]),
        ("all.map(|of| of + 1)", &[1, 1]),
        ("let Some(at) = x.find('a') else { return };", &[1]),
        ("TypeId::of(ray.at(0.5))", &[]),
        ("fn of(self) -> u32 { 1 }", &[1]),
        ("reading! { Constants of reading, whole }", &[]),
        // The braces are apart, so that this file has no such text itself.
        (concat!("println!(\"{", "at:?} of all\")"), &[1]),
        ("// let of = 1;\nlet name = \"of\";", &[]),
    ] {
        let mut found = Vec::new();
        named(text.parse().unwrap(), &mut found);
        assert_eq!(found, lines, "{text}");
    }
    assert_eq!(names_in_shader("#include \"at.glsl\"\nivec2 at = p; // of it\nint state = look(at);\n"), [2, 3]);
}
