//! The numbers of the preset `published`: each is held to the print by the section and the words that give it, or its
//! source says that the print does not give it.

use ssct::gpu::programs::{ConeMarchMipConstants, LinearConstants};
use ssct::methods::{METHODS, MethodInfo, thesis};
use ssct_ground::math::constants;
use ssct_ground::parameter::Parameter;

/// Methods of the documents and a parameter of theirs, the published value, the section, and the printed words with the
/// value in them.
const PRINTED: &[(&[&str], &str, &str, &str, &str)] = &[
    (&["ssct", "hzct"], "start-level", "0", "§4.2.7, Alg. 4, line 2", "level ← 0"),
    (
        &["ssct", "hzct"],
        "cone-samples",
        "7",
        "§4.2.8",
        "a good number of maximal iterations in the HiZConeTrace procedure is 7",
    ),
    (&["ssct", "linear"], "march-steps", "100", "§4.2.2, both listings, line 1", "#define LINEAR_MARCH_COUNT 100"),
    (&["ssct", "linear"], "march-increase", "1.5", "§4.2.2, listing 2, line 2", "#define LINEAR_MARCH_INCREASE 1.5"),
    (&["ssct", "linear"], "search-steps", "32", "§4.2.2, listing 2, line 3", "#define BINARY_SEARCH_COUNT 32"),
    (&["ssct", "linear"], "search-decrease", "0.5", "§4.2.2, listing 2, line 4", "#define BINARY_SEARCH_DECREASE 0.5"),
    (&["ssct", "linear"], "search-tolerance", "0.01", "§4.2.2, listing 2, line 5", "#define DEPTH_DELTA_EPSILON 0.01"),
    (
        &["poster"],
        "march-increase",
        "1.5",
        "Technical Approach",
        "continuously increasing step size by a factor of 1.5",
    ),
    (
        &["ssct", "hzct", "linear", "poster"],
        "fade-start",
        "0.8",
        "§4.2.9",
        "I_start specifies the interpolation start factor, which is set to 0.8 in the demo",
    ),
    (&["ssct", "hzct", "linear", "poster"], "fade-end", "1", "§4.2.9, Eq. 4.7, line 1", "I_end = 1"),
    (&["ssct", "hzct"], "cone-xi", "0.244", "§4.2.8", "0.244 seems to be a good choice in practice"),
    (
        &["ssct", "hzct"],
        "cone-mirror-alpha",
        "1000",
        "§4.2.8",
        "we can interpolate theta to zero if alpha is greater than 1000 for instance",
    ),
    (&["poster"], "march-steps", "100", "Technical Approach", "for a maximum of 100 steps"),
    (&["poster"], "search-steps", "30", "Technical Approach", "with a binary search of 30 steps"),
    (&["poster"], "search-decrease", "0.5", "Technical Approach", "decreasing the step size by a factor of 0.5"),
    (&["ssr"], "pixel-step", "1", "Schmidt, listing 4, line 24", "float pixelStepSize = 1;"),
    (&["ssr-fast"], "pixel-step", "1", "Schmidt, listing 4, line 21", "Initial step is one pixel (1)"),
];

/// Values that the print gives in words or in formulas, likewise.
const SAID: &[(&[&str], &str, &str, &str, &str)] = &[
    (
        &["ssct", "linear"],
        "search-first",
        "1",
        "§4.2.2, listing 2, line 18",
        "BinarySearch((prevRay+ray) * 0.5, dir * stride)",
    ),
    (&["ssct", "hzct"], "cone-lengthened", "off", "§4.2.8, Alg. 5, line 2", "Initialize h to length of reflection ray"),
    (&["ssct", "hzct"], "chain-filter", "hardware", "§4.2.6", "We leave it with the standard GPU based process"),
    (
        &["ssct", "hzct"],
        "chain-mask",
        "none",
        "ch. 6",
        "we can further enhance the image quality by using a mask buffer",
    ),
    (&["ssct", "hzct"], "hi-z-maximum", "off", "§4.2.4", "In our case we will use the minimum"),
    (&["ssct", "hzct"], "split", "off", "§4.2.3", "The last two steps can be combined into a single shader"),
    (&["sslr"], "uniform-back", "0", "§4.3.1", "even a binary search for refinement is omitted"),
    (
        &["sslr"],
        "mask-filter",
        "weighted",
        "§4.3.2",
        "the previously generated mask buffer is used additionally to weight the texture samples",
    ),
    (&["sslr"], "spreading-factor", "1", "§4.3.3, listing, line 3", "mipCount * roughness * spreading"),
    (&["linear"], "march", "growing", "§4.2.2", "increases the step size (or rather stride) in each iteration"),
    (
        &["poster"],
        "poster-filter",
        "mip",
        "Technical Approach",
        "we pre-filter all three textures in the GBuffer with hardware MIP-mapping",
    ),
    (
        &["poster", "ssr", "ssr-fast"],
        "layers",
        "1",
        "Conclusion; Schmidt §6",
        "We want to extend SSCT by using several layers; the single layer depth map",
    ),
    (&["ssr-fast"], "distance-blur", "off", "Schmidt, listing 5, line 56", "toggleBlur is a boolean uniform"),
    (&["ssr-fast"], "chain-filter", "hardware", "Schmidt, listing 5, line 61", "textureLod(DiffuseTex, …, 7)"),
];

/// What a parameter's source says where the print gives no value.
const UNPRINTED: &[&str] =
    &["not printed", "unbounded", "not in ", "this project", "leave it open", "is wrong in print", "as dda-"];

/// The methods whose numbers come from the three documents' own listings and algorithms.
const METHODS_OF_PRINT: &[&str] = &["ssct", "hzct", "sslr", "linear", "poster", "ssr", "ssr-fast"];

fn method(name: &str) -> &'static MethodInfo {
    METHODS.iter().find(|m| m.name == name).unwrap()
}

fn parameter(method_name: &str, name: &str) -> Parameter {
    let rows = (method(method_name).parameters)();
    rows.into_iter().find(|p| p.typed_name() == name).unwrap_or_else(|| panic!("{method_name} has no {name}"))
}

/// Whether a number stands in a text by itself.
fn holds(text: &str, number: &str) -> bool {
    text.split(|c: char| !(c.is_ascii_digit() || c == '.')).any(|word| word.trim_end_matches('.') == number)
}

#[test]
fn published_values_are_those_of_print() {
    for (methods, name, value, place, words) in PRINTED.iter().chain(SAID) {
        for method in *methods {
            assert_eq!(parameter(method, name).published.to_string(), *value, "{method} {name}: {place}: {words}");
        }
    }
    for (methods, name, value, place, words) in PRINTED {
        assert!(holds(words, value), "{methods:?} {name}: {place}: {words}");
    }
}

#[test]
fn what_is_not_printed_says_so() {
    let mut unprinted = 0;
    for name in METHODS_OF_PRINT {
        for row in (method(name).parameters)() {
            let printed =
                |entry: &(&[&str], &str, &str, &str, &str)| entry.0.contains(name) && entry.1 == row.typed_name();
            let is_printed = PRINTED.iter().chain(SAID).any(printed);
            let says = UNPRINTED.iter().any(|words| row.source.contains(words));
            assert!(is_printed || says, "{name}, {}: not held to the print; its source is {:?}", row.name, row.source);
            unprinted += usize::from(!is_printed);
        }
    }
    assert!(unprinted > 10, "only {unprinted} values are not printed");
}

#[test]
fn constants_of_shaders_are_those_of_print() {
    let march: LinearConstants = LinearConstants::default();
    for (value, name) in [
        (march.linear_march_count.to_string(), "march-steps"),
        (march.linear_march_increase.to_string(), "march-increase"),
        (march.binary_search_count.to_string(), "search-steps"),
        (march.binary_search_decrease.to_string(), "search-decrease"),
        (march.depth_delta_epsilon.to_string(), "search-tolerance"),
    ] {
        assert_eq!(value, parameter("linear", name).published.to_string(), "{name} of linear_ray_march.glsl");
    }
    let poster = ConeMarchMipConstants::default();
    for (value, name) in [
        (poster.step_count.to_string(), "march-steps"),
        (poster.step_increase.to_string(), "march-increase"),
        (poster.search_count.to_string(), "search-steps"),
        (poster.search_decrease.to_string(), "search-decrease"),
    ] {
        assert_eq!(value, parameter("poster", name).published.to_string(), "{name} of cone_march.frag");
    }
    // §4.2.8: "0.244 seems to be a good choice in practice"; "θ to zero if α is greater than 1000 for instance".
    assert_eq!((constants::XI, constants::MIRROR_ALPHA), (0.244, 1000.0));
    // §4.3.2, listing, lines 2 to 8: 0.002, 0.028, 0.233, 0.474, 0.233, 0.028, 0.002.
    let weights = [constants::GAUSSIAN_0, constants::GAUSSIAN_1, constants::GAUSSIAN_2, constants::GAUSSIAN_3];
    assert_eq!(weights, [0.474, 0.233, 0.028, 0.002]);
    // §4.2.9, Eq. 4.7: "I_end = 1"; "I_start specifies the interpolation start factor, which is set to 0.8 in the demo".
    let scene = crate::common::built_in("rooms");
    let camera = scene.views[0].camera(&scene, [960, 540]);
    let block = thesis::block(&camera, [960, 540], 10, true);
    assert_eq!((block.fade_start, block.fade_end), (0.8, 1.0));
}
