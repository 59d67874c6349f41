//! Checks the statements of an OBJ file and rewrites them into a form that tobj reads reliably.
//!
//! tobj reports no line numbers, accepts numbers that are not finite, loses track of corners that lack a
//! texture coordinate or normal, and fails on short texture coordinates and on vertex colours. It is therefore
//! given a plain file: three numbers per vertex, absolute indices that exist, and, where a corner lacks an
//! attribute, the index of a NaN entry (which no file can contain itself).

use crate::error::{Error, Result};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

/// The name of the material of faces that precede any `usemtl`.
pub(super) const NO_MATERIAL: &str = "default";

/// The most vertices, texture coordinates, normals and triangles that a file may have.
const MAX_COUNT: usize = 1 << 24;

/// The most corners that a face may have. The time to triangulate a concave face grows with the cube of its
/// corners.
const MAX_CORNERS: usize = 1024;

/// A normalised OBJ file, and the information that tobj does not report.
#[derive(Debug)]
pub(super) struct Statements {
    /// The `v`, `vt` and `vn` statements. The first `vt` and the first `vn` are NaN and stand for a missing
    /// attribute.
    pub vertices: String,
    /// The `g`, `usemtl` (by index into `material_names`) and `f` statements.
    pub faces: String,
    /// The names of the materials in the order of their first use.
    pub material_names: Vec<String>,
    /// The file names in `mtllib` statements, with their line numbers.
    pub libraries: Vec<(usize, String)>,
    /// The smoothing group of each face, in file order; 0 is none.
    pub smoothing: Vec<u32>,
}

/// Normalises the text of the file at `path`; errors name that path.
pub(super) fn normalise(path: &Path, text: &str) -> Result<Statements> {
    let mut scan = Scan::new(path);
    for (line, statement) in logical_lines(text) {
        scan.line = line;
        scan.statement(&statement)?;
    }
    scan.finish()
}

/// The lines with their numbers. A line that ends in a backslash is joined with the next, except for statements
/// that end in a name, because a name may end in a backslash.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let mut lines = text.split(separator).enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut statement = Cow::Borrowed(first.trim());
        if matches!(statement.split_whitespace().next(), Some("v" | "vt" | "vn" | "f")) {
            while let Some(head) = statement.strip_suffix('\\') {
                let next = lines.next().map_or("", |(_, l)| l.trim());
                statement = Cow::Owned(format!("{head} {next}"));
            }
        }
        Some((index + 1, statement))
    })
}

/// One of the three lists that faces refer to.
#[derive(Debug, Default)]
struct Counter {
    count: usize,
    /// The highest index that a face uses, and the line where it does.
    highest: (usize, usize),
}

struct Scan<'a> {
    path: &'a Path,
    line: usize,
    out: Statements,
    counters: [Counter; 3],
    triangles: usize,
    smoothing: u32,
    materials: HashMap<String, usize>,
}

const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl<'a> Scan<'a> {
    fn new(path: &'a Path) -> Self {
        let out = Statements {
            vertices: "vt NaN NaN\nvn NaN NaN NaN\n".into(),
            faces: String::from("mtllib all\n"),
            material_names: Vec::new(),
            libraries: Vec::new(),
            smoothing: Vec::new(),
        };
        let (counters, materials) = Default::default();
        Self { path, line: 0, out, counters, triangles: 0, smoothing: 0, materials }
    }

    fn error(&self, message: impl Into<String>) -> Error {
        Error::malformed(self.path, Some(self.line), message)
    }

    fn statement(&mut self, statement: &str) -> Result<()> {
        let (keyword, rest) = statement.split_once(char::is_whitespace).unwrap_or((statement, ""));
        match keyword {
            "v" => self.numbers(0, rest, 3, 3),
            "vt" => self.numbers(1, rest, 1, 2),
            "vn" => self.numbers(2, rest, 3, 3),
            "f" | "fo" => self.face(rest),
            "g" | "o" => {
                // Writing to a String cannot fail.
                let _ = writeln!(self.out.faces, "g {}", rest.trim());
                Ok(())
            }
            "s" => {
                self.smoothing = rest.trim().parse().unwrap_or(0);
                Ok(())
            }
            "usemtl" => {
                self.use_material(rest.trim());
                Ok(())
            }
            "mtllib" => {
                self.out.libraries.push((self.line, rest.trim().to_owned()));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Reads a vertex, texture coordinate or normal: it must have at least `needed` numbers, and `kept` of them
    /// are kept, with 0 for missing ones. Further numbers (weights, colours) are ignored.
    fn numbers(&mut self, kind: usize, rest: &str, needed: usize, kept: usize) -> Result<()> {
        let mut words = rest.split_whitespace();
        self.out.vertices.push_str(["v", "vt", "vn"][kind]);
        for i in 0..kept {
            let word = match words.next() {
                Some(word) => word,
                None if i >= needed => "0",
                None => {
                    return Err(self.error(format!("a {} ends after {i} numbers; it needs {needed}", KINDS[kind])));
                }
            };
            match word.parse::<f32>() {
                Ok(number) if number.is_finite() => {}
                Ok(_) => {
                    return Err(self.error(format!("{word:?} in a {} is not finite", KINDS[kind])));
                }
                Err(_) => {
                    return Err(self.error(format!("{word:?} in a {} is not a number", KINDS[kind])));
                }
            }
            self.out.vertices.push(' ');
            self.out.vertices.push_str(word);
        }
        self.out.vertices.push('\n');
        self.counters[kind].count += 1;
        if self.counters[kind].count > MAX_COUNT {
            return Err(self.error(format!("there are more than {MAX_COUNT} {} statements", KINDS[kind])));
        }
        Ok(())
    }

    fn face(&mut self, rest: &str) -> Result<()> {
        if self.out.material_names.is_empty() {
            self.use_material(NO_MATERIAL);
        }
        let mut face = String::with_capacity(rest.len() + 16);
        let mut corners = 0;
        for word in rest.split_whitespace().take_while(|w| !w.starts_with('#')) {
            let [v, vt, vn] = self.corner(word)?;
            // Texture coordinates and normals are numbered after the NaN entry that stands for a missing one.
            let _ = write!(face, " {v}/{}/{}", vt + 1, vn + 1);
            corners += 1;
        }
        if corners == 0 {
            return Err(self.error("a face has no corners"));
        }
        if corners > MAX_CORNERS {
            return Err(self.error(format!("a face has {corners} corners, more than {MAX_CORNERS}")));
        }
        if corners < 3 {
            return Ok(());
        }
        self.triangles += corners - 2;
        if self.triangles > MAX_COUNT {
            return Err(self.error(format!("there are more than {MAX_COUNT} triangles")));
        }
        self.out.faces.push('f');
        self.out.faces.push_str(&face);
        self.out.faces.push('\n');
        self.out.smoothing.push(self.smoothing);
        Ok(())
    }

    /// The absolute indices of a corner, counted from 1; 0 for a missing texture coordinate or normal.
    fn corner(&mut self, word: &str) -> Result<[usize; 3]> {
        let mut indices = [0; 3];
        for (kind, index) in word.split('/').enumerate() {
            if kind > 2 || (kind == 0 && index.is_empty()) {
                return Err(self.error(format!("{word:?} in a face is not of the form v/vt/vn")));
            }
            if index.is_empty() {
                continue;
            }
            let Ok(stated) = index.parse::<i64>() else {
                return Err(self.error(format!("{word:?} in a face is not of the form v/vt/vn")));
            };
            let count = self.counters[kind].count;
            let absolute = if stated < 0 { stated.saturating_add(count as i64 + 1) } else { stated };
            if absolute < 1 || absolute as u64 > MAX_COUNT as u64 {
                return Err(self.out_of_range(kind, stated, count));
            }
            indices[kind] = absolute as usize;
            if indices[kind] > self.counters[kind].highest.0 {
                self.counters[kind].highest = (indices[kind], self.line);
            }
        }
        Ok(indices)
    }

    fn out_of_range(&self, kind: usize, stated: i64, count: usize) -> Error {
        let name = KINDS[kind];
        self.error(format!("a face refers to {name} {stated}, but there are {count}"))
    }

    fn use_material(&mut self, name: &str) {
        let name = if name.is_empty() { NO_MATERIAL } else { name };
        let names = &mut self.out.material_names;
        let index = *self.materials.entry(name.to_owned()).or_insert_with(|| {
            names.push(name.to_owned());
            names.len() - 1
        });
        let _ = writeln!(self.out.faces, "usemtl {index}");
    }

    fn finish(mut self) -> Result<Statements> {
        for kind in 0..3 {
            let Counter { count, highest: (index, line) } = self.counters[kind];
            if index > count {
                self.line = line;
                return Err(self.out_of_range(kind, index as i64, count));
            }
        }
        if self.out.smoothing.is_empty() {
            return Err(Error::malformed(self.path, None, "there are no faces in this file"));
        }
        Ok(self.out)
    }
}
