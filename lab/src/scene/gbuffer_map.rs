//! Maps of G-buffers: a TOML file says which channel of which file is what, and in which conventions, so that the
//! G-buffer of any renderer can be read as it is. docs/gbuffer-maps.md has the format, with all keys.
//!
//! A map is checked when it is read ([`GBufferMap::parse`]), without any file of a frame; every mistake has its line.
//! Then it reads frames ([`GBufferMap::read`]): files and channels (`files`, `source`), the camera (`camera`, `axes`,
//! `numbers`), and what the channels mean (`depth`, `normals`, `surface`).

mod axes;
mod camera;
mod depth;
mod files;
mod keys;
mod normals;
mod numbers;
mod source;
mod surface;

use super::scene_file::SourceText;
use super::{Camera, GBufferData, Surface, bounded};
use crate::error::{Error, Result};
use axes::MapConventions;
use camera::MapCamera;
use depth::MapDepth;
use files::MapFiles;
use glam::DVec3;
use keys::{MapKeys, MapSection};
use normals::MapNormals;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use surface::{MapColour, MapPixels, MapReflectivity, MapRoughness, MapSky};

/// The largest map, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// A checked map.
#[derive(Debug, Clone)]
pub struct GBufferMap {
    path: PathBuf,
    bottom_up: bool,
    conventions: MapConventions,
    camera: MapCamera,
    depth: MapDepth,
    normals: MapNormals,
    roughness: MapRoughness,
    reflectivity: MapReflectivity,
    color: Vec<MapColour>,
    sky: Option<MapSky>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Sections {
    #[serde(default)]
    origin: MapOrigin,
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
}

/// Where the first row of the files is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum MapOrigin {
    #[default]
    TopLeft,
    BottomLeft,
}

impl GBufferMap {
    /// Reads a map.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read; those of [`Self::parse`].
    pub fn load(path: &Path) -> Result<Self> {
        let bytes = bounded::read(path, "a map of a G-buffer", MAX_BYTES)?;
        let text = String::from_utf8(bytes)
            .map_err(|_| Error::malformed(path, None, "a map of a G-buffer must be UTF-8 text"))?;
        Self::parse(&text, path)
    }

    /// Checks the text of a map. Errors call the file `path`.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line of what is wrong: syntax, a section or key that is unknown or missing, a
    /// value that is none of those that there are.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let text = SourceText { path, text };
        let sections: Sections = toml::from_str(text.text).map_err(|e| match text.syntax_error(&e) {
            // The only section that is a list.
            Error::Malformed { path, line, message } if message.contains("expected a sequence") => {
                Error::Malformed { path, line, message: format!("colours are listed as [[color]] ({message})") }
            }
            other => other,
        })?;
        let needed = |name: &str, section: Option<MapSection>| {
            let missing = || Error::malformed(path, None, format!("there is no [{name}]"));
            section.map(|section| MapKeys::new(&text, &format!("[{name}]"), section)).ok_or_else(missing)
        };
        let optional =
            |name: &str, section: Option<MapSection>| section.map(|s| MapKeys::new(&text, &format!("[{name}]"), s));
        if sections.color.is_empty() {
            return Err(Error::malformed(path, None, "there is no [[color]]"));
        }
        let color = sections.color.into_iter().map(|term| MapColour::take(MapKeys::new(&text, "[[color]]", term)));
        let reflectivity =
            match (optional("reflectivity", sections.reflectivity), optional("metallic", sections.metallic)) {
                (Some(given), None) => {
                    let beside = [("base-color", sections.base_color), ("f0", sections.f0)];
                    if let Some((name, section)) = beside.into_iter().find_map(|(name, s)| Some((name, s?))) {
                        return Err(text
                            .error(section.span(), format!("[{name}] is read beside [metallic], and there is none")));
                    }
                    MapReflectivity::given(given)?
                }
                (None, Some(metallic)) => {
                    let base = needed("base-color", sections.base_color)?;
                    MapReflectivity::metallic(metallic, base, optional("f0", sections.f0))?
                }
                (Some(_), Some(metallic)) => {
                    return Err(metallic.error(metallic.line, "there is [reflectivity] already"));
                }
                (None, None) => {
                    let message = "there is neither [reflectivity] nor [metallic] with [base-color]";
                    return Err(Error::malformed(path, None, message));
                }
            };
        let map = Self {
            path: path.to_owned(),
            bottom_up: sections.origin == MapOrigin::BottomLeft,
            conventions: MapConventions::take(MapKeys::or_empty(&text, "[conventions]", sections.conventions))?,
            camera: MapCamera::take(needed("camera", sections.camera)?)?,
            depth: MapDepth::take(needed("depth", sections.depth)?)?,
            normals: MapNormals::take(needed("normal", sections.normal)?)?,
            roughness: MapRoughness::take(needed("roughness", sections.roughness)?)?,
            reflectivity,
            color: color.collect::<Result<_>>()?,
            sky: optional("sky", sections.sky).map(MapSky::take).transpose()?,
        };
        if map.normals.need_world() && !map.camera.has_place() {
            let message = "[camera]: normals in world space need the camera's place: world-to-view, view-to-world, or \
             eye with \
                           look-at or forward";
            return Err(Error::malformed(path, Some(map.camera.line()), message));
        }
        Ok(map)
    }

    /// Reads a frame: `main` is the file that the command names, and files that the map names lie beside it.
    ///
    /// # Errors
    /// [`Error::Io`] if a file cannot be read; [`Error::Malformed`] with the line of the map for a file, part, channel
    /// or attribute that is not there, for files of several sizes, for a camera that cannot be, and for the first pixel
    /// whose value cannot be; [`Error::Malformed`] for a file that is no image that can be read.
    pub fn read(&self, main: &Path) -> Result<GBufferData> {
        let mut files = MapFiles::new(&self.path, main, self.bottom_up);
        let planes = self.depth.read(&mut files)?;
        let size = files.size();
        let (camera, coding) = self.camera.get(&self.conventions, &self.depth, &mut files)?;
        let depth = self.depth.reversed(&planes, &camera, coding, self.conventions.metres, &self.path, size)?;
        let normal = self.normals.read(&mut files, &self.conventions, &camera, &depth, &self.path)?;
        let pixels = MapPixels { map: &self.path, width: size[0], depth: &depth };
        let roughness = self.roughness.read(&mut files, &pixels)?;
        let mut reflectivity = self.reflectivity.read(&mut files, &pixels)?;
        // A surface without a normal is one that its renderer does not light as others. It reflects nothing.
        for (reflectivity, normal) in reflectivity.iter_mut().zip(&normal) {
            if !normals::has_direction(*normal) {
                *reflectivity = 0.0;
            }
        }
        let color = MapColour::read_sum(&self.color, &mut files, &self.path)?;
        let surface = match &self.sky {
            Some(sky) => sky.read(&mut files, depth.len())?,
            None => vec![Surface::Lit; depth.len()],
        };
        files.finish()?;
        let [width, height] = size;
        Ok(GBufferData { width, height, camera, depth, normal, reflectivity, roughness, color, surface })
    }
}

/// The view-space ray through the centre of a pixel, with z = 1.
fn camera_ray(camera: &Camera, [width, height]: [u32; 2], pixel: usize) -> DVec3 {
    let (x, y) = (pixel % width as usize, pixel / width as usize);
    let clip = camera.view_to_clip_reversed().as_dmat4();
    let ndc = [(x as f64 + 0.5) / f64::from(width) * 2.0 - 1.0, 1.0 - (y as f64 + 0.5) / f64::from(height) * 2.0];
    let along = |ndc: f64, shift: f64, scale: f64| (ndc - shift) / scale;
    DVec3::new(along(ndc[0], clip.z_axis.x, clip.x_axis.x), along(ndc[1], clip.z_axis.y, clip.y_axis.y), 1.0)
}
