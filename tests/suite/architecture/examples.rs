//! Checks that examples in documentation are run as tests.

use super::{manifest, packages_of_the_map, texts};

/// A package whose documentation has an example that rustdoc can run does not set `doctest = false`. Otherwise nobody
/// would see that the example no longer compiles.
#[test]
fn examples_in_documentation_are_tested() {
    for (name, (folder, _)) in &packages_of_the_map() {
        let doctest = manifest(folder).get("lib").and_then(|lib| lib.get("doctest")?.as_bool());
        let is_tested = doctest != Some(false);
        let found = texts(&[&format!("{folder}/src")], &["rs"]).into_iter().filter(|(_, text)| has_example(text));
        let examples: Vec<_> = found.map(|(path, _)| path).collect();
        assert!(is_tested || examples.is_empty(), "{name} does not run the examples of {examples:?}");
    }
}

/// Returns whether documentation comments have a code block that rustdoc runs: one of no language, or of Rust.
fn has_example(text: &str) -> bool {
    let fences = text.lines().filter_map(|line| {
        let comment = line.trim_start();
        comment.strip_prefix("//!").or_else(|| comment.strip_prefix("///"))?.trim().strip_prefix("```")
    });
    let is_run = |language: &str| {
        language.is_empty()
            || ["rust", "no_run", "compile_fail", "should_panic"].iter().any(|l| language.starts_with(l))
    };
    // Every second fence ends a block.
    fences.step_by(2).any(is_run)
}

/// Blocks without a language, in Rust, or with an attribute of rustdoc count as examples; blocks of text, GLSL, or in
/// plain comments do not.
#[test]
fn a_block_of_another_language_is_no_example() {
    let block = |language: &str| format!("/// ```{language}\n/// a\n/// ```\nfn a() {{}}\n");
    assert!(["", "no_run", "compile_fail,E0308", "rust"].iter().all(|language| has_example(&block(language))));
    assert!(["text", "glsl"].iter().all(|language| !has_example(&block(language))) && !has_example("// ```\n"));
}
