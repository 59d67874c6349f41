//! The parts of a scene that methods need. If a scene lacks a part, the method that needs it shows nothing: its
//! reflection is black everywhere, and its time is that of an empty loop.

use ssct_ground::scene::{Scene, planes};

/// A part of a scene that a method reflects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Rectangles with images ([`Scene::impostors`]).
    Impostors,
    /// Lights with an extent ([`Scene::area_lights`]).
    AreaLights,
    /// Flat surfaces that are lit. The materials of a view say which of them reflect.
    Planes,
    /// Places where cube maps are captured ([`Scene::probes`]).
    Probes,
}

impl Need {
    /// The part's name in messages, in the plural.
    pub fn words(self) -> &'static str {
        match self {
            Self::Impostors => "impostors",
            Self::AreaLights => "area lights",
            Self::Planes => "flat surfaces",
            Self::Probes => "probes",
        }
    }

    /// Whether a scene has this part.
    pub fn is_met(self, scene: &Scene) -> bool {
        match self {
            Self::Impostors => !scene.impostors.is_empty(),
            Self::AreaLights => !scene.area_lights.is_empty(),
            Self::Planes => !planes::coplanar_groups(scene).is_empty(),
            Self::Probes => !scene.probes.is_empty(),
        }
    }
}
