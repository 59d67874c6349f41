//! The sweeps of `ssct error`: variants of methods over ranges of their settings.

use super::error::Variant;
use ssct::methods::billboard::{self, BillboardParams};
use ssct::methods::dda::{self, DdaParams};
use ssct::methods::linear::{self, LinearParams};
use ssct::methods::setup::{BeyondScreen, CaptureCount, CaptureSide};
use ssct::methods::stochastic::{self, StochasticParams};
use ssct::methods::{EffectParams, Fallback, MethodInfo, Setup};
use ssct::passes::billboard::{Occlusion, Order};
use ssct::passes::linear_trace::LinearMarch;
use ssct_ground::parameter::Preset;

/// The roughness values of the error study.
pub const ROUGHNESS: [f32; 5] = [0.0, 0.05, 0.1, 0.3, 0.6];

/// Makes the variants of some methods: each method with each of its [`setups`] around a base.
pub fn variants(methods: &[&'static MethodInfo], base: &Setup) -> Vec<Variant> {
    let method_variants = |method: &&'static MethodInfo| {
        let method = *method;
        setups(method, base).into_iter().map(move |setup| Variant { method, setup })
    };
    methods.iter().flat_map(method_variants).collect()
}

/// Makes the setups of a method around a base. First come the published preset, and this preset with each value of each
/// parameter's sweep. The same of the author's preset follows, if it has other values for the method, and then
/// combinations of several parameters.
pub fn setups(method: &MethodInfo, base: &Setup) -> Vec<Setup> {
    let parameters = method.read_parameters();
    let mut all: Vec<Setup> = Vec::new();
    for preset in [Preset::Published, Preset::Author] {
        if preset == Preset::Author && !parameters.iter().any(|p| p.author != p.published) {
            continue;
        }
        let preset_setup = base.of_preset(preset);
        all.push(preset_setup.clone());
        for parameter in &parameters {
            for (swept_preset, value) in &parameter.sweep {
                if *swept_preset == preset && preset_setup.values.value(parameter) != *value {
                    let mut setup = preset_setup.clone();
                    setup.values.set(parameter, *value);
                    all.push(setup);
                }
            }
        }
    }
    all.extend(combinations(method.name, &base.of_preset(Preset::Published)));
    all
}

/// Makes the setups of a method that differ from a base in several parameters at once.
fn combinations(method: &str, base: &Setup) -> Vec<Setup> {
    if method == stochastic::INFO.name {
        // Each pixel traces as many rays itself as the filter would gather from neighbours, and gathers none.
        let with_rays =
            |rays| base.with(|p: &mut StochasticParams| (p.stochastic_rays, p.stochastic_gathered) = (rays, 1));
        vec![with_rays(4), with_rays(16)]
    } else if method == dda::INFO.name {
        // The march without refinement, at the other two strides.
        let unrefined = |stride| base.with(|p: &mut DdaParams| (p.dda_stride, p.dda_refine) = (stride, false));
        vec![unrefined(1), unrefined(16)]
    } else if method == linear::INFO.name {
        // The march of a hundred steps that span the screen.
        let fixed = |p: &mut LinearParams| (p.march, p.numbers.march_stride) = (LinearMarch::Fixed, 0.01);
        vec![base.with(fixed)]
    } else if method == billboard::INFO.name {
        let nearest =
            |p: &mut BillboardParams| (p.billboard_order, p.billboard_occlusion) = (Order::Nearest, Occlusion::Depth);
        vec![base.with(nearest)]
    } else {
        Vec::new()
    }
}

/// Makes variants of a method without captures, and with each number of captures at each size of face, around a base
/// setup.
pub fn captures(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    use CaptureCount::{None, Number};
    use CaptureSide::{Scene, Side128, Side256, Side512, Side1024};
    let sides = [Side128, Side256, Side512, Side1024];
    let counts_and_sides = [1, 2, 4, 8].into_iter().flat_map(|count| sides.map(|side| (Number(count), side)));
    let variant = |(count, side)| Variant {
        method,
        setup: base.with(|p: &mut EffectParams| {
            p.beyond = if count == None { BeyondScreen::None } else { BeyondScreen::Captures };
            (p.captures, p.capture_side) = (count, side);
        }),
    };
    std::iter::once((None, Scene)).chain(counts_and_sides).map(variant).collect()
}

/// Makes variants of a method that show different things beyond the screen. A screen-space method has a variant without
/// a fallback, one with the environment, and one with `pccm`. If its rays can go on in captures or among triangles, it
/// also has a variant with the captures of `base`, and one with the scene's triangles. Any other method has one
/// variant, which is `base` without a fallback.
pub fn fallbacks(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    use Fallback::{Environment, None, Pccm};
    let variant = |fallback, captures, beyond| Variant {
        method,
        setup: base.with(|p: &mut EffectParams| (p.fallback, p.captures, p.beyond) = (fallback, captures, beyond)),
    };
    let captures = base.effect().captures;
    if !method.is_screen_space() {
        return vec![variant(None, captures, base.effect().beyond)];
    }
    let with_fallback = |fallback| variant(fallback, CaptureCount::None, BeyondScreen::None);
    let mut variants = [None, Environment, Pccm].map(with_fallback).to_vec();
    if method.takes_captures && captures != CaptureCount::None {
        variants.push(variant(None, captures, BeyondScreen::Captures));
    }
    if method.takes_triangles {
        variants.push(variant(None, CaptureCount::None, BeyondScreen::Triangles));
    }
    variants
}

/// Makes variants of a screen-space method with each number of bounces up to that of `base`; any other method has one
/// variant, with one bounce.
pub fn bounces(method: &'static MethodInfo, base: &Setup) -> Vec<Variant> {
    let most = if method.is_screen_space() { base.effect().bounces } else { 1 };
    let variant = |bounces| Variant { method, setup: base.with(|p: &mut EffectParams| p.bounces = bounces) };
    (1..=most).map(variant).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct::methods::{METHODS, unified};
    use std::collections::BTreeSet;

    #[test]
    fn sweeps_differ_from_their_base_and_from_each_other() {
        for method in METHODS {
            let recorded: Vec<_> =
                setups(method, &Setup::new([64, 48])).iter().map(|s| s.recorded(Some(method))).collect();
            for (n, one) in recorded.iter().enumerate() {
                assert!(!recorded[..n].contains(one), "{}: {one:?} twice", method.name);
            }
        }
        assert_eq!(combinations(stochastic::INFO.name, &Setup::new([64, 48])).len(), 2);
    }

    #[test]
    fn a_sweep_of_captures_has_every_number_of_every_size_once() {
        let base = Setup::new([64, 36]);
        let all = captures(&unified::INFO, &base);
        let count_and_texels =
            |v: &Variant| (v.setup.effect().captures.wanted(), v.setup.effect().capture_side.texels());
        let distinct: BTreeSet<String> = all.iter().map(|v| format!("{:?}", count_and_texels(v))).collect();
        assert_eq!((all.len(), distinct.len()), (17, 17));
        assert_eq!(count_and_texels(&all[0]), (None, None));
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
        let fallbacks_alone =
            [Fallback::None, Fallback::Environment, Fallback::Pccm].map(|f| (f, CaptureCount::None, None));
        assert_eq!(settings("ssct"), fallbacks_alone);
        let in_captures = (Fallback::None, CaptureCount::Number(4), Captures);
        let among_triangles = (Fallback::None, CaptureCount::None, Triangles);
        assert_eq!(settings("unified"), [&fallbacks_alone[..], &[in_captures, among_triangles]].concat());
        assert_eq!(settings("captures"), [(Fallback::None, CaptureCount::Number(4), Auto)]);
    }
}
