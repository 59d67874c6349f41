//! Compiles every program under `shaders-glsl/` to SPIR-V with shaderc (glslang) for Vulkan 1.3. Writes Rust declarations of what
//! GLSL declares, so that nothing is declared twice:
//!
//! - `programs.rs` has a struct for each program, whose fields are the bindings and push constants found in its module, and a
//!   struct for its specialization constants.
//! - `blocks.rs` has a struct for each uniform or push-constant block.
//!
//! Without the feature `compile-shaders` the script does without shaderc. The SPIR-V then comes from `shaders-spirv/`, which
//! `scripts/package.sh` puts into the package, and the declarations are made from it in the same way.

// The window includes this module, too, and reads a field that this script does not: the files that a compilation read.
#[allow(dead_code)]
#[path = "src/gpu/glsl.rs"]
mod glsl;
#[path = "src/gpu/interface.rs"]
mod interface;

use glsl::NamedProgram;
use interface::{Block, Constant, Interface, StageBinding};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const ROOT: &str = glsl::FOLDER;

/// The folder of the programs' modules, below the folder that Cargo gives to this script. A package contains it.
const MODULES: &str = "spirv";

/// The file beside the modules with the hash of the GLSL that they were compiled from.
const FINGERPRINT: &str = "glsl.txt";

fn main() {
    println!("cargo:rerun-if-changed={ROOT}");
    println!("cargo:rerun-if-changed=build.rs");
    if let Err(message) = run() {
        eprintln!("{message}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), String> {
    let out = PathBuf::from(std::env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let fingerprint = fingerprint()?;
    let compiler = Compiler::new(&fingerprint)?;
    let modules = out.join(MODULES);
    // A module of a program that was renamed or removed would be packaged with the others.
    if modules.exists() {
        std::fs::remove_dir_all(&modules).map_err(|e| format!("{}: {e}", modules.display()))?;
    }
    std::fs::create_dir_all(&modules).map_err(|e| format!("{}: {e}", modules.display()))?;
    std::fs::write(modules.join(FINGERPRINT), fingerprint).map_err(|e| format!("{FINGERPRINT}: {e}"))?;
    let mut structs: BTreeMap<String, Block> = BTreeMap::new();
    let (mut programs, mut all, mut names) = (String::new(), String::new(), BTreeSet::new());
    for path in glsl::stages(Path::new(ROOT))? {
        let file = path.strip_prefix(ROOT).map_err(|e| e.to_string())?.to_string_lossy().replace('\\', "/");
        let source = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let named = glsl::programs(&source, &path)?;
        if named.is_empty() {
            return Err(format!("{}: it names no program (`#pragma program(Name)`)", path.display()));
        }
        let in_compute = glsl::in_either_stage(&source, &path)?;
        let mut interface_of = |program: &NamedProgram| -> Result<Interface, String> {
            if !names.insert(program.name.clone()) {
                return Err(format!("{}: there is another program {}", path.display(), program.name));
            }
            let words = compiler.words(&path, program)?;
            let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
            let binary = modules.join(format!("{}.spv", program.name));
            std::fs::write(&binary, bytes).map_err(|e| format!("{}: {e}", binary.display()))?;
            let interface = Interface::from_words(&words, &file)?;
            collect(&interface, &file, &mut structs)?;
            Ok(interface)
        };
        for program in named {
            let interface = interface_of(&program)?;
            programs.push_str(&declared_program(&program, &file, &interface));
            let _ = writeln!(all, "    {}::SHADER,", program.name);
            let mut shaders = String::new();
            for (n, defines) in in_compute.iter().enumerate() {
                let twin = program.in_compute(defines);
                let made = interface_of(&twin)?;
                let stored =
                    stored(&interface, &made).map_err(|e| format!("{}: {}: {e}", path.display(), twin.name))?;
                let _ = writeln!(shaders, "    {},", declared_shader(&twin, &file, &made, &stored));
                let _ = writeln!(all, "    &{}::COMPUTE[{n}],", program.name);
            }
            if !in_compute.is_empty() {
                let generics = if interface.bindings.is_empty() && interface.push.is_none() { "" } else { "<'_>" };
                let _ = writeln!(
                    programs,
                    "impl InEitherStage for {}{generics} {{\n    const COMPUTE: &'static [Shader] = &[\n{shaders}    ];\n}}",
                    program.name
                );
            }
        }
    }
    let _ = write!(programs, "/// The shaders of all programs.\npub static ALL: &[&Shader] = &[\n{all}];\n");
    let blocks: String = structs.iter().map(|(name, block)| declaration(block, name)).collect();
    for (name, text) in [("programs.rs", programs), ("blocks.rs", blocks)] {
        std::fs::write(out.join(name), text).map_err(|e| format!("{name}: {e}"))?;
    }
    Ok(())
}

/// Adds the blocks of a program to the known ones. Every program that uses a block has to declare it alike.
fn collect(interface: &Interface, file: &str, structs: &mut BTreeMap<String, Block>) -> Result<(), String> {
    for (name, block) in &interface.blocks {
        match structs.get(name) {
            Some(known) if known.fields != block.fields => {
                return Err(format!("{file}: block {name} differs from its declaration for {}", known.used_in));
            }
            Some(_) => {}
            None => drop(structs.insert(name.clone(), block.clone())),
        }
    }
    Ok(())
}

/// Binding and format of the images that a compute program stores to, in the order of the outputs of the fragment program of the
/// same source. Apart from these images, both programs have the same bindings and constants.
fn stored(fragment: &Interface, compute: &Interface) -> Result<Vec<(u32, &'static str)>, String> {
    let is_read = |bound: &&StageBinding| fragment.bindings.contains(bound);
    let outputs: Vec<&StageBinding> = compute.bindings.iter().filter(|bound| !is_read(bound)).collect();
    let read = compute.bindings.len() - outputs.len();
    let reads_alike = read == fragment.bindings.len()
        && compute.push == fragment.push
        && compute.constants == fragment.constants
        && outputs.len() == fragment.outputs.len();
    if !reads_alike {
        return Err("its fragment program and its compute program differ in more than where they write".into());
    }
    let format = |bound: &&StageBinding| {
        let found = compute.formats.get(&bound.binding).map(|format| (bound.binding, *format));
        found.ok_or_else(|| format!("the output {} has no format", bound.name))
    };
    outputs.iter().map(format).collect()
}

/// Hashes the paths and texts of all sources (FNV-1a).
fn fingerprint() -> Result<String, String> {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |bytes: &[u8]| {
        // The length of each text goes in first, so that two texts hash differently if the border between them moves.
        for byte in (bytes.len() as u64).to_le_bytes().iter().chain(bytes) {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for path in glsl::files(Path::new(ROOT), &[glsl::STAGES, &["glsl"]].concat())? {
        add(path.to_string_lossy().replace('\\', "/").as_bytes());
        add(&std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?);
    }
    Ok(format!("{hash:016x}\n"))
}

/// The source of the modules: shaderc.
#[cfg(feature = "compile-shaders")]
struct Compiler(shaderc::Compiler);

#[cfg(feature = "compile-shaders")]
impl Compiler {
    fn new(_: &str) -> Result<Self, String> {
        shaderc::Compiler::new().map(Self).map_err(|e| format!("shaderc: {e}"))
    }

    fn words(&self, path: &Path, program: &NamedProgram) -> Result<Vec<u32>, String> {
        Ok(glsl::compile(&self.0, Path::new(ROOT), path, &program.defines)?.words)
    }
}

/// The source of the modules: the package.
#[cfg(not(feature = "compile-shaders"))]
struct Compiler;

#[cfg(not(feature = "compile-shaders"))]
impl Compiler {
    const PACKAGED: &str = "shaders-spirv";

    fn new(fingerprint: &str) -> Result<Self, String> {
        let folder = Self::PACKAGED;
        println!("cargo:rerun-if-changed={folder}");
        match std::fs::read_to_string(Path::new(folder).join(FINGERPRINT)) {
            Ok(packaged) if packaged == fingerprint => {
                println!(
                    "cargo:warning=the shaders are the packaged SPIR-V of {folder}/; the feature compile-shaders \
                     compiles them from {ROOT}/ instead"
                );
                Ok(Self)
            }
            Ok(_) => Err(format!(
                "{ROOT}/ is not what the SPIR-V of {folder}/ was compiled from: turn on the feature compile-shaders of \
                 ssct, which needs libshaderc, or run `make package` in the repository, which writes {folder}/ anew"
            )),
            Err(_) => Err(format!(
                "there is no compiled shader, since this is no package of ssct ({folder}/ is missing): turn on its \
                 feature compile-shaders, which needs libshaderc (scripts/setup.sh installs it), or run `make package`, \
                 which writes {folder}/"
            )),
        }
    }

    fn words(&self, _: &Path, program: &NamedProgram) -> Result<Vec<u32>, String> {
        let path = Path::new(Self::PACKAGED).join(format!("{}.spv", program.name));
        let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        if bytes.len() < 20 || !bytes.len().is_multiple_of(4) {
            return Err(format!("{}: it is no SPIR-V", path.display()));
        }
        Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}

/// Declares a program's struct, with the traits through which pipelines and frames use it (`src/gpu/program.rs`).
fn declared_program(program: &NamedProgram, file: &str, interface: &Interface) -> String {
    let name = &program.name;
    let Interface { bindings, push, outputs, constants, .. } = interface;
    let (mut fields, mut resources) = (String::new(), String::new());
    for StageBinding { binding, name: field, kind, count, block, read_only } in bindings {
        let (ty, resource) = match (*kind, *count, *read_only) {
            ("SampledImage", 1, _) => ("Sampled<'a>".to_owned(), format!("Sampled(self.{field})")),
            ("SampledImage", n, _) => (format!("[Sampled<'a>; {n}]"), format!("SampledArray(&self.{field})")),
            ("StorageTexels", ..) => ("&'a TexelBuffer".to_owned(), format!("Texels(self.{field})")),
            ("StorageImage", _, true) => ("ImageSlice<'a>".to_owned(), format!("Loaded(self.{field})")),
            ("StorageImage", _, false) => ("ImageSlice<'a>".to_owned(), format!("Storage(self.{field})")),
            ("RayStructure", ..) => ("&'a RayStructure".to_owned(), format!("Rays(self.{field})")),
            ("UniformBuffer", ..) => (format!("&'a {block}"), format!("Uniform(bytemuck::bytes_of(self.{field}))")),
            (_, _, true) => ("&'a Buffer".to_owned(), format!("ReadBuffer(self.{field})")),
            (_, _, false) => ("&'a Buffer".to_owned(), format!("Buffer(self.{field})")),
        };
        let _ = writeln!(fields, "    /// Binding {binding}.\n    pub {field}: {ty},");
        let _ = write!(resources, "Resource::{resource}, ");
    }
    if let Some(push) = push {
        let _ = writeln!(fields, "    /// Push constants.\n    pub {}: &'a {},", push.name, push.block);
    }
    let (generics, elided, fixed) = if fields.is_empty() { ("", "", "") } else { ("<'a>", "<'_>", "<'static>") };
    let pushed = push.as_ref().map_or("&[]".to_owned(), |p| format!("bytemuck::bytes_of(self.{})", p.name));
    let title = [&[file.to_owned()], &program.defines[..]].concat().join(" ");
    let shader = declared_shader(program, file, interface, &[]);
    let (constants_type, constants) = declared_constants(name, constants);
    let kind = match Path::new(file).extension().and_then(|e| e.to_str()) {
        Some("frag") => format!("Fragment for {name}{elided} {{\n    type Outputs<T> = [T; {}];\n}}", outputs.len()),
        Some("vert") => format!("VertexProgram for {name}{elided} {{}}"),
        _ => format!("Compute for {name}{elided} {{}}"),
    };
    let written = match &outputs[..] {
        [] => String::new(),
        some => {
            let list: Vec<_> = some.iter().map(|(name, ty)| format!("`{name}` ({ty})")).collect();
            format!("\n///\n/// Outputs: {}.", list.join(", "))
        }
    };
    format!(
        "/// What `{ROOT}/{title}` reads.{written}\n#[derive(Clone, Copy)]\n#[allow(non_snake_case)]\npub struct {name}{generics} {{\n{fields}}}\n\
         impl Program for {name}{elided} {{\n    type Kind = {name}{fixed};\n    type Constants = {constants_type};\n    \
         const SHADER: &'static Shader = &{shader};\n    \
         fn resources(&self) -> Vec<Resource<'_>> {{ vec![{resources}] }}\n    \
         fn push(&self) -> &[u8] {{ {pushed} }}\n}}\nimpl {kind}\n{constants}"
    )
}

/// Declares a program's `Shader`. `stored` has binding and format of each image that a compute program stores to in place of a
/// fragment program's outputs.
fn declared_shader(program: &NamedProgram, file: &str, interface: &Interface, stored: &[(u32, &str)]) -> String {
    let NamedProgram { name, defines } = program;
    let title = [&[file.to_owned()], &defines[..]].concat().join(" ");
    let (push_size, local_size) = (interface.push.as_ref().map_or(0, |p| p.size), interface.local_size);
    let binding = |StageBinding { binding, name, kind, count, .. }: &StageBinding| {
        format!("Binding {{ name: {name:?}, binding: {binding}, kind: BindingKind::{kind}, count: {count} }}, ")
    };
    let bindings: String = interface.bindings.iter().map(binding).collect();
    let stored: String =
        stored.iter().map(|(binding, format)| format!("({binding}, vk::Format::{format}), ")).collect();
    format!(
        "Shader {{\n        name: {title:?},\n        file: {file:?},\n        defines: &{defines:?},\n        \
         spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{MODULES}/{name}.spv\")),\n        \
         push_constant_size: {push_size},\n        local_size: {local_size:?},\n        bindings: &[{bindings}],\n        \
         stored: &[{stored}],\n    }}"
    )
}

/// Returns the name of the type of a program's specialization constants, and its declaration.
fn declared_constants(program: &str, constants: &[Constant]) -> (String, String) {
    if constants.is_empty() {
        return ("()".into(), String::new());
    }
    let (mut fields, mut entries) = (String::new(), String::new());
    let mut defaults = String::new();
    for Constant { id, name, ty, default } in constants {
        let field = name.to_ascii_lowercase();
        let value = match *ty {
            "f32" => format!("f32::from_bits({default})"),
            "bool" => (*default != 0).to_string(),
            "i32" => default.cast_signed().to_string(),
            _ => default.to_string(),
        };
        let _ = write!(defaults, "{field}: {value}, ");
        let _ = writeln!(fields, "    /// `{name}`.\n    pub {field}: {ty},");
        let bits = match *ty {
            "f32" => format!("self.{field}.to_bits()"),
            "bool" => format!("u32::from(self.{field})"),
            "i32" => format!("self.{field}.cast_unsigned()"),
            _ => format!("self.{field}"),
        };
        let _ = write!(entries, "({id}, {bits}), ");
    }
    let name = format!("{program}Constants");
    let text = format!(
        "/// Specialization constants of [`{program}`].\n#[derive(Debug, Clone, Copy, PartialEq)]\npub struct {name} {{\n{fields}}}\n\
         impl Constants for {name} {{\n    fn entries(&self) -> Vec<(u32, u32)> {{ vec![{entries}] }}\n}}\n\
         /// The values that the shader gives them.\nimpl Default for {name} {{\n    fn default() -> Self {{ Self {{ {defaults}}} }}\n}}\n"
    );
    (name, text)
}

/// Declares the Rust struct that has the layout of a block.
fn declaration(block: &Block, name: &str) -> String {
    let mut text = format!(
        "/// Twin of the block `{name}` ({} bytes), first declared for `{}`.\n#[repr(C)]\n#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n#[allow(missing_docs, non_snake_case)]\npub struct {name} {{\n",
        block.size, block.used_in
    );
    let (mut end, mut checks) = (0, String::new());
    for (i, (field, offset, ty, size)) in block.fields.iter().enumerate() {
        if end < *offset {
            let _ = writeln!(text, "    pub _pad{i}: [u8; {}],", offset - end);
        }
        let _ = writeln!(text, "    pub {field}: {ty},");
        let _ = writeln!(checks, "    assert!(std::mem::offset_of!({name}, {field}) == {offset});");
        end = offset + size;
    }
    if end < block.size {
        let _ = writeln!(text, "    pub _pad_end: [u8; {}],", block.size - end);
    }
    let _ = write!(
        text,
        "}}\nimpl Default for {name} {{ fn default() -> Self {{ bytemuck::Zeroable::zeroed() }} }}\nconst _: () = {{\n    assert!(std::mem::size_of::<{name}>() == {});\n{checks}}};\n",
        block.size
    );
    text
}
