//! Compiles a user's shader and finds its bindings. GLSL for OpenGL is accepted, too: variables get bindings and
//! locations, and loose uniforms are put into a block.

use super::built_in;
use super::includes::{self, Includes, MAX_BYTES};
use super::loose_uniforms::{self, HoistedUniforms};
use super::manifest::{Manifest, Pass, PassStage};
use super::old_glsl;
use super::reflect::{ShaderInterface, VariableKind, reflect};
use sha2::{Digest, Sha256};
use shaderc::{CompileOptions, Compiler, OptimizationLevel, ResolvedInclude, ShaderKind, TargetEnv};
use ssct::gpu::interface::{Interface, PushBlock, StageBinding};
use ssct::gpu::loose;
use ssct::gpu::shader::Shader;
use ssct_geometry::bounded;
use ssct_ground::{Error, Result};
use ssct_scenes::source_text;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// A compiled stage, its interface, and the files that it was made of.
pub struct CompiledPass {
    /// The code for pipelines.
    pub shader: &'static Shader,
    /// The interface of the code.
    pub interface: ShaderInterface,
    /// Names of uniforms with their initial values; `None` for a value that does not consist of numbers alone.
    pub initial_values: Vec<(String, Option<Vec<f64>>)>,
    /// The files that the shader was made of, and paths at which new files would change it.
    pub files: Vec<PathBuf>,
}

/// Code whose interface is not read yet; fields as in [`CompiledPass`].
struct CompiledCode {
    /// The words of the SPIR-V module.
    words: Vec<u32>,
    initial_values: Vec<(String, Option<Vec<f64>>)>,
    files: Vec<PathBuf>,
}

/// Compiles the shader of a pass, or reads it if it is compiled already (`.spv`), and reads its interface.
///
/// # Errors
/// [`Io`](ssct_ground::Error::Io) if there is no file. [`Malformed`](ssct_ground::Error::Malformed) with the line of the compiler's
/// first message, and for files outside of the allowed folders.
pub fn compile(manifest: &Manifest, pass: &Pass) -> Result<CompiledPass> {
    let (path, method) = (&pass.shader, &manifest.name);
    includes::check_shader(path, &manifest.folder)?;
    let is_binary = path.extension().is_some_and(|e| e == "spv");
    let compiled = if is_binary { read_spirv(path)? } else { compile_glsl(manifest, pass)? };
    let interface = reflect(&compiled.words, pass.stage == PassStage::Fragment)
        .map_err(|message| Error::malformed(path, None, message))?;
    let spirv: Vec<u8> = interface.words.iter().flat_map(|w| w.to_le_bytes()).collect();
    // The digest distinguishes the code from all other code whose pipelines a device keeps.
    let digest = Sha256::digest(&spirv).iter().take(8).map(|b| format!("{b:02x}")).collect::<String>();
    let file = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let shader = loose::make_shader(format!("{method}/{file}#{digest}"), spirv, &pipeline_interface(&interface))
        .map_err(|e| Error::malformed(path, None, e.to_string()))?;
    Ok(CompiledPass { shader, interface, initial_values: compiled.initial_values, files: compiled.files })
}

/// Returns the part of an interface that a pipeline needs.
fn pipeline_interface(interface: &ShaderInterface) -> Interface {
    let bindings = interface.variables.iter().map(|v| StageBinding {
        binding: v.binding,
        name: v.name.clone(),
        kind: match v.kind {
            VariableKind::Sampled(_) => "SampledImage",
            VariableKind::Stored(_) => "StorageImage",
            VariableKind::Uniform(_) => "UniformBuffer",
            VariableKind::Storage(_) => "StorageBuffer",
        },
        count: v.count,
        block: v.block.clone(),
        read_only: v.read_only,
    });
    Interface {
        bindings: bindings.collect(),
        push: interface.push.as_ref().map(|(block, layout)| PushBlock {
            name: block.clone(),
            block: block.clone(),
            size: layout.size,
        }),
        outputs: Vec::new(),
        constants: interface.constants.clone(),
        local_size: interface.local_size,
        blocks: BTreeMap::new(),
        formats: BTreeMap::new(),
    }
}

/// Reads a file of SPIR-V, which needs no compiler.
fn read_spirv(path: &Path) -> Result<CompiledCode> {
    let bytes = bounded::read(path, "a shader", MAX_BYTES)?;
    // A module has a header of five words, of which the first is SPIR-V's magic number.
    let is_code =
        bytes.len() >= 20 && bytes.len().is_multiple_of(4) && bytes.starts_with(&0x0723_0203_u32.to_le_bytes());
    if !is_code {
        return Err(Error::malformed(path, None, "is not SPIR-V"));
    }
    let words = bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
    Ok(CompiledCode { words, initial_values: Vec::new(), files: vec![path.to_path_buf()] })
}

/// The one compiler of the process. It is never dropped: without any compiler, GLSL's built-in functions are forgotten,
/// and the next compiler reads them again. That takes far longer than compiling a shader
/// (findings/shaderc-forgets-what-it-knows.sh).
static COMPILER: LazyLock<std::result::Result<Compiler, shaderc::Error>> = LazyLock::new(Compiler::new);

/// Compiles GLSL in two steps. The compiler's preprocessor removes comments, macros, includes and lines that are
/// switched off, so that loose uniforms can be recognised by their tokens. Then the text with these uniforms in blocks
/// is compiled.
fn compile_glsl(manifest: &Manifest, pass: &Pass) -> Result<CompiledCode> {
    let path = &pass.shader;
    let source = match built_in::text(path) {
        Some(text) => text.to_owned(),
        None => source_text::read_program(path, "a shader", MAX_BYTES)?,
    };
    old_glsl::check(path, &source)?;
    let wrong = |message: String| Error::malformed(path, None, message);
    // The compiler's binding panics on a NUL character.
    let has_nul = |text: &String| text.contains('\0');
    if has_nul(&source) || pass.defines.iter().any(has_nul) {
        return Err(wrong("a shader's text and its defines must not hold a NUL character".to_owned()));
    }
    let compiler = COMPILER.as_ref().map_err(|e| wrong(format!("the compiler cannot be started: {e}")))?;
    let includes = RefCell::new(Includes::new(&manifest.folder, &manifest.include, path));
    let mut options = CompileOptions::new().map_err(|e| wrong(e.to_string()))?;
    options.set_target_env(TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_optimization_level(OptimizationLevel::Zero);
    options.set_auto_bind_uniforms(true);
    options.set_auto_map_locations(true);
    options.set_suppress_warnings();
    for define in &pass.defines {
        let (name, value) = define.split_once('=').map_or((define.as_str(), None), |(name, value)| (name, Some(value)));
        options.add_macro_definition(name, value);
    }
    options.set_include_callback(|name, _, includer, _| {
        let (resolved_name, content) = includes.borrow_mut().read(name, includer)?;
        if has_nul(&content) {
            return Err(format!("{resolved_name}: a shader's text must not hold a NUL character"));
        }
        Ok(ResolvedInclude { resolved_name, content })
    });
    let kind = match pass.stage {
        PassStage::Fragment => ShaderKind::Fragment,
        PassStage::Compute => ShaderKind::Compute,
    };
    let label = path.to_string_lossy();
    let failed =
        |e: shaderc::Error| match (first_compiler_error(path, &e.to_string()), includes.borrow_mut().refused.take()) {
            // If an include was refused, the message is only the reason, without the compiler's words around it.
            (Error::Malformed { path, line, .. }, Some(message)) => Error::Malformed { path, line, message },
            (error, _) => error,
        };
    let preprocessed = compiler.preprocess(&source, &label, "main", Some(&options)).map_err(failed)?.as_text();
    let HoistedUniforms { text, initial_values } = loose_uniforms::hoist(&preprocessed);
    let artifact = compiler.compile_into_spirv(&text, kind, &label, "main", Some(&options)).map_err(failed)?;
    let words = artifact.as_binary().to_vec();
    drop(options);
    let awaited = pass.awaited.iter().cloned();
    Ok(CompiledCode {
        words,
        initial_values,
        files: includes.into_inner().watched().into_iter().chain(awaited).collect(),
    })
}

/// Makes an error of the first message in the compiler's output `text`, with the file and line that the message is
/// about. Without any message, the error is about the file `path` and has the whole output.
fn first_compiler_error(path: &Path, text: &str) -> Error {
    for line in text.lines() {
        // A line of the output has the form FILE:LINE: error: MESSAGE.
        let Some((place, message)) = line.split_once(": error: ") else { continue };
        let Some((file, number)) = place.rsplit_once(':') else { continue };
        // In Vulkan's GLSL, `texture2D` is a type that cannot be constructed. The message does not name it, but the
        // line of the file does.
        let source_line = match number.parse::<usize>() {
            Ok(number) if message.contains("cannot construct this type") => line_of(Path::new(file), number),
            _ => None,
        };
        let is_named = |name: &str| match &source_line {
            Some(line) => line.contains(&format!("{name}(")) || line.contains(&format!("{name} (")),
            None => message.contains(&format!("'{name}'")),
        };
        let old_name = old_glsl::NAMES.iter().find(|(name, _)| is_named(name));
        let message = match old_name {
            Some((name, instead)) => format!("{name} is old GLSL; {instead}"),
            None => message.trim().to_owned(),
        };
        return Error::malformed(Path::new(file), number.parse().ok(), message);
    }
    Error::malformed(path, None, text.trim().replace('\n', "; "))
}

/// The line `number` of a file, counted from 1; `None` if the file cannot be read.
fn line_of(path: &Path, number: usize) -> Option<String> {
    let text = source_text::read_program(path, "a shader", MAX_BYTES).ok()?;
    text.lines().nth(number.checked_sub(1)?).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_message_of_the_compiler_names_file_and_line() {
        let text = "a/b.frag:12: error: 'x' : undeclared identifier\na/b.frag:13: error: other\n2 errors generated.\n";
        let error = first_compiler_error(Path::new("a/b.frag"), text).to_string();
        assert_eq!(error, "a/b.frag:12: 'x' : undeclared identifier");
        let old = first_compiler_error(
            Path::new("a.frag"),
            "a.frag:4: error: 'texture2D' : no matching overloaded function found",
        );
        assert_eq!(old.to_string(), "a.frag:4: texture2D is old GLSL; write texture");
    }
}
