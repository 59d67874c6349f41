//! Compares the twin of the Hi-Z ray tracing on the CPU with the shader, ray by ray, over the Hi-Z chain that the pass
//! made.

use glam::{Vec2, Vec3};
use ssct::gpu::Pixels;
use ssct::methods::thesis::{self, HiZParams};
use ssct::methods::{self, Setup, Wants};
use ssct::passes::{Content, PathCode};
use ssct_lab::stage::image::render;
use ssct_lab::stage::{Globals, Shot, Stage};
use ssct_lab::study::twin::hi_z_constants;
use ssct_truth::reference::Level;
use ssct_truth::reference::hi_z::MinMax;
use ssct_truth::reference::hi_z_ray_trace::{End, reflection_ray, trace};

/// The size of the image, which is no power of two, so that levels have odd sides.
const SIZE: [u32; 2] = [97, 55];

/// In two views, at least 98 % of the rays of the shader and of the twin end in one way, and hits lie within a pixel.
/// The twin draws figures and counts steps, which are wrong if it goes another way.
#[test]
fn every_ray_ends_where_the_shader_says() {
    let gpu = crate::common::gpu();
    let scene = crate::common::built_in("rooms");
    let mut stage = Stage::new(&gpu, &scene).unwrap();
    let setup = Setup::new(SIZE);
    let globals = Globals { roughness: Some(0.0), reflectivity: 1.0, normal_deviation: Some(0.0) };
    for name in ["corridor", "window"] {
        let view = scene.view(name).unwrap();
        let camera = view.camera(&scene, SIZE);
        let method = methods::find("ssct").unwrap();
        let shot = Shot::new(&mut stage, method, &setup, Wants::HITS, camera, globals.materials(&scene, view)).unwrap();
        let images = render(&mut stage, &shot, true).unwrap().intermediates.unwrap();
        let find = |wanted: &str| -> &Pixels { &images.iter().find(|(name, ..)| name == wanted).unwrap().2 };
        let (normals, hits) = (find("normal"), find("hits"));
        let chain: Vec<Level<MinMax>> = images
            .iter()
            .filter(|(_, kind, _)| *kind == Content::StandardDepth)
            .map(|(.., image)| Level {
                width: image.width,
                height: image.height,
                texels: image.texels().map(MinMax::from_texel).collect(),
            })
            .collect();
        assert_eq!((chain[0].width, chain[0].height), (SIZE[0], SIZE[1]));
        let published: HiZParams = setup.parameters();
        let numbers = published.fill(thesis::block(&camera, SIZE, chain.len() as u32, true));
        let constants = hi_z_constants(&numbers);
        let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
        let (mut rays, mut agreeing, mut hit_count) = (0, 0, 0);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let found = hits.texel(x, y);
                let path = PathCode::from_channel(found[3]).unwrap();
                if path.by_hi_z() != Some(true) {
                    continue;
                }
                // P and V of the thesis: the pixel and the reflected ray in screen space.
                let p_ss = ((Vec2::new(x as f32, y as f32) + 0.5) / size).extend(chain[0].at_clamped(x, y).min);
                let normal = Vec3::from_slice(normals.texel(x, y)).normalize();
                let v_ss = reflection_ray(&camera, p_ss, normal, numbers.reflection_offset);
                let traced = trace(&chain, p_ss, v_ss, &constants);
                let shader_end = match path {
                    PathCode::HiZ => End::Hit,
                    PathCode::Miss => End::LeftScreen,
                    _ => End::Exhausted,
                };
                let offset = (traced.last().truncate() - Vec2::new(found[0], found[1])) * size;
                let agrees = traced.end == shader_end && (shader_end != End::Hit || offset.abs().max_element() <= 1.0);
                rays += 1;
                hit_count += u32::from(shader_end == End::Hit);
                agreeing += u32::from(agrees);
            }
        }
        println!("{name}: {agreeing} of {rays} rays agree, {hit_count} hit");
        assert!(rays > 1000 && hit_count > 500, "{name}: {rays} rays, {hit_count} hits");
        // In the other rays, rounding decides whether a ray meets a cell, and the ray goes on differently from there.
        assert!(f64::from(agreeing) >= 0.98 * f64::from(rays), "{name}: {agreeing} of {rays}");
    }
}
