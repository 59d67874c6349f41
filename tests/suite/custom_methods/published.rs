//! Tests the published methods as folders. Each equals its built-in method to the bit, wherever the folder lies. A
//! change of one constant or of one file of its shaders changes the image. If a manifest lacks fields, the error names
//! all of them, with the values that they may have.

use super::*;
use std::collections::BTreeMap;

/// The built-in methods that `examples/methods` has as folders, which name the built-in shaders.
const METHODS: [&str; 5] = ["ssct", "hzct", "sslr", "ssr", "linear"];

/// Renders a method at a roughness, and returns the bytes of three files: reflection, hits and finished image.
fn drawn(folder: &Folder, method: &str, roughness: &str) -> [Vec<u8>; 3] {
    let options = ["--roughness", roughness, "--reflectivity", "1"];
    folder.succeed(&on_room("render", &[&["--method", method, "--dump", "dump"], &options[..]].concat()));
    ["reflection.exr", "hits.exr", "composite.exr"].map(|file| std::fs::read(folder.path("dump").join(file)).unwrap())
}

/// Each of five published methods gives the same three files from its folder as built in. Another value of one constant
/// in a manifest changes an image; otherwise the folder's values would not be those that are used.
#[test]
fn a_published_method_from_its_folder_is_the_built_in_one_to_the_bit_and_one_constant_changes_it() {
    for method in METHODS {
        // The copy lies far away from the repository.
        let folder = with_example(method);
        let roughness = if method == "linear" { "0" } else { "0.3" };
        let built_in = drawn(&folder, method, roughness);
        assert!(built_in == drawn(&folder, "./m", roughness), "{method} at {roughness}");
        if method == "ssct" {
            change(&folder, "m/method.toml", "cone_interpolated = 0 ", "cone_interpolated = 1 ");
            assert!(built_in != drawn(&folder, "./m", roughness));
        }
    }
}

/// `ssr` names the built-in method although there is a folder `ssr`; `./ssr` names the folder. A folder beside a user's
/// files must not replace a method unnoticed.
#[test]
fn a_name_of_a_built_in_method_is_no_folder() {
    let folder = with_example("march");
    std::fs::rename(folder.path("m"), folder.path("ssr")).unwrap();
    let passes = |method: &str| folder.succeed(&on_room("render", &["--method", method, "--explain", "-o", "a.png"]));
    assert!(passes("ssr").contains("recorded  ray march"), "the built-in method");
    assert!(passes("./ssr").contains("recorded  march"), "the folder");
}

/// A shader file in the method's folder replaces the built-in file of that path, and a mistake in the file is reported
/// with its line.
#[test]
fn a_file_of_the_folder_stands_in_the_place_of_the_built_in_one() {
    let folder = with_example("ssct");
    std::fs::create_dir(folder.path("m/thesis")).unwrap();
    let text = std::fs::read_to_string(repository().join("shaders-glsl/thesis/border_fade.glsl")).unwrap();
    folder.write("m/thesis/border_fade.glsl", &text);
    assert!(drawn(&folder, "ssct", "0") == drawn(&folder, "./m", "0"), "the copy is the same text");
    assert!(text.contains("return 1.0 - max"));
    folder.write("m/thesis/border_fade.glsl", text.replace("return 1.0 - max", "return 0.5 - 0.5 * max"));
    assert!(drawn(&folder, "ssct", "0") != drawn(&folder, "./m", "0"), "the folder's text is taken");
    // The error of a mistake has the path in the folder, and not that of the built-in file.
    folder.write("m/thesis/border_fade.glsl", text.replace("return 1.0", "return one"));
    let message = sentence(&folder, &["render", "--method", "./m", "-o", "x.png", "--size", "34x19"]);
    assert!(message.starts_with("./m/thesis/border_fade.glsl:9: 'one'"), "{message}");
}

/// Removes a section from the manifest of an example, and returns the removed table.
fn without_section(folder: &Folder, section: &str) -> toml::Table {
    let text = folder.text("m/method.toml");
    let (before, rest) = text.split_once(&format!("[{section}]\n")).unwrap();
    let (removed, after) = rest.split_once("\n[").unwrap();
    folder.write("m/method.toml", format!("{before}[{after}"));
    toml::from_str(removed).unwrap()
}

/// Returns the words in brackets that an error's sentence has behind each field that nothing feeds, by the field's name
/// without that of its block.
fn hints(message: &str) -> BTreeMap<String, String> {
    let fields = message.split("the field ").skip(1).filter_map(|field| field.split_once(" ("));
    let name = |full_name: &str| full_name.rsplit('.').next().unwrap_or(full_name).to_owned();
    fields.map(|(full_name, rest)| (name(full_name), rest.split(')').next().unwrap_or_default().to_owned())).collect()
}

/// Without its section `[values]`, each example is refused with one sentence, which names every field, its option, and
/// its published value as in the removed section. A user can thus write the section from the sentence alone.
#[test]
fn fields_that_are_missing_are_all_named_with_their_options_and_published_values() {
    for method in METHODS {
        let folder = with_example(method);
        let values = without_section(&folder, "values");
        let message = sentence(&folder, &["render", "--method", "./m", "-o", "x.png", "--size", "34x19"]);
        let hints = hints(&message);
        for (name, value) in &values {
            // A value without a hint is that of a specialization constant, which has a default.
            let Some(hint) = hints.get(name) else { continue };
            let (option, number) = hint.split_once(", published ").unwrap_or(("", hint));
            match value {
                toml::Value::String(source) => assert_eq!(number, format!("{source:?}"), "{name}"),
                // Only another method reads this field.
                value if value.as_integer() == Some(0) && !option.is_empty() => {}
                value => {
                    let removed = value.as_float().or(value.as_integer().map(|n| n as f64));
                    assert_eq!(removed, number.parse().ok(), "{method}: {name}");
                    let text = folder.text("m/method.toml");
                    assert!(option.starts_with("--") && !text.contains(name.as_str()), "{name}: {option}");
                }
            }
        }
        // Names in capitals are specialization constants, which may be left out.
        let fields = values.keys().filter(|name| name.chars().any(|c| c.is_ascii_lowercase()));
        for name in fields {
            assert!(hints.contains_key(name) || message.contains(&format!("{name} ")), "{method}: {name} in {message}");
        }
    }
    let folder = with_example("ssct");
    without_section(&folder, "values");
    let message = sentence(&folder, &["render", "--method", "./m", "-o", "x.png"]);
    assert!(
        message.contains("ThesisBlock.view_direction_epsilon (--direction-tolerance, published 0.00001)"),
        "{message}"
    );
    assert!(
        message.contains("pass \"hi-z\": nothing feeds the field HiZBlock.Offset (\"hi-z-offset\") of hi_z.frag"),
        "{message}"
    );
    assert!(message.ends_with("name them under [inputs] or [values]"), "{message}");
}
