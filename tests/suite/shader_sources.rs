//! Tests the names in the pragmas of shader sources, and the declarations that `build.rs` makes of them in Rust.

// `build.rs` uses all of this module, and the tests use a part.
#[allow(dead_code)]
#[path = "../../src/gpu/declarations.rs"]
mod declarations;

use declarations::{Groups, Permutation, Stage, declare_program, find_stored};
use ssct::gpu::glsl::{self, Group, NamedProgram, groups_in, in_either_stage, programs};
use ssct::gpu::interface::{self, Interface, StageBinding};
use std::collections::BTreeMap;
use std::path::Path;

/// Returns a permutation of the program `Made`, with bindings of some names and kinds and a number of outputs. The
/// extension of `source` says whether its stage is fragment or compute.
fn shader(source: &str, bindings: &[(&str, &'static str)], outputs: usize) -> Permutation {
    let path = Path::new(source);
    let named = glsl::programs("#pragma program(Made: Tree)\n", path).unwrap().remove(0);
    let binding = |(n, (name, kind)): (usize, &(&str, &'static str))| StageBinding {
        binding: n as u32,
        name: (*name).to_owned(),
        kind,
        count: 1,
        block: String::new(),
        read_only: *kind != "StorageImage",
    };
    let interface = Interface {
        bindings: bindings.iter().enumerate().map(binding).collect(),
        push: None,
        outputs: vec![("out_color".into(), "f32"); outputs],
        constants: Vec::new(),
        local_size: [0; 3],
        blocks: BTreeMap::new(),
        formats: (0..bindings.len() as u32).map(|n| (n, "R32_SFLOAT")).collect(),
    };
    let stage = if source.ends_with(".frag") { Stage::Fragment } else { Stage::Compute };
    Permutation { named, stage, file: source.into(), module: String::new(), interface, stored: Vec::new() }
}

/// Returns the Rust text that is declared for some permutations and groups, or the error.
fn declared(permutations: &mut [Permutation], groups: &[(&str, &[&str])]) -> Result<String, String> {
    let named = groups.iter().map(|(name, members)| Group {
        name: (*name).to_owned(),
        members: members.iter().map(|member| (*member).to_owned()).collect(),
    });
    let mut groups = Groups::new(named.collect());
    find_stored(permutations)?;
    let text = declare_program("Made", permutations, &mut groups)?;
    Ok(text + &groups.text()?)
}

/// A binding for a sampled image.
const READ: (&str, &str) = ("depth", "SampledImage");
/// A binding that only one permutation has.
const ONLY: (&str, &str) = ("tree", "StorageBuffer");
/// A binding for a storage image, into which a compute shader stores.
const STORED: (&str, &str) = ("color_image", "StorageImage");

/// A binding that one of two permutations lacks is an `Option`. The storage image that stands for an output is listed
/// as stored and is no field: the frame binds it as a target.
#[test]
fn a_binding_of_some_permutations_is_an_option_and_an_output_is_no_field() {
    let text = declared(&mut [shader("a.frag", &[READ], 1), shader("a.comp", &[READ, ONLY, STORED], 0)], &[]).unwrap();
    assert!(text.contains("pub depth: Sampled<'a>,") && text.contains("pub tree: Option<&'a Buffer>,"), "{text}");
    assert!(text.contains("stored: &[(2, vk::Format::R32_SFLOAT), ]") && !text.contains("pub color_image"), "{text}");
}

/// Bindings of a group become one field of the struct. A group of which no permutation has all bindings is refused.
#[test]
fn bindings_of_a_group_are_one_field() {
    let group: (&str, &[&str]) = ("TreeParts", &["depth", "tree"]);
    let text = declared(&mut [shader("a.comp", &[READ, ONLY], 0)], &[group]).unwrap();
    assert!(text.contains("pub tree_parts: TreeParts<'a>") && text.contains("self.tree_parts.tree"), "{text}");
    let unused = declared(&mut [shader("a.comp", &[READ], 0)], &[group]).unwrap_err();
    assert!(unused.contains("TreeParts"), "{unused}");
}

/// Permutations of one program with other outputs, other kinds of a binding or one stage are refused. One struct could
/// not describe both.
#[test]
fn permutations_that_do_not_fit_each_other_are_refused() {
    let refused = |mut permutations: Vec<Permutation>| declared(&mut permutations, &[]).unwrap_err();
    let buffer = ("depth", "StorageBuffer");
    assert!(refused(vec![shader("a.comp", &[READ], 0), shader("b.frag", &[buffer], 1)]).contains("stores 0 images"));
    assert!(refused(vec![shader("a.frag", &[READ], 1), shader("b.frag", &[buffer], 1)]).contains("depth"));
    assert!(refused(vec![shader("a.frag", &[READ], 1), shader("b.frag", &[READ], 1)]).contains("same stage"));
    assert!(refused(vec![shader("a.frag", &[READ], 1), shader("b.frag", &[READ], 2)]).contains("outputs"));
}

/// The pragma `in_either_stage` adds compute programs to a fragment program, with the macro COMPUTE and its own macros.
/// Wrong pragmas are refused with their line, since GLSL itself ignores unknown pragmas.
#[test]
fn compute_programs_of_fragment_programs_are_read_off_their_pragmas() {
    let path = Path::new("a.frag");
    let source = "#version 460\n#pragma program(A, B)\n#pragma in_either_stage\n#pragma in_either_stage(C)\n";
    let twins = in_either_stage(source, path).unwrap();
    let program = programs(source, path).unwrap().remove(0);
    let named: Vec<_> = twins.iter().map(|t| program.in_compute(t)).map(|n| (n.name, n.defines.join(" "))).collect();
    assert_eq!(named, [("A".into(), "B COMPUTE".into()), ("A".into(), "B COMPUTE C".into())]);
    for wrong in ["#pragma in_either_stage()", "#pragma in_either_stage(A", "#pragma in_either_stages"] {
        let message = in_either_stage(wrong, path).unwrap_err();
        assert!(message.starts_with("a.frag:1: ") && message.contains(wrong), "{message}");
    }
}

/// The pragma `program` gives a name, an optional source of rays and macros. Wrong pragmas are refused with their line.
#[test]
fn programs_are_read_off_their_pragmas() {
    let named = |source| programs(source, Path::new("a.frag"));
    let found = named("#version 460\n#pragma program(Down)\n#pragma program( Across , VOLUME,HITS )\nvoid main() {}\n");
    let program = |name: &str, rays: Option<&str>, defines: &[&str]| NamedProgram {
        name: name.into(),
        rays: rays.map(str::to_owned),
        defines: defines.iter().map(|d| (*d).to_owned()).collect(),
    };
    assert_eq!(found, Ok(vec![program("Down", None, &[]), program("Across", None, &["VOLUME", "HITS"])]));
    let found = named("#pragma program(Mirror: Screen)\n#pragma program(Mirror: Tree, A, B)\n");
    assert_eq!(found, Ok(vec![program("Mirror", Some("Screen"), &[]), program("Mirror", Some("Tree"), &["A", "B"])]));
    for wrong in [
        "#pragma program()",
        "#pragma program(A",
        "#pragma program(A, )",
        "#pragma program(A:)",
        "#pragma program(A:, B)",
        "#pragma program(: B)",
        "#pragma program(A, B: C)",
        "#pragma programme(A)",
    ] {
        let source = format!("#version 460\n{wrong}\n");
        let message = programs(&source, Path::new("a.frag")).unwrap_err();
        assert!(message.starts_with("a.frag:2: ") && message.contains(wrong), "{message}");
    }
}

/// The pragma `group` gives a name and its members. Wrong pragmas are refused with their file.
#[test]
fn groups_are_read_off_their_pragmas() {
    let named = |source: &str| groups_in(source, Path::new("a.glsl"));
    let group = named("// Text.\n#pragma group(LightConstants, LIGHTS, SHADOWS)\n").unwrap().remove(0);
    assert_eq!((group.field().as_str(), group.members.len()), ("light_constants", 2));
    for wrong in ["#pragma group(Empty)", "#pragma group(Open, A", "#pragma group(A, )"] {
        assert!(named(wrong).unwrap_err().contains("a.glsl"), "{wrong}");
    }
}
