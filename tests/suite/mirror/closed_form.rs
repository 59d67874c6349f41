//! Hits and colours of the Hi-Z methods against the closed form, pixel by pixel, near and far.

use super::{CELL, CELLS, Case, EYE, WALL_Z, bytes, cell_color, is_near, mirror_ray, on_screen, path, reflecting};
use crate::common::{Builder, Shown, camera, gpu, show, unfaded};
use glam::{DVec2, DVec3, Vec3};
use ssct::methods::Setup;
use ssct::passes::PathCode;
use ssct_ground::parameter::Preset;
use ssct_lab::stage::Globals;

/// What a case's pixels were compared with.
struct Compared {
    /// Pixels whose mirror ray meets the wall on screen.
    expected: usize,
    /// Expected pixels without a hit.
    missed: usize,
    /// Distances of the hits from where they should be, in pixels, in the worse direction; sorted.
    errors: Vec<f64>,
    /// Expected pixels far enough from the border of a cell to say which colour they must have.
    colored: usize,
}

impl Compared {
    fn error_at(&self, share: f64) -> f64 {
        self.errors[((self.errors.len() - 1) as f64 * share) as usize]
    }
}

/// Compares hits and colours with the closed form. A colour must agree where the right hit lies
/// more than `margin` pixels inside its cell.
fn compare(case: &Case, shown: &Shown, margin: f64) -> Compared {
    let (hits, reflection, composite) = (shown.get("hits"), shown.get("reflection"), shown.get("composite"));
    let size = DVec2::new(f64::from(hits.width), f64::from(hits.height));
    let pixels_a_metre = size.y / (2.0 * (37_f64.to_radians()).tan() * WALL_Z);
    let mut found = Compared { expected: 0, missed: 0, errors: Vec::new(), colored: 0 };
    for (x, y, uv) in reflecting(shown) {
        let (p, r) = mirror_ray(shown, uv, -EYE, case.normal());
        let wall = p + r * ((WALL_Z - p.z) / r.z);
        let Some(expected) = on_screen(shown, wall) else { continue };
        found.expected += 1;
        let hit = hits.texel(x, y);
        if path(hit) != PathCode::HiZ {
            assert_eq!(path(hit), PathCode::Miss, "({x}, {y})");
            assert_eq!(reflection.texel(x, y), [0.0; 4], "a miss is black");
            found.missed += 1;
            continue;
        }
        let error = (DVec2::new(f64::from(hit[0]), f64::from(hit[1])) - expected) * size;
        found.errors.push(error.abs().max_element());
        // In cells: bottom left is (0, 0).
        let cell = DVec2::new(wall.x / CELL + f64::from(CELLS[0]) / 2.0, (wall.y + EYE.y + 3.0) / CELL);
        let inside = cell.fract().min(DVec2::ONE - cell.fract()).min_element() * CELL * pixels_a_metre;
        // The mirror cuts the wall's lowest cells.
        let above = (wall + EYE).dot(case.normal()) * pixels_a_metre;
        if inside.min(above) > margin {
            let right = cell_color(cell.x as u32, cell.y as u32);
            assert!(
                is_near(bytes(reflection.texel(x, y)), right),
                "({x}, {y}): {:?}, not {right:?}",
                reflection.texel(x, y)
            );
            assert!(is_near(bytes(composite.texel(x, y)), right), "({x}, {y}): composite {:?}", composite.texel(x, y));
            found.colored += 1;
        }
    }
    found.errors.sort_by(f64::total_cmp);
    found
}

#[test]
fn mirror_rays_meet_the_wall_where_they_should() {
    let gpu = gpu();
    for roll in [0.0, 0.3, -0.2] {
        let case = Case { roll };
        let scene = case.scene();
        for extent in [[512, 256], [321, 239]] {
            for (method, preset) in [
                ("ssct", Preset::Published),
                ("ssct", Preset::Author),
                ("hzct", Preset::Published),
                ("hzct", Preset::Author),
            ] {
                let what = format!("{method}, {preset:?}, roll {roll}, {extent:?}");
                let setup = unfaded(extent).of_preset(preset);
                let shown = show(&gpu, &scene, case.camera(extent), method, &setup, &Globals::default());
                // A ray is pushed half a pixel past each boundary that it crosses (erratum), so one
                // that meets the wall within its first cells stands behind it when it is first
                // compared: by the cell and half a pixel. The first step is over a cell of the start
                // level and may be followed by one of level 1, before the ray has seen the wall's
                // depth; cells of an odd size are a little larger.
                let start = if preset == Preset::Author { 4.0 } else { 2.0 };
                let farthest = start * 1.02 + 0.5;
                // Bilinear lookup of the colour, and of the pattern's own mip level: 1 and 2 pixels.
                let found = compare(&case, &shown, farthest + 3.0);
                println!(
                    "{what}: {} pixels, {} missed, {} with colour; error median {:.3}, 90 % {:.3}, 99 % {:.3}, worst {:.3} px",
                    found.expected,
                    found.missed,
                    found.colored,
                    found.error_at(0.5),
                    found.error_at(0.9),
                    found.error_at(0.99),
                    found.error_at(1.0)
                );
                assert!(found.expected > extent[0] as usize * extent[1] as usize / 4, "{what}");
                assert!(found.colored > found.expected / 4, "{what}");
                // All other rays are as good as Alg. 2's finite difference, whose slope is wrong by
                // 3e-2 at 20 m in the worst twentieth (docs/numerics.md, "Errata of the thesis"), thus by 3e-3 at 6 m,
                // as its cancellation grows with the square of the distance; times 30 pixels that a ray
                // typically drifts across before the depth plane stops it.
                assert!(found.error_at(0.5) < 0.02 && found.error_at(0.9) < 0.1, "{what}");
                assert!(found.error_at(0.97) < 1.5, "{what}");
                assert!(found.error_at(1.0) < farthest, "{what}");
                // A first step that ends outside the screen.
                assert!(found.missed * 5_000 <= found.expected, "{what}");
            }
        }
    }
}

#[test]
fn far_rays_fall_back_as_published() {
    // V_z is that of one near-plane length (Alg. 2): n · n f / (f − n) / z² · R_z, with n = 0.1 and R_z
    // nearly 1. It falls below ε = 1e-5 at about 32 m (an erratum of Alg. 6 that is kept).
    let gpu = gpu();
    let mut b = Builder::new("far");
    let mirror = b.mirror();
    b.quad(mirror, Vec3::new(-200.0, 0.0, 0.0), Vec3::X * 400.0, Vec3::Z * 200.0, Vec3::Y);
    let gray = b.matt(Vec3::splat(0.5));
    b.quad(gray, Vec3::new(-200.0, -1.0, 200.0), Vec3::X * 400.0, Vec3::Y * 300.0, -Vec3::Z);
    let extent = [160, 240];
    let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
    for (method, beyond) in [("ssct", Some(false)), ("hzct", None)] {
        let setup = Setup::new(extent);
        let shown = show(&gpu, &b.0, view, method, &setup, &Globals::default());
        let (mut near, mut far) = (0, 0);
        for (x, y, uv) in reflecting(&shown) {
            let (p, _) = mirror_ray(&shown, uv, -EYE, DVec3::Y);
            let by = path(shown.get("hits").texel(x, y)).by_hi_z();
            if p.z < 25.0 {
                near += 1;
                assert_eq!(by, Some(true), "{method}, {} m", p.z);
            } else if p.z > 40.0 {
                far += 1;
                assert_eq!(by, beyond, "{method}, {} m", p.z);
            }
        }
        assert!(near > 1000 && far > 300, "{near} {far}");
    }
}
