//! Compiles every program under `shaders-glsl/` to SPIR-V with shaderc (glslang) for Vulkan 1.3. Writes Rust declarations of what
//! GLSL declares, so that nothing is declared twice:
//!
//! - `programs.rs` has a struct for each program, whose fields are the bindings and push constants found in the modules of its
//!   permutations, and a struct for its specialization constants.
//! - `blocks.rs` has a struct for each uniform or push-constant block.
//!
//! Without the feature `compile-shaders` the script does without shaderc. The SPIR-V then comes from `shaders-spirv/`, which
//! `scripts/package.sh` puts into the package, and the declarations are made from it in the same way.

// The window includes this module, too, and reads the field `CompiledStage::files`, which this script does not read.
#[allow(dead_code)]
#[path = "src/gpu/glsl.rs"]
mod glsl;
#[path = "src/gpu/interface.rs"]
mod interface;
// No other program includes this module.
#[path = "src/gpu/declarations.rs"]
mod declarations;

use declarations::{Groups, MODULES, Permutation, Stage, block_struct, declare_program, find_stored, title};
use glsl::NamedProgram;
use interface::{Block, Interface};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const ROOT: &str = glsl::FOLDER;

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

/// Compiles every program, and writes the modules and the Rust declarations into the output folder that cargo gives the
/// script. An error is the sentence that `main` prints.
fn run() -> Result<(), String> {
    let out = PathBuf::from(std::env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let fingerprint = fingerprint()?;
    let compiler = Compiler::new(&fingerprint)?;
    let modules = out.join(MODULES);
    // The folder is emptied, since the module of a program that was removed would be packaged with the others.
    if modules.exists() {
        std::fs::remove_dir_all(&modules).map_err(|e| format!("{}: {e}", modules.display()))?;
    }
    std::fs::create_dir_all(&modules).map_err(|e| format!("{}: {e}", modules.display()))?;
    std::fs::write(modules.join(FINGERPRINT), fingerprint).map_err(|e| format!("{FINGERPRINT}: {e}"))?;
    let mut blocks: BTreeMap<String, Block> = BTreeMap::new();
    let mut module_names = BTreeSet::new();
    let (mut names_in_order, mut programs) = (Vec::new(), BTreeMap::<String, Vec<Permutation>>::new());
    for path in glsl::stages(Path::new(ROOT))? {
        let source = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let named_programs = glsl::programs(&source, &path)?;
        if named_programs.is_empty() {
            return Err(format!("{}: it names no program (`#pragma program(Name)`)", path.display()));
        }
        let in_compute = glsl::in_either_stage(&source, &path)?;
        for named in named_programs {
            let compute_twins = in_compute.iter().map(|defines| named.in_compute(defines));
            for named in std::iter::once(named.clone()).chain(compute_twins) {
                let permutation = compile(&compiler, &path, &named, &modules)?;
                add_blocks(&permutation.interface, &permutation.file, &mut blocks)?;
                if !module_names.insert(permutation.module.clone()) {
                    return Err(format!("{}: another module has the file {}", path.display(), permutation.module));
                }
                if !programs.contains_key(&named.name) {
                    names_in_order.push(named.name.clone());
                }
                programs.entry(named.name).or_default().push(permutation);
            }
        }
    }
    let mut groups = Groups::new(glsl::groups(Path::new(ROOT))?);
    let (mut text, mut shader_list) = (String::new(), String::new());
    for name in &names_in_order {
        let permutations = programs.get_mut(name).map_or(&mut [][..], |permutations| &mut permutations[..]);
        find_stored(permutations).map_err(|e| format!("{name}: {e}"))?;
        text.push_str(&declare_program(name, permutations, &mut groups).map_err(|e| format!("{name}: {e}"))?);
        for n in 0..permutations.len() {
            let _ = writeln!(shader_list, "    {name}::PERMUTATIONS[{n}].shader,");
        }
    }
    text.push_str(&groups.text()?);
    let _ = write!(text, "/// The shaders of all programs.\npub static ALL: &[&Shader] = &[\n{shader_list}];\n");
    let block_structs: String = blocks.iter().map(|(name, block)| block_struct(block, name)).collect();
    for (name, text) in [("programs.rs", text), ("blocks.rs", block_structs)] {
        std::fs::write(out.join(name), text).map_err(|e| format!("{name}: {e}"))?;
    }
    Ok(())
}

/// Compiles the permutation `named` of the stage file at `path`, writes its SPIR-V into the folder `modules`, and reads
/// the interface of the module.
fn compile(compiler: &Compiler, path: &Path, named: &NamedProgram, modules: &Path) -> Result<Permutation, String> {
    let file = path.strip_prefix(ROOT).map_err(|e| e.to_string())?.to_string_lossy().replace('\\', "/");
    let stage = match path.extension().and_then(|e| e.to_str()) {
        _ if named.defines.iter().any(|define| define == glsl::COMPUTE) => Stage::Compute,
        Some("frag") => Stage::Fragment,
        Some("vert") => Stage::Vertex,
        _ => Stage::Compute,
    };
    let title = title(&file, &named.defines);
    let module = title.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let words = compiler.words(path, &named.defines, &module)?;
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    let binary = modules.join(format!("{module}.spv"));
    std::fs::write(&binary, bytes).map_err(|e| format!("{}: {e}", binary.display()))?;
    let interface = Interface::from_words(&words, &title)?;
    Ok(Permutation { named: named.clone(), stage, file, module, interface, stored: Vec::new() })
}

/// Adds the uniform and push-constant blocks of a program to `blocks`, by their names. Fails if another program
/// declares a block of the same name with other fields.
fn add_blocks(interface: &Interface, file: &str, blocks: &mut BTreeMap<String, Block>) -> Result<(), String> {
    for (name, block) in &interface.blocks {
        match blocks.get(name) {
            Some(known) if known.fields != block.fields => {
                return Err(format!("{file}: block {name} differs from its declaration for {}", known.used_in));
            }
            Some(_) => {}
            None => drop(blocks.insert(name.clone(), block.clone())),
        }
    }
    Ok(())
}

/// Returns a hash of the paths and texts of all GLSL sources (FNV-1a, 64 bits), as 16 hexadecimal digits.
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

/// Gets the SPIR-V of a program by compiling its GLSL with shaderc.
#[cfg(feature = "compile-shaders")]
struct Compiler(shaderc::Compiler);

#[cfg(feature = "compile-shaders")]
impl Compiler {
    fn new(_fingerprint: &str) -> Result<Self, String> {
        shaderc::Compiler::new().map(Self).map_err(|e| format!("shaderc: {e}"))
    }

    /// Compiles a shader with macros, and returns the words of its SPIR-V.
    fn words(&self, path: &Path, defines: &[String], _module: &str) -> Result<Vec<u32>, String> {
        Ok(glsl::compile(&self.0, Path::new(ROOT), path, defines)?.words)
    }
}

/// Gets the SPIR-V of a program from the folder of compiled modules in the package.
#[cfg(not(feature = "compile-shaders"))]
struct Compiler;

#[cfg(not(feature = "compile-shaders"))]
impl Compiler {
    const PACKAGED: &str = "shaders-spirv";

    /// Fails if the folder of modules is missing, or if the modules were compiled from GLSL with another hash than
    /// `fingerprint`.
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

    /// Reads the words of a module from its file in the package. The header of SPIR-V has five words, or 20 bytes.
    fn words(&self, _path: &Path, _defines: &[String], module: &str) -> Result<Vec<u32>, String> {
        let path = Path::new(Self::PACKAGED).join(format!("{module}.spv"));
        let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        if bytes.len() < 20 || !bytes.len().is_multiple_of(4) {
            return Err(format!("{}: it is no SPIR-V", path.display()));
        }
        Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}
