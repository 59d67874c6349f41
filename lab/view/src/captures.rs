//! The captures that the user has moved, added or removed, and the file that they are saved in.

use glam::Vec3;
use ssct_lab::error::{Error, Result};
use ssct_lab::report::files;
use ssct_scenes::capture::MAX_CAPTURES;
use ssct_scenes::{Capture, scene_file};
use std::path::Path;

/// The list of captures while it is edited.
#[derive(Debug)]
pub struct CaptureEditor {
    /// The captures that replace the scene's; `None` as long as nothing was changed.
    pub list: Option<Vec<Capture>>,
    /// The selected capture, counted from 0.
    pub selected: usize,
    /// The file in which the captures are saved: a scene file, or a file of captures alone.
    pub file: String,
    /// A message about the last change or save.
    pub message: String,
    /// The factor by which the scene was enlarged when it was loaded.
    scale: f32,
}

impl CaptureEditor {
    /// Makes an editor for a scene that was loaded from some files and enlarged by `scale`. The first file is that of
    /// the captures if it is a scene file.
    pub fn new(sources: &[std::path::PathBuf], scale: f32) -> Self {
        let is_file = |p: &&std::path::PathBuf| p.extension().is_some_and(|e| e == "toml");
        let file = sources.first().filter(is_file).map_or("captures.toml".into(), |p| p.display().to_string());
        Self { list: None, selected: 0, file, message: String::new(), scale }
    }

    /// Adds a capture at a place and selects it. If nothing was changed before, the list begins with the captures
    /// `shown`, which the window shows.
    pub fn add(&mut self, shown: &[Capture], place: Vec3) {
        let list = self.list.get_or_insert_with(|| shown.to_vec());
        if list.len() == MAX_CAPTURES {
            self.message = format!("a scene has at most {MAX_CAPTURES} captures");
            return;
        }
        let template = list.first().copied().unwrap_or(Capture::placed_at(place));
        list.push(Capture { position: place, ..template });
        self.selected = list.len() - 1;
        self.message = format!("capture {} added", list.len());
    }

    /// Moves the selected capture to a place; `shown` is as in [`Self::add`].
    pub fn put(&mut self, shown: &[Capture], place: Vec3) {
        let list = self.list.get_or_insert_with(|| shown.to_vec());
        self.message = match list.get_mut(self.selected) {
            Some(capture) => {
                capture.position = place;
                format!("capture {} moved", self.selected + 1)
            }
            None => "there is no capture to move".to_owned(),
        };
    }

    /// Removes the selected capture; `shown` is as in [`Self::add`]. If no capture is left, captures are placed as for
    /// a scene file without any.
    pub fn remove(&mut self, shown: &[Capture]) {
        let list = self.list.get_or_insert_with(|| shown.to_vec());
        if self.selected >= list.len() {
            self.message = "there is no capture to remove".to_owned();
            return;
        }
        list.remove(self.selected);
        self.message = format!("capture {} removed", self.selected + 1);
        if list.is_empty() {
            self.message += "; without any, they are placed automatically";
        }
        self.selected = self.selected.min(list.len().saturating_sub(1));
    }

    /// Drops all changes, so that the scene's captures are used again.
    pub fn forget(&mut self) {
        (self.list, self.selected) = (None, 0);
        self.message = "the captures of the scene".to_owned();
    }

    /// Writes the captures of the list, or those that are shown if nothing was changed, into the file. Everything else
    /// in an existing file stays as it is.
    pub fn save(&mut self, shown: &[Capture]) {
        let captures = self.list.as_deref().unwrap_or(shown);
        self.message = match self.write_file(captures) {
            Ok(()) => format!("{} captures saved in {}", captures.len(), self.file),
            Err(e) => e.to_string(),
        };
    }

    /// Writes captures to the file, in the units that the scene had before it was enlarged.
    fn write_file(&self, captures: &[Capture]) -> Result<()> {
        let path = Path::new(&self.file);
        let old_text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(e) => return Err(Error::io("read", path, e)),
        };
        let unscaled = |c: &Capture| Capture { position: c.position / self.scale, near_m: c.near_m / self.scale, ..*c };
        let captures: Vec<Capture> = captures.iter().map(unscaled).collect();
        Ok(files::write(path, scene_file::with_captures(&old_text, &captures, path)?.as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn captures_are_added_moved_removed_and_saved_beside_what_a_file_has() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("room.scene.toml");
        let kept_text = "# A room.\nscale = 2.0\n\n[[mesh]]\nfile = 'room.obj'\n\n";
        let replaced_text = "[[capture]] # old\nplace = [9, 9, 9]\n\n";
        std::fs::write(&path, format!("{kept_text}{replaced_text}[view.hall]\neye = [0, 1, 0]\nlook_at = [1, 1, 0]\n"))
            .unwrap();
        let mut editor = CaptureEditor::new(std::slice::from_ref(&path), 0.5);
        let shown = [Capture { resolution: 64, ..Capture::placed_at(Vec3::ONE) }];
        editor.add(&shown, Vec3::X);
        editor.add(&shown, Vec3::Y);
        editor.put(&shown, Vec3::Z);
        editor.selected = 0;
        editor.remove(&shown);
        let places: Vec<Vec3> = editor.list.as_ref().unwrap().iter().map(|c| c.position).collect();
        assert_eq!((places, editor.selected), (vec![Vec3::X, Vec3::Z], 0));
        editor.save(&shown);
        assert!(editor.message.starts_with("2 captures saved in "), "{}", editor.message);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with(kept_text) && text.contains("[view.hall]") && !text.contains("9, 9, 9"), "{text}");
        let table: toml::Table = toml::from_str(&text).unwrap();
        let saved = table["capture"].as_array().unwrap();
        assert_eq!(saved.len(), 2);
        // The scene was halved when it was loaded, and its file is right-handed.
        assert_eq!(saved[1]["place"].as_array().unwrap()[2].as_float(), Some(-2.0));
        assert_eq!(saved[1]["resolution"].as_integer(), Some(64));
        for _ in 0..MAX_CAPTURES {
            editor.add(&shown, Vec3::ONE);
        }
        assert_eq!((editor.list.as_ref().unwrap().len(), &editor.message[..]), (8, "a scene has at most 8 captures"));
        editor.forget();
        assert!(editor.list.is_none());
    }

    #[test]
    fn a_file_that_cannot_take_captures_stays_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        let mut editor = CaptureEditor::new(std::slice::from_ref(&path), 1.0);
        for (text, message) in
            [("capture = [{ place = [0, 0, 0] }]\n", "other tables than [[capture]]"), ("no toml at all", "expected")]
        {
            std::fs::write(&path, text).unwrap();
            editor.save(&[Capture::placed_at(Vec3::ZERO)]);
            assert!(editor.message.contains(message) && editor.message.contains("a.toml"), "{}", editor.message);
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
        std::fs::remove_file(&path).unwrap();
        editor.save(&[Capture::placed_at(Vec3::ZERO)]);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), Capture::placed_at(Vec3::ZERO).to_toml());
    }
}
