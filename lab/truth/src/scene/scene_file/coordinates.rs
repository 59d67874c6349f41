//! The coordinates in which a file states places, directions and paths, and the way from them to the program's own, which are
//! left-handed. The way back is the same one, since z is negated.

use crate::scene::obj::Handedness;
use crate::scene::{Aabb, AreaLight, AreaShape, Capture, Impostor, Light, Probe, View};
use glam::Vec3;

impl Handedness {
    /// The coordinates of the places in a scene file. What the file says of them goes first; else they are those of its OBJ
    /// files, and else right-handed, as glTF is.
    pub(super) fn of_places(said: Option<Self>, of_obj: Option<Self>, has_obj: bool) -> Self {
        said.or(of_obj.filter(|_| has_obj)).unwrap_or_default()
    }

    /// A place or a direction in the program's own coordinates, given one in these; or the other way round.
    #[must_use]
    pub fn mirrored(self, vector: Vec3) -> Vec3 {
        match self {
            Self::Left => vector,
            // Not -z, so that 0 stays 0 where it is written.
            Self::Right => vector.with_z(0.0 - vector.z),
        }
    }

    /// An angle about a mirrored axis: a turn goes the other way where the axis is mirrored.
    pub(super) fn turn(self, angle: f32) -> f32 {
        match self {
            Self::Left => angle,
            Self::Right => -angle,
        }
    }

    /// The key that says it, as a scene file has it.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Left => "coordinates = \"left\"",
            Self::Right => "coordinates = \"right\"",
        }
    }

    pub(super) fn light(self, light: Light) -> Light {
        match light {
            Light::Point { position, energy } => Light::Point { position: self.mirrored(position), energy },
            Light::Directional { direction, energy } => {
                Light::Directional { direction: self.mirrored(direction), energy }
            }
        }
    }

    pub(super) fn view(self, view: View) -> View {
        View { eye: self.mirrored(view.eye), look_at: self.mirrored(view.look_at), ..view }
    }

    pub(super) fn probe(self, probe: Probe) -> Probe {
        let [a, b] = [probe.bounds.min, probe.bounds.max].map(|corner| self.mirrored(corner));
        Probe { position: self.mirrored(probe.position), bounds: Aabb { min: a.min(b), max: a.max(b) }, ..probe }
    }

    pub(super) fn impostor(self, impostor: Impostor) -> Impostor {
        let [centre, half_u, half_v] =
            [impostor.centre, impostor.half_u, impostor.half_v].map(|vector| self.mirrored(vector));
        Impostor { centre, half_u, half_v, ..impostor }
    }

    /// A capture, which is there and back the same.
    #[must_use]
    pub fn capture(self, capture: Capture) -> Capture {
        Capture { position: self.mirrored(capture.position), ..capture }
    }

    pub(super) fn area_light(self, light: AreaLight) -> AreaLight {
        let to = |vector: Vec3| self.mirrored(vector);
        let shape = match light.shape {
            AreaShape::Sphere { centre, radius } => AreaShape::Sphere { centre: to(centre), radius },
            AreaShape::Capsule { a, b, radius } => AreaShape::Capsule { a: to(a), b: to(b), radius },
            AreaShape::Cylinder { a, b, radius } => AreaShape::Cylinder { a: to(a), b: to(b), radius },
            AreaShape::Rectangle { centre, half_u, half_v } => {
                // The light shines to the side of half_u × half_v, which mirroring alone would turn round.
                AreaShape::Rectangle { centre: to(centre), half_u: to(half_u), half_v: self.turned(to(half_v)) }
            }
            AreaShape::Cuboid { centre, half_u, half_v, half_w } => {
                AreaShape::Cuboid { centre: to(centre), half_u: to(half_u), half_v: to(half_v), half_w }
            }
        };
        AreaLight { shape, ..light }
    }

    /// The opposite of a vector where coordinates are mirrored.
    fn turned(self, vector: Vec3) -> Vec3 {
        match self {
            Self::Left => vector,
            Self::Right => -vector,
        }
    }
}
