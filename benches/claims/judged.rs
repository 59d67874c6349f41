//! Compares each method with a copy of it in which one thing is changed: how much the change does to the image, and
//! which of the two images is nearer to the truth.
//!
//! Columns: claim, method, scene, view, roughness, and then numbers. `share` and `rmse` say by how much the display
//! images differ, as in `cargo bench --bench errata`. `error` and `error_changed` are the RMSE of the reflection
//! against the reference, unchanged and changed. Mirrors also have `right` and `right_changed`, the shares of right
//! hits by the oracle, and `false` and `false_changed`, the shares of false hits.
//!
//! Claims of the documents are compared with the exact image of the same screen, at 480×270. Claims named `dda-…` are
//! those of the errata of that method, at 320×180. All others are compared with the world: `billboards-…` and `car-…`
//! (only the bodies of the cars reflect) at 640×360, and `behind-…` (the fallback behind a screen-space method) at
//! 320×180.

use super::edited::{Edits, difference};
use super::{Bench, Change, SAME, THESIS, globals, method, scene};
use ssct::methods::billboard::BillboardParams;
use ssct::methods::dda::DdaParams;
use ssct::methods::setup::{EffectParams, Fallback};
use ssct::methods::ssct::ThesisDrawing;
use ssct::methods::thesis::MarchParams;
use ssct::methods::{MethodInfo, Setup, Wants};
use ssct::passes::billboard::{Occlusion, Order};
use ssct::passes::color_chain::ChainFilter;
use ssct_ground::math::OracleVersion;
use ssct_lab::report::images::{Rgb, display};
use ssct_lab::stage::{Globals, Shot, Stage, gbuffer, image};
use ssct_scenes::{Material, Scene, View};
use ssct_truth::metrics::hits::HitAgreement;
use ssct_truth::metrics::image::masked_rmse;
use ssct_truth::reference::first_hits::FirstHits;
use ssct_truth::reference::hierarchy::Hierarchy;
use ssct_truth::reference::screen::{Sampling, ScreenReference};
use ssct_truth::reference::surface::World;
use ssct_truth::reference::world::WorldReference;
use std::collections::HashMap;

/// Rays a pixel of the references.
const RAYS: u32 = 16;

/// The views on which a claim is measured, and the reference with which its images are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// The thesis's views against the exact image of the screen.
    Thesis,
    /// Views of rooms, museum and street against the exact image of the screen.
    Dda,
    /// Views with billboards against the world.
    Billboards,
    /// Views of scenes with polished floors against the world.
    Behind,
    /// The bodies of the street's cars against the world, in the view of Schmidt's figure 47.
    Car,
}

impl Place {
    /// The scenes of the place, each with the names of its views; an empty list stands for all views.
    fn views(self) -> &'static [(&'static str, &'static [&'static str])] {
        match self {
            Self::Thesis => THESIS,
            Self::Dda => &[("rooms", &[]), ("museum", &[]), ("street", &[])],
            Self::Billboards => &[("street", &["street", "car", "puddles", "signs"]), ("museum", &["museum"])],
            Self::Behind => &[("museum", &[]), ("corridor", &[]), ("rooms", &[])],
            Self::Car => &[("street", &["car"])],
        }
    }

    /// The width and height of the images in pixels.
    fn size(self) -> [u32; 2] {
        match self {
            Self::Thesis => [480, 270],
            Self::Dda | Self::Behind => [320, 180],
            Self::Billboards | Self::Car => [640, 360],
        }
    }

    /// The global factors for a roughness.
    fn globals(self, roughness: f32) -> Globals {
        match self {
            Self::Dda | Self::Behind => Globals { roughness: Some(roughness), ..Globals::default() },
            Self::Thesis | Self::Billboards | Self::Car => globals(roughness, 0.1),
        }
    }

    /// Returns the materials of a view at a roughness. At the place `Car`, only the bodies of cars reflect.
    fn materials(self, scene: &Scene, view: &View, roughness: f32) -> Vec<Material> {
        let mut materials = self.globals(roughness).materials(scene, view);
        if self == Self::Car {
            let bodies: Vec<usize> =
                scene.meshes.iter().filter(|mesh| mesh.name == "car-body").map(|mesh| mesh.material).collect();
            let others = materials.iter_mut().enumerate().filter(|(n, _)| !bodies.contains(n));
            others.for_each(|(_, material)| material.reflectivity = 0.0);
        }
        materials
    }
}

/// A claim: a method, and the change whose effect is judged.
struct Claim {
    name: &'static str,
    method: &'static str,
    place: Place,
    /// The roughness values at which the claim is measured.
    roughness: &'static [f32],
    /// The change of parameters on both sides.
    base: Change,
    /// The change of parameters on the changed side, made after `base`.
    change: Change,
    /// The changes of shaders on the changed side.
    edits: Edits,
}

/// Makes a claim that edits lines of a method's shaders, on the thesis's views.
const fn edited(name: &'static str, method: &'static str, roughness: &'static [f32], edits: Edits) -> Claim {
    Claim { name, method, place: Place::Thesis, roughness, base: SAME, change: SAME, edits }
}

/// Makes a claim about lines of the shader of `dda`; `base` sets parameters of both sides.
const fn dda(name: &'static str, base: Change, edits: Edits) -> Claim {
    Claim { name, method: "dda", place: Place::Dda, roughness: &[0.0], base, change: SAME, edits }
}

/// Makes a claim about parameters of `billboard`.
const fn billboards(name: &'static str, change: Change) -> Claim {
    Claim { name, method: "billboard", place: Place::Billboards, roughness: &[0.0], base: SAME, change, edits: &[] }
}

/// Makes a claim about the fallback behind `ssct`.
const fn behind(name: &'static str, change: Change) -> Claim {
    Claim { name, method: "ssct", place: Place::Behind, roughness: &[0.0, 0.1], base: SAME, change, edits: &[] }
}

/// Makes a claim about how a method shows the bodies of cars.
const fn car(name: &'static str, method: &'static str, edits: Edits) -> Claim {
    Claim { name, method, place: Place::Car, roughness: &[0.0], base: SAME, change: SAME, edits }
}

// Shaders, lines of them that claims change, and changes that several claims make.
const VISIBILITY: &str = "thesis/visibility.frag";
const MARCH: &str = "thesis/linear_ray_march.glsl";
const SCHMIDT: &str = "schmidt/screen_space_reflections.frag";
const TRACE: &str = "thesis/sslr_ray_trace.frag";
const DDA: &str = "dda/dda.frag";
const COARSE_VISIBILITY: &str = "coarseVisibility = dot(vec4(0.25), integration);";
const RAY_LENGTH: &str = "float rayLength = min(distance(pixel.P_ss.xy, hit.xy), 1.0);";
const MINIMUM_OF_FOUR: &str = "float z_min = min(min(z0.r, z1.r), min(z2.r, z3.r));";
const FIRST_STEP: &str = "float from = REFINE && i == 1 ? OWN_PIXEL : max(s - 0.5 * dda.stride, OWN_PIXEL);";
const FROM_START: Edits = &[(DDA, FIRST_STEP, "float from = i == 1 ? 0.0 : max(s - 0.5 * dda.stride, OWN_PIXEL);")];
const SECOND_WAY: Edits = &[(DDA, "meets = meets || (behind && !was_behind[l]);", "")];

/// Makes a Hi-Z buffer of true minima: every texel that a cell covers is read.
pub const TRUE_MINIMA: Edits = &[(
    "thesis/hi_z.frag",
    MINIMUM_OF_FOUR,
    "float z_min = z0.r;\n    for (int y = 0; y <= hiz.Offset.y; ++y)\n        for (int x = 0; x <= hiz.Offset.x; ++x)\n            z_min = min(z_min, ReadDepth(P_sample + ivec2(x, y)).r);",
)];

/// Interpolates the Hi-Z buffer between the four cells around a place, in place of reading the cell there.
const LINEAR_HI_Z: Edits = &[(
    "thesis/hi_z_ray_trace.glsl",
    "    return textureLod(hiZBuffer, ray, level).r;",
    "    int l = int(level);\n    ivec2 last = textureSize(hiZBuffer, l) - 1;\n    vec2 place = ray * vec2(last + 1) - 0.5;\n    ivec2 a = clamp(ivec2(floor(place)), ivec2(0), last), b = min(a + 1, last);\n    vec2 share = clamp(place - vec2(a), 0.0, 1.0);\n    float near = mix(texelFetch(hiZBuffer, a, l).r, texelFetch(hiZBuffer, ivec2(b.x, a.y), l).r, share.x);\n    return mix(near, mix(texelFetch(hiZBuffer, ivec2(a.x, b.y), l).r, texelFetch(hiZBuffer, b, l).r, share.x), share.y);",
)];

/// Makes the linear march compare depths in metres. It interpolates them linearly along the ray on the screen, as if
/// the ray were straight in them.
const LINEAR_DEPTH: Edits = &[
    (
        MARCH,
        "bool LeftScreen(vec2 ray) {",
        "float Metres(float z) {\n    return thesis.near_plane * thesis.far_plane / (thesis.far_plane - z * (thesis.far_plane - thesis.near_plane));\n}\n\nbool LeftScreen(vec2 ray) {",
    ),
    (
        MARCH,
        "float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;\n\n        // 15-19",
        "float depth = Metres(textureLod(hiZBuffer, ray.xy, 0.0).r);\n\n        // 15-19",
    ),
    (
        MARCH,
        "float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;\n\n        // 37-40",
        "float depth = Metres(textureLod(hiZBuffer, ray.xy, 0.0).r);\n\n        // 37-40",
    ),
    (MARCH, "if (abs(depthDelta) < DEPTH_DELTA_EPSILON)", "if (abs(depthDelta) < 0.01)"),
    (
        "thesis/linear.frag",
        "    vec3 dir = normalize(pixel.V_ss);",
        "    vec3 end = pixel.P_ss + pixel.V_ss;\n    pixel.P_ss.z = Metres(pixel.P_ss.z);\n    vec3 dir = vec3(end.xy, Metres(end.z)) - pixel.P_ss;\n    dir /= max(length(dir.xy), 1e-9);",
    ),
];

/// Makes Schmidt's march compare depths as they are stored, with the same number for the thickness.
const POST_PROJECTED: Edits = &[(
    SCHMIDT,
    "    return (2.0 * camera.near_plane)\n        / (camera.far_plane + camera.near_plane - z * (camera.far_plane - camera.near_plane));",
    "    return z;",
)];

/// Makes the ray of Schmidt's march straight in linearised depth.
const STRAIGHT_IN_LINEAR: Edits = &[(
    SCHMIDT,
    "        float currentDepth = linearizeDepth(currentSamplePosition.z);\n        float sampledDepth = SampleDepth(samplingPosition, currentDepth, 0.001);",
    "        float first = linearizeDepth(ssPosition.z);\n        float currentDepth = first + float(count + 2) * (linearizeDepth(ssPosition.z + ssReflectionVector.z) - first);\n        float sampledDepth = SampleDepth(samplingPosition, currentDepth, 0.001);",
)];

/// Makes Schmidt's shader reflect nothing.
const BLACK: Edits = &[(
    SCHMIDT,
    "        out_reflection = ScreenSpaceReflections(vsPosition, vsNormal, vsReflectionVector);",
    "        out_reflection = vec4(0.0);",
)];

/// Makes a claim that computes the cone's angle by Eq. 4.5 with another ξ, from the exponent of the lobe that a
/// roughness stands for.
macro_rules! xi {
    ($value:literal) => {
        edited(
            concat!("xi-", $value),
            "ssct",
            &[0.1, 0.3, 0.6],
            &[(
                "thesis/cone_angle.glsl",
                "return 0.5 * max(roughness, 0.0);",
                concat!("return acos(pow(cos(0.5 * max(roughness, 0.0)), log(", $value, ") / log(0.244)));"),
            )],
        )
    };
}

const CLAIMS: &[Claim] = &[
    xi!("0.01"),
    xi!("0.05"),
    xi!("0.1"),
    xi!("0.15"),
    xi!("0.2"),
    xi!("0.3"),
    xi!("0.4"),
    xi!("0.5"),
    xi!("0.7"),
    xi!("0.9"),
    edited(
        "visibility-7-bits",
        "ssct",
        &[0.1, 0.3, 0.6],
        &[(VISIBILITY, COARSE_VISIBILITY, "coarseVisibility = round(dot(vec4(0.25), integration) * 127.0) / 127.0;")],
    ),
    edited(
        "visibility-4-bits",
        "ssct",
        &[0.1, 0.3, 0.6],
        &[(VISIBILITY, COARSE_VISIBILITY, "coarseVisibility = round(dot(vec4(0.25), integration) * 15.0) / 15.0;")],
    ),
    edited("visibility-none", "ssct", &[0.1, 0.3, 0.6], &[(VISIBILITY, COARSE_VISIBILITY, "coarseVisibility = 1.0;")]),
    edited(
        "length-7-bits",
        "sslr",
        &[0.1, 0.3],
        &[(TRACE, RAY_LENGTH, "float rayLength = round(min(distance(pixel.P_ss.xy, hit.xy), 1.0) * 127.0) / 127.0;")],
    ),
    edited(
        "length-4-bits",
        "sslr",
        &[0.1, 0.3],
        &[(TRACE, RAY_LENGTH, "float rayLength = round(min(distance(pixel.P_ss.xy, hit.xy), 1.0) * 15.0) / 15.0;")],
    ),
    edited("mask", "sslr", &[0.1, 0.3], &[("thesis/sslr_blur.frag", "return Mask(texCoord) > 0.0 ?", "return true ?")]),
    edited("true-minima", "ssct", &[0.0, 0.1], TRUE_MINIMA),
    edited("linear-hi-z", "ssct", &[0.0, 0.1], LINEAR_HI_Z),
    edited("linear-hi-z-hzct", "hzct", &[0.0], LINEAR_HI_Z),
    Claim {
        base: |s| s.with(|p: &mut MarchParams| p.search_tolerance = 2e-4),
        ..edited("linear-depth", "linear", &[0.0], LINEAR_DEPTH)
    },
    edited("ssr-post-projected", "ssr", &[0.0], POST_PROJECTED),
    edited("ssr-straight-in-linear", "ssr", &[0.0], STRAIGHT_IN_LINEAR),
    car("car-ssr", "ssr", BLACK),
    car("car-ssr-fast", "ssr-fast", BLACK),
    car("car-pccm", "pccm", &[]),
    car("car-billboard", "billboard", &[]),
    edited("true-minima-hzct", "hzct", &[0.0], TRUE_MINIMA),
    Claim {
        change: |s| s.with(|p: &mut ThesisDrawing| p.chain_filter = ChainFilter::Gaussian),
        ..edited("gaussian", "ssct", &[0.1, 0.3, 0.6], &[])
    },
    dda(
        "dda-depth-before",
        |s| s.with(|p: &mut DdaParams| (p.dda_stride, p.dda_jitter) = (16, true)),
        &[(DDA, "Meets(line, Place(line, s), from, next, l);", "Meets(line, Place(line, s), from, s, l);")],
    ),
    dda(
        "dda-from-start-1",
        |s| s.with(|p: &mut DdaParams| (p.dda_stride, p.dda_jitter, p.dda_refine) = (1, true, false)),
        FROM_START,
    ),
    dda(
        "dda-from-start-4",
        |s| s.with(|p: &mut DdaParams| (p.dda_stride, p.dda_jitter, p.dda_refine) = (4, true, false)),
        FROM_START,
    ),
    dda("dda-second-way-4", SAME, SECOND_WAY),
    dda("dda-second-way-16", |s| s.with(|p: &mut DdaParams| p.dda_stride = 16), SECOND_WAY),
    dda(
        "dda-unchecked",
        |s| s.with(|p: &mut DdaParams| (p.dda_stride, p.dda_jitter) = (16, true)),
        &[(
            DDA,
            "if (!REFINE || Meets(line, Place(line, hit), max(hit - 1.0, OWN_PIXEL), hit, l)) {",
            "if (REFINE && !Meets(line, Place(line, hit), max(hit - 1.0, OWN_PIXEL), hit, l))\n                hit = s;\n            {",
        )],
    ),
    billboards("billboards-unbroken", |s| s.with(|p: &mut BillboardParams| p.billboard_order = Order::Unbroken)),
    billboards("billboards-nearest", |s| s.with(|p: &mut BillboardParams| p.billboard_order = Order::Nearest)),
    billboards("billboards-occlusion", |s| {
        s.with(|p: &mut BillboardParams| {
            (p.billboard_order, p.billboard_occlusion) = (Order::Nearest, Occlusion::Depth);
        })
    }),
    behind("behind-planar", |s| s.with(|p: &mut EffectParams| p.fallback = Fallback::Planar)),
    behind("behind-pccm", |s| s.with(|p: &mut EffectParams| p.fallback = Fallback::Pccm)),
    behind("behind-environment", |s| s.with(|p: &mut EffectParams| p.fallback = Fallback::Environment)),
];

/// A linear colour for each pixel.
type Colors = Vec<[f32; 3]>;

/// The truth with which the images of a view at a roughness are compared.
struct Truth {
    /// Which pixels reflect.
    mask: Vec<bool>,
    /// The reference's reflection.
    color: Colors,
    /// Positions of the oracle's hits in pixels; `None` unless all surfaces are mirrors.
    hits: Option<Vec<Option<[f64; 2]>>>,
}

/// An image of a method.
struct MethodImage {
    /// The reflection as a display image.
    display: Rgb,
    /// The reflection in linear colour.
    color: Colors,
    /// Positions of the hits in pixels, if the method tells them.
    hits: Option<Vec<Option<[f64; 2]>>>,
}

/// A view of a scene at a roughness, drawn as a claim's place says.
struct Subject<'a> {
    scene: &'a Scene,
    view: &'a View,
    place: Place,
    roughness: f32,
}

impl Subject<'_> {
    /// Draws an image of a method; returns it with the shot that drew it.
    fn draw(&self, stage: &mut Stage, method: &MethodInfo, setup: &Setup) -> (MethodImage, Shot) {
        let materials = self.place.materials(self.scene, self.view, self.roughness);
        let camera = self.view.camera(self.scene, self.place.size());
        let wants = if method.is_screen_space() { Wants::HITS } else { Wants::REFLECTION };
        let shot = Shot::new(stage, method, setup, wants, camera, materials).expect("a shot");
        let image = image::render(stage, &shot, true).expect("an image");
        let intermediates = image.intermediates.unwrap_or_default();
        let hits =
            intermediates.iter().find(|(name, ..)| name == "hits").map(|(.., hits)| gbuffer::hit_positions(hits));
        let color = image.reflection.texels().map(|texel| [texel[0], texel[1], texel[2]]).collect();
        (MethodImage { display: display(&image.reflection), color, hits }, shot)
    }

    /// Makes the truth for the G-buffer that a shot drew last: the exact image of the screen or of the world, as the
    /// place says.
    fn compute_truth(&self, stage: &mut Stage, shot: &Shot) -> Truth {
        let data = gbuffer::read(&mut stage.context, shot).expect("the G-buffer");
        let mask = data.reflecting();
        if [Place::Billboards, Place::Behind, Place::Car].contains(&self.place) {
            let materials = self.place.materials(self.scene, self.view, self.roughness);
            let world = World::new(self.scene, &materials);
            let first_hits = FirstHits::shown(&world, &data);
            let reference = WorldReference::new(&world, &first_hits, &data.camera, 1);
            let mut state = reference.start();
            reference.add(&mut state, RAYS);
            let color = reference.image(&state).reflection.iter().map(|c| c.to_array()).collect();
            return Truth { mask, color, hits: None };
        }
        let sampling = Sampling { samples: RAYS, seed: 1, oracle: OracleVersion::default(), bounces: 1 };
        let image = ScreenReference::render(&data, &mask, sampling);
        let hierarchy = Hierarchy::new(&data);
        let oracle_hit = |i: usize| {
            let (x, y) = (i as u32 % data.width, i as u32 / data.width);
            mask[i].then(|| hierarchy.trace(x, y).position()).flatten().map(|p| [p.x, p.y])
        };
        let hits = (self.roughness == 0.0).then(|| (0..mask.len()).map(oracle_hit).collect());
        Truth { color: image.color.iter().map(|c| c.to_array()).collect(), hits, mask }
    }
}

/// Returns the shares of right and of false hits as texts; empty where there are no hits to compare.
fn hit_shares(truth: &Truth, image: &MethodImage) -> [String; 2] {
    let both_hits = truth.hits.as_ref().zip(image.hits.as_ref());
    let Some((oracle_hits, method_hits)) = both_hits else { return Default::default() };
    let agreement = HitAgreement::new(&truth.mask, method_hits, oracle_hits);
    [agreement.hit_agreement, agreement.false_hits].map(|share| share.map_or_else(String::new, |s| format!("{s:.6}")))
}

/// The unchanged images of methods, and the truths. Several claims need them, and their keys name all that they depend
/// on.
#[derive(Default)]
struct Cache {
    images: HashMap<String, MethodImage>,
    truths: HashMap<String, Truth>,
}

/// Measures a claim on a view, and prints its row.
fn judge(bench: &Bench, stage: &mut Stage, claim: &Claim, subject: &Subject, cache: &mut Cache) {
    let info = method(claim.method);
    let unchanged_setup = (claim.base)(&Setup::new(claim.place.size()));
    let truth_key = format!("{} {} {:?}", subject.view.name, subject.roughness, claim.place);
    let image_key = format!("{} {truth_key} {:?}", claim.method, unchanged_setup.recorded(Some(info)));
    if !cache.images.contains_key(&image_key) || !cache.truths.contains_key(&truth_key) {
        let (image, shot) = subject.draw(stage, info, &unchanged_setup);
        cache.images.insert(image_key.clone(), image);
        cache.truths.entry(truth_key.clone()).or_insert_with(|| subject.compute_truth(stage, &shot));
    }
    let changed_setup = (claim.change)(&unchanged_setup);
    let (changed, _) = bench.shaders.run_with(&bench.gpu, claim.edits, || subject.draw(stage, info, &changed_setup));
    let (unchanged, truth) = (&cache.images[&image_key], &cache.truths[&truth_key]);
    let (share, rmse) = difference(&unchanged.display, &changed.display);
    let images = [unchanged, &changed];
    let [error, error_changed] = images.map(|image| masked_rmse(&truth.color, &image.color, &truth.mask));
    let [[right, wrong], [right_changed, wrong_changed]] = images.map(|image| hit_shares(truth, image));
    println!(
        "{},{},{},{},{},{share:.6},{rmse:.6},{error:.6},{error_changed:.6},{right},{right_changed},{wrong},{wrong_changed}",
        claim.name, claim.method, subject.scene.name, subject.view.name, subject.roughness
    );
}

/// Judges every claim that is asked for.
pub fn run(bench: &Bench) {
    println!(
        "claim,method,scene,view,roughness,share,rmse,error,error_changed,right,right_changed,false,false_changed"
    );
    for name in ["rooms", "atrium", "street", "museum", "corridor"] {
        let mut loaded = None;
        for claim in CLAIMS.iter().filter(|c| bench.wants(c.name)) {
            let Some((_, views)) = claim.place.views().iter().find(|(scene_name, _)| *scene_name == name) else {
                continue;
            };
            let (scene, stage, cache) = loaded.get_or_insert_with(|| {
                let scene = scene(name);
                let stage = Stage::new(&bench.gpu, &scene).expect("device memory");
                (scene, stage, Cache::default())
            });
            for view in scene.views.iter().filter(|v| views.is_empty() || views.contains(&v.name.as_str())) {
                for &roughness in claim.roughness {
                    judge(bench, stage, claim, &Subject { scene, view, place: claim.place, roughness }, cache);
                }
            }
        }
    }
}
