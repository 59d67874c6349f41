//! Tests the table of requests that an effect refuses: each row is the first match of some request, and names a
//! parameter that exists.

use ssct::methods::exclusions::{EXCLUSIONS, EffectRequest, Exclusion, GivenPart, check};
use ssct::methods::layers::LayerParams;
use ssct::methods::setup::{BeyondScreen, CaptureCount, Tracer};
use ssct::methods::{EffectParams, Fallback, Setup, find, parameters};
use ssct::passes::trace_normals::TraceNormals;
use ssct_ground::scene::ProjectionKind;

/// Returns a request for a method beside the scene.
fn with_scene<'a>(method: &'static str, setup: &'a Setup) -> EffectRequest<'a> {
    let info = find(method).unwrap();
    let (effect, given_part) = (setup.effect(), None);
    EffectRequest { info, setup, effect, has_scene: true, has_captures: false, has_triangles: false, given_part }
}

/// Returns a request for a method on a G-buffer without the scene, beside the captures or triangles that the caller
/// brought, if any.
fn without_scene<'a>(method: &'static str, setup: &'a Setup, given_part: Option<GivenPart>) -> EffectRequest<'a> {
    let [has_captures, has_triangles] =
        [GivenPart::Captures, GivenPart::Triangles].map(|part| given_part == Some(part));
    EffectRequest { has_scene: false, has_captures, has_triangles, given_part, ..with_scene(method, setup) }
}

/// For each row of the table in order, one request is refused by that row first, in a sentence. A row that an earlier
/// one covers would never be used. A plain request is not refused.
#[test]
fn each_row_is_the_first_that_refuses_some_request() {
    let plain = Setup::new([8, 8]);
    let with = |change: fn(&mut EffectParams)| plain.with(change);
    let (captures, triangles) = (Some(GivenPart::Captures), Some(GivenPart::Triangles));
    let in_captures = |setup| EffectRequest { has_captures: true, ..with_scene("unified", setup) };
    let among_triangles = |setup| EffectRequest { has_triangles: true, ..with_scene("unified", setup) };
    let at_eye = with(|p| p.captures = CaptureCount::Camera);
    let renewed = with(|p| p.captures_per_frame = 1);
    let at_camera = with(|p| (p.captures, p.captures_per_frame) = (CaptureCount::Camera, 1));
    let on_screen = with(|p| p.beyond = BeyondScreen::None);
    let queried = with(|p| p.tracer = Tracer::Query);
    let parallel = plain.seen_by(ProjectionKind::Orthographic);
    let small = with(|p| p.resolution_scale = 0.5);
    let layered = plain.with(|p: &mut LayerParams| p.layers = 2);
    let level = with(|p| p.trace_normals = TraceNormals::Up);
    let bouncing = with(|p| p.bounces = 2);
    let bumped = with(|p| p.bump_after = 1.0);
    let over_maps = with(|p| p.fallback = Fallback::Pccm);
    let requests = [
        without_scene("ssct", &plain, captures),
        without_scene("unified", &at_eye, captures),
        without_scene("unified", &renewed, captures),
        in_captures(&at_camera),
        without_scene("ssct", &plain, triangles),
        without_scene("unified", &on_screen, triangles),
        without_scene("unified", &queried, triangles),
        without_scene("pccm", &plain, None),
        with_scene("ssct", &parallel),
        with_scene("pccm", &small),
        without_scene("dda", &layered, None),
        with_scene("pccm", &level),
        with_scene("pccm", &bouncing),
        among_triangles(&bouncing),
        with_scene("ssct", &bumped),
        with_scene("pccm", &over_maps),
        without_scene("ssct", &over_maps, None),
    ];
    let first = |request: &EffectRequest| EXCLUSIONS.iter().position(|exclusion| (exclusion.applies)(request));
    assert_eq!(requests.iter().filter_map(first).collect::<Vec<_>>(), (0..EXCLUSIONS.len()).collect::<Vec<_>>());
    for request in &requests {
        assert!(check(request).is_err_and(|e| e.to_string().len() > 40));
    }
    assert!(check(&with_scene("unified", &plain)).is_ok());
}

/// Each row names a parameter of the methods, or the method itself, since the window shows the refusal beside that
/// parameter.
#[test]
fn each_row_names_a_parameter_that_there_is() {
    let named: Vec<&str> = parameters().into_iter().map(|(parameter, _)| parameter.name).collect();
    for Exclusion { parameter, .. } in EXCLUSIONS {
        assert!(*parameter == "method" || named.contains(parameter), "{parameter}");
    }
}
