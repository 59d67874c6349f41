//! Tests the numbers of the preset `published`. Each equals the number that the print gives, by the section and the
//! words in `printed.csv`, or its source says that the print does not give it.

use super::root;
use ssct::gpu::programs::{ConeMarchMipConstants, LinearConstants};
use ssct::methods::{METHODS, MethodInfo, thesis};
use ssct_docs::records::{Row, read};
use ssct_ground::math::constants;
use ssct_ground::parameter::Parameter;

/// Reads the printed values, by the columns of the file `printed.csv`.
fn printed() -> Vec<Row> {
    let rows = read(&root().join("tests/suite/docs/printed.csv"), "").unwrap();
    assert!(rows.len() > 25, "only {} values are printed", rows.len());
    rows
}

/// Words by which a parameter's source says that the print gives no value.
const UNPRINTED: &[&str] =
    &["not printed", "unbounded", "not in ", "this project", "leave it open", "is wrong in print", "as dda-"];

/// The methods whose numbers come from the listings and algorithms of the three documents.
const METHODS_OF_PRINT: &[&str] = &["ssct", "hzct", "sslr", "linear", "poster", "ssr", "ssr-fast"];

/// Returns a method by its name.
fn method(name: &str) -> &'static MethodInfo {
    METHODS.iter().find(|m| m.name == name).unwrap()
}

/// Returns a method's parameter by its name on the command line. Panics if there is none.
fn parameter(method_name: &str, name: &str) -> Parameter {
    let rows = (method(method_name).parameters)();
    rows.into_iter().find(|p| p.typed_name() == name).unwrap_or_else(|| panic!("{method_name} has no {name}"))
}

/// Returns whether a number occurs in a text as a word of its own.
fn has_number(text: &str, number: &str) -> bool {
    text.split(|c: char| !(c.is_ascii_digit() || c == '.')).any(|word| word.trim_end_matches('.') == number)
}

/// Each value of the preset `published` that the documents print is the printed one, and the quoted words contain it. A
/// typing error would change every measurement of a published method.
#[test]
fn published_values_are_those_of_print() {
    for row in printed() {
        let [name, value, place, words] = ["parameter", "value", "place", "words"].map(|field| &row[field]);
        for method in row["methods"].split(' ') {
            assert_eq!(parameter(method, name).published.to_string(), *value, "{method} {name}: {place}: {words}");
        }
        assert!(row["is_number"] == "no" || has_number(words, value), "{name}: {place}: {words}");
    }
}

/// Each parameter of these methods either has a printed value, or a source that says that none is printed. A reader
/// could otherwise take a value of this project for a published one.
#[test]
fn what_is_not_printed_says_so() {
    let printed = printed();
    let mut unprinted = 0;
    for name in METHODS_OF_PRINT {
        for row in (method(name).parameters)() {
            let is_own = |p: &&Row| p["parameter"] == row.typed_name() && p["methods"].split(' ').any(|m| m == *name);
            let is_printed = printed.iter().any(|p| is_own(&p));
            let is_said_unprinted = UNPRINTED.iter().any(|words| row.source.contains(words));
            assert!(
                is_printed || is_said_unprinted,
                "{name}, {}: not held to the print; its source is {:?}",
                row.name,
                row.source
            );
            unprinted += usize::from(!is_printed);
        }
    }
    assert!(unprinted > 10, "only {unprinted} values are not printed");
}

/// The default constants of shaders, and the constants that shaders and Rust share, are the printed ones. Parameters
/// replace some of them when a pipeline is made, so that a wrong default need not show in an image.
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
    // §4.2.9, Eq. 4.7: "I_end = 1"; "I_start specifies the interpolation start factor, which is set to 0.8 in the
    // demo".
    let scene = crate::common::built_in("rooms");
    let camera = scene.views[0].camera(&scene, [960, 540]);
    let block = thesis::block(&camera, [960, 540], 10, true);
    assert_eq!((block.fade_start, block.fade_end), (0.8, 1.0));
}
