//! Reads and writes files of camera paths (TOML), and reads the sections of scene files that have a path.

use super::obj::Handedness;
use super::source_text::{MAX_FILE_BYTES, stem};
use crate::source_text::{self, SourceText};
use serde::Deserialize;
use ssct_ground::{Error, Result};
use std::fmt::Write;
use std::path::Path;
use toml::Spanned;

pub use ssct_ground::scene::path::{CameraPath, KeyFrame, VIEWS};

/// Reads a path file. It has an optional `name`, the handedness of its `coordinates` (`"right"`, the default, or
/// `"left"`), and `[[key]]` tables with `eye`, `look_at` and, in all of them or in none, `time` in seconds.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; [`Error::Malformed`], with file and line, if its content is wrong.
pub fn load(path: &Path) -> Result<CameraPath> {
    parse(&source_text::read(path, "a path file", MAX_FILE_BYTES)?, path)
}

/// Parses the text of a path file. Errors name the file by `path`.
///
/// # Errors
/// [`Error::Malformed`] with file and line.
pub fn parse(text: &str, path: &Path) -> Result<CameraPath> {
    let source = SourceText { path, text };
    let file: PathFile = source.deserialized()?;
    source.camera_path(&file.name.unwrap_or_else(|| stem(path)), &file.key, 1.0, file.coordinates)
}

/// Returns the text of a path file, in right-handed coordinates, which are also the default of scene files.
pub fn to_toml(path: &CameraPath) -> String {
    let mut text = format!("name = {}\ncoordinates = \"right\"\n", toml::Value::from(path.name.as_str()));
    for key in path.keys() {
        let points = [key.eye, key.look_at].map(|point| Handedness::Right.mirrored(point));
        let [eye, look_at] = points.map(|point| format!("[{:?}, {:?}, {:?}]", point.x, point.y, point.z));
        // Writing to a String cannot fail.
        let _ = write!(text, "\n[[key]]\neye = {eye}\nlook_at = {look_at}\n");
        if let Some(time) = key.time_s {
            let _ = writeln!(text, "time = {time:?}");
        }
    }
    text
}

/// The contents of a path file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PathFile {
    name: Option<String>,
    #[serde(default)]
    coordinates: Handedness,
    #[serde(default)]
    key: Vec<Spanned<KeySection>>,
}

/// The section of a path in a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathSection {
    #[serde(default)]
    pub(super) key: Vec<Spanned<KeySection>>,
}

/// A key frame as the file states it; `time` is in seconds.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeySection {
    eye: Spanned<[f32; 3]>,
    look_at: Spanned<[f32; 3]>,
    time: Option<f32>,
}

impl SourceText<'_> {
    /// Makes a camera path from the key frames of a file, whose points are in `coordinates` and are multiplied by
    /// `extra_scale`. Errors name the line of the faulty key frame.
    pub(super) fn camera_path(
        &self,
        name: &str,
        sections: &[Spanned<KeySection>],
        extra_scale: f32,
        coordinates: Handedness,
    ) -> Result<CameraPath> {
        let key = |section: &Spanned<KeySection>| {
            let KeySection { eye, look_at, time } = section.get_ref();
            let [eye, look_at] = [self.vector("eye", eye)?, self.vector("look_at", look_at)?]
                .map(|point| coordinates.mirrored(point) * extra_scale);
            Ok(KeyFrame { eye, look_at, time_s: *time })
        };
        let keys = sections.iter().map(key).collect::<Result<Vec<_>>>()?;
        CameraPath::through_keys(name, keys).map_err(|(index, message)| {
            match index.and_then(|index| sections.get(index)) {
                Some(section) => self.error(section.span(), message),
                None => Error::malformed(self.path, None, format!("path {name}: {message}")),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Makes a key frame that looks along +z.
    fn key(eye: [f32; 3], time_s: Option<f32>) -> KeyFrame {
        let eye = Vec3::from(eye);
        KeyFrame { eye, look_at: eye + Vec3::Z, time_s }
    }

    #[test]
    fn a_written_file_reads_back_equal() {
        let keys = vec![key([0.1, -2.0, 1e-7], Some(0.0)), key([1.0, 2.0, 3.0], Some(1.5))];
        for keys in [keys.clone(), keys.into_iter().map(|key| KeyFrame { time_s: None, ..key }).collect()] {
            let path = CameraPath::new("a \"walk\"", keys).expect("a path");
            let file = tempfile::Builder::new().suffix(".toml").tempfile().expect("a file");
            std::fs::write(file.path(), to_toml(&path)).expect("written");
            assert_eq!(load(file.path()).expect("read"), path);
        }
    }

    #[test]
    fn places_are_right_handed_unless_a_file_says_otherwise() {
        let keys = "[[key]]\neye = [0, 0, 1]\nlook_at = [0, 0, 2]\n[[key]]\neye = [0, 0, 2]\nlook_at = [0, 0, 3]\n";
        let first_z = |text: &str| parse(text, Path::new("a.toml")).expect("a path").keys()[0].eye.z;
        let z_of_first_eyes =
            ["", "coordinates = \"right\"\n", "coordinates = \"left\"\n"].map(|line| first_z(&format!("{line}{keys}")));
        assert_eq!(z_of_first_eyes, [-1.0, -1.0, 1.0]);
    }

    #[test]
    fn errors_name_the_line() {
        let table = "[[key]]\neye = [0, 0, 0]\nlook_at = [0, 0, 1]\n";
        let cases = [
            ("", "at least two key frames, not 0"),
            (table, "not 1"),
            ("[[key]]\neye = [0, 0]\n", ":2: "),
            (&format!("{table}[[key]]\neye = [1, 0, 0]\nlook_at = [1, 0, 0]\n"), ":4: it looks at its own eye"),
            (&format!("{table}[[key]]\neye = [1, nan, 0]\nlook_at = [1, 0, 0]\n"), ":5: eye must have three finite"),
            (&format!("{table}{table}"), ":4: it repeats"),
            (&format!("{table}[[key]]\neye = [1, 0, 0]\nlook_at = [1, 0, 1]\ntime = 1.0\n"), ":4: either every"),
            (&format!("{table}time = 1\n[[key]]\neye = [1, 0, 0]\nlook_at = [1, 0, 1]\ntime = 1\n"), ":5: its time"),
            (&format!("{table}speed = 3\n"), ":4: unknown field"),
        ];
        for (text, expected) in cases {
            let file = tempfile::Builder::new().suffix(".toml").tempfile().expect("a file");
            std::fs::write(file.path(), text).expect("written");
            let message = load(file.path()).expect_err(text).to_string();
            assert!(message.contains(expected), "{message}\n{text}");
        }
    }
}
