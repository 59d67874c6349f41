//! Finds the texts of the repository that people write.

use super::repository;
use std::path::{Path, PathBuf};

/// The file extensions of shaders.
pub const GLSL: [&str; 4] = ["glsl", "vert", "frag", "comp"];

/// The names of folders whose files are made by programs.
const SKIPPED: [&str; 4] = ["target", "corpus", "runs", "golden"];

/// Returns the path, from the repository's root, and the text of each file that has one of the extensions. `places` are
/// the files and folders of the repository in which they are looked for; folders of made files are left out.
pub fn texts(places: &[&str], extensions: &[&str]) -> Vec<(String, String)> {
    let is_wanted = |path: &Path| path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted));
    let is_skipped = |path: &Path| path.file_name().is_some_and(|name| SKIPPED.iter().any(|skipped| name == *skipped));
    let mut to_visit: Vec<PathBuf> = places.iter().map(|place| repository().join(place)).collect();
    let mut found = Vec::new();
    while let Some(path) = to_visit.pop() {
        if path.is_dir() {
            let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
            to_visit.extend(entries.filter(|entry| !is_skipped(entry)));
        } else if is_wanted(&path) {
            let name = path.strip_prefix(repository()).unwrap().to_string_lossy().replace('\\', "/");
            found.push((name, std::fs::read_to_string(&path).unwrap()));
        }
    }
    found
}
