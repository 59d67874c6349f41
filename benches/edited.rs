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

/// Programs whose code some edits change, with their new code.
type Replaced = Vec<(&'static Shader, Arc<[u8]>)>;

/// The folder of shaders, and a compiler for changed copies of it.
pub struct Shaders {
    /// The folder of the unchanged shaders.
    root: PathBuf,
    compiler: shaderc::Compiler,
    /// The changed programs of each set of edits so far. They are kept, since finding them takes compiling every
    /// program.
    compiled: RefCell<HashMap<Edits, Replaced>>,
}

impl Shaders {
    /// Takes the shaders of this repository.
    pub fn new() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders-glsl");
        Self { root, compiler: shaderc::Compiler::new().expect("a compiler"), compiled: RefCell::default() }
    }

    /// Runs `act` and returns its result. Every pipeline that is made meanwhile has the shaders with the edits.
    pub fn run_with<T>(&self, gpu: &Gpu, edits: Edits, act: impl FnOnce() -> T) -> T {
        let replaced = self.compiled.borrow_mut().entry(edits).or_insert_with(|| self.compile_edited(edits)).clone();
        for (shader, code) in &replaced {
            gpu.shared().replaced_shaders.set(shader, Some(code.clone()));
        }
        let result = act();
        for (shader, _) in &replaced {
            gpu.shared().replaced_shaders.set(shader, None);
        }
        result
    }

    /// Compiles the programs with some edits; returns those whose code the edits change, with their new code.
    fn compile_edited(&self, edits: Edits) -> Replaced {
        if edits.is_empty() {
            return Vec::new();
        }
        let copy = tempfile::tempdir().expect("a folder");
        self.copy_to(copy.path());
        for (file, from, to) in edits {
            let path = copy.path().join(file);
            let text = std::fs::read_to_string(&path).expect("a shader");
            assert_eq!(text.matches(from).count(), 1, "{file}: {from}");
            std::fs::write(&path, text.replace(from, to)).expect("a changed shader");
        }
        let compiled = |&shader: &&'static Shader| {
            let path = copy.path().join(shader.file);
            let code =
                glsl::compile(&self.compiler, copy.path(), &path, shader.defines).expect("a shader that compiles");
            let bytes: Arc<[u8]> = code.words.iter().flat_map(|w| w.to_le_bytes()).collect();
            let is_edited = edits.iter().any(|(file, ..)| code.files.iter().any(|f| f.ends_with(file)));
            is_edited.then_some((shader, bytes))
        };
        let found: Vec<_> = programs::ALL.iter().filter_map(compiled).collect();
        assert!(!found.is_empty(), "no program has {}", edits[0].0);
        found
    }

    /// Copies all shaders into a folder.
    fn copy_to(&self, to: &Path) {
        for folder in std::fs::read_dir(&self.root).expect("the shaders").flatten() {
            let target = to.join(folder.file_name());
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
    let differs = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
    let pixels = a.bytes.chunks_exact(3).zip(b.bytes.chunks_exact(3));
    let (differing, all) = (pixels.filter(|p| differs(*p)).count(), a.bytes.len() / 3);
    let square = |(a, b): (&u8, &u8)| ((f64::from(*a) - f64::from(*b)) / 255.0).powi(2);
    let sum: f64 = a.bytes.iter().zip(&b.bytes).map(square).sum();
    (differing as f64 / all as f64, (sum / a.bytes.len() as f64).sqrt())
}
