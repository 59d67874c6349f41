//! A mirror ramp, whose rays go away from the camera and towards it: which methods trace them, and how hits fade.

use super::{Case, EYE, bytes, mirror_ray, on_screen, path, reflecting};
use crate::common::{Builder, Shown, camera, gpu, show};
use glam::{DVec2, DVec3, Vec3};
use ssct::gpu::Gpu;
use ssct::methods::{EffectParams, Setup};
use ssct::passes::PathCode;
use ssct_lab::stage::Globals;

/// A mirror ramp under a red ceiling: its rays go up, at its top away from the camera and at its foot towards the
/// camera. All else is black.
struct Ramp;

impl Ramp {
    /// The angle of the ramp, in radians.
    const TILT: f64 = 0.635;
    /// The middle of the ramp's lower edge, in metres.
    const FOOT: DVec3 = DVec3::new(0.0, 0.0, 3.2);

    /// Returns the unit normal of the ramp.
    fn normal() -> DVec3 {
        DVec3::new(0.0, Self::TILT.cos(), -Self::TILT.sin())
    }

    /// Shows the ramp with a method.
    fn show(gpu: &Gpu, method: &str, fade: bool) -> Shown {
        let mut b = Builder::new("ramp");
        let mirror = b.mirror();
        let up = Vec3::new(0.0, Self::TILT.sin() as f32, Self::TILT.cos() as f32);
        b.quad(mirror, Self::FOOT.as_vec3() - Vec3::X * 2.0, Vec3::X * 4.0, up * 1.5, Self::normal().as_vec3());
        let black = b.matt(Vec3::ZERO);
        b.quad(black, Vec3::new(-30.0, -10.0, 12.0), Vec3::X * 60.0, Vec3::Y * 40.0, -Vec3::Z);
        let red = b.matt(Vec3::X);
        b.light(Vec3::Y);
        b.quad(red, Vec3::new(-9.0, 3.0, 2.0), Vec3::X * 18.0, Vec3::Z * 10.0, -Vec3::Y);
        let extent = [320, 240];
        let setup = Setup::new(extent).with(|p: &mut EffectParams| p.fade = fade);
        let view = camera(EYE.as_vec3(), EYE.as_vec3() + Vec3::Z, extent);
        show(gpu, &b.0, view, method, &setup, &Globals::default())
    }

    /// Returns the direction of a pixel's mirror ray, and whether the ray meets the ceiling where the screen shows it.
    fn ray(shown: &Shown, uv: DVec2) -> (DVec3, bool) {
        let (origin, reflected) = mirror_ray(shown, uv, Self::FOOT - EYE, Self::normal());
        (reflected, on_screen(shown, origin + reflected * ((3.0 - EYE.y - origin.y) / reflected.y)).is_some())
    }
}

/// Both methods trace rays away from the camera by Hi-Z, which cannot follow rays towards the camera. `ssct` marches
/// linearly along those, and finds the ceiling in 98 % of the cases; `hzct` leaves them black.
#[test]
fn rays_towards_the_camera_are_traced_by_ssct_alone() {
    let gpu = gpu();
    let [ssct, hzct] = ["ssct", "hzct"].map(|m| Ramp::show(&gpu, m, true));
    let (mut away, mut towards, mut on_ceiling, mut red) = (0, 0, 0, 0);
    for (x, y, uv) in reflecting(&ssct) {
        let (reflected, meets_ceiling) = Ramp::ray(&ssct, uv);
        let paths = [&ssct, &hzct].map(|s| path(s.get("hits").texel(x, y)));
        let colors = [&ssct, &hzct].map(|s| s.get("reflection").texel(x, y));
        // The threshold between the two kinds of ray is not at R_z = 0. It is at a V_z of 1e-5, where V_z belongs to a
        // ray whose length is the distance of the near plane.
        if reflected.z > 0.03 {
            away += 1;
            assert_eq!(paths.map(PathCode::by_hi_z), [Some(true); 2], "({x}, {y}), {reflected}");
        } else if reflected.z < 0.0 {
            towards += 1;
            assert_eq!(paths[0].by_hi_z(), Some(false), "({x}, {y}), {reflected}");
            assert_eq!(paths[1], PathCode::Untraced, "({x}, {y}), {reflected}");
            assert_eq!(colors[1], [0.0; 4], "hzct is black");
            assert_eq!(hzct.get("composite").texel(x, y)[..3], [0.0; 3], "hzct is black");
            if meets_ceiling {
                on_ceiling += 1;
                red += usize::from(paths[0] == PathCode::Linear && bytes(colors[0]) == [255, 0, 0]);
            }
        }
    }
    println!("{away} pixels away from the camera, {towards} towards it, {red} of {on_ceiling} find the ceiling");
    assert!(away > 1000 && towards > 1000 && on_ceiling > 1000);
    // The march finds the ceiling, unless its growing step carries it off the screen first.
    assert!(red * 100 > on_ceiling * 98, "{red} of {on_ceiling}");
}

/// The fade of each hit is that of Eq. 4.7 with the distance from the middle of the screen. In `hzct` it also falls
/// with R_z of the ray. The composite weighs each reflection by it.
#[test]
fn hits_fade_towards_the_border_and_hzct_towards_the_camera() {
    let gpu = gpu();
    for method in ["ssct", "hzct"] {
        let (mut gone, mut partial, mut whole, mut grazing) = (0, 0, 0, 0);
        let case = Case { roll: 0.3 };
        let extent = [320, 240];
        let setup = Setup::new(extent);
        let wall = show(&gpu, &case.scene(), case.camera(extent), method, &setup, &Globals::default());
        let ramp = Ramp::show(&gpu, method, true);
        for (shown, is_ramp) in [(&wall, false), (&ramp, true)] {
            let (hits, reflection) = (shown.get("hits"), shown.get("reflection"));
            for (x, y, uv) in reflecting(shown) {
                let hit = hits.texel(x, y);
                if !path(hit).is_hit() {
                    continue;
                }
                // The expected fade is that of Eq. 4.7 with I_start = 0.8 and I_end = 1.
                let distance = (DVec2::new(f64::from(hit[0]), f64::from(hit[1])) - 0.5).length() * 2.0;
                let mut fade = 1.0 - ((distance - 0.8) / 0.2).clamp(0.0, 1.0);
                let mut tolerance = 1.0 / 1024.0;
                if method == "hzct" && is_ramp {
                    let (reflected, _) = Ramp::ray(shown, uv);
                    fade *= (10.0 * reflected.z).clamp(0.0, 1.0);
                    grazing += usize::from(reflected.z < 0.09);
                    // A normal in 16-bit floats is off by at most 5e-4, the direction R by twice that, and the fade by
                    // ten times that.
                    tolerance = 0.012;
                }
                let shown_fade = f64::from(reflection.texel(x, y)[3]);
                assert!((shown_fade - fade).abs() <= tolerance, "{method}, ({x}, {y}): {shown_fade} against {fade}");
                if !is_ramp {
                    gone += usize::from(fade == 0.0);
                    partial += usize::from(fade > 0.0 && fade < 1.0);
                    whole += usize::from(fade == 1.0);
                    let (color, composite) = (reflection.texel(x, y), shown.get("composite").texel(x, y));
                    for c in 0..3 {
                        assert!((composite[c] - color[c] * color[3]).abs() <= 1.0 / 1024.0, "({x}, {y})");
                    }
                }
            }
        }
        assert!(gone > 50 && partial > 1000 && whole > 1000, "{gone} {partial} {whole}");
        assert!(method == "ssct" || grazing > 500, "{grazing}");
    }
}

/// With the fade off, every hit has a fade of 1 and every other pixel one of 0.
#[test]
fn without_fade_nothing_fades() {
    let gpu = gpu();
    for method in ["ssct", "hzct", "ssr", "ssr-fast"] {
        let shown = Ramp::show(&gpu, method, false);
        for (hit, color) in shown.get("hits").texels().zip(shown.get("reflection").texels()) {
            assert_eq!(color[3], if path(hit).is_hit() { 1.0 } else { 0.0 });
        }
    }
}
