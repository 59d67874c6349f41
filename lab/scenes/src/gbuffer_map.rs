//! Maps of G-buffers: a TOML file says which channels of which files hold depth, normals and so on, and in which
//! conventions. The files of any renderer can therefore be read unchanged. docs/gbuffer-maps.md describes the format
//! with all keys.
//!
//! [`GBufferMap::parse`] checks a map without reading any frame; an error has the line of the mistake.
//! [`GBufferMap::read`] then reads frames. The submodules find files and channels (`files`, `source`), make the camera
//! (`camera`, `axes`, `numbers`), and convert the channels to this program's conventions (`depth`, `normals`,
//! `surface`); `keys` takes the keys of a section. [`GBufferMap::check`] tests whether the parts of a G-buffer that was
//! read agree (`check`, `agreement`, `readings`).

mod agreement;
mod axes;
mod camera;
mod check;
mod depth;
mod files;
mod keys;
mod normals;
mod numbers;
mod readings;
mod source;
mod surface;

use super::{GBufferData, Surface};
use crate::source_text::{self, SourceText};
use axes::MapConventions;
use camera::MapCamera;
use check::MapPosition;
pub use check::disagreement;
use depth::MapDepth;
use files::{Arrangement, MapFiles};
use glam::DVec2;
use keys::{MapKeys, MapSection};
use normals::MapNormals;
use serde::Deserialize;
use ssct_ground::{Error, Result};
use std::path::{Path, PathBuf};
use surface::{MapColour, MapReflectivity, MapRoughness, MapSky};

/// The largest map, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// A map that was checked, from which frames can be read.
#[derive(Debug, Clone)]
pub struct GBufferMap {
    path: PathBuf,
    /// True if the first row of the files is the lowest row of the image.
    bottom_up: bool,
    /// The view to read from files with several views, such as one of two eyes.
    view: Option<String>,
    conventions: MapConventions,
    camera: MapCamera,
    depth: MapDepth,
    normals: MapNormals,
    roughness: MapRoughness,
    reflectivity: MapReflectivity,
    color: Vec<MapColour>,
    sky: Option<MapSky>,
    position: Option<MapPosition>,
}

/// The sections of a map, whose keys are not checked yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Sections {
    #[serde(default)]
    origin: MapOrigin,
    view: Option<String>,
    conventions: Option<MapSection>,
    camera: Option<MapSection>,
    depth: Option<MapSection>,
    normal: Option<MapSection>,
    roughness: Option<MapSection>,
    reflectivity: Option<MapSection>,
    metallic: Option<MapSection>,
    base_color: Option<MapSection>,
    f0: Option<MapSection>,
    #[serde(default)]
    color: Vec<MapSection>,
    sky: Option<MapSection>,
    position: Option<MapSection>,
}

/// The place of the files' first row: top or bottom.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum MapOrigin {
    #[default]
    TopLeft,
    BottomLeft,
}

impl GBufferMap {
    /// Reads and checks a map.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; [`Error::Malformed`] if it is larger than 1 MiB or not UTF-8 text, and
    /// the errors of [`Self::parse`].
    pub fn load(path: &Path) -> Result<Self> {
        Self::parse(&source_text::read(path, "a map of a G-buffer", MAX_BYTES)?, path)
    }

    /// Reads the text of a map, and checks it. Errors name the file by `path`.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line of the mistake: wrong syntax, an unknown or missing section or key, or a
    /// value that its key cannot have.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let text = SourceText { path, text };
        let mut sections: Sections = toml::from_str(text.text).map_err(|e| match text.syntax_error(&e) {
            // [[color]] is the only section that is a list.
            Error::Malformed { path, line, message } if message.contains("expected a sequence") => {
                Error::Malformed { path, line, message: format!("colours are listed as [[color]] ({message})") }
            }
            other => other,
        })?;
        if sections.color.is_empty() {
            return Err(Error::malformed(path, None, "there is no [[color]]"));
        }
        let reflectivity = take_reflectivity(&text, &mut sections)?;
        let color =
            sections.color.into_iter().map(|section| MapColour::take(MapKeys::new(&text, "[[color]]", section)));
        let map = Self {
            path: path.to_owned(),
            bottom_up: sections.origin == MapOrigin::BottomLeft,
            view: sections.view,
            conventions: MapConventions::take(MapKeys::or_empty(&text, "[conventions]", sections.conventions))?,
            camera: MapCamera::take(required_keys(&text, "[camera]", sections.camera)?)?,
            depth: MapDepth::take(required_keys(&text, "[depth]", sections.depth)?)?,
            normals: MapNormals::take(required_keys(&text, "[normal]", sections.normal)?)?,
            roughness: MapRoughness::take(required_keys(&text, "[roughness]", sections.roughness)?)?,
            reflectivity,
            color: color.collect::<Result<_>>()?,
            sky: sections.sky.map(|sky| MapSky::take(MapKeys::new(&text, "[sky]", sky))).transpose()?,
            position: sections
                .position
                .map(|position| MapPosition::take(MapKeys::new(&text, "[position]", position)))
                .transpose()?,
        };
        if map.position.as_ref().is_some_and(MapPosition::are_in_world) && !map.camera.has_place() {
            let message = "[camera]: places in world space need the camera's place, as normals in world space do";
            return Err(Error::malformed(path, Some(map.camera.line), message));
        }
        if map.normals.are_in_world() && !map.camera.has_place() {
            let message = "[camera]: normals in world space need the camera's place: world-to-view, view-to-world, or \
                           eye with look-at or forward";
            return Err(Error::malformed(path, Some(map.camera.line), message));
        }
        Ok(map)
    }

    /// Returns the order of rows and the view that the map states for all of its files.
    fn arrangement(&self) -> Arrangement<'_> {
        Arrangement { bottom_up: self.bottom_up, view: self.view.as_deref() }
    }

    /// Reads a frame. `main` is the main file; the other files that the map names lie in its folder.
    ///
    /// # Errors
    /// [`Error::Io`] if a file cannot be read, and [`Error::Malformed`] if it is no image that can be read.
    /// [`Error::Malformed`] with the line of the map for a missing file, part, channel or attribute, for files of
    /// several sizes, for an unusable camera, and for the first pixel whose value is out of range.
    pub fn read(&self, main: &Path) -> Result<GBufferData> {
        let mut files = MapFiles::new(&self.path, main, self.arrangement());
        let planes = self.depth.read(&mut files)?;
        let [width, height] = files.size();
        let (camera, depth_coding) = self.camera.get(&self.conventions, &self.depth, &mut files)?;
        let depth = self.depth.to_reversed(&planes, &camera, depth_coding, self.conventions.metres, [width, height])?;
        let normal = self.normals.read(&mut files, &self.conventions, &camera, &depth)?;
        let roughness = self.roughness.read(&mut files, &depth)?;
        let mut reflectivity = self.reflectivity.read(&mut files, &depth)?;
        // A surface that its renderer does not light has no normal, and is taken not to reflect.
        for (reflectivity, normal) in reflectivity.iter_mut().zip(&normal) {
            if !normals::has_direction(*normal) {
                *reflectivity = 0.0;
            }
        }
        let color = MapColour::read_sum(&self.color, &mut files)?;
        let surface = match &self.sky {
            Some(sky) => sky.read(&mut files)?,
            None => vec![Surface::Lit; depth.len()],
        };
        files.check_main_is_used()?;
        Ok(GBufferData { width, height, camera, depth, normal, reflectivity, roughness, color, surface })
    }
}

/// Returns the centre of a pixel in normalised device coordinates, with y up. `pixel_index` counts along rows, from the
/// top left.
fn pixel_ndc([width, height]: [u32; 2], pixel_index: usize) -> DVec2 {
    let (x, y) = (pixel_index % width as usize, pixel_index / width as usize);
    DVec2::new((x as f64 + 0.5) / f64::from(width) * 2.0 - 1.0, 1.0 - (y as f64 + 0.5) / f64::from(height) * 2.0)
}

/// Returns the keys of a required section, or an error if the map lacks it. `name` names the section, as in "[depth]".
fn required_keys<'a>(text: &'a SourceText, name: &str, section: Option<MapSection>) -> Result<MapKeys<'a>> {
    let missing = || Error::malformed(text.path, None, format!("there is no {name}"));
    Ok(MapKeys::new(text, name, section.ok_or_else(missing)?))
}

/// Takes the sections that give reflectivity: `[reflectivity]`, or `[metallic]` with `[base-color]` and maybe `[f0]`.
fn take_reflectivity(text: &SourceText, sections: &mut Sections) -> Result<MapReflectivity> {
    let [base_color, f0] = [sections.base_color.take(), sections.f0.take()];
    match (sections.reflectivity.take(), sections.metallic.take()) {
        (Some(reflectivity), None) => {
            for (name, section) in [("[base-color]", base_color), ("[f0]", f0)] {
                if let Some(section) = section {
                    return Err(
                        text.error(section.span(), format!("{name} is read beside [metallic], and there is none"))
                    );
                }
            }
            MapReflectivity::take_direct(MapKeys::new(text, "[reflectivity]", reflectivity))
        }
        (None, Some(metallic)) => {
            let base_color = required_keys(text, "[base-color]", base_color)?;
            let f0 = f0.map(|f0| MapKeys::new(text, "[f0]", f0));
            MapReflectivity::take_metallic(MapKeys::new(text, "[metallic]", metallic), base_color, f0)
        }
        (Some(_), Some(metallic)) => Err(text.error(metallic.span(), "[metallic]: there is [reflectivity] already")),
        (None, None) => {
            let message = "there is neither [reflectivity] nor [metallic] with [base-color]";
            Err(Error::malformed(text.path, None, message))
        }
    }
}
