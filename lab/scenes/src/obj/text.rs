//! Checks the statements of an OBJ file and rewrites them into a form that tobj reads reliably.
//!
//! The crate tobj reports no line numbers, and accepts numbers that are not finite. It confuses corners that lack a
//! texture coordinate or normal, and fails on short texture coordinates and on vertex colours. tobj therefore gets a
//! plain text: three numbers per vertex, absolute indices that exist, and, where a corner lacks an attribute, the index
//! of a NaN entry. No file can contain such an entry itself, since numbers that are not finite are replaced.

use crate::far_away::far_origin;
use glam::DVec3;
use ssct_geometry::bounded::printable_name;
use ssct_ground::{Error, Result};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;
use std::path::Path;

/// The name of the material of faces that precede any `usemtl`.
pub(super) const NO_MATERIAL: &str = "default";

/// Greatest number of vertices, texture coordinates, normals and triangles that a file may have.
const MAX_COUNT: usize = 1 << 24;

/// Greatest number of corners that a face may have. The time to triangulate a concave face grows with the square of its
/// corners.
const MAX_CORNERS: usize = 1024;

/// A normalised OBJ file, and the information that tobj does not report.
#[derive(Debug)]
pub(super) struct Statements {
    /// The `v`, `vt` and `vn` statements. The first `vt` and the first `vn` are NaN and stand for a missing attribute.
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

/// The numbers that a first reading of a file finds, and that a second reading needs.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FirstReading {
    /// Upper bounds of the numbers of vertices, texture coordinates and normals.
    counts: [usize; 3],
    /// Offset that is subtracted from every vertex, in units of the file.
    origin: DVec3,
}

/// Normalises the text of the file at `path`; errors and warnings name that path. `origin`, in units of the file, is
/// subtracted from every vertex. If `origin` is `None`, it becomes the centre of the vertices if these are too far from
/// the file's origin for their size, else zero. `scale` is the number of metres in a unit of the file.
///
/// The text is read a second time if the vertices must be moved, or if faces refer to texture coordinates or normals
/// that are not there.
pub(super) fn normalise(
    path: &Path,
    text: &str,
    origin: &mut Option<DVec3>,
    scale: f32,
    warnings: &mut Vec<String>,
) -> Result<Statements> {
    let read_text = |first_reading: FirstReading| {
        let mut scan = Scan::new(path, first_reading);
        for (line, statement) in logical_lines(text) {
            scan.line = line;
            scan.read_statement(&statement)?;
        }
        Ok(scan)
    };
    let mut first_reading = FirstReading { counts: [usize::MAX; 3], origin: origin.unwrap_or(DVec3::ZERO) };
    let mut scan = read_text(first_reading)?;
    let scale = f64::from(scale);
    let far = far_origin(scan.bounds.map(|corner| corner * scale)).filter(|_| origin.is_none());
    if let Some(far) = &far {
        warnings.push(format!("{}: {}", path.display(), far.sentence()));
        first_reading.origin = far.centre / scale;
    }
    *origin = Some(first_reading.origin);
    if far.is_some() || scan.refers_to_missing_attributes() {
        first_reading.counts = scan.counters.each_ref().map(|counter| counter.count);
        scan = read_text(first_reading)?;
    }
    scan.finish(warnings)
}

/// Returns the lines with their numbers, from 1 on. A line that ends in a backslash is joined with the next one. This
/// is done only for statements of numbers, since a name may end in a backslash.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let separator = if text.contains('\n') { '\n' } else { '\r' };
    let mut lines = text.split(separator).enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut statement = Cow::Borrowed(first.trim());
        let keyword = statement.split_whitespace().next().unwrap_or("");
        if ["v", "vt", "vn", "f", "fo"].iter().any(|name| keyword.eq_ignore_ascii_case(name)) {
            while let Some(head) = statement.strip_suffix('\\') {
                let next = lines.next().map_or("", |(_, line)| line.trim());
                statement = Cow::Owned(format!("{head} {next}"));
            }
        }
        Some((index + 1, statement))
    })
}

/// The counts of one of the three lists that faces refer to: vertices, texture coordinates and normals.
#[derive(Debug, Default)]
struct Counter {
    /// Number of entries so far.
    count: usize,
    /// The highest index that a face uses.
    highest: usize,
    /// The line of the face that uses the highest index.
    highest_line: usize,
}

/// One reading of a file, statement by statement.
struct Scan<'a> {
    path: &'a Path,
    first_reading: FirstReading,
    /// The line of the current statement.
    line: usize,
    output: Statements,
    counters: [Counter; 3],
    /// The least and the greatest coordinates of the vertices, as written in the file.
    bounds: [DVec3; 2],
    /// Number of triangles of all faces so far.
    triangles: usize,
    /// The current smoothing group; 0 is none.
    smoothing: u32,
    /// The index of each material in the order of first use, by its name.
    materials: HashMap<String, usize>,
    /// Warnings about dropped or replaced statements: one for each kind, with the line of the first.
    dropped: BTreeMap<&'static str, usize>,
}

/// The names, in messages, of an entry of each of the three lists that faces refer to, in the order of the counters.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Statements of free-form curves and surfaces, which have no corners.
const FREE_FORM: [&str; 21] = [
    "vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "end", "con",
    "bzp", "bsp", "cdc", "cdp", "res", "mg",
];

/// Statements that tell other programs how to draw, which are ignored without a warning.
const DRAWING_HINTS: [&str; 8] = ["bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "ctech", "stech"];

impl<'a> Scan<'a> {
    /// Makes a reading before its first statement. Its output begins with the NaN entries.
    fn new(path: &'a Path, first_reading: FirstReading) -> Self {
        let output = Statements {
            vertices: "vt NaN NaN\nvn NaN NaN NaN\n".into(),
            faces: String::from("mtllib all\n"),
            material_names: Vec::new(),
            libraries: Vec::new(),
            smoothing: Vec::new(),
        };
        let (counters, materials, dropped) = Default::default();
        let bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        Self { path, first_reading, line: 0, output, counters, bounds, triangles: 0, smoothing: 0, materials, dropped }
    }

    /// Makes an error at the current line.
    fn error(&self, message: impl Into<String>) -> Error {
        Error::malformed(self.path, Some(self.line), message)
    }

    /// Notes a warning about a dropped statement, unless the file has the same warning already.
    fn note_dropped(&mut self, sentence: &'static str) {
        let line = self.line;
        self.dropped.entry(sentence).or_insert(line);
    }

    /// Reads one statement, and adds it in plain form to the output.
    fn read_statement(&mut self, statement: &str) -> Result<()> {
        let (keyword, arguments) = statement.split_once(char::is_whitespace).unwrap_or((statement, ""));
        let keyword = keyword.to_ascii_lowercase();
        match keyword.as_str() {
            // The index into `KINDS`, and the least and the greatest count of the numbers that are read.
            "v" => self.read_numbers(0, arguments, 3, 3)?,
            "vt" => self.read_numbers(1, arguments, 1, 2)?,
            "vn" => self.read_numbers(2, arguments, 3, 3)?,
            "f" | "fo" => self.read_face(arguments)?,
            "g" | "o" => {
                // Writing to a String cannot fail.
                let _ = writeln!(self.output.faces, "g {}", arguments.trim());
            }
            "s" => self.smoothing = smoothing_group(arguments),
            "usemtl" => self.use_material(arguments.trim()),
            "mtllib" => self.output.libraries.push((self.line, arguments.trim().to_owned())),
            "l" | "p" => self.note_dropped("lines and points are not drawn"),
            "call" => self.note_dropped("files that the statement call names are not read"),
            "usemap" | "maplib" => self.note_dropped("usemap and maplib are not supported and were ignored"),
            _ if keyword.is_empty() || keyword.starts_with('#') || DRAWING_HINTS.contains(&keyword.as_str()) => {}
            _ if FREE_FORM.contains(&keyword.as_str()) => {
                self.note_dropped("curves and free-form surfaces are not supported and were left out");
            }
            _ => self.note_dropped("a statement is unknown and was ignored"),
        }
        Ok(())
    }

    /// Reads a vertex, texture coordinate or normal; `kind` is an index into [`KINDS`]. The statement must have at
    /// least `needed` numbers. The first `used` numbers are read, and missing ones become 0. Further numbers (weights,
    /// colours) are ignored.
    fn read_numbers(&mut self, kind: usize, arguments: &str, needed: usize, used: usize) -> Result<()> {
        let mut words = arguments.split_whitespace().take_while(|word| !word.starts_with('#'));
        let mut stated = ["0"; 3];
        let mut numbers = [0.0_f64; 3];
        for i in 0..used {
            match words.next() {
                Some(word) => stated[i] = word,
                None if i >= needed => break,
                None => {
                    return Err(self.error(format!("a {} ends after {i} numbers; it needs {needed}", KINDS[kind])));
                }
            }
            numbers[i] = stated_number(stated[i]).ok_or_else(|| {
                self.error(format!("{:?} in a {} is not a number", printable_name(stated[i]), KINDS[kind]))
            })?;
        }
        if kind == 0 && words.count() >= 3 {
            self.note_dropped("colours of vertices are not supported and were ignored");
        }
        let is_finite = |number: &f64| (*number as f32).is_finite();
        match numbers.iter().position(|number| !is_finite(number)) {
            // A vertex needs all of its three numbers, but texture coordinates and normals can be replaced.
            Some(index) if kind == 0 => {
                let message = format!(
                    "the position of a vertex is not a number: {:?} is not finite",
                    printable_name(stated[index])
                );
                return Err(self.error(message));
            }
            Some(_) => {
                stated = ["0"; 3];
                self.note_dropped(match kind {
                    1 => "texture coordinates that are not finite count as 0",
                    _ => "normals that are not finite were made from the faces",
                });
            }
            None => {}
        }
        self.write_numbers(kind, &stated[..used], DVec3::from(numbers));
        self.counters[kind].count += 1;
        if self.counters[kind].count > MAX_COUNT {
            return Err(self.error(format!("there are more than {MAX_COUNT} {} statements", KINDS[kind])));
        }
        Ok(())
    }

    /// Writes a statement with its numbers as stated; `kind` is an index into [`KINDS`]. A vertex also widens the
    /// bounds. If the scene is moved, the origin is subtracted from the vertex, whose values are `numbers`.
    fn write_numbers(&mut self, kind: usize, stated: &[&str], numbers: DVec3) {
        self.output.vertices.push_str(["v", "vt", "vn"][kind]);
        if kind == 0 {
            self.bounds = [self.bounds[0].min(numbers), self.bounds[1].max(numbers)];
        }
        if kind == 0 && self.first_reading.origin != DVec3::ZERO {
            let DVec3 { x, y, z } = numbers - self.first_reading.origin;
            // Writing to a String cannot fail.
            let _ = write!(self.output.vertices, " {} {} {}", x as f32, y as f32, z as f32);
        } else {
            for word in stated {
                self.output.vertices.push(' ');
                self.output.vertices.push_str(word);
            }
        }
        self.output.vertices.push('\n');
    }

    /// Reads a face, and writes it with absolute indices. A face of one or two corners is dropped.
    fn read_face(&mut self, arguments: &str) -> Result<()> {
        if self.output.material_names.is_empty() {
            self.use_material(NO_MATERIAL);
        }
        let mut face = String::with_capacity(arguments.len() + 16);
        let mut corners = 0;
        for word in arguments.split_whitespace().take_while(|word| !word.starts_with('#')) {
            let [v, vt, vn] = self.corner(word)?;
            // The NaN entry, which stands for a missing attribute, has the number 1, so that all others move by one.
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
        self.output.faces.push('f');
        self.output.faces.push_str(&face);
        self.output.faces.push('\n');
        self.output.smoothing.push(self.smoothing);
        Ok(())
    }

    /// Returns the absolute indices of a corner's vertex, texture coordinate and normal, counted from 1; 0 for a
    /// missing texture coordinate or normal. `word` is the corner as the file writes it, such as `1/2/3`.
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
            let greatest = if kind == 0 { MAX_COUNT } else { self.first_reading.counts[kind] };
            if absolute < 1 || absolute as u64 > MAX_COUNT.min(greatest) as u64 {
                if kind == 0 {
                    return Err(self.out_of_range(kind, stated, count));
                }
                self.note_dropped(match kind {
                    1 => "a face refers to texture coordinates that are not there; they count as 0",
                    _ => "a face refers to normals that are not there; they were made from the faces",
                });
                continue;
            }
            indices[kind] = absolute as usize;
            let counter = &mut self.counters[kind];
            if indices[kind] > counter.highest {
                (counter.highest, counter.highest_line) = (indices[kind], self.line);
            }
        }
        Ok(indices)
    }

    /// Makes the error about a face that states the index `stated` in a list of only `count` entries; `kind` is an
    /// index into [`KINDS`].
    fn out_of_range(&self, kind: usize, stated: i64, count: usize) -> Error {
        let name = KINDS[kind];
        self.error(format!("a face refers to {name} {stated}, but there are {count}"))
    }

    /// Makes a material the current one; an empty name stands for [`NO_MATERIAL`].
    fn use_material(&mut self, name: &str) {
        let name = if name.is_empty() { NO_MATERIAL } else { name };
        let names = &mut self.output.material_names;
        let index = *self.materials.entry(name.to_owned()).or_insert_with(|| {
            names.push(name.to_owned());
            names.len() - 1
        });
        let _ = writeln!(self.output.faces, "usemtl {index}");
    }

    /// Returns true if faces refer to texture coordinates or normals that the file lacks.
    fn refers_to_missing_attributes(&self) -> bool {
        self.counters[1..].iter().any(|counter| counter.highest > counter.count)
    }

    /// Ends the reading: refuses a face with a vertex that the file lacks, and a file without faces. Adds the warnings,
    /// and returns the statements in plain form.
    fn finish(mut self, warnings: &mut Vec<String>) -> Result<Statements> {
        let Counter { count, highest, highest_line } = self.counters[0];
        if highest > count {
            self.line = highest_line;
            return Err(self.out_of_range(0, highest as i64, count));
        }
        // `smoothing` has an entry for each face.
        if self.output.smoothing.is_empty() {
            return Err(Error::malformed(self.path, None, "there are no faces in this file"));
        }
        let place = self.path.display();
        warnings.extend(self.dropped.iter().map(|(sentence, line)| format!("{place}:{line}: {sentence}")));
        Ok(self.output)
    }
}

/// Returns the smoothing group that a statement sets; 0 is none, as for `off` and `null`. Only the first word counts,
/// since a comment may follow it. Some programs write `on`, which names no group, and counts as group 1.
fn smoothing_group(arguments: &str) -> u32 {
    match arguments.split_whitespace().next() {
        Some(word) if word.eq_ignore_ascii_case("on") => 1,
        Some(word) => word.parse().unwrap_or(0),
        None => 0,
    }
}

/// Returns the number that a word states, which need not be finite; `None` if the word is no number. The result is NaN
/// for words such as `-1.#IND` and `1.#INF`, by which Windows prints numbers that are not finite.
pub(super) fn stated_number(word: &str) -> Option<f64> {
    let number = word.parse().ok();
    number.or_else(|| {
        let word = word.to_ascii_lowercase();
        let is_not_finite = ["#ind", "#qnan", "#snan", "#inf", "nan(", "-nan"].iter().any(|mark| word.contains(mark));
        is_not_finite.then_some(f64::NAN)
    })
}
