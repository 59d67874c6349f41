//! Compiles shaders anew while the program runs, so that a change to a shader can be tried without building the
//! program. The sources are in the folder that a window watches, or in the one that the variable `SSCT_SHADERS` names.

use super::glsl::{self, CompiledStage};
use super::interface::Interface;
use super::programs::ALL;
use super::shader::Shader;
use crate::error::{Error, Result};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// The variable that names a folder of sources.
pub const VARIABLE: &str = "SSCT_SHADERS";

/// A folder of sources, and their compiler.
pub struct Sources {
    root: PathBuf,
    compiler: shaderc::Compiler,
}

impl Sources {
    /// Opens a folder; `flag` is the option or variable that named the folder, for the errors.
    ///
    /// # Errors
    /// [`Error::Usage`] if there are no shaders in it.
    pub fn open(root: &Path, flag: &str) -> Result<Self> {
        if !glsl::stages(root).is_ok_and(|stages| !stages.is_empty()) {
            return Err(Error::Usage(format!("{flag} {}: there are no shaders", root.display())));
        }
        let compiler = shaderc::Compiler::new()
            .map_err(|e| Error::Usage(format!("{flag}: the compiler cannot be started: {e}")))?;
        Ok(Self { root: root.to_path_buf(), compiler })
    }

    /// Compiles a shader, whether it fits the program or not ([`code_that_fits`]).
    ///
    /// # Errors
    /// The compiler's message, which names file and line.
    pub fn compile(&self, shader: &Shader) -> std::result::Result<CompiledStage, String> {
        glsl::compile(&self.compiler, &self.root, &self.root.join(shader.file), shader.defines)
    }
}

/// Returns new code of a shader as bytes, if its interface is still the one that the program was built with.
///
/// # Errors
/// A sentence that says what differs.
pub fn code_that_fits(shader: &Shader, words: &[u32]) -> std::result::Result<Arc<[u8]>, String> {
    let built_words: Vec<u32> = shader.spirv.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect();
    let (built, new) = (Interface::from_words(&built_words, shader.name)?, Interface::from_words(words, shader.name)?);
    if built == new {
        return Ok(words.iter().flat_map(|word| word.to_le_bytes()).collect());
    }
    let what = if built.bindings != new.bindings {
        "its bindings"
    } else if built.blocks != new.blocks || built.push != new.push {
        "a uniform or push-constant block"
    } else if built.outputs != new.outputs {
        "its outputs"
    } else if built.constants != new.constants {
        "its specialization constants"
    } else if built.formats != new.formats {
        "the format of an image"
    } else {
        "its workgroup size"
    };
    Err(format!("{}: {what} changed, so the program must be built again", shader.name))
}

/// Returns the folder that [`VARIABLE`] names, if it is set and not empty.
pub fn named_folder() -> Option<PathBuf> {
    std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()).map(PathBuf::from)
}

/// The code of one of the program's own shaders, compiled from the folder that [`VARIABLE`] names; `None` without that
/// variable, and for a user's shader. Each shader is compiled once, even if its source changes meanwhile.
///
/// # Errors
/// [`Error::Usage`] for a folder without shaders, and for a shader that does not compile, or whose bindings, blocks or
/// outputs are no longer those that the program was built with.
pub fn code_from_folder(shader: &Shader) -> Result<Option<Arc<[u8]>>> {
    type CompiledSources = (Sources, HashMap<&'static str, Arc<[u8]>>);
    static OPENED: Mutex<Option<CompiledSources>> = Mutex::new(None);
    let is_own = ALL.iter().any(|own| own.name == shader.name);
    let Some(folder) = named_folder().filter(|_| is_own) else { return Ok(None) };
    let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    let (sources, compiled) = match &mut *opened {
        Some(opened) => opened,
        closed => closed.insert((Sources::open(&folder, VARIABLE)?, HashMap::new())),
    };
    if let Some(code) = compiled.get(shader.name) {
        return Ok(Some(Arc::clone(code)));
    }
    let code = sources.compile(shader).and_then(|stage| code_that_fits(shader, &stage.words)).map_err(Error::Usage)?;
    compiled.insert(shader.name, Arc::clone(&code));
    Ok(Some(code))
}
