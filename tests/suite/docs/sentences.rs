//! Tests that sentences of the pages are short.

use super::{pages, root};
use ssct_docs::pages::outside_code;
use std::fs;

/// The greatest number of words of a sentence.
const MOST_WORDS: usize = 35;

/// Returns a text without the parts between an opening and a closing mark.
fn without(text: &str, [open, close]: [&str; 2]) -> String {
    let (mut kept, mut rest) = (String::new(), text);
    while let Some((before, marked)) = rest.split_once(open) {
        kept.push_str(before);
        rest = marked.split_once(close).map_or("", |(_, after)| after);
    }
    kept + rest
}

/// Returns the paragraphs of a page, and the items of its lists. Code, tables, headings and addresses are left out,
/// since they are no prose.
fn paragraphs(page: &str) -> Vec<String> {
    let page = without(&outside_code(page).join("\n"), ["<!--", "-->"]);
    let mut paragraphs: Vec<String> = Vec::new();
    // Whether the next line goes on with the last paragraph.
    let mut is_open = false;
    for line in page.lines().map(str::trim) {
        let is_number = line.split_once(". ").is_some_and(|(number, _)| number.parse::<u32>().is_ok());
        if line.is_empty() || line.starts_with(['|', '#']) || line.starts_with('[') && line.contains("]: ") {
            is_open = false;
        } else if is_open && !line.starts_with("- ") && !line.starts_with("* ") && !is_number {
            let paragraph = paragraphs.last_mut().unwrap();
            paragraph.push(' ');
            paragraph.push_str(line);
        } else {
            paragraphs.push(line.to_owned());
            is_open = true;
        }
    }
    paragraphs
}

/// Returns the sentences of a paragraph that have too many words. A colon ends a sentence if the next word begins as a
/// sentence does.
fn wordy(paragraph: &str) -> Vec<String> {
    let text = without(paragraph, ["](", ")"]);
    let words: Vec<&str> = text.split_whitespace().collect();
    let begins = |word: &&str| word.starts_with(|c: char| c.is_uppercase() || "`*[(".contains(c));
    let is_end = |n: usize| words[n].ends_with(['.', '!', '?', ':']) && words.get(n + 1).is_none_or(begins);
    let (mut wordy, mut start) = (Vec::new(), 0);
    for n in 0..words.len() {
        if is_end(n) || n + 1 == words.len() {
            let sentence = &words[start..=n];
            let count = sentence.iter().filter(|word| word.contains(char::is_alphanumeric)).count();
            wordy.extend((count > MOST_WORDS).then(|| sentence.join(" ")));
            start = n + 1;
        }
    }
    wordy
}

/// No sentence of a page has more than `MOST_WORDS` words. Sentences grow when facts are added to them.
#[test]
fn sentences_have_few_words() {
    let map = fs::read_to_string(root().join("src/ARCHITECTURE.md")).unwrap();
    let (mut paragraph_count, mut wrong) = (0, Vec::new());
    for (name, text) in pages().into_iter().chain([("src/ARCHITECTURE.md".to_owned(), map)]) {
        for paragraph in paragraphs(&text) {
            paragraph_count += 1;
            wrong.extend(wordy(&paragraph).iter().map(|sentence| format!("{name}: {sentence}")));
        }
    }
    assert!(wrong.is_empty(), "sentences of more than {MOST_WORDS} words:\n{}", wrong.join("\n"));
    assert!(paragraph_count > 900, "only {paragraph_count} paragraphs");
}

/// The count finds a sentence of too many words over a line break, and leaves out headings, addresses of links, code,
/// tables and comments.
#[test]
fn words_are_counted_as_readers_count_them() {
    let thirty = "word ".repeat(30);
    let found = |page: &str| paragraphs(page).iter().flat_map(|paragraph| wordy(paragraph)).count();
    assert_eq!(found(&format!("# Heading\n\n{thirty}one two three four [five](a/b.md)\n")), 0);
    assert_eq!(found(&format!("First.\n\n{thirty}\none two three four five six\n")), 1);
    assert_eq!(found(&format!("{thirty}. A sentence {thirty}.\n- An item: {thirty}")), 0);
    assert_eq!(found(&format!("```\n{thirty}{thirty}\n```\n| {thirty}{thirty} |\n<!-- {thirty}{thirty} -->\n")), 0);
}
