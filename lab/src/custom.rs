//! Methods from folders: a manifest (`method.toml`) and shaders become a method like any other (docs/custom-methods.md).
//!
//! `manifest` reads the manifest, and `shader` compiles the stages. `includes` says which files a shader may consist of, and `built_in` has
//! the project's own shaders, which a folder may use without a copy. `old_glsl` refuses GLSL that is too old. `loose_uniforms` puts
//! uniforms outside of blocks into blocks, and `initial_values` evaluates the values that they begin with.
//!
//! `reflect` reads the interfaces of the stages, and `bindings` checks them against the manifest. `published` says which values and images
//! feed the project's own shaders, and `kinds` checks that images, inputs and outputs fit each other.
//! `source` names what a shader may read, `inputs` makes these images from the G-buffer, and `values` fills uniform blocks. `method`
//! records the passes, and `finish` makes a reflection from their images.

mod bindings;
mod built_in;
mod conventions;
mod finish;
mod includes;
mod initial_values;
mod inputs;
mod kinds;
mod loose_uniforms;
mod manifest;
mod method;
mod noise;
mod old_glsl;
mod published;
mod reflect;
mod shader;
mod source;
mod values;

pub use includes::allow as allow_includes;
use manifest::Manifest;
use method::CustomMethod;
use ssct::gpu::Gpu;
use ssct::methods::{self, Added, Method, MethodInfo, MethodRequest};
use ssct_ground::parameter::{Choices, Parameter, Preset};
use ssct_ground::{Error, Result};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// The name of the manifest in its folder.
pub const MANIFEST: &str = "method.toml";

/// True if methods look for changes of their files while they run.
static WATCHED: AtomicBool = AtomicBool::new(false);

/// The function of [`give_up_by`], which is called with a sentence if a shader does not end.
static GIVE_UP: OnceLock<fn(&str)> = OnceLock::new();

/// Sets the function that is called with a sentence if a method's shader does not end. Such a shader cannot be stopped,
/// so the function must end the program.
pub fn give_up_by(give_up: fn(&str)) {
    GIVE_UP.get_or_init(|| give_up);
}

/// Makes methods from folders check between frames whether their files have changed, as the window wants it.
pub fn watch() {
    WATCHED.store(true, Ordering::Relaxed);
}

/// Returns the folder of a method if `name` is the path of one. A name without a separator is taken for a path if no
/// known method has this name and the folder has a manifest.
pub fn folder(name: &str) -> Option<PathBuf> {
    let path = Path::new(name);
    let is_path = name.contains(['/', '\\']);
    let is_folder = || methods::find(name).is_err() && path.join(MANIFEST).is_file();
    (is_path || is_folder()).then(|| path.to_path_buf())
}

/// Reads a folder's manifest, compiles its shaders, and adds the method to the known methods; returns its row. No
/// parameter of the method may have a name in `reserved`, since the name of a parameter becomes an option.
///
/// # Errors
/// [`Io`](ssct_ground::Error::Io), and [`Malformed`](ssct_ground::Error::Malformed) with file and line for what is wrong in the
/// manifest or in a shader, and if there is a method of its name.
pub fn add(folder: &Path, reserved: &BTreeSet<String>) -> Result<&'static MethodInfo> {
    // Compiles once here, so that errors appear before a device is opened.
    let (manifest, parameters) = read_checked(folder, reserved)?;
    // A method that was added stays until the program ends, so its texts need never be freed.
    let leak = |text: &str| -> &'static str { text.to_owned().leak() };
    let (name, summary, source) = (leak(&manifest.name), leak(&manifest.summary), leak(&manifest.source));
    let (fades, takes_captures) = (manifest.reads_value("fade"), manifest.captures);
    let added: &'static FolderMethod = Box::leak(Box::new(FolderMethod { manifest, parameters }));
    let info = MethodInfo { fades, takes_captures, ..MethodInfo::added(name, summary, source, added) };
    methods::add(info).map_err(|e| Error::malformed(folder.join(MANIFEST), None, e.to_string()))
}

/// Reads and checks a folder as [`add`] does, but adds no method and reserves no names.
pub fn check(folder: &Path) -> Result<()> {
    read_checked(folder, &BTreeSet::new()).map(drop)
}

/// Reads the manifest of a folder with its parameters, and checks that the folder's shaders fit the manifest.
fn read_checked(folder: &Path, reserved: &BTreeSet<String>) -> Result<(Manifest, Vec<Parameter>)> {
    let manifest = Manifest::read(folder)?;
    let parameters = manifest.parameters(reserved)?;
    bindings::check(&manifest)?;
    Ok((manifest, parameters))
}

/// A method that was read from a folder.
struct FolderMethod {
    manifest: Manifest,
    parameters: Vec<Parameter>,
}

impl Added for FolderMethod {
    fn parameters(&self) -> Vec<Parameter> {
        self.parameters.clone()
    }

    /// Makes the method on a device. A preset is refused, since it would change nothing of a method from a folder.
    fn create(&self, gpu: &Gpu, request: &MethodRequest) -> ssct::Result<Box<dyn Method>> {
        let preset = request.setup.values.preset;
        if preset != Preset::default() {
            let (name, preset) = (&self.manifest.name, preset.name());
            return Err(ssct::Error::Usage(format!(
                "the preset {preset} does not change {name}, whose values are those of its manifest: name it without a preset"
            )));
        }
        if let Some(give_up) = GIVE_UP.get() {
            gpu.wait_at_most(self.manifest.patience, *give_up);
        }
        let watched = WATCHED.load(Ordering::Relaxed);
        Ok(Box::new(CustomMethod::new(gpu, &self.manifest, &self.parameters, request, watched)?))
    }
}
