//! Captures as a folder of files, so that any renderer can provide its own probes with depth beside a G-buffer file
//! ([`gbuffer_file`](super::gbuffer_file)).
//!
//! ```text
//! captures.toml                 the places of the captures: the [[capture]] tables of a scene file, and perhaps bounds
//! 1/px.exr 1/nx.exr …           the six faces of the first capture
//! 2/px.exr …                    the faces of the second capture, and so on, for at most eight captures
//! sky/px.exr …                  what is seen at infinity; the folder may be absent
//! ```
//!
//! `captures.toml` has a table for each capture, in the order of the folders: `place`, the centre of the cube in world
//! space, in metres; `resolution`, the texels along a side of its faces, 1…4096; `near`, the distance of the near plane
//! in metres. All captures of a folder have one resolution and one near plane. Before the tables there may be `bounds`,
//! the least and the greatest corner of a box in world space, in metres: `bounds = [[x, y, z], [x, y, z]]`. There is no
//! surface outside of the box, so that rays that are lost there end in the sky.
//!
//! The faces `px nx py ny pz nz` look along +x −x +y −y +z −z. The texels are ordered as in a cube map of Vulkan: in
//! world axes, which are left-handed with y up, the texel at (u, v) from the top left looks along
//! [`sky::face_direction`](super::sky::face_direction). Each face is a square OpenEXR image, compressed without loss,
//! with these channels of 32-bit or 16-bit floats:
//!
//! - `R`, `G`, `B`: the lit colour, linear;
//! - `depth`: the depth after projection, reversed, 0…1, for the near plane and a far plane at
//!   [`FAR_M`](super::capture::FAR_M): near (far − z) / (z (far − near)), 0 where there is no surface. A file may have
//!   `Z` instead, the view-space z in metres, 0 or infinite where there is no surface;
//! - `N.X`, `N.Y`, `N.Z`: the normal in the view space of the face (x right, y up, z into the image), 0 where there is
//!   no surface;
//! - `sky`, which may be missing: 1 where a surface shows the sky, else 0.
//!
//! The colour is not read where there is no surface, or where a surface shows the sky. The sky's colour comes from the
//! cube `sky`, whose faces have any one size, and `R`, `G`, `B` alone; without this cube it is black.

use super::capture::face_camera;
use super::exr_channels::{self, ExrChannels, check_values, components, vector_channels};
use super::gbuffer_file::{MAX_BYTES, reversed_depth};
use super::{Aabb, Capture, GBufferData, Surface, scene_file};
use exr::meta::header::LayerAttributes;
use glam::Vec3;
use ssct_geometry::bounded;
use ssct_ground::{Error, Result};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

pub use super::sky::SkyCube;

/// Name of the file that lists the captures and their places.
pub const LIST: &str = "captures.toml";

/// The names of the faces, in Vulkan's order.
pub const FACES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];

/// Name of the folder of the sky.
const SKY: &str = "sky";

/// A folder of captures whose list was read.
#[derive(Debug, Clone)]
pub struct CaptureFolder {
    path: PathBuf,
    captures: Vec<Capture>,
    bounds: Aabb,
}

impl CaptureFolder {
    /// Reads the list of a folder.
    ///
    /// # Errors
    /// [`Error::Io`] if the list cannot be read; [`Error::Malformed`], with the line if known, for a list without
    /// captures, an unknown key, a number out of range, or captures of several resolutions or near planes.
    pub fn open(path: &Path) -> Result<Self> {
        let (captures, bounds) = scene_file::captures::load_list(&path.join(LIST))?;
        Ok(Self { path: path.to_owned(), captures, bounds })
    }

    /// A box in the world, in metres, outside of which there is no surface; [`Aabb::ALL`] if the list gives none.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The captures of the list: at least one, at most [`MAX_CAPTURES`](super::capture::MAX_CAPTURES).
    pub fn captures(&self) -> &[Capture] {
        &self.captures
    }

    /// Reads a face of a capture. `capture` counts from 0 in the order of the list, and `face` from 0 to 5.
    /// Reflectivity and roughness are 0. A texel of sky has depth 0 or [`Surface::Sky`], and the colour black.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read. [`Error::Malformed`] if the file is missing, is no readable OpenEXR
    /// image, is not square, or has another size than the list says. This error is also returned if a channel is
    /// missing, a value is not finite, or a depth lies outside 0 to 1.
    pub fn face(&self, capture: usize, face: usize) -> Result<GBufferData> {
        let path = face_path(&self.path, capture, face);
        let cube_name = format!("capture {}", capture + 1);
        let bytes = read_face(&path, &cube_name)?;
        let mut file = ExrChannels::decode(&bytes, &path, "the face")?;
        let malformed = |message: String| Error::malformed(&path, None, message);
        let side = square_side(&file, &path)?;
        let Capture { position, near_m, resolution } = self.captures[capture];
        if side != resolution {
            let message = format!("the face has {side}x{side} texels, where {LIST} says {resolution}x{resolution}");
            return Err(malformed(message));
        }
        let camera = face_camera(position, face, near_m);
        let depth = match (file.take("depth"), file.take("Z")) {
            (Some(depth), _) => {
                let is_depth = |value: f32| (0.0..=1.0).contains(&value);
                check_values(&path, (side, "texel"), "depth", "a number from 0 to 1", &depth, is_depth)?;
                depth
            }
            (None, Some(z)) => {
                check_values(&path, (side, "texel"), "Z", "a number from 0 on, in metres", &z, |z| z >= 0.0)?;
                z.iter().map(|z| reversed_depth(*z, &camera.lens)).collect()
            }
            (None, None) => return Err(malformed("channels depth and Z are both missing".into())),
        };
        let mut color = take_finite(&mut file, &path, ["R", "G", "B"])?;
        let normal = take_finite(&mut file, &path, ["N.X", "N.Y", "N.Z"])?;
        let surface = file.take_surfaces();
        for ((color, surface), depth) in color.iter_mut().zip(&surface).zip(&depth) {
            if *surface == Surface::Sky || *depth == 0.0 {
                *color = Vec3::ZERO;
            }
        }
        let zeros = vec![0.0; depth.len()];
        Ok(GBufferData {
            width: side,
            height: side,
            camera,
            depth,
            normal,
            reflectivity: zeros.clone(),
            roughness: zeros,
            color,
            surface,
        })
    }

    /// Reads the six faces of the sky; `None` if the folder has no sky.
    ///
    /// # Errors
    /// The errors of [`Self::face`], and [`Error::Malformed`] for faces of different sizes.
    pub fn sky(&self) -> Result<Option<SkyCube>> {
        if !self.path.join(SKY).is_dir() {
            return Ok(None);
        }
        let mut cube = SkyCube { side: 0, texels: Vec::new() };
        for face in 0..FACES.len() {
            let path = sky_path(&self.path, face);
            let bytes = read_face(&path, "the sky")?;
            let mut file = ExrChannels::decode(&bytes, &path, "the face")?;
            let side = square_side(&file, &path)?;
            if face > 0 && side != cube.side {
                let (first, expected) = (FACES[0], cube.side);
                let message = format!("the face has {side}x{side} texels, where {first}.exr has {expected}x{expected}");
                return Err(Error::malformed(&path, None, message));
            }
            cube.side = side;
            cube.texels.append(&mut take_finite(&mut file, &path, ["R", "G", "B"])?);
        }
        Ok(Some(cube))
    }
}

/// Returns the path of a face in a folder of captures. `capture` counts from 0, and `face` from 0 to 5.
pub fn face_path(folder: &Path, capture: usize, face: usize) -> PathBuf {
    folder.join((capture + 1).to_string()).join(FACES[face]).with_extension("exr")
}

/// Returns the path of a face (0…5) of the sky in a folder of captures.
pub fn sky_path(folder: &Path, face: usize) -> PathBuf {
    folder.join(SKY).join(FACES[face]).with_extension("exr")
}

/// Returns the text of the file [`LIST`] for these captures and bounds.
pub fn encode_list(captures: &[Capture], bounds: Aabb) -> String {
    let [min, max] = [bounds.min, bounds.max].map(|corner| corner.to_array());
    format!("bounds = [{min:?}, {max:?}]\n\n{}", encode_tables(captures))
}

/// Returns the `[[capture]]` tables of a scene file for these captures.
pub fn encode_tables(captures: &[Capture]) -> String {
    captures.iter().map(|capture| capture.to_toml()).collect::<Vec<_>>().join("\n")
}

/// Encodes depth, normal, colour and surface of a face as the bytes of a file.
///
/// # Errors
/// [`Error::Malformed`] if the format cannot hold the face. `path` is only used to name the file in the error.
pub fn encode_face(face: &GBufferData, path: &Path) -> Result<Vec<u8>> {
    let mut channels = vec![("depth", face.depth.clone())];
    channels.extend(vector_channels(["R", "G", "B"], &face.color));
    channels.extend(vector_channels(["N.X", "N.Y", "N.Z"], &face.normal));
    channels.extend(exr_channels::sky_channel(&face.surface));
    exr_channels::encode([face.width, face.height], LayerAttributes::default(), channels, path)
}

/// Encodes the colours of a face of the sky, with `side` texels along a side, as the bytes of a file.
///
/// # Errors
/// The errors of [`encode_face`].
pub fn encode_sky(side: u32, colors: &[Vec3], path: &Path) -> Result<Vec<u8>> {
    let channels = vector_channels(["R", "G", "B"], colors).into();
    exr_channels::encode([side; 2], LayerAttributes::default(), channels, path)
}

/// Reads the bytes of one face of a cube. The error about a missing file names the cube, as in "the sky".
fn read_face(path: &Path, cube_name: &str) -> Result<Vec<u8>> {
    bounded::read(path, "a face of a cube", MAX_BYTES).map_err(|e| match e {
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => {
            Error::malformed(path, None, format!("there is no such file, and {cube_name} needs all of its six faces"))
        }
        other => other,
    })
}

/// Checks that a face is square, and returns the number of texels along a side.
fn square_side(file: &ExrChannels, path: &Path) -> Result<u32> {
    let (width, height) = (file.width, file.height);
    if width != height {
        let message = format!("the face has {width}x{height} texels, and the faces of a cube are square");
        return Err(Error::malformed(path, None, message));
    }
    Ok(width)
}

/// Takes three channels, whose values must be finite, as one vector for each texel.
fn take_finite(file: &mut ExrChannels, path: &Path, names: [&str; 3]) -> Result<Vec<Vec3>> {
    let vectors = file.vectors(names)?;
    for (component, name) in names.into_iter().enumerate() {
        let values = components(&vectors, component);
        check_values(path, (file.width, "texel"), name, "a finite number", &values, f32::is_finite)?;
    }
    Ok(vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a face of 2 × 2 texels of a capture: texel 1 shows the sky, and texel 3 has no surface.
    fn face(capture: &Capture, face: usize) -> GBufferData {
        GBufferData {
            width: 2,
            height: 2,
            camera: face_camera(capture.position, face, capture.near_m),
            depth: vec![0.25, 0.5, 1.0, 0.0],
            normal: (0..4).map(|i| Vec3::new(0.0, 0.6, -0.8) * (3 - i) as f32).collect(),
            reflectivity: vec![0.0; 4],
            roughness: vec![0.0; 4],
            color: vec![Vec3::splat(face as f32 / 7.0), Vec3::ZERO, Vec3::new(0.1, 0.2, 0.3), Vec3::ZERO],
            surface: vec![Surface::Lit, Surface::Sky, Surface::Lit, Surface::Lit],
        }
    }

    const BOUNDS: Aabb = Aabb { min: Vec3::new(-8.5, -0.1, -3.0), max: Vec3::new(1.0, 2.7, 1e-3) };

    /// Writes a folder with two captures and a sky; returns the folder, which is deleted when dropped, and the
    /// captures.
    fn write_folder() -> (tempfile::TempDir, Vec<Capture>) {
        let folder = tempfile::tempdir().unwrap();
        let capture_at = |x: f32| Capture { resolution: 2, ..Capture::placed_at(Vec3::new(x, 1.5, -0.1)) };
        let captures = vec![capture_at(0.1), capture_at(-7.25)];
        std::fs::write(folder.path().join(LIST), encode_list(&captures, BOUNDS)).unwrap();
        for (index, capture) in captures.iter().enumerate() {
            std::fs::create_dir(folder.path().join((index + 1).to_string())).unwrap();
            for side in 0..6 {
                let path = face_path(folder.path(), index, side);
                std::fs::write(&path, encode_face(&face(capture, side), &path).unwrap()).unwrap();
            }
        }
        std::fs::create_dir(folder.path().join(SKY)).unwrap();
        for side in 0..6 {
            let path = sky_path(folder.path(), side);
            std::fs::write(&path, encode_sky(1, &[Vec3::splat(side as f32)], &path).unwrap()).unwrap();
        }
        (folder, captures)
    }

    /// Reads all faces and the sky of a folder.
    fn read_all(folder: &Path) -> Result<(Vec<GBufferData>, Option<SkyCube>)> {
        let opened = CaptureFolder::open(folder)?;
        let indices = (0..opened.captures().len()).flat_map(|capture| (0..6).map(move |face| (capture, face)));
        let faces = indices.map(|(capture, face)| opened.face(capture, face)).collect::<Result<_>>()?;
        Ok((faces, opened.sky()?))
    }

    #[test]
    fn a_folder_round_trips_every_bit() {
        let (folder, captures) = write_folder();
        let opened = CaptureFolder::open(folder.path()).unwrap();
        assert_eq!((opened.captures(), opened.bounds()), (&captures[..], BOUNDS));
        std::fs::write(folder.path().join(LIST), encode_tables(&captures)).unwrap();
        assert_eq!(CaptureFolder::open(folder.path()).unwrap().bounds(), Aabb::ALL);
        let (faces, sky) = read_all(folder.path()).unwrap();
        for (i, decoded) in faces.iter().enumerate() {
            assert!(*decoded == face(&captures[i / 6], i % 6), "face {i}");
        }
        let texels = (0..6).map(|face| Vec3::splat(face as f32)).collect();
        assert_eq!(sky, Some(SkyCube { side: 1, texels }));
        std::fs::remove_dir_all(folder.path().join(SKY)).unwrap();
        assert_eq!(read_all(folder.path()).unwrap().1, None);
    }

    #[test]
    fn view_z_is_as_good_as_depth_and_colours_of_the_sky_are_not_read() {
        let (folder, captures) = write_folder();
        let path = face_path(folder.path(), 0, 3);
        let z = vec![0.05, 4.0, 0.0, f32::INFINITY];
        let ones = || vec![1.0; 4];
        let mut channels = ["R", "G", "B", "N.X", "N.Y", "N.Z"].map(|name| (name, ones())).to_vec();
        channels.push(("Z", z));
        let bytes = exr_channels::encode([2; 2], LayerAttributes::default(), channels, &path).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let decoded = CaptureFolder::open(folder.path()).unwrap().face(0, 3).unwrap();
        let clip = face_camera(captures[0].position, 3, captures[0].near_m).view_to_clip_reversed();
        let expected = clip.project_point3(Vec3::new(0.0, 0.0, 4.0)).z;
        assert!(decoded.depth[0] == 1.0 && (decoded.depth[1] / expected - 1.0).abs() < 1e-5, "{:?}", decoded.depth);
        assert_eq!(decoded.depth[2..], [0.0, 0.0]);
        assert_eq!(decoded.color, [Vec3::ONE, Vec3::ONE, Vec3::ZERO, Vec3::ZERO]);
    }

    /// Returns the error message of reading a folder after `change`, with DIR for the path of the folder.
    fn error_after(change: impl FnOnce(&Path, &[Capture])) -> String {
        let (folder, captures) = write_folder();
        change(folder.path(), &captures);
        read_all(folder.path()).unwrap_err().to_string().replace(&folder.path().display().to_string(), "DIR")
    }

    /// Returns the error message of reading a folder after `change` of the last face of its second capture.
    fn error_of_changed_face(change: impl FnOnce(&mut GBufferData)) -> String {
        error_after(|folder, captures| {
            let mut changed = face(&captures[1], 5);
            change(&mut changed);
            let path = face_path(folder, 1, 5);
            std::fs::write(&path, encode_face(&changed, &path).unwrap()).unwrap();
        })
    }

    #[test]
    fn what_is_wrong_gets_one_sentence_that_says_where() {
        let error_of_list = |text: &str| error_after(|folder, _| std::fs::write(folder.join(LIST), text).unwrap());
        assert_eq!(error_of_list(""), "DIR/captures.toml: it lists no captures");
        let unknown = error_of_list("[[capture]]\nplace = [0, 0, 0]\nside = 2\n");
        assert!(unknown.starts_with("DIR/captures.toml:3: unknown field `side`"), "{unknown}");
        let unknown = error_of_list("scale = 2\n");
        assert!(unknown.starts_with("DIR/captures.toml:1: unknown field `scale`"), "{unknown}");
        let table_text = |near: &str, resolution: &str| {
            format!("[[capture]]\nplace = [0, 0, 0]\nnear = {near}\nresolution = {resolution}\n")
        };
        assert_eq!(
            error_of_list(&(table_text("0.1", "2") + &table_text("0.2", "2"))),
            "DIR/captures.toml:5: all captures of a folder have one near plane: this one has 0.2 m, the first has 0.1 m"
        );
        assert_eq!(
            error_of_list(&(table_text("0.1", "2") + &table_text("0.1", "4"))),
            "DIR/captures.toml:8: all captures of a scene have one resolution: this one has 4, the first has 2"
        );
        for (flaw, corners) in [("turned", "[[0, 0, 0], [1, -1, 1]]"), ("endless", "[[0, 0, 0], [1, inf, 1]]")] {
            let message = error_of_list(&format!("# {flaw}\nbounds = {corners}\n{}", table_text("0.1", "2")));
            let reason = "bounds must be the least and the greatest corner of a box, of finite numbers";
            assert_eq!(message, format!("DIR/captures.toml:2: {reason}"));
        }
        assert_eq!(
            error_of_list(&table_text("0.1", "4")),
            "DIR/1/px.exr: the face has 2x2 texels, where captures.toml says 4x4"
        );
        assert_eq!(
            error_after(|folder, _| std::fs::remove_file(face_path(folder, 1, 3)).unwrap()),
            "DIR/2/ny.exr: there is no such file, and capture 2 needs all of its six faces"
        );
        assert_eq!(
            error_after(|folder, _| std::fs::remove_file(sky_path(folder, 4)).unwrap()),
            "DIR/sky/pz.exr: there is no such file, and the sky needs all of its six faces"
        );
        let text = error_after(|folder, _| std::fs::write(face_path(folder, 0, 0), "hello").unwrap());
        assert!(text.starts_with("DIR/1/px.exr: cannot be read as an OpenEXR image: "), "{text}");
        assert_eq!(
            error_of_changed_face(|f| (f.width, f.height) = (4, 1)),
            "DIR/2/nz.exr: the face has 4x1 texels, and the faces of a cube are square"
        );
        assert_eq!(
            error_of_changed_face(|f| f.depth[3] = f32::NAN),
            "DIR/2/nz.exr: channel depth is NaN at texel 1, 1; it must be a number from 0 to 1"
        );
        assert_eq!(
            error_of_changed_face(|f| f.depth[2] = 1.5),
            "DIR/2/nz.exr: channel depth is 1.5 at texel 0, 1; it must be a number from 0 to 1"
        );
        assert_eq!(
            error_of_changed_face(|f| f.color[1].y = f32::INFINITY),
            "DIR/2/nz.exr: channel G is inf at texel 1, 0; it must be a finite number"
        );
        let sky_of_two = error_after(|folder, _| {
            let path = sky_path(folder, 2);
            std::fs::write(&path, encode_sky(2, &[Vec3::ZERO; 4], &path).unwrap()).unwrap();
        });
        assert_eq!(sky_of_two, "DIR/sky/py.exr: the face has 2x2 texels, where px.exr has 1x1");
        let without_normals = error_after(|folder, _| {
            let path = face_path(folder, 0, 1);
            let channels = ["R", "G", "B", "depth"].map(|name| (name, vec![0.5; 4])).to_vec();
            let bytes = exr_channels::encode([2; 2], LayerAttributes::default(), channels, &path).unwrap();
            std::fs::write(&path, bytes).unwrap();
        });
        assert_eq!(without_normals, "DIR/1/nx.exr: channel N.X is missing");
    }
}
