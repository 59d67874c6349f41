//! Compiles every stage under `shaders-glsl/` to SPIR-V with shaderc (glslang) for Vulkan 1.3 and
//! writes `shaders.rs`: one `Shader` per file, with the bindings found in the module, and one Rust
//! struct per uniform, storage or push-constant block. A block is thus declared once, in GLSL.

// The window, which shares it, also asks for the files that were read.
#[allow(dead_code)]
#[path = "src/gpu/glsl.rs"]
mod glsl;

use glsl::{Block, Interface};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const ROOT: &str = glsl::FOLDER;

fn main() {
    println!("cargo:rerun-if-changed={ROOT}");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-env=SSCT_COMMIT={}", commit());
    if let Err(message) = run() {
        eprintln!("{message}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), String> {
    let out = PathBuf::from(std::env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let mut structs: BTreeMap<String, Block> = BTreeMap::new();
    let (mut text, mut all) = (String::new(), String::new());
    for path in glsl::stages(Path::new(ROOT))? {
        let words = glsl::compile(&compiler, Path::new(ROOT), &path)?.words;
        let name = path.strip_prefix(ROOT).map_err(|e| e.to_string())?.to_string_lossy().replace('\\', "/");
        let file = format!("{}.spv", name.replace('/', "."));
        let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
        std::fs::write(out.join(&file), bytes).map_err(|e| format!("{file}: {e}"))?;
        let interface = glsl::interface(&words, &name)?;
        text.push_str(&constant(&interface, &name, &file));
        let _ = writeln!(all, "    &{},", constant_name(&name));
        for (block_name, block) in interface.blocks {
            match structs.get(&block_name) {
                Some(known) if known.fields != block.fields => {
                    return Err(format!(
                        "{name}: block {block_name} differs from its declaration for {}",
                        known.used_in
                    ));
                }
                Some(_) => {}
                None => drop(structs.insert(block_name, block)),
            }
        }
    }
    let _ = write!(text, "/// Every shader.\npub static ALL: &[&Shader] = &[\n{all}];\n");
    for (name, block) in &structs {
        text.push_str(&declaration(block, name));
    }
    std::fs::write(out.join("shaders.rs"), text).map_err(|e| e.to_string())
}

/// A stage's constant.
fn constant(interface: &Interface, name: &str, file: &str) -> String {
    let Interface { bindings, push_size, local_size, .. } = interface;
    let mut text = format!(
        "/// `{ROOT}/{name}`.\npub static {}: Shader = Shader {{\n    name: {name:?},\n    spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}\")),\n    push_constant_size: {push_size},\n    local_size: {local_size:?},\n    bindings: &[\n",
        constant_name(name),
    );
    for (binding, name, kind, count) in bindings {
        let _ = writeln!(
            text,
            "        Binding {{ name: {name:?}, binding: {binding}, kind: BindingKind::{kind}, count: {count} }},"
        );
    }
    text.push_str("    ],\n};\n");
    text
}

/// A block's Rust twin.
fn declaration(block: &Block, name: &str) -> String {
    let mut text = format!(
        "/// Twin of the block `{name}` ({} bytes), first declared for `{}`.\n#[repr(C)]\n#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n#[allow(missing_docs, non_snake_case)]\npub struct {name} {{\n",
        block.size, block.used_in
    );
    let (mut at, mut checks) = (0, String::new());
    for (i, (field, offset, ty, size)) in block.fields.iter().enumerate() {
        if at < *offset {
            let _ = writeln!(text, "    pub _pad{i}: [u8; {}],", offset - at);
        }
        let _ = writeln!(text, "    pub {field}: {ty},");
        let _ = writeln!(checks, "    assert!(std::mem::offset_of!({name}, {field}) == {offset});");
        at = offset + size;
    }
    if at < block.size {
        let _ = writeln!(text, "    pub _pad_end: [u8; {}],", block.size - at);
    }
    let _ = write!(
        text,
        "}}\nimpl Default for {name} {{ fn default() -> Self {{ bytemuck::Zeroable::zeroed() }} }}\nconst _: () = {{\n    assert!(std::mem::size_of::<{name}>() == {});\n{checks}}};\n",
        block.size
    );
    text
}

/// `thesis/hi_z.frag` → `THESIS_HI_Z_FRAG`.
fn constant_name(path: &str) -> String {
    path.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' }).collect()
}

/// The commit that is built, for records; "unknown" outside a repository, "+" after it for a
/// working tree that differs.
fn commit() -> String {
    let git = |args: &[&str]| {
        let output = std::process::Command::new("git").args(args).output().ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // The index changes with every commit and checkout; in a worktree it is not under `.git`. The
    // sources decide whether the tree differs.
    println!("cargo:rerun-if-changed=src");
    for file in ["HEAD", "index"].iter().filter_map(|f| git(&["rev-parse", "--git-path", f])) {
        println!("cargo:rerun-if-changed={file}");
    }
    match git(&["rev-parse", "--short=10", "HEAD"]) {
        None => "unknown".into(),
        Some(commit) => match git(&["status", "--porcelain", "--untracked-files=no"]) {
            Some(changes) if changes.is_empty() => commit,
            _ => commit + "+",
        },
    }
}
