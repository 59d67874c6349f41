//! Converts positions, directions and paths between the coordinates in which a file states them and the program's own
//! left-handed coordinates. The conversion negates z or does nothing, so that it is the same in both directions.

use crate::obj::Handedness;
use crate::{Aabb, AreaLight, AreaShape, Capture, Impostor, Light, Probe, View};
use glam::Vec3;

impl Handedness {
    /// Returns the coordinates of the positions in a scene file. They are `stated`, the value of the key `coordinates`,
    /// if the file has this key; else `obj_handedness`, the value of the key `handedness`, if the file names any OBJ
    /// file (`has_obj`). The default is right-handed, as in glTF.
    pub(super) fn of_places(stated: Option<Self>, obj_handedness: Option<Self>, has_obj: bool) -> Self {
        stated.or(obj_handedness.filter(|_| has_obj)).unwrap_or_default()
    }

    /// Converts a position or a direction from these coordinates to the program's own, or back.
    #[must_use]
    pub fn mirrored(self, vector: Vec3) -> Vec3 {
        match self {
            Self::Left => vector,
            // The difference 0 − z is never −0, which would be written with its sign.
            Self::Right => vector.with_z(0.0 - vector.z),
        }
    }

    /// Converts the angle of a turn about an axis that [`Self::mirrored`] converts: in right-handed coordinates its
    /// sign changes.
    pub(super) fn mirrored_angle(self, angle: f32) -> f32 {
        match self {
            Self::Left => angle,
            Self::Right => -angle,
        }
    }

    /// Returns the line of a scene file that states these coordinates.
    pub(super) fn toml_line(self) -> &'static str {
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
        let [first, second] = [probe.bounds.min, probe.bounds.max].map(|corner| self.mirrored(corner));
        let bounds = Aabb { min: first.min(second), max: first.max(second) };
        Probe { position: self.mirrored(probe.position), bounds, ..probe }
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
        let converted = |vector: Vec3| self.mirrored(vector);
        let shape = match light.shape {
            AreaShape::Sphere { centre, radius } => AreaShape::Sphere { centre: converted(centre), radius },
            AreaShape::Capsule { a, b, radius } => AreaShape::Capsule { a: converted(a), b: converted(b), radius },
            AreaShape::Cylinder { a, b, radius } => AreaShape::Cylinder { a: converted(a), b: converted(b), radius },
            AreaShape::Rectangle { centre, half_u, half_v } => {
                // The light shines to the side of half_u × half_v. Mirroring reverses this side, so that half_v is
                // reversed, too.
                let half_v = self.reversed_edge(converted(half_v));
                AreaShape::Rectangle { centre: converted(centre), half_u: converted(half_u), half_v }
            }
            AreaShape::Cuboid { centre, half_u, half_v, half_w } => {
                let [centre, half_u, half_v] = [centre, half_u, half_v].map(converted);
                AreaShape::Cuboid { centre, half_u, half_v, half_w }
            }
        };
        AreaLight { shape, ..light }
    }

    /// Reverses the edge of a rectangle if it comes from right-handed coordinates, since [`Self::mirrored`] then turns
    /// the front of the rectangle into its back. In left-handed coordinates, returns the edge itself.
    fn reversed_edge(self, edge: Vec3) -> Vec3 {
        match self {
            Self::Left => edge,
            Self::Right => -edge,
        }
    }
}
