//! Compiles a user's shader and finds what it binds. GLSL for OpenGL is taken, too: names get bindings and locations, and
//! uniforms that stand alone become a block.

use super::manifest::{Pass, PassStage};
use crate::error::{Error, Result};
use crate::gpu::glsl::{self, Interface};
use crate::gpu::loose;
use crate::gpu::shader::Shader;
use crate::scene::source_text;
use sha2::{Digest, Sha256};
use shaderc::{CompileOptions, Compiler, OptimizationLevel, ResolvedInclude, ShaderKind, TargetEnv};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// The largest shader, in bytes.
const MAX_BYTES: u64 = 1 << 24;

/// The block of uniforms that stand alone.
const LOOSE: &str = "LooseUniforms";

/// Types of uniforms that may stand in a block.
const PLAIN: [&str; 18] = [
    "float", "int", "uint", "bool", "vec2", "vec3", "vec4", "ivec2", "ivec3", "ivec4", "uvec2", "uvec3", "uvec4",
    "mat3", "mat4", "mat3x3", "mat4x4", "mat2x4",
];

/// A compiled stage, its interface, and the files that it was made of.
pub struct CompiledPass {
    pub shader: &'static Shader,
    pub interface: Interface,
    pub files: Vec<PathBuf>,
}

/// Compiles the shader of a pass; `include` is where includes are looked for that are not beside the file.
///
/// # Errors
/// [`Error::Io`] without the file, and [`Error::Malformed`] with its line for what the compiler says first.
pub fn compile(method: &str, include: &Path, pass: &Pass) -> Result<CompiledPass> {
    let path = &pass.shader;
    let is_binary = path.extension().is_some_and(|e| e == "spv");
    let (words, files) = if is_binary { (binary(path)?, vec![path.clone()]) } else { glsl(include, pass)? };
    let words = in_one_set(&words).ok_or_else(|| Error::malformed(path, None, "is not SPIR-V"))?;
    let name = path.display().to_string();
    let mut interface = glsl::interface(&words, &name).map_err(|m| {
        let message = m.strip_prefix(&format!("{name}: ")).unwrap_or(&m).to_owned();
        let hint = "; images are bound with their samplers (sampler2D), or stored to (image2D)";
        Error::malformed(path, None, if m.contains("unknown kind") { message + hint } else { message })
    })?;
    // A block may be read by no name but its own.
    interface.bindings.retain(|b| b.count > 0);
    let spirv: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
    // The name tells the code from all other code that a device keeps pipelines of.
    let digest = Sha256::digest(&spirv).iter().take(8).map(|b| format!("{b:02x}")).collect::<String>();
    let file = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let shader = loose::shader(format!("{method}/{file}#{digest}"), spirv, &interface)?;
    Ok(CompiledPass { shader, interface, files })
}

fn binary(path: &Path) -> Result<Vec<u32>> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let is_code =
        bytes.len() >= 20 && bytes.len().is_multiple_of(4) && bytes.starts_with(&0x0723_0203_u32.to_le_bytes());
    if !is_code {
        return Err(Error::malformed(path, None, "is not SPIR-V"));
    }
    Ok(bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
}

fn glsl(include: &Path, pass: &Pass) -> Result<(Vec<u32>, Vec<PathBuf>)> {
    let path = &pass.shader;
    let source = hoisted(&source_text::read(path, "a shader", MAX_BYTES)?);
    let wrong = |message: String| Error::malformed(path, None, message);
    let compiler = Compiler::new().map_err(|e| wrong(format!("the compiler cannot be started: {e}")))?;
    let files = RefCell::new(vec![path.clone()]);
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
        let beside = Path::new(includer).parent().unwrap_or(include).join(name);
        let path = if beside.exists() { beside } else { include.join(name) };
        let content = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        files.borrow_mut().push(path.clone());
        Ok(ResolvedInclude { resolved_name: path.to_string_lossy().into_owned(), content: hoisted(&content) })
    });
    let kind = match pass.stage {
        PassStage::Fragment => ShaderKind::Fragment,
        PassStage::Compute => ShaderKind::Compute,
    };
    let label = path.to_string_lossy();
    let made = compiler.compile_into_spirv(&source, kind, &label, "main", Some(&options));
    let words = made.map(|artifact| artifact.as_binary().to_vec()).map_err(|e| compiler_says(path, &e.to_string()))?;
    drop(options);
    Ok((words, files.into_inner()))
}

/// The first of the compiler's messages, with the file and line that it is about.
fn compiler_says(path: &Path, text: &str) -> Error {
    for line in text.lines() {
        // FILE:LINE: error: what
        let Some((place, what)) = line.split_once(": error: ") else { continue };
        let Some((file, number)) = place.rsplit_once(':') else { continue };
        let what = what.trim().to_owned();
        return Error::malformed(Path::new(file), number.parse().ok(), what);
    }
    Error::malformed(path, None, text.trim().replace('\n', "; "))
}

/// Moves uniforms that stand alone, as OpenGL has them, into a block. Lines stay where they are.
fn hoisted(source: &str) -> String {
    let mut fields = String::new();
    let mut lines: Vec<String> = Vec::new();
    let mut first = None;
    for (n, line) in source.lines().enumerate() {
        match field(line) {
            Some(declared) => {
                fields.push_str(&declared);
                first.get_or_insert(n);
                lines.push(String::new());
            }
            None => lines.push(line.to_owned()),
        }
    }
    if let Some(at) = first {
        lines[at] = format!("layout(std140) uniform {LOOSE} {{ {fields}}};");
    }
    lines.join("\n") + "\n"
}

/// The declaration of a plain uniform on a line of its own, without its qualifiers and its value.
fn field(line: &str) -> Option<String> {
    let code = line.split("//").next()?.trim();
    let code = code.strip_suffix(';')?;
    let (mut words, mut rest) = (Vec::new(), code);
    if rest.starts_with("layout") {
        // layout(location = 3) uniform …, which a block has none of.
        let (inside, after) = rest.strip_prefix("layout")?.trim_start().strip_prefix('(')?.split_once(')')?;
        if inside.contains("binding") || inside.contains("set") {
            return None;
        }
        rest = after.trim_start();
    }
    for _ in 0..3 {
        let (word, after) = rest.split_once(char::is_whitespace)?;
        words.push(word);
        rest = after.trim_start();
        if PLAIN.contains(&word) {
            break;
        }
    }
    let (kind, before) = words.split_last()?;
    let qualifiers = ["uniform", "highp", "mediump", "lowp"];
    let is_uniform = before.first() == Some(&"uniform") && before.iter().all(|w| qualifiers.contains(w));
    if !is_uniform || !PLAIN.contains(kind) || rest.contains(['{', '(']) && !rest.contains('=') {
        return None;
    }
    // A default value is given in the manifest.
    let names = rest.split('=').next()?.trim();
    Some(format!("{kind} {names}; "))
}

/// Moves every binding of every descriptor set into set 0, numbered in their order; `None` for what is not SPIR-V.
fn in_one_set(words: &[u32]) -> Option<Vec<u32>> {
    const DECORATE: u32 = 71;
    const BINDING: u32 = 33;
    const SET: u32 = 34;
    let decorations = |words: &[u32]| -> Option<Vec<(usize, u32, u32)>> {
        let (mut at, mut found) = (5, Vec::new());
        while at < words.len() {
            let length = (words[at] >> 16) as usize;
            if length == 0 || at + length > words.len() {
                return None;
            }
            if words[at] & 0xffff == DECORATE && length == 4 && matches!(words[at + 2], BINDING | SET) {
                found.push((at + 3, words[at + 1], words[at + 2]));
            }
            at += length;
        }
        Some(found)
    };
    let found = decorations(words)?;
    let of = |id: u32, wanted: u32| {
        found.iter().find(|(_, target, what)| *target == id && *what == wanted).map_or(0, |(at, ..)| words[*at])
    };
    let mut places: Vec<(u32, u32)> = found.iter().map(|(_, id, _)| (of(*id, SET), of(*id, BINDING))).collect();
    places.sort_unstable();
    places.dedup();
    let mut moved = words.to_vec();
    for (at, id, what) in &found {
        let place = (of(*id, SET), of(*id, BINDING));
        let number = places.iter().position(|p| *p == place).unwrap_or(0) as u32;
        moved[*at] = if *what == SET { 0 } else { number };
    }
    Some(moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniforms_that_stand_alone_become_a_block() {
        let source = "#version 330\nuniform sampler2D a;\nuniform mat4 m; // m\nuniform highp float x = 2.0;\n\
            layout(location = 3) uniform vec2 size, other[2];\nuniform Block { float y; };\nvoid main() {}\n";
        let made = hoisted(source);
        let lines: Vec<&str> = made.lines().collect();
        assert_eq!(lines.len(), source.lines().count());
        assert_eq!(lines[2], "layout(std140) uniform LooseUniforms { mat4 m; float x; vec2 size, other[2]; };");
        assert_eq!((lines[1], lines[3], lines[4]), ("uniform sampler2D a;", "", ""));
        assert_eq!(lines[5], "uniform Block { float y; };");
        let plain = "#version 460\nlayout(std140, binding = 0) uniform B {\n    float x;\n} b;\nvoid main() {}\n";
        assert_eq!(hoisted(plain), plain);
    }

    #[test]
    fn the_first_message_of_the_compiler_names_file_and_line() {
        let text = "a/b.frag:12: error: 'x' : undeclared identifier\na/b.frag:13: error: other\n2 errors generated.\n";
        let error = compiler_says(Path::new("a/b.frag"), text).to_string();
        assert_eq!(error, "a/b.frag:12: 'x' : undeclared identifier");
    }
}
