//! The coordinates in which a file states places, directions and paths, and their conversion to the program's own left-handed
//! coordinates. The conversion back is the same, since it negates z.

use crate::obj::Handedness;
use crate::{Aabb, AreaLight, AreaShape, Capture, Impostor, Light, Probe, View};
use glam::Vec3;

impl Handedness {
    /// The coordinates of the places in a scene file. The file's own statement comes first, then the handedness of its OBJ
    /// files; the default is right-handed, as in glTF.
    pub(super) fn of_places(said: Option<Self>, of_obj: Option<Self>, has_obj: bool) -> Self {
        said.or(of_obj.filter(|_| has_obj)).unwrap_or_default()
    }

    /// Converts a place or a direction from these coordinates to the program's own, or back.
    #[must_use]
    pub fn mirrored(self, vector: Vec3) -> Vec3 {
        match self {
            Self::Left => vector,
            // 0 − z is used instead of −z, so that 0 is written without a sign.
            Self::Right => vector.with_z(0.0 - vector.z),
        }
    }

    /// The angle of a turn about a mirrored axis, which has the opposite sign in mirrored coordinates.
    pub(super) fn turn(self, angle: f32) -> f32 {
        match self {
            Self::Left => angle,
            Self::Right => -angle,
        }
    }

    /// The key of these coordinates, as written in a scene file.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Left => "coordinates = \"left\"",
            Self::Right => "coordinates = \"right\"",
        }
    }

    /// Converts a light to the program's coordinates, or back.
    pub(super) fn light(self, light: Light) -> Light {
        match light {
            Light::Point { position, energy } => Light::Point { position: self.mirrored(position), energy },
            Light::Directional { direction, energy } => {
                Light::Directional { direction: self.mirrored(direction), energy }
            }
        }
    }

    /// Converts a view to the program's coordinates, or back.
    pub(super) fn view(self, view: View) -> View {
        View { eye: self.mirrored(view.eye), look_at: self.mirrored(view.look_at), ..view }
    }

    /// Converts a probe with its box to the program's coordinates, or back.
    pub(super) fn probe(self, probe: Probe) -> Probe {
        let [a, b] = [probe.bounds.min, probe.bounds.max].map(|corner| self.mirrored(corner));
        Probe { position: self.mirrored(probe.position), bounds: Aabb { min: a.min(b), max: a.max(b) }, ..probe }
    }

    /// Converts an impostor to the program's coordinates, or back.
    pub(super) fn impostor(self, impostor: Impostor) -> Impostor {
        let [centre, half_u, half_v] =
            [impostor.centre, impostor.half_u, impostor.half_v].map(|vector| self.mirrored(vector));
        Impostor { centre, half_u, half_v, ..impostor }
    }

    /// Converts a capture to the program's coordinates, or back.
    #[must_use]
    pub fn capture(self, capture: Capture) -> Capture {
        Capture { position: self.mirrored(capture.position), ..capture }
    }

    /// Converts an area light to the program's coordinates, or back.
    pub(super) fn area_light(self, light: AreaLight) -> AreaLight {
        let to = |vector: Vec3| self.mirrored(vector);
        let shape = match light.shape {
            AreaShape::Sphere { centre, radius } => AreaShape::Sphere { centre: to(centre), radius },
            AreaShape::Capsule { a, b, radius } => AreaShape::Capsule { a: to(a), b: to(b), radius },
            AreaShape::Cylinder { a, b, radius } => AreaShape::Cylinder { a: to(a), b: to(b), radius },
            AreaShape::Rectangle { centre, half_u, half_v } => {
                // The light shines to the side of half_u × half_v, which mirroring alone would reverse.
                AreaShape::Rectangle { centre: to(centre), half_u: to(half_u), half_v: self.turned(to(half_v)) }
            }
            AreaShape::Cuboid { centre, half_u, half_v, half_w } => {
                AreaShape::Cuboid { centre: to(centre), half_u: to(half_u), half_v: to(half_v), half_w }
            }
        };
        AreaLight { shape, ..light }
    }

    /// The opposite of a vector in mirrored coordinates; otherwise the vector itself.
    fn turned(self, vector: Vec3) -> Vec3 {
        match self {
            Self::Left => vector,
            Self::Right => -vector,
        }
    }
}
