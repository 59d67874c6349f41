//! The normals of a map: reads channels that are signed, encoded from 0 to 1, or octahedral, in the axes of the
//! renderer's world or view space.

use super::axes::MapConventions;
use super::files::MapFiles;
use super::keys::MapKeys;
use super::source::{MapPlanes, MapSource, SourceRules};
use crate::Camera;
use glam::{DMat3, DVec2, DVec3, Vec3};
use ssct_ground::Result;
use ssct_ground::conventions::NormalEncoding;

/// The encodings of normals that a map may state.
#[derive(Debug, Clone, Copy, PartialEq)]
enum MapEncoding {
    /// One of the encodings that images of other renderers have, too.
    Shared(NormalEncoding),
    /// Octahedral coordinates as two numbers of 12 bits in three channels of 8 bits.
    Octahedral888,
}

/// The section of normals in a map.
#[derive(Debug, Clone)]
pub(super) struct MapNormals {
    source: MapSource,
    /// True if the normals are in world space, false if they are in view space.
    is_world: bool,
    encoding: MapEncoding,
}

/// Least length of a normal with a direction; a shorter one shows no surface, or a surface that is not lit.
const SHORTEST_NORMAL: f64 = 1e-3;

impl MapNormals {
    /// Takes the keys of the section `[normal]`.
    pub fn take(mut keys: MapKeys) -> Result<Self> {
        use MapEncoding::{Octahedral888, Shared};
        use NormalEncoding::{Float, Octahedral, OctahedralUnorm, Unorm};
        let is_world = keys.required_word("space", &[("view", false), ("world", true)])?;
        let encodings = [
            ("signed", Shared(Float)),
            ("unorm", Shared(Unorm)),
            ("octahedral", Shared(Octahedral)),
            ("octahedral-unorm", Shared(OctahedralUnorm)),
            ("octahedral-888", Octahedral888),
        ];
        let encoding = keys.word("encoding", &encodings)?.unwrap_or(Shared(Float));
        let counts: &[usize] = if matches!(encoding, Shared(Octahedral | OctahedralUnorm)) { &[2] } else { &[3] };
        let source = MapSource::take(&mut keys, SourceRules { counts, ..SourceRules::EXACT })?;
        keys.finish()?;
        Ok(Self { source, is_world, encoding })
    }

    /// Returns this section with the other space (world or view) for the same channels.
    pub fn in_other_space(&self) -> Self {
        Self { is_world: !self.is_world, ..self.clone() }
    }

    /// Returns true if the normals are in world space. They can then be read only if the camera's place is known.
    pub fn are_in_world(&self) -> bool {
        self.is_world
    }

    /// Reads the normals, and converts them to view space; they are zero where the reversed `depth` is 0 (sky). Normals
    /// with the encoding `signed` keep their length; all others get length 1, or stay zero.
    ///
    /// # Errors
    /// The errors of [`MapSource::read`]; [`Error::Malformed`](ssct_ground::Error::Malformed) for a normal that is not
    /// finite.
    pub fn read<'a>(
        &'a self,
        files: &mut MapFiles<'a>,
        conventions: &MapConventions,
        camera: &Camera,
        depth: &[f32],
    ) -> Result<Vec<Vec3>> {
        let planes = self.source.read(files)?;
        let to_view = if self.is_world {
            DMat3::from_mat4(camera.world_to_view.as_dmat4()) * conventions.world
        } else {
            conventions.view
        };
        let convert = |(pixel, depth): (usize, &f32)| {
            if *depth <= 0.0 {
                return Ok(Vec3::ZERO);
            }
            let normal = (to_view * self.decode(&planes, pixel)).as_vec3();
            if normal.is_finite() {
                return Ok(normal);
            }
            // The error shows the first value that is not finite, or else the first value.
            let values = || (0..self.source.count()).map(|plane| planes.value(plane, pixel));
            let reported = values().find(|value| !value.is_finite()).or(values().next()).unwrap_or(f64::NAN);
            Err(planes.error(pixel, reported, "be finite"))
        };
        depth.iter().enumerate().map(convert).collect()
    }

    /// Decodes the normal of a pixel, in the axes of the renderer.
    fn decode(&self, planes: &MapPlanes, pixel: usize) -> DVec3 {
        let [x, y] = [0, 1].map(|plane| planes.value(plane, pixel));
        match self.encoding {
            MapEncoding::Shared(NormalEncoding::Float) => DVec3::new(x, y, planes.value(2, pixel)),
            MapEncoding::Shared(NormalEncoding::Unorm) => {
                unit_or_zero(DVec3::new(x, y, planes.value(2, pixel)) * 2.0 - 1.0)
            }
            MapEncoding::Shared(NormalEncoding::Octahedral) => octahedral(DVec2::new(x, y)),
            MapEncoding::Shared(NormalEncoding::OctahedralUnorm) => octahedral(DVec2::new(x, y) * 2.0 - 1.0),
            MapEncoding::Octahedral888 => {
                let bytes = [x, y, planes.value(2, pixel)].map(|value| (value * 255.0).round().clamp(0.0, 255.0));
                // The third byte has the upper four bits of each 12-bit number: those of x in its lower half, and those
                // of y in its upper half. The greatest 12-bit number is 4095.
                let (upper_y, upper_x) = ((bytes[2] / 16.0).floor(), bytes[2] % 16.0);
                let packed = DVec2::new(upper_x * 256.0 + bytes[0], upper_y * 256.0 + bytes[1]);
                octahedral(packed / 4095.0 * 2.0 - 1.0)
            }
        }
    }
}

/// Returns true if a normal is long enough to have a direction.
pub(super) fn has_direction(normal: Vec3) -> bool {
    f64::from(normal.length()) >= SHORTEST_NORMAL
}

/// Scales a vector to length 1, or to zero if it is too short for a direction.
fn unit_or_zero(vector: DVec3) -> DVec3 {
    if vector.length() < SHORTEST_NORMAL { DVec3::ZERO } else { vector.normalize() }
}

/// Returns the unit vector of octahedral coordinates from −1 to 1. The sphere is projected onto an octahedron, whose
/// half with z below 0 is folded outwards around the square |x| + |y| ≤ 1 (Cigolle et al. 2014).
fn octahedral(point: DVec2) -> DVec3 {
    let z = 1.0 - point.x.abs() - point.y.abs();
    let fold = (-z).max(0.0);
    unit_or_zero(DVec3::new(point.x - fold * point.x.signum(), point.y - fold * point.y.signum(), z))
}
