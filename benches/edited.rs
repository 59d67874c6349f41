//! Makes changed copies of the shaders, for benches that measure what a line of a shader does.

use ssct::gpu::shader::Shader;
use ssct::gpu::{Gpu, glsl, programs};
use ssct_lab::report::images::Rgb;
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file below `shaders-glsl`, a text that stands in the file exactly once, and the text that replaces it.
pub type Edit = (&'static str, &'static str, &'static str);

/// Changes of some files.
pub type Edits = &'static [Edit];

/// The programs whose code some edits change, with their new SPIR-V.
type EditedPrograms = Vec<(&'static Shader, Arc<[u8]>)>;

/// The folder of shaders, and a compiler for changed copies of it.
pub struct Shaders {
    /// The folder of the unchanged shaders.
    root: PathBuf,
    compiler: shaderc::Compiler,
    /// The changed programs of each set of edits so far. They are kept, since finding them takes compiling every
    /// program.
    compiled: RefCell<HashMap<Edits, EditedPrograms>>,
}

impl Shaders {
    /// Takes the shaders of this repository.
    pub fn new() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-glsl");
        Self { root, compiler: shaderc::Compiler::new().expect("a compiler"), compiled: RefCell::default() }
    }

    /// Runs `action` and returns its result. Every pipeline that `action` makes has the shaders with the edits.
    pub fn run_with<T>(&self, gpu: &Gpu, edits: Edits, action: impl FnOnce() -> T) -> T {
        let edited_programs =
            self.compiled.borrow_mut().entry(edits).or_insert_with(|| self.compile_edited(edits)).clone();
        for (shader, code) in &edited_programs {
            gpu.shared().replaced_shaders.set(shader, Some(code.clone()));
        }
        let result = action();
        for (shader, _) in &edited_programs {
            gpu.shared().replaced_shaders.set(shader, None);
        }
        result
    }

    /// Compiles the programs with some edits; returns those whose code the edits change, with their new code.
    fn compile_edited(&self, edits: Edits) -> EditedPrograms {
        if edits.is_empty() {
            return Vec::new();
        }
        let copy = tempfile::tempdir().expect("a folder");
        self.copy_to(copy.path());
        for (file, original, replacement) in edits {
            let path = copy.path().join(file);
            let text = std::fs::read_to_string(&path).expect("a shader");
            assert_eq!(text.matches(original).count(), 1, "{file}: {original}");
            std::fs::write(&path, text.replace(original, replacement)).expect("a changed shader");
        }
        let compile_if_edited = |&shader: &&'static Shader| {
            let path = copy.path().join(shader.file);
            let code =
                glsl::compile(&self.compiler, copy.path(), &path, shader.defines).expect("a shader that compiles");
            let bytes: Arc<[u8]> = code.words.iter().flat_map(|word| word.to_le_bytes()).collect();
            let is_edited = edits.iter().any(|(file, ..)| code.files.iter().any(|f| f.ends_with(file)));
            is_edited.then_some((shader, bytes))
        };
        let edited_programs: Vec<_> = programs::ALL.iter().filter_map(compile_if_edited).collect();
        assert!(!edited_programs.is_empty(), "no program has {}", edits[0].0);
        edited_programs
    }

    /// Copies the folders of all shaders into another folder.
    fn copy_to(&self, destination: &Path) {
        for folder in std::fs::read_dir(&self.root).expect("the shaders").flatten() {
            let target = destination.join(folder.file_name());
            std::fs::create_dir(&target).expect("a folder");
            for file in std::fs::read_dir(folder.path()).expect("a folder").flatten() {
                std::fs::copy(file.path(), target.join(file.file_name())).expect("a shader");
            }
        }
    }
}

/// Returns the share of the pixels that differ by more than 1/255 in a channel, and the root mean square difference
/// over all channels. Both pictures have the same size.
pub fn difference(a: &Rgb, b: &Rgb) -> (f64, f64) {
    let differs = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1);
    let pixel_pairs = a.bytes.chunks_exact(3).zip(b.bytes.chunks_exact(3));
    let (differing, pixel_count) = (pixel_pairs.filter(differs).count(), a.bytes.len() / 3);
    let squared_difference = |(a, b): (&u8, &u8)| ((f64::from(*a) - f64::from(*b)) / 255.0).powi(2);
    let sum: f64 = a.bytes.iter().zip(&b.bytes).map(squared_difference).sum();
    (differing as f64 / pixel_count as f64, (sum / a.bytes.len() as f64).sqrt())
}
