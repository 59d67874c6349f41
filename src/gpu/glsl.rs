//! Finds the files of shaders, reads which programs they name, and compiles GLSL to SPIR-V (by shaderc, with the
//! feature `compile-shaders`). `build.rs` includes this file, and so does the window, which compiles changed shaders
//! anew: both therefore compile alike.
//!
//! A stage file names its programs right below `#version`, one a line, with the macros that are defined for each:
//!
//! ```glsl
//! #pragma program(BlurAcross, ACROSS)
//! #pragma program(BlurDown)
//! ```
//!
//! Lines with one name are permutations of one program, and have one struct. A `.frag` and a `.comp` file may share a
//! program. The word after a colon says where the rays of a permutation end (`RaySource` in `program.rs`):
//!
//! ```glsl
//! #pragma program(Mirror: Confirmed, CONFIRMED)
//! ```
//!
//! Each program of a `.frag` file with the line `#pragma in_either_stage` is compiled once more as a compute shader,
//! with COMPUTE defined. `#pragma in_either_stage(MINIMUM)` adds further compute programs with MINIMUM
//! defined, for images of other formats.

use std::path::{Path, PathBuf};

/// Folder of the sources in the repository.
pub const FOLDER: &str = "shaders-glsl";

/// The macro that is defined for a compute program of a `.frag` file.
pub const COMPUTE: &str = "COMPUTE";

/// Extensions of the files of a shader stage.
pub const STAGES: &[&str] = &["vert", "frag", "comp"];

/// Lists the files of shader stages below a folder, sorted. `.glsl` files are none: other files include them.
pub fn stages(folder: &Path) -> Result<Vec<PathBuf>, String> {
    files(folder, STAGES)
}

/// Lists the files below a folder that have one of the extensions, sorted.
pub fn files(folder: &Path, extensions: &[&str]) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| e.to_string())?.path();
        if path.is_dir() {
            found.extend(files(&path, extensions)?);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted)) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(feature = "compile-shaders")]
fn shader_kind(path: &Path) -> Option<shaderc::ShaderKind> {
    match path.extension()?.to_str()? {
        "vert" => Some(shaderc::ShaderKind::Vertex),
        "frag" => Some(shaderc::ShaderKind::Fragment),
        "comp" => Some(shaderc::ShaderKind::Compute),
        _ => None,
    }
}

/// A program that a stage file names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedProgram {
    /// Name of the program's struct in Rust.
    pub name: String,
    /// Name of the `RaySource` of the permutation, if there is one.
    pub rays: Option<String>,
    /// Macros that are defined for the permutation.
    pub defines: Vec<String>,
}

impl NamedProgram {
    /// Returns the compute permutation of this fragment program, with further macros.
    pub fn in_compute(&self, defines: &[String]) -> Self {
        let defines = [&self.defines[..], &[COMPUTE.to_owned()], defines].concat();
        Self { defines, ..self.clone() }
    }
}

/// The pragma of a source whose fragment programs are compute programs, too.
const IN_EITHER_STAGE: &str = "in_either_stage";

/// Reads the pragmas `in_either_stage` of a source. Each asks that every program of the source is compiled once more,
/// as a compute shader with COMPUTE and the macros in the pragma's brackets defined. Returns each pragma's macros.
///
/// # Errors
/// A sentence about a pragma that has another form.
pub fn in_either_stage(source: &str, path: &Path) -> Result<Vec<Vec<String>>, String> {
    let mut found = Vec::new();
    for (line, text) in source.lines().enumerate() {
        let Some(brackets) = text.strip_prefix("#pragma ").and_then(|text| text.strip_prefix(IN_EITHER_STAGE)) else {
            continue;
        };
        let defines = match brackets {
            "" => Some(Vec::new()),
            _ => brackets.strip_prefix('(').and_then(|list| list.strip_suffix(')')).and_then(words),
        };
        found.push(defines.ok_or_else(|| {
            format!(
                "{}:{}: {text:?} should be `#pragma {IN_EITHER_STAGE}` or `#pragma {IN_EITHER_STAGE}(DEFINED, …)`",
                path.display(),
                line + 1
            )
        })?);
    }
    Ok(found)
}

/// Splits a list at its commas; `None` if a part is not a word of letters, digits and underscores.
fn words(list: &str) -> Option<Vec<String>> {
    let words: Vec<&str> = list.split(',').map(str::trim).collect();
    let is_word = |w: &&str| !w.is_empty() && w.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    words.iter().all(is_word).then(|| words.into_iter().map(str::to_owned).collect())
}

/// Reads the programs that a stage's source names, in order.
///
/// # Errors
/// A sentence about a pragma that has another form.
pub fn programs(source: &str, path: &Path) -> Result<Vec<NamedProgram>, String> {
    let mut found = Vec::new();
    for (line, text) in source.lines().enumerate() {
        let Some(pragma) = text.strip_prefix("#pragma ") else { continue };
        if pragma.starts_with(IN_EITHER_STAGE) {
            continue;
        }
        let list = pragma.trim().strip_prefix("program(").and_then(|rest| rest.strip_suffix(')'));
        let program = list.and_then(read_program).ok_or_else(|| {
            format!(
                "{}:{}: {text:?} should be `#pragma program(Name)`, `#pragma program(Name, DEFINED, …)` or \
                 `#pragma program(Name: RaySource, DEFINED, …)`",
                path.display(),
                line + 1
            )
        })?;
        found.push(program);
    }
    Ok(found)
}

/// Reads the text in the brackets of `#pragma program(…)`, such as `Name: RaySource, DEFINED`; `None` for a wrong form.
fn read_program(list: &str) -> Option<NamedProgram> {
    let (rays, name_and_defines) = match list.split_once(':') {
        None => (None, list.to_owned()),
        Some((name, _)) if name.contains(',') => return None,
        Some((name, after_colon)) => {
            let (rays, defines) = after_colon.split_once(',').unwrap_or((after_colon, ""));
            let separator = if after_colon.contains(',') { "," } else { "" };
            (Some(words(rays)?.remove(0)), format!("{name}{separator}{defines}"))
        }
    };
    let mut words = words(&name_and_defines)?;
    Some(NamedProgram { name: words.remove(0), rays, defines: words })
}

/// Bindings or specialization constants that several programs share, as a source names them. In Rust they have a struct
/// of their own, which is one field of each program that has all of them.
///
/// ```glsl
/// #pragma group(LightConstants, LIGHTS, SHADOWS)
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Name of the group's struct in Rust.
    pub name: String,
    /// Names of the bindings or constants.
    pub members: Vec<String>,
}

impl Group {
    /// Returns the name of the group's field in the structs of programs: the group's name in snake case.
    pub fn field(&self) -> String {
        let in_snake_case = |(i, c): (usize, char)| {
            let underscore = (i > 0 && c.is_ascii_uppercase()).then_some('_');
            underscore.into_iter().chain([c.to_ascii_lowercase()])
        };
        self.name.chars().enumerate().flat_map(in_snake_case).collect()
    }
}

/// Reads the groups that the `.glsl` files below a folder declare, sorted by file.
///
/// # Errors
/// A sentence about a file that cannot be read, or a pragma that has another form.
pub fn groups(folder: &Path) -> Result<Vec<Group>, String> {
    let mut found = Vec::new();
    for path in files(folder, &["glsl"])? {
        let source = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        found.extend(groups_in(&source, &path)?);
    }
    Ok(found)
}

/// Reads the groups of bindings or constants that the lines `#pragma group(…)` of a source declare.
///
/// # Errors
/// A sentence about such a line that has another form.
pub fn groups_in(source: &str, path: &Path) -> Result<Vec<Group>, String> {
    let lists = source.lines().filter_map(|text| text.strip_prefix("#pragma group(").map(|list| (text, list)));
    let group = |(text, list): (&str, &str)| {
        let words = list.strip_suffix(')').and_then(words).filter(|words| words.len() > 1);
        let wrong = || format!("{}: {text:?} should be `#pragma group(Name, member, …)`", path.display());
        let mut members = words.ok_or_else(wrong)?;
        Ok(Group { name: members.remove(0), members })
    };
    lists.map(group).collect()
}

/// Compiles a stage for Vulkan 1.3 with some macros defined. Included files lie beside the includer or in `root`.
///
/// # Errors
/// The compiler's message, which names file and line.
#[cfg(feature = "compile-shaders")]
pub fn compile<D: AsRef<str>>(
    compiler: &shaderc::Compiler,
    root: &Path,
    path: &Path,
    defines: &[D],
) -> Result<CompiledStage, String> {
    let included = std::cell::RefCell::new(vec![path.to_path_buf()]);
    let source = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut options = shaderc::CompileOptions::new().map_err(|e| format!("shaderc: {e}"))?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_warnings_as_errors();
    for define in defines {
        options.add_macro_definition(define.as_ref(), None);
    }
    // The module is not optimised: the driver does so, and the module stays close to the source.
    options.set_optimization_level(shaderc::OptimizationLevel::Zero);
    options.set_include_callback(|name, _, includer, _| {
        let beside = Path::new(includer).parent().unwrap_or(root).join(name);
        let path = if beside.exists() { beside } else { root.join(name) };
        let content = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        included.borrow_mut().push(path.clone());
        Ok(shaderc::ResolvedInclude { resolved_name: path.to_string_lossy().into_owned(), content })
    });
    let is_compute = defines.iter().any(|define| define.as_ref() == COMPUTE);
    let stage = if is_compute { shaderc::ShaderKind::Compute } else { shader_kind(path).ok_or("not a stage")? };
    let words = compiler
        .compile_into_spirv(&source, stage, &path.to_string_lossy(), "main", Some(&options))
        .map(|artifact| artifact.as_binary().to_vec())
        .map_err(|e| e.to_string())?;
    drop(options);
    Ok(CompiledStage { words, files: included.into_inner() })
}

/// A stage's code, and the files that it was made from: its source, then the included files.
#[cfg(feature = "compile-shaders")]
pub struct CompiledStage {
    /// SPIR-V.
    pub words: Vec<u32>,
    /// Paths of the files; one path may be there several times.
    pub files: Vec<PathBuf>,
}
