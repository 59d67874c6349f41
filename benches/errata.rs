//! Measures what the departures from print change. Each entry of `VARIANTS` changes one thing of a method back to
//! print, or to another choice, in a copy of its shaders or by its parameters. The image is compared with that of the
//! unchanged method.
//!
//! Prints a table in CSV to standard output, with a row for each variant and view. `share` is the share of the pixels
//! of which a channel of the display image differs by more than 1/255, and `rmse` is the root mean square difference of
//! the display images. The pages of errata (`shaders-glsl/*/ERRATA.md`) show medians and maxima over the views.
//!
//! Usage: `cargo bench --bench errata [-- VARIANT…]`

#![allow(clippy::expect_used)]

mod edited;
#[path = "errata_schmidt.rs"]
mod schmidt;

use edited::{Edits, Shaders, difference};
use ssct::gpu::{DeviceQuery, Gpu};
use ssct::methods::ibr::IbrParams;
use ssct::methods::poster::PosterParams;
use ssct::methods::sslr::{DepthSampling, SslrParams};
use ssct::methods::thesis::{ConeAngle, ConeParams, HiZParams, MarchParams};
use ssct::methods::{METHODS, Setup, Wants};
use ssct::passes::PosterFilter;
use ssct::passes::mask_chain::MaskFilter;
use ssct_lab::report::images::{Rgb, display};
use ssct_lab::stage::{Globals, Shot, Stage, image};
use ssct_scenes::library;
use std::collections::HashMap;

/// A change of parameters.
type Change = fn(&Setup) -> Setup;

/// One departure: its name in the table, where it is measured, and the two sides that are compared.
struct Variant {
    name: &'static str,
    method: &'static str,
    views: Views,
    /// The change of parameters on both sides.
    base: Change,
    /// The change of parameters on the changed side, made after `base`.
    change: Change,
    /// The changes of shaders on the changed side.
    edits: Edits,
}

/// The views of a variant, with their size and materials.
#[derive(Clone, Copy, PartialEq)]
enum Views {
    /// All views of the rooms and `hall` of the atrium, at roughness and normal deviation 0.1.
    Gloss,
    /// Views of `Gloss` with roughness 0.
    GlossMirrors,
    /// Five views of the rooms, and `hall`, at roughness 0.
    Mirrors,
    /// Views of `Mirrors`, and `ceiling`.
    MirrorsAndCeiling,
    /// Four views of the street and one of the museum, with the materials' own roughness.
    Billboards,
}

impl Views {
    /// Returns the names of the views, each behind the name of its scene.
    fn scenes_and_views(self) -> Vec<(&'static str, &'static str)> {
        let mirrors = ["corridor", "cylinder", "window", "window-floor", "two-cylinders"].map(|view| ("rooms", view));
        let hall = ("atrium", "hall");
        match self {
            Self::Mirrors => [&mirrors[..], &[hall]].concat(),
            Self::Gloss | Self::GlossMirrors | Self::MirrorsAndCeiling => {
                [&mirrors[..], &[("rooms", "ceiling"), hall]].concat()
            }
            Self::Billboards => {
                [&["street", "car", "puddles", "signs"].map(|view| ("street", view))[..], &[("museum", "museum")]]
                    .concat()
            }
        }
    }

    /// The width and height of the images in pixels.
    fn size(self) -> [u32; 2] {
        if self == Self::Billboards { [640, 360] } else { [960, 540] }
    }

    /// The roughness and the normal deviation of all surfaces; `None` for those of the materials.
    fn globals(self) -> Globals {
        let (roughness, normal_deviation) = match self {
            Self::Gloss => (Some(0.1), Some(0.1)),
            Self::GlossMirrors => (Some(0.0), Some(0.1)),
            Self::Mirrors | Self::MirrorsAndCeiling => (Some(0.0), None),
            Self::Billboards => (None, Some(0.1)),
        };
        Globals { roughness, normal_deviation, ..Globals::default() }
    }
}

/// The change that leaves all parameters as they are.
const SAME: Change = Setup::clone;

/// Makes a variant whose changed side has changed lines of shaders.
const fn edited(name: &'static str, method: &'static str, views: Views, edits: Edits) -> Variant {
    Variant { name, method, views, base: SAME, change: SAME, edits }
}

/// Makes a variant whose changed side has changed parameters.
const fn changed(name: &'static str, method: &'static str, views: Views, change: Change) -> Variant {
    Variant { name, method, views, base: SAME, change, edits: &[] }
}

const MARCH: &str = "thesis/linear_ray_march.glsl";
const HI_Z: &str = "thesis/hi_z_ray_trace.glsl";
const CONE: &str = "thesis/cone_trace.glsl";
const ANGLE: &str = "thesis/cone_angle.glsl";
const POSTER: &str = "poster/cone_march.frag";
const HALF_ROUGHNESS: &str = "return 0.5 * max(roughness, 0.0);";

const VARIANTS: &[Variant] = &[
    changed("ibr-0.1", "ibr", Views::Billboards, |s| s.with(|p: &mut IbrParams| p.ibr_depth = 0.1)),
    changed("ibr-2", "ibr", Views::Billboards, |s| s.with(|p: &mut IbrParams| p.ibr_depth = 2.0)),
    changed("ibr-64", "ibr", Views::Billboards, |s| s.with(|p: &mut IbrParams| p.ibr_side = 64)),
    edited(
        "equal-hits",
        "linear",
        Views::Gloss,
        &[(
            MARCH,
            "if (ray.z > depth)\n            return BinarySearch",
            "if (ray.z >= depth)\n            return BinarySearch",
        )],
    ),
    edited(
        "search-off-screen",
        "ssct",
        Views::Gloss,
        &[(
            MARCH,
            "        // Departure: a search that leaves the screen has nothing left to refine (author's program).\n        if (LeftScreen(ray.xy))",
            "        if (false)",
        )],
    ),
    edited(
        "linear-nearest",
        "linear",
        Views::Gloss,
        &[
            (
                MARCH,
                "float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;\n\n        // 15-19",
                "float depth = texelFetch(hiZBuffer, ivec2(ray.xy * thesis.resolution), 0).r;\n\n        // 15-19",
            ),
            (
                MARCH,
                "float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;\n\n        // 37-40",
                "float depth = texelFetch(hiZBuffer, ivec2(ray.xy * thesis.resolution), 0).r;\n\n        // 37-40",
            ),
        ],
    ),
    edited(
        "linear-from-pixel",
        "linear",
        Views::Gloss,
        &[(
            "thesis/linear.frag",
            "LinearRayMarch(pixel.P_ss + dir * stride, dir, stride)",
            "LinearRayMarch(pixel.P_ss, dir, stride)",
        )],
    ),
    edited(
        "sslr-off-screen",
        "sslr",
        Views::Gloss,
        &[(
            MARCH,
            "as the text says of practice.\n        if (LeftScreen(ray.xy))",
            "as the text says of practice.\n        if (false)",
        )],
    ),
    changed("search-tolerance", "ssct", Views::Gloss, |s| s.with(|p: &mut MarchParams| p.search_tolerance = 2e-4)),
    changed("search-first", "ssct", Views::Gloss, |s| {
        s.with(|p: &mut MarchParams| (p.search_tolerance, p.search_first) = (2e-4, 0.25 / 1.5))
    }),
    edited(
        "linearize",
        "ssct",
        Views::Gloss,
        &[("thesis/visibility.frag", "range.near_plane - z *", "range.near_plane - (2.0 * z - 1.0) *")],
    ),
    edited(
        "step-back",
        "ssct",
        Views::Gloss,
        &[(HI_Z, "max(ray.z, GetCellMinimumDepthPlane(ray.xy, level))", "GetCellMinimumDepthPlane(ray.xy, level)")],
    ),
    edited(
        "planes",
        "ssct",
        Views::Gloss,
        &[(
            HI_Z,
            "CrossedCellBoundary(cellIndex, GetCell(temporaryRay, cellCount));",
            "GetCellBoundaryDepthPlane(rayOrigin, rayDirection, cellIndex, cellCount, crossStep, crossOffset) < minimumPlane;",
        )],
    ),
    edited(
        "hi-z-off-screen",
        "ssct",
        Views::Gloss,
        &[(HI_Z, "        if (LeftScreen(ray.xy))\n            return INVALID_RAY;", "")],
    ),
    changed("iterations", "ssct", Views::Gloss, |s| s.with(|p: &mut HiZParams| p.iterations = 65536)),
    edited(
        "cell-count",
        "ssct",
        Views::Gloss,
        &[(
            HI_Z,
            "max(floor(size / (level > 0.0 ? exp2(level) : 1.0)), vec2(1.0))",
            "floor(size / (level > 0.0 ? exp2(level) : 1.0))",
        )],
    ),
    changed("cross-offset", "ssct", Views::Gloss, |s| s.with(|p: &mut HiZParams| p.cross_offset = 0.001)),
    edited("cosine", "ssct", Views::Gloss, &[(ANGLE, HALF_ROUGHNESS, "return cos(cos(0.5 * roughness));")]),
    edited(
        "growing-alpha",
        "ssct",
        Views::Gloss,
        &[(ANGLE, HALF_ROUGHNESS, "return acos(pow(0.244, 1.0 / (mix(0.1, 1024.0, roughness) + 1.0)));")],
    ),
    changed("interpolated", "ssct", Views::Gloss, |s| {
        s.with(|p: &mut ConeParams| p.cone_angle = ConeAngle::Interpolated)
    }),
    edited("no-cone", "ssct", Views::Gloss, &[(ANGLE, HALF_ROUGHNESS, "return 0.0;")]),
    changed("lengthened", "ssct", Views::Gloss, |s| s.with(|p: &mut ConeParams| p.cone_lengthened = true)),
    edited(
        "level-of-height",
        "ssct",
        Views::Gloss,
        &[(
            CONE,
            "r * max(thesis.resolution.x, thesis.resolution.y)",
            "r * min(thesis.resolution.x, thesis.resolution.y)",
        )],
    ),
    edited(
        "no-fallback",
        "ssct",
        Views::Gloss,
        &[(
            "thesis/ray_trace.glsl",
            "if (V_ss.z <= thesis.view_direction_epsilon)",
            "if (1.0 <= thesis.view_direction_epsilon)",
        )],
    ),
    changed("sslr-nearest", "sslr", Views::Gloss, |s| {
        s.with(|p: &mut SslrParams| p.depth_sampling = DepthSampling::Nearest)
    }),
    changed("sslr-nearest-mirrors", "sslr", Views::GlossMirrors, |s| {
        s.with(|p: &mut SslrParams| p.depth_sampling = DepthSampling::Nearest)
    }),
    changed("sslr-hardware", "sslr", Views::Gloss, |s| {
        s.with(|p: &mut SslrParams| p.mask_filter = MaskFilter::Hardware)
    }),
    edited(
        "sigma-1",
        "sslr",
        Views::Gloss,
        &[
            ("common/constants.glsl", "GAUSSIAN_0 = 0.474", "GAUSSIAN_0 = 0.39905"),
            ("common/constants.glsl", "GAUSSIAN_1 = 0.233", "GAUSSIAN_1 = 0.24204"),
            ("common/constants.glsl", "GAUSSIAN_2 = 0.028", "GAUSSIAN_2 = 0.05400"),
            ("common/constants.glsl", "GAUSSIAN_3 = 0.002", "GAUSSIAN_3 = 0.00443"),
        ],
    ),
    edited(
        "linear-8-bits",
        "sslr",
        Views::Gloss,
        &[(
            "thesis/sslr_ray_trace.frag",
            "vec4(textureLod(colorBuffer, hit.xy, 0.0).rgb, rayLength);",
            "vec4(round(clamp(textureLod(colorBuffer, hit.xy, 0.0).rgb, 0.0, 1.0) * 255.0) / 255.0, rayLength);",
        )],
    ),
    changed("spreading", "sslr", Views::Gloss, |s| s.with(|p: &mut SslrParams| p.spreading_factor = 10.0)),
    edited(
        "cone-direction",
        "ssct",
        Views::Gloss,
        // R_origin and R_direction of Eq. 4.4: from the near plane to the far plane, through pixel and hit.
        &[(
            CONE,
            "    vec3 color = HiZConeTrace(texCoord, hit.xy, theta);",
            "    float depth = textureLod(hiZBuffer, texCoord, 0.0).r;\n    vec2 direction = (hit.xy - texCoord) / (hit.z - depth);\n    vec2 origin = texCoord - direction * depth;\n    vec3 color = HiZConeTrace(origin, origin + direction, theta);",
        )],
    ),
    edited(
        "length-over-diagonal",
        "sslr",
        Views::Gloss,
        &[(
            "thesis/sslr_ray_trace.frag",
            "float rayLength = min(distance(pixel.P_ss.xy, hit.xy), 1.0);",
            "float rayLength = distance(pixel.P_ss.xy, hit.xy) / sqrt(2.0);",
        )],
    ),
    changed("poster-retries", "poster", Views::Gloss, |s| s.with(|p: &mut PosterParams| p.edge_retries = 3)),
    edited(
        "poster-any-facing",
        "poster",
        Views::Gloss,
        &[(POSTER, "if (dot(facing, cone.direction) >= 0.0)", "if (false)")],
    ),
    edited(
        "poster-at-hit",
        "poster",
        Views::Gloss,
        &[(POSTER, "vec2 beyond = hit.xy +", "vec2 beyond = hit.xy + 0.0 *")],
    ),
    changed("poster-volume", "poster", Views::Gloss, |s| {
        s.with(|p: &mut PosterParams| p.poster_filter = PosterFilter::Volume)
    }),
    changed("poster-edge-aware", "poster", Views::Gloss, |s| {
        s.with(|p: &mut PosterParams| p.poster_filter = PosterFilter::EdgeAware)
    }),
];

/// Renders a variant's method with a setup on a view. Returns the reflection as a display image.
fn render_side(stage: &mut Stage, variant: &Variant, setup: &Setup, scene: &ssct_scenes::Scene, view: &str) -> Rgb {
    let method = METHODS.iter().find(|m| m.name == variant.method).expect("a method");
    let view = scene.view(view).expect("a view");
    let materials = variant.views.globals().materials(scene, view);
    let shot = Shot::new(stage, method, setup, Wants::REFLECTION, view.camera(scene, variant.views.size()), materials)
        .expect("a shot");
    display(&image::render(stage, &shot, false).expect("an image").reflection)
}

/// Measures a variant on its views of a scene, and prints a row for each. `unchanged` has the images of unchanged
/// methods so far, with which other variants are compared, too.
fn measure(
    stage: &mut Stage,
    variant: &Variant,
    scene: &ssct_scenes::Scene,
    shaders: &Shaders,
    unchanged: &mut HashMap<String, Rgb>,
) {
    let views: Vec<_> = variant.views.scenes_and_views().into_iter().filter(|(name, _)| *name == scene.name).collect();
    if views.is_empty() {
        return;
    }
    let unchanged_setup = (variant.base)(&Setup::new(variant.views.size()));
    let changed_setup = (variant.change)(&unchanged_setup);
    let recorded = unchanged_setup.recorded(METHODS.iter().find(|m| m.name == variant.method));
    // The key of an unchanged image names everything on which the image depends.
    let key = |view: &str| format!("{} {view} {:?} {recorded:?}", variant.method, variant.views.globals().roughness);
    for (_, view) in &views {
        unchanged.entry(key(view)).or_insert_with(|| render_side(stage, variant, &unchanged_setup, scene, view));
    }
    let gpu = stage.context.gpu().clone();
    shaders.run_with(&gpu, variant.edits, || {
        for (_, view) in &views {
            let changed_image = render_side(stage, variant, &changed_setup, scene, view);
            let (share, rmse) = difference(&unchanged[&key(view)], &changed_image);
            println!("{},{},{},{view},{share:.6},{rmse:.6}", variant.name, variant.method, scene.name);
        }
    });
}

/// Measures the variants that the command line names, or all of them, on every scene that they have views of.
fn main() {
    let wanted: Vec<_> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let gpu = Gpu::open(&DeviceQuery::default()).expect("a Vulkan device");
    let shaders = Shaders::new();
    println!("# {} ({}), ssct {}", gpu.info().name, gpu.info().driver, env!("CARGO_PKG_VERSION"));
    println!("variant,method,scene,view,share,rmse");
    for name in library::names() {
        let scene = library::scene(name).expect("a built-in scene");
        let mut stage = Stage::new(&gpu, &scene).expect("device memory");
        let mut unchanged = HashMap::new();
        for variant in
            VARIANTS.iter().chain(schmidt::VARIANTS).filter(|v| wanted.is_empty() || wanted.iter().any(|w| w == v.name))
        {
            measure(&mut stage, variant, &scene, &shaders, &mut unchanged);
        }
    }
}
