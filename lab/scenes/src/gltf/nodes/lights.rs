//! Places lights of `KHR_lights_punctual` in the world, and scales them by one exposure. Files give brightness in lux
//! and candela. Blender, for example, writes a sun of 3 W/m² as 2049 lx, since it multiplies by 683 lumens for a watt.

use super::Units;
use crate::gltf::Notes;
use crate::{Light, MAX_COORDINATE_M};
use glam::{DMat4, Vec3};
use gltf::khr_lights_punctual::Kind;
use ssct_geometry::texture::luminance;
use ssct_ground::math::constants;

/// A light with the illuminance that it gives at the scene's centre, in lux.
pub(super) struct PlacedLight {
    light: Light,
    illuminance_lux: f64,
}

/// Places a light in the world, and computes its illuminance at the scene's centre. Its colour is replaced by white of
/// the same luminance. The result is `None` if the illuminance is not positive and finite, or if the light stands too
/// far away.
pub(super) fn place_light(
    light: &gltf::khr_lights_punctual::Light,
    to_world: &DMat4,
    units: &Units,
    notes: &mut Notes,
) -> Option<PlacedLight> {
    let colour = Vec3::from(light.color());
    let grey = luminance(colour);
    if (colour - grey).abs().max_element() > 1e-3 {
        notes.add("coloured", "coloured lights are not supported; they shine white with their luminance".to_owned());
    }
    let intensity = f64::from(light.intensity() * grey);
    let position = to_world.w_axis.truncate();
    let placed = match light.kind() {
        Kind::Directional => {
            let direction = -to_world.z_axis.truncate().normalize_or_zero().as_vec3();
            let light = Light::Directional { direction, energy: 1.0 };
            PlacedLight { light, illuminance_lux: if direction == Vec3::ZERO { 0.0 } else { intensity } }
        }
        kind => {
            if matches!(kind, Kind::Spot { .. }) {
                notes.add("spots", "spot lights are not supported; they shine in all directions".to_owned());
            }
            if light.range().is_some() {
                notes.add("ranges", "ranges of lights are not supported; lights reach as far as they fade".to_owned());
            }
            // Candelas relate to the file's unit of length, which glTF calls a metre. A light less than a unit from the
            // centre counts as one unit away.
            let metres_per_unit = f64::from(units.scale);
            let distance_units = ((position - units.centre.as_dvec3()).length() / metres_per_unit).max(1.0);
            // The attenuation is energy / distance², so that the energy is scaled like a squared length.
            let light = Light::Point {
                position: position.as_vec3(),
                energy: (intensity * metres_per_unit * metres_per_unit) as f32,
            };
            PlacedLight { light, illuminance_lux: intensity / (distance_units * distance_units) }
        }
    };
    let is_sound = placed.illuminance_lux.is_finite()
        && placed.illuminance_lux > 0.0
        && position.is_finite()
        && position.abs().max_element() <= f64::from(MAX_COORDINATE_M);
    is_sound.then_some(placed)
}

/// Returns the lights scaled by one exposure, with which the brightest gives 1 at the scene's centre. Also returns a
/// sentence about the exposure, but none without lights. If there are too many lights, the brightest are kept, with a
/// note.
/// Far from a point light of energy e the attenuation at the distance d is e / d², as in glTF.
pub(super) fn expose(mut placed: Vec<PlacedLight>, notes: &mut Notes) -> (Vec<Light>, Option<String>) {
    placed.sort_by(|a, b| b.illuminance_lux.total_cmp(&a.illuminance_lux));
    let max_lights = constants::MAX_LIGHTS as usize;
    if placed.len() > max_lights {
        notes.add(
            "lights",
            format!("{} lights are more than the {max_lights} that are drawn; the brightest stay", placed.len()),
        );
        placed.truncate(max_lights);
    }
    let Some(brightest_lux) = placed.first().map(|light| light.illuminance_lux) else { return (Vec::new(), None) };
    let with_exposure = |placed: PlacedLight| match placed.light {
        Light::Directional { direction, .. } => {
            Light::Directional { direction, energy: (placed.illuminance_lux / brightest_lux) as f32 }
        }
        Light::Point { position, energy } => {
            Light::Point { position, energy: (f64::from(energy) / brightest_lux) as f32 }
        }
    };
    let shines = |light: &Light| match *light {
        Light::Directional { energy, .. } | Light::Point { energy, .. } => energy.is_finite() && energy > 0.0,
    };
    let lights: Vec<Light> = placed.into_iter().map(with_exposure).filter(shines).collect();
    let sentence = format!(
        "its lights are exposed so that the brightest, which gives {} lx at the scene's centre, gives 1",
        lux_text(brightest_lux)
    );
    (lights, Some(sentence))
}

/// Writes an illuminance in lux: as a whole number from 1000 on, else with three decimals.
fn lux_text(lux: f64) -> String {
    if lux >= 1000.0 { format!("{lux:.0}") } else { format!("{lux:.3}") }
}
