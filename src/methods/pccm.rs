//! `pccm`: parallax-corrected cube maps (Schmidt 2013, section 5.2, listing 1), which this renderer captures at the
//! scene's probes. A frame uses two of them, and blends the two in each pixel (section 6).

use super::capture::{capture_cube_maps, captured_materials};
use super::needs::Need;
use super::{Input, Intermediate, Method, MethodInfo, MethodOutput, SceneInput, Setup};
use crate::error::{Error, Result};
use crate::gpu::{Frame, FrameContext, Gpu, Image};
use crate::passes::pccm::PccmPass;
use crate::passes::{Content, CubeMap};
use glam::Vec3;
use ssct_ground::scene::{Material, Probe};

/// The method's row in the table of methods.
pub const INFO: MethodInfo = MethodInfo {
    needs: &[Need::Probes],
    takes_orthographic: true,
    ..MethodInfo::scene(
        "pccm",
        "cube maps captured in the scene, corrected for parallax by proxy boxes",
        "Schmidt 2013, §5.2, listing 1",
        |gpu, request| Ok(Box::new(PccmMethod::new(gpu, &request.setup, true)?)),
    )
};

/// The lookup, and the maps once they are captured.
pub struct PccmMethod {
    pass: PccmPass,
    maps: Vec<(Probe, Image)>,
    /// The materials that the maps were captured with.
    captured_with: Vec<Material>,
}

impl PccmMethod {
    /// Makes the method without maps, which `prepare` captures. `corrected` is false for `local-map` alone.
    pub fn new(gpu: &Gpu, setup: &Setup, corrected: bool) -> Result<Self> {
        let pass = PccmPass::new(gpu, setup.stage(), setup.extent, setup.projection, corrected)?;
        Ok(Self { pass, maps: Vec::new(), captured_with: Vec::new() })
    }
}

impl Method for PccmMethod {
    fn prepare(&mut self, context: &mut FrameContext, scene: &SceneInput) -> Result<()> {
        let materials = captured_materials(scene.materials);
        if self.maps.is_empty() || self.captured_with != materials {
            let probes = scene.data.probes();
            let places: Vec<Vec3> = probes.iter().map(|p| p.position).collect();
            self.maps = probes.iter().cloned().zip(capture_cube_maps(context, scene, &places)?).collect();
            self.captured_with = materials;
        }
        Ok(())
    }

    fn record<'a>(&'a self, frame: &mut Frame, input: &Input<'a, '_>) -> Result<MethodOutput<'a>> {
        let Some(nearest) = two_nearest(&self.maps, |(probe, _)| probe, input.camera.eye()) else {
            return Err(Error::Usage("the cube maps were not captured: the scene was not given".into()));
        };
        let maps = nearest.map(|(probe, map)| (probe, CubeMap(map)));
        let reflection = self.pass.record(frame, &input.gbuffer, input.camera, maps)?;
        let intermediate =
            |name, (_, map): &'a (Probe, Image)| Intermediate { name, content: Content::Color, image: map };
        let intermediates = vec![intermediate("first-map", nearest[0]), intermediate("second-map", nearest[1])];
        Ok(MethodOutput { intermediates, ..MethodOutput::new(reflection) })
    }
}

/// Returns the two maps whose boxes are nearest to `eye`, the nearest first. A box around the eye has distance 0; among
/// equals, the map captured nearer comes first. A single map is returned twice; `None` without maps.
fn two_nearest<T>(maps: &[T], probe: impl Fn(&T) -> &Probe, eye: Vec3) -> Option<[&T; 2]> {
    // Distances from the eye to the map's box, and to the place where the map was captured.
    let distances = |map: &T| {
        let Probe { position, bounds, .. } = probe(map);
        [eye.distance(eye.clamp(bounds.min, bounds.max)), eye.distance(*position)]
    };
    let mut sorted: Vec<&T> = maps.iter().collect();
    sorted.sort_by(|a, b| distances(a).partial_cmp(&distances(b)).unwrap_or(std::cmp::Ordering::Equal));
    let first = *sorted.first()?;
    Some([first, sorted.get(1).copied().unwrap_or(first)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_ground::scene::Aabb;

    #[test]
    fn maps_whose_boxes_are_nearest_come_first_and_a_single_map_twice() {
        let probe = |name: &str, position_x: f32, min_x: f32, max_x: f32| Probe {
            name: name.into(),
            position: Vec3::X * position_x,
            bounds: Aabb { min: Vec3::new(min_x, -1.0, -1.0), max: Vec3::new(max_x, 1.0, 1.0) },
        };
        let probes = [probe("far", 9.0, 8.0, 12.0), probe("next", 3.1, 3.0, 8.0), probe("here", -2.0, -4.0, 3.0)];
        let nearest_names =
            |probes: &[Probe], x: f32| two_nearest(probes, |p| p, Vec3::X * x).map(|two| two.map(|p| p.name.clone()));
        // In the box of "here", though "next" was captured nearer by.
        assert_eq!(nearest_names(&probes, 2.9).unwrap(), ["here", "next"]);
        assert_eq!(nearest_names(&probes, 8.5).unwrap(), ["far", "next"]);
        assert_eq!(nearest_names(&probes[..1], 0.0).unwrap(), ["far", "far"]);
        assert!(nearest_names(&[], 0.0).is_none());
    }
}
