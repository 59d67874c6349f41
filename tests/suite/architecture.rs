//! The import rules and the other invariants of the architecture, checked on the sources' text. Imports point down
//! only, and the packages that others embed depend on little. A pass knows no other pass, one file writes barriers, and
//! `unsafe` stays in few folders. No shader is a wrapper, and no number is declared in GLSL and in Rust.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod doors;
mod examples;

use crate::common::repository;
use crate::common::sources::{GLSL, texts};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A package: the folder of its sources, and the modules at its root, each with the modules of the package that it may
/// import. Where no modules are listed, all stand beside each other and import each other in no circle. The manifest
/// says which other packages it may import (`packages_need_what_the_map_says`).
struct Package {
    sources: &'static str,
    layers: &'static [(&'static str, &'static [&'static str])],
}

/// The window's package, which stands above all layers.
const VIEW: &str = "lab/view/src";

/// The package that loads scenes, with the door to files.
const SCENES: &str = "lab/scenes/src";

const PACKAGES: &[Package] = &[
    Package {
        sources: "ground/src",
        layers: &[
            ("error", &[]),
            ("conventions", &[]),
            // Every layer may declare parameters with the values and names of this module.
            ("parameter", &["error"]),
            ("math", &["error", "parameter"]),
            ("scene", &["error", "conventions", "math"]),
            ("lib", &[]),
        ],
    },
    Package {
        sources: "src",
        layers: &[
            ("error", &[]),
            ("gpu", &["error"]),
            ("passes", &["error", "gpu"]),
            ("methods", &["error", "gpu", "passes"]),
            ("embed", &["error", "gpu", "passes", "methods"]),
            ("lib", &[]),
        ],
    },
    Package { sources: "lab/geometry/src", layers: &[] },
    Package { sources: SCENES, layers: &[] },
    Package { sources: "lab/truth/src", layers: &[("reference", &[]), ("metrics", &["reference"]), ("lib", &[])] },
    Package {
        sources: "lab/src",
        layers: &[
            ("error", &[]),
            ("custom", &[]),
            ("stage", &[]),
            ("study", &["error", "stage"]),
            ("report", &["error", "stage", "study"]),
            ("app", &["error", "stage", "study", "report", "custom"]),
            ("main", &["app"]),
            ("lib", &[]),
        ],
    },
    Package { sources: VIEW, layers: &[] },
];

/// Imports that a module may not have, although its package needs them: package, module, forbidden words.
const NOT_IMPORTED: &[(&str, &str, &[&str])] = &[
    ("lab/src", "custom", &["ssct_truth::"]),
    ("lab/src", "stage", &["ssct_truth::reference", "ssct_scenes::inside"]),
];

/// The greatest number of direct dependencies of the packages that others embed. It counts optional ones, too, except
/// the crate that builds trees over triangles, which few users need.
const MOST_DEPENDENCIES: usize = 10;

/// Crates on which the embedded packages never depend: command lines, plots, windows, and the laboratory's packages.
const NOT_EMBEDDED: &[&str] =
    &["ash-window", "clap", "egui", "plotters", "ssct-geometry", "ssct-lab", "ssct-scenes", "winit"];

/// Modules of `passes` that are no pass: several passes read them or are made of them.
const SHARED_BY_PASSES: &[&str] = &["lost", "scene_data", "tiles", "traced", "triangle_scene"];

/// Words, and the only files that contain them. `gpu/device/compile_only.rs` replaces a driver and records nothing.
const ONLY_IN: &[(&str, &[&str])] = &[
    ("cmd_pipeline_barrier2", &["gpu/frame.rs", "gpu/device/compile_only.rs"]),
    ("ImageMemoryBarrier2", &["gpu/frame.rs"]),
    ("BufferMemoryBarrier2", &["gpu/frame.rs"]),
    // A file has the wrapper of each call, and one file alone calls the wrappers.
    ("cmd_write_timestamp2", &["gpu/timing.rs", "gpu/device/compile_only.rs"]),
    (".stamp(", &["gpu/frame.rs"]),
    ("cmd_begin_query", &["gpu/timing.rs", "gpu/device/compile_only.rs"]),
    ("cmd_begin_debug_utils_label", &["gpu/device.rs"]),
    (".begin_label(", &["gpu/frame.rs"]),
    (".end_label(", &["gpu/frame.rs"]),
];

/// A source file: its package's folder of sources, its path in it, and its code without comments and unit tests.
struct Source {
    package: &'static str,
    path: String,
    code: String,
}

impl Source {
    /// Returns whether the source is the file of this module at the root of its package, or stands in that module's
    /// folder.
    fn is_of(&self, module: &str) -> bool {
        self.path.split(['/', '.']).next() == Some(module)
    }
}

/// Returns the code of a source without comments and without the unit tests at its end, which may import anything.
fn code(text: &str) -> String {
    // `mod tests;` only names another file; what follows it is shipped.
    let is_inline =
        |(offset, attribute): &(usize, &str)| text[offset + attribute.len()..].lines().next().unwrap().contains('{');
    let tests_start = text.match_indices("#[cfg(test)]\nmod ").find(is_inline).map_or(text.len(), |(offset, _)| offset);
    let shipped = &text[..tests_start];
    shipped.lines().map(|l| l.split("//").next().unwrap()).collect::<Vec<_>>().join("\n")
}

/// Returns the files below a folder that have one of the extensions: their paths in the folder, and their texts.
fn files(folder: &str, extensions: &[&str]) -> impl Iterator<Item = (String, String)> {
    let in_folder = move |(path, text): (String, String)| (path[folder.len() + 1..].to_owned(), text);
    texts(&[folder], extensions).into_iter().map(in_folder)
}

/// Returns the Rust sources of all packages, without files of unit tests.
fn sources() -> Vec<Source> {
    let shipped = |(path, _): &(String, String)| Path::new(path).file_stem().is_some_and(|stem| stem != "tests");
    let package_sources = |package: &Package| {
        let package = package.sources;
        let source = move |(path, text): (String, String)| Source { package, path, code: code(&text) };
        files(package, &["rs"]).filter(shipped).map(source).collect::<Vec<_>>()
    };
    let found: Vec<_> = PACKAGES.iter().flat_map(package_sources).collect();
    assert!(found.len() > 500, "only {} sources found", found.len());
    found
}

/// Returns the shaders' sources, without comments.
fn shaders() -> Vec<Source> {
    let source = |(path, text): (String, String)| Source { package: "shaders-glsl", path, code: code(&text) };
    let found: Vec<_> = files("shaders-glsl", &GLSL).map(source).collect();
    assert!(found.len() > 50, "only {} shaders found", found.len());
    found
}

/// Returns whether a shader has no code of its own: it only defines and includes.
fn is_wrapper(code: &str) -> bool {
    code.lines().map(str::trim).all(|line| line.is_empty() || line.starts_with('#'))
}

/// A number that a source declares as a constant.
#[derive(Debug, Clone, PartialEq)]
struct Number {
    name: String,
    /// True if the literal spells a whole number.
    is_whole: bool,
    value: f64,
    path: String,
}

impl Number {
    /// Reads a number from the literal that a source at a path gives it, or returns `None` for another expression.
    fn new(name: &str, literal: &str, path: &str) -> Option<Self> {
        let digits = literal.trim().trim_end_matches(['u', 'f']).replace('_', "");
        let value = digits.parse().ok().filter(|_| digits.starts_with(|c: char| c.is_ascii_digit() || c == '-'))?;
        let is_whole = !digits.contains(['.', 'e', 'E']);
        Some(Self { name: name.to_owned(), is_whole, value, path: path.to_owned() })
    }

    /// Returns the words of the number's name, in capitals: `MaxSteps` and `MAX_STEPS` both give MAX and STEPS.
    fn words(&self) -> Vec<String> {
        let mut words = vec![String::new()];
        let mut before = 'A';
        for c in self.name.chars() {
            if c == '_' || (c.is_uppercase() && before.is_lowercase()) {
                words.push(String::new());
            }
            if let (true, Some(word)) = (c != '_', words.last_mut()) {
                word.extend(c.to_uppercase());
            }
            before = c;
        }
        words
    }

    /// Returns whether two numbers are one: their names, or their values and a word of their names, are equal.
    fn repeats(&self, other: &Self) -> bool {
        let is_word = |w: &String| w.len() > 2 && other.words().contains(w);
        let is_same = self.value == other.value && self.is_whole == other.is_whole;
        self.name == other.name || (is_same && self.words().iter().any(is_word))
    }
}

/// Returns the numbers that a shader declares by `#define NAME 1.0` or `const float NAME = 1.0;`.
fn numbers_of_glsl(Source { path, code, .. }: &Source) -> Vec<Number> {
    let found = code.lines().filter_map(|line| {
        let line = line.trim();
        let declared = match (line.strip_prefix("#define "), line.strip_prefix("const ")) {
            (Some(defined), _) => defined.split_once(' '),
            (_, Some(constant)) => {
                constant.split_once(' ').and_then(|(_, rest)| rest.strip_suffix(';')?.split_once(" = "))
            }
            _ => None,
        };
        declared.and_then(|(name, literal)| Number::new(name, literal, path))
    });
    found.collect()
}

/// Returns the numbers that a Rust source declares by `const NAME: f32 = 1.0;`, and by `Name = 1,` in an enum.
fn numbers_of_rust(Source { path, code, .. }: &Source) -> Vec<Number> {
    let found = code.lines().filter_map(|line| {
        let line = line.trim();
        let constant = line.split_once("const ").and_then(|(_, rest)| rest.strip_suffix(';')?.split_once(" = "));
        let variant = line.strip_suffix(',').and_then(|rest| rest.split_once(" = "));
        let (name, literal) = constant.map(|(name, v)| (name.split(':').next().unwrap_or(name), v)).or(variant)?;
        name.starts_with(char::is_uppercase).then(|| Number::new(name, literal, path)).flatten()
    });
    found.collect()
}

/// Returns a sentence for each number that Rust and a shader both declare, and for each that two shaders declare.
fn declared_twice(glsl: &[Number], rust: &[Number]) -> Vec<String> {
    let sentence = |a: &Number, b: &Number| format!("{} of {} is {} of {}", a.name, a.path, b.name, b.path);
    let across = rust.iter().flat_map(|r| glsl.iter().filter(|g| r.repeats(g)).map(move |g| sentence(r, g)));
    let is_same = |a: &Number, b: &Number| a.name == b.name && a.value == b.value;
    let pairs = glsl.iter().enumerate().flat_map(|(i, a)| glsl[..i].iter().map(move |b| (a, b)));
    across.chain(pairs.filter(|(a, b)| is_same(a, b)).map(|(a, b)| sentence(a, b))).collect()
}

/// Returns the names that follow a prefix in code: `crate::gpu::Image` has `gpu` after `crate::`, and `crate::{gpu,
/// math::cone}` has `gpu` and `math`.
fn names_after(code: &str, prefix: &str) -> Vec<String> {
    let word = |s: &str| s.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut names = Vec::new();
    for (offset, _) in code.match_indices(prefix) {
        let before = code[..offset].chars().next_back();
        // A longer word or a longer path ends in the prefix.
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        let rest = &code[offset + prefix.len()..];
        let Some(list) = rest.strip_prefix('{') else {
            names.push(word(rest));
            continue;
        };
        // The first word of each item of the list; items of nested lists are left out.
        let (mut depth, mut item) = (0, String::new());
        for c in list.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => names.push(word(&std::mem::take(&mut item))),
                _ if depth == 0 => item.push(c),
                _ => {}
            }
        }
        names.push(word(&item));
    }
    names.retain(|n| !n.is_empty());
    names
}

/// Returns the module at the root of its package that a file belongs to.
fn module(path: &str) -> &str {
    path.split(['/', '.']).next().unwrap()
}

/// Returns a sentence for each import of a file that the layers of its package do not allow.
fn wrong_imports(Source { package, path, code }: &Source) -> Vec<String> {
    let Package { layers, .. } = PACKAGES.iter().find(|p| p.sources == *package).unwrap();
    if layers.is_empty() {
        return Vec::new();
    }
    let module = module(path);
    let Some((_, allowed)) = layers.iter().find(|(name, _)| *name == module) else {
        return vec![format!("{path}: the module {module} stands in no layer")];
    };
    let prefix = match module {
        "lib" => return Vec::new(),
        "main" => "ssct_lab::",
        _ => "crate::",
    };
    let is_wrong = |name: &String| name != module && !allowed.contains(&name.as_str());
    let wrong_names = names_after(code, prefix).into_iter().filter(is_wrong);
    let mut found: Vec<_> = wrong_names.map(|name| format!("{path} imports {name}")).collect();
    let forbidden =
        NOT_IMPORTED.iter().filter(|(p, m, _)| p == package && *m == module).flat_map(|(_, _, words)| *words);
    found.extend(forbidden.filter(|word| code.contains(**word)).map(|word| format!("{path} imports {word}")));
    found
}

/// Returns a sentence for each other pass that the code of a pass imports; `passes` are the names of all passes.
fn wrong_siblings(path: &str, code: &str, passes: &[String]) -> Vec<String> {
    let names = [names_after(code, "super::"), names_after(code, "crate::passes::")].concat();
    let wrong = |n: &String| passes.contains(n);
    names.into_iter().filter(wrong).map(|n| format!("{path} imports the pass {n}")).collect()
}

/// No module imports one that its package's list of layers does not allow.
#[test]
fn imports_point_down_only() {
    let wrong: Vec<_> = sources().iter().flat_map(wrong_imports).collect();
    assert_eq!(wrong, [""; 0]);
}

/// Returns the packages that the map in src/ARCHITECTURE.md lists: by name, the folder and the packages that it needs.
fn packages_of_the_map() -> BTreeMap<String, (String, BTreeSet<String>)> {
    let map = std::fs::read_to_string(repository().join("src/ARCHITECTURE.md")).unwrap();
    let quoted = |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let row = |line: &str| {
        let cells: Vec<_> = line.split('|').map(quoted).collect();
        let [_, name, folder, needs, ..] = &cells[..] else { return None };
        let is_package =
            name.len() == 1 && name[0].starts_with("ssct") && folder.len() == 1 && folder[0].ends_with('/');
        is_package.then(|| (name[0].clone(), (folder[0].clone(), needs.iter().cloned().collect())))
    };
    map.lines().filter_map(row).collect()
}

/// Each package of the workspace is in the map, and its manifest has the dependencies on other packages that the map
/// says. Three packages do not depend on the Vulkan bindings `ash`.
#[test]
fn packages_need_what_the_map_says() {
    let members: Vec<_> = manifest(".")["workspace"]["members"].as_array().unwrap().clone();
    let map = packages_of_the_map();
    assert_eq!(map.len(), members.len(), "every package is in the map: {map:?}");
    for (name, (folder, needs)) in &map {
        let manifest = manifest(folder);
        assert_eq!(manifest["package"]["name"].as_str(), Some(&**name), "{folder}");
        let dependencies = manifest["dependencies"].as_table().unwrap().keys();
        let ours: BTreeSet<_> = dependencies.filter(|d| map.contains_key(*d)).cloned().collect();
        assert_eq!(ours, *needs, "what {name} needs");
        let is_plain = matches!(&**name, "ssct-ground" | "ssct-scenes" | "ssct-truth");
        assert!(!is_plain || !manifest["dependencies"].as_table().unwrap().contains_key("ash"), "{name} knows Vulkan");
    }
}

/// Returns the manifest of the package in a folder of the repository.
fn manifest(folder: &str) -> toml::Table {
    let path = repository().join(folder).join("Cargo.toml");
    std::fs::read_to_string(path).unwrap().parse().expect("a manifest")
}

/// The packages `ssct` and `ssct-ground` have at most 10 direct dependencies, and none on the crates of command lines,
/// plots and windows.
#[test]
fn what_others_embed_depends_on_little() {
    let manifests = [manifest("."), manifest("ground")];
    assert!(manifests.iter().all(|m| !m.contains_key("target")), "count dependencies of one system here, too");
    let keys = |table: &str| -> BTreeSet<String> {
        manifests.iter().filter_map(|m| m.get(table)?.as_table()).flat_map(|t| t.keys().cloned()).collect()
    };
    let mut names = keys("dependencies");
    // The first builds trees over triangles, which few users need; the other is ours.
    names.retain(|n| n != "obvhs" && n != "ssct-ground");
    assert!(names.contains("ash") && names.len() <= MOST_DEPENDENCIES, "{}: {names:?}", names.len());
    for table in ["dependencies", "build-dependencies", "dev-dependencies"] {
        let found = keys(table).into_iter().find(|name| NOT_EMBEDDED.contains(&name.as_str()));
        assert_eq!(found, None, "in {table}");
    }
}

/// No file of `passes` imports another pass, and the shared modules of `passes` record nothing themselves.
#[test]
fn a_pass_imports_no_other_pass() {
    let sources = sources();
    let stem = |s: &Source| Some(s.path.strip_prefix("passes/")?.strip_suffix(".rs")?.to_owned());
    let passes: Vec<_> =
        sources.iter().filter_map(stem).filter(|n| n != "mod" && !SHARED_BY_PASSES.contains(&n.as_str())).collect();
    assert!(passes.len() >= 7, "{passes:?}");
    let in_passes = || sources.iter().filter(|s| s.is_of("passes"));
    let wrong: Vec<_> = in_passes().flat_map(|s| wrong_siblings(&s.path, &s.code, &passes)).collect();
    assert_eq!(wrong, [""; 0]);
    for shared in SHARED_BY_PASSES {
        let s = in_passes().find(|s| s.path == format!("passes/{shared}.rs")).expect("the file");
        assert!(!s.code.contains("fn record"), "{shared} records, so it is a pass");
    }
}

/// Each word of `ONLY_IN` occurs in its files, and in no other source.
#[test]
fn one_file_writes_barriers_timestamps_and_labels() {
    let sources = sources();
    for (word, allowed) in ONLY_IN {
        let found: Vec<_> = sources.iter().filter(|s| s.code.contains(word)).map(|s| s.path.as_str()).collect();
        assert_eq!(found, *allowed, "{word}");
    }
}

/// Code with `unsafe` stands only in `gpu` and `embed` of the main package, and in `presentation` of the window's
/// package.
#[test]
fn unsafe_code_stays_in_gpu_at_the_door_and_in_the_window() {
    let mut found = 0;
    // A name follows `unsafe` in `unsafe fn` and `unsafe impl`.
    for s in sources().iter().filter(|s| !names_after(&s.code, "unsafe").is_empty() || s.code.contains("unsafe {")) {
        let folders: &[&str] = match s.package {
            "src" => &["gpu", "embed"],
            VIEW => &["presentation"],
            _ => &[],
        };
        let is_there = folders.iter().any(|folder| s.is_of(folder));
        assert!(is_there, "{} in {}", s.path, s.package);
        found += 1;
    }
    assert!(found >= 5, "the word is found where it is");
}

/// Returns the path of a module in its package, one element for each folder and one for the file. It is empty for
/// `lib.rs` and `main.rs`.
fn module_path(path: &str) -> Vec<&str> {
    let stem = path.strip_suffix(".rs").unwrap_or(path);
    if ["lib", "main"].contains(&stem) { Vec::new() } else { stem.split('/').collect() }
}

/// No source file is called `mod.rs`: the file of a module stands beside the module's folder.
#[test]
fn a_module_stands_beside_its_folder() {
    let sources = sources();
    let found: Vec<_> = sources.iter().filter(|s| s.path.ends_with("mod.rs")).map(|s| (s.package, &s.path)).collect();
    assert!(found.is_empty() && !sources.is_empty(), "these stand in their folder: {found:?}");
}

/// Returns the imports between modules that stand beside each other: by folder of the package and by module, the names
/// that the module imports from that folder.
fn siblings(sources: &[Source], package: &str) -> BTreeMap<String, BTreeMap<String, BTreeSet<String>>> {
    let mut folders = BTreeMap::<String, BTreeMap<String, BTreeSet<String>>>::new();
    for s in sources.iter().filter(|s| s.package == package) {
        let path = module_path(&s.path);
        for depth in 0..path.len() {
            let above: String = path[..depth].iter().map(|module| format!("{module}::")).collect();
            let mut names = names_after(&s.code, &format!("crate::{above}"));
            names.extend(names_after(&s.code, &"super::".repeat(path.len() - depth)));
            names.retain(|name| name != path[depth]);
            folders.entry(above).or_default().entry(path[depth].to_owned()).or_default().extend(names);
        }
    }
    folders
}

/// The package and the folder whose files may import each other in a circle, since all of them know the device.
const ONE_CIRCLE: (&str, &str) = ("src", "gpu::");

/// In each folder but `ONE_CIRCLE`, the imports between neighbouring modules have no circle.
#[test]
fn no_modules_beside_each_other_import_each_other_in_a_circle() {
    let sources = sources();
    let mut found = 0;
    for Package { sources: package, .. } in PACKAGES {
        for (folder, mut imports) in siblings(&sources, package) {
            let modules: BTreeSet<String> = imports.keys().cloned().collect();
            for names in imports.values_mut() {
                names.retain(|name| modules.contains(name));
                found += names.len();
            }
            // Modules that import no remaining module are removed, one after another, so that only circles remain.
            let without_imports = |left: &BTreeMap<String, BTreeSet<String>>| {
                left.iter()
                    .find(|(_, names)| names.iter().all(|n| !left.contains_key(n)))
                    .map(|(module, _)| module.clone())
            };
            while let Some(module) = without_imports(&imports) {
                imports.remove(&module);
            }
            assert!(imports.is_empty() || (*package, &*folder) == ONE_CIRCLE, "{package}, {folder}: {imports:?}");
        }
    }
    assert!(found > 300, "imports are found: {found}");
}

/// Each shader file has code of its own besides lines that begin with `#`.
#[test]
fn no_shader_only_defines_and_includes() {
    let wrappers: Vec<_> = shaders().into_iter().filter(|s| is_wrapper(&s.code)).map(|s| s.path).collect();
    assert_eq!(
        wrappers, [""; 0],
        "a variant is a `#pragma program` or a specialization constant of the file with the code"
    );
}

/// No number is declared in a shader and in Rust, or in two shaders; shaders-glsl/common/constants.glsl declares them
/// for both.
#[test]
fn no_constant_is_declared_in_both_languages() {
    let glsl: Vec<_> = shaders().iter().flat_map(numbers_of_glsl).collect();
    let rust: Vec<_> = sources().iter().flat_map(numbers_of_rust).collect();
    assert!(glsl.len() > 40 && rust.len() > 100, "only {} and {} found", glsl.len(), rust.len());
    assert_eq!(declared_twice(&glsl, &rust), [""; 0], "shaders-glsl/common/constants.glsl is for both");
}
