//! Variants that `ssct error` sweeps: methods with their settings.

use super::error::Variant;
use ssct::methods::setup::{BeyondScreen, CaptureCount, CaptureSide};
use ssct::methods::{EffectParams, Fallback, MethodInfo, Setup};

/// The roughness values of the study.
pub const ROUGHNESS: [f32; 5] = [0.0, 0.05, 0.1, 0.3, 0.6];

/// Every variant of some methods: each method's own sweep, around a base setup.
pub fn variants(methods: &[&'static MethodInfo], base: &Setup) -> Vec<Variant> {
    let method_variants = |method: &&'static MethodInfo| {
        let method = *method;
        method.sweep(base).into_iter().map(move |setup| Variant { method, setup })
    };
    methods.iter().flat_map(method_variants).collect()
}

/// Variants of a method without captures, and with each number of captures at each size of face, around a base setup.
pub fn captures(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    use CaptureCount::{None, Number};
    use CaptureSide::{Scene, Side128, Side256, Side512, Side1024};
    let sides = [Side128, Side256, Side512, Side1024];
    let all = [1, 2, 4, 8].into_iter().flat_map(|count| sides.map(|side| (Number(count), side)));
    let variant = |(count, side)| Variant {
        method,
        setup: base.with(|p: &mut EffectParams| {
            p.beyond = if count == None { BeyondScreen::None } else { BeyondScreen::Captures };
            (p.captures, p.capture_side) = (count, side);
        }),
    };
    std::iter::once((None, Scene)).chain(all).map(variant).collect()
}

/// Variants with each fallback: a screen-space method has none, the environment, or `pccm`; a method that takes captures or
/// triangles also has the captures of `base`, and the triangles of the scene.
pub fn fallbacks(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    use Fallback::{Environment, None, Pccm};
    let behind: &[Fallback] = if method.is_screen_space() { &[None, Environment, Pccm] } else { &[None] };
    let with = |fallback, captures, beyond| Variant {
        method,
        setup: base.with(|p: &mut EffectParams| (p.fallback, p.captures, p.beyond) = (fallback, captures, beyond)),
    };
    let (captures, on_screen) = (base.effect().captures, method.is_screen_space());
    // A method that traces in captures alone always keeps them.
    let without = if on_screen { CaptureCount::None } else { captures };
    let is_captured = on_screen && method.takes_captures && captures != CaptureCount::None;
    let alone = if on_screen { BeyondScreen::None } else { base.effect().beyond };
    let all = behind.iter().map(|fallback| with(*fallback, without, alone));
    let is_among_triangles = on_screen && method.takes_triangles;
    all.chain(is_captured.then(|| with(None, captures, BeyondScreen::Captures)))
        .chain(is_among_triangles.then(|| with(None, without, BeyondScreen::Triangles)))
        .collect()
}

/// Variants of a screen-space method with each number of bounces up to that of `base`; another method has one variant.
pub fn bounces(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    let most = if method.is_screen_space() { base.effect().bounces } else { 1 };
    let with = |n| Variant { method, setup: base.with(|p: &mut EffectParams| p.bounces = n) };
    (1..=most).map(with).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::methods::{METHODS, unified};
    use std::collections::BTreeSet;

    #[test]
    fn a_sweep_of_captures_has_every_number_of_every_size_once() {
        let base = Setup::new([64, 36]);
        let all = captures(&unified::INFO, &base);
        let texels = |v: &Variant| (v.setup.effect().captures.wanted(), v.setup.effect().capture_side.texels());
        let distinct: BTreeSet<String> = all.iter().map(|v| format!("{:?}", texels(v))).collect();
        assert_eq!((all.len(), distinct.len()), (17, 17));
        assert_eq!(texels(&all[0]), (None, None));
    }

    #[test]
    fn a_sweep_of_fallbacks_has_each_and_captures_once() {
        let base = Setup::new([64, 36]).with(|p: &mut EffectParams| p.captures = CaptureCount::Number(4));
        let settings = |name: &str| {
            let method = METHODS.iter().find(|m| m.name == name);
            let variants = method.map_or_else(Vec::new, |method| fallbacks(method, &base));
            let effects = variants.iter().map(|v| v.setup.effect());
            effects.map(|e| (e.fallback, e.captures, e.beyond)).collect::<Vec<_>>()
        };
        use BeyondScreen::{Auto, Captures, None, Triangles};
        let behind = [Fallback::None, Fallback::Environment, Fallback::Pccm].map(|f| (f, CaptureCount::None, None));
        assert_eq!(settings("ssct"), behind);
        let [captured, among] = [(CaptureCount::Number(4), Captures), (CaptureCount::None, Triangles)];
        let more = [captured, among].map(|(captures, beyond)| (Fallback::None, captures, beyond));
        assert_eq!(settings("unified"), [&behind[..], &more].concat());
        assert_eq!(settings("captures"), [(Fallback::None, CaptureCount::Number(4), Auto)]);
    }
}
