//! Tests of the language of queries, on records of a few lines.

use crate::queries::Queries;
use std::fs;
use std::path::PathBuf;

const QUERIES: &str = r#"
["over $method $other"]
from = "a.csv"
answer = "{ratio(median(over(ms, $method, $other)))}"

["twice $method $other"]
from = "twice.csv"
answer = "{ratio(median(over(ms, $method, $other)))}"

[table]
rows = ["method: distinct [a.csv:] method"]
from = "a.csv"
where = "method=$method"
when = "some()"
columns = [["method", "`$method`"], ["$view", "{or(fixed([view=$view] ms, 1), \"–\")}", "view: x; y"]]

[empty]
rows = ["each [a.csv: method=none]"]
columns = [["method", "$method"]]

[grouped]
from = "a.csv"
answer = "{range(greatest_by(method, ms), 0)} of {count()}, {sum(ms * holds(view=x))}"

[frames]
from = "b.json#frames"
answer = "{mean([method=a] frames.ms)} in {text(size)}"

[screen]
from = "c.csv"
answer = "{median(rmse)}"
"#;

/// Makes a repository with these queries and a run with records; the name of a run begins with its day. Returns the
/// temporary folder of the repository, its queries, and the folders of records.
fn repository(run: &str) -> (tempfile::TempDir, Queries, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    write("lab/docs/queries/all.toml", QUERIES);
    write("lab/docs/queries/words.toml", "'over(x, a, b)' = '[method=$a] $x / [method=$b] $x'");
    write(&format!("{run}/a.csv"), "method,view,ms\na,x,1\na,y,3\nb,y,2\nb,x,4\nc,x,5\n");
    write(
        &format!("{run}/b.json"),
        r#"[{"method": "a", "width": 4, "height": 3, "frames": [{"ms": 1.5}, {"ms": 2.5}]}]"#,
    );
    write(&format!("{run}/twice.csv"), "method,view,ms\na,x,1\na,y,3\nb,x,2\nb,x,4\n");
    write(&format!("{run}/c.csv"), "against,rmse\nscreen,1\n");
    let queries = Queries::read(folder.path()).unwrap();
    let folders = vec![folder.path().join(run)];
    (folder, queries, folders)
}

#[test]
fn an_answer_matches_groups_and_counts_the_rows_of_records() {
    let (_folder, queries, run) = repository("runs/2026-11-30-lavapipe");
    let says = |query: &str| queries.answer(query, &run);
    // Rows are matched by their views, in whatever order they stand.
    assert_eq!(says("over a b").unwrap(), "0.88");
    assert_eq!(says("grouped").unwrap(), "3 to 5 of 5, 10");
    assert_eq!(says("frames").unwrap(), "2 in 4x3");
    let table = "\n| method | x | y |\n|---|---|---|\n| `a` | 1.0 | 3.0 |\n| `b` | 4.0 | 2.0 |\n| `c` | 5.0 | – |\n\n";
    assert!(says("table").unwrap().starts_with(table));
    assert_eq!(says("screen").unwrap(), "1");
}

#[test]
fn a_query_for_which_records_are_missing_or_too_old_is_an_error() {
    let (_folder, queries, run) = repository("runs/2026-11-27-lavapipe");
    for (query, words) in [
        ("over a c", "has no other beside it"),
        // Two rows of b are both in the view x, so that the row of a in the view y is compared with none.
        ("twice b a", "the record of y has no other beside it"),
        ("over a none", "none of 0 records has ms"),
        ("empty", "the table would be empty"),
        ("screen", "is against an older reference"),
        ("unknown", "nothing is called \"unknown\""),
    ] {
        let said = queries.answer(query, &run).unwrap_err();
        assert!(said.contains(words), "{query}: {said}");
    }
}
