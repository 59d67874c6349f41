//! Reloads shaders that change while the window is open. A shader is compiled when its file or an included file
//! changes. It is rejected if it no longer fits the built program; the caller then keeps the last valid pipeline.

use ssct::gpu::programs::ALL;
use ssct::gpu::shader::Shader;
use ssct::gpu::sources::{Sources, code_that_fits};
use ssct_lab::error::Result;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, SystemTime};

/// The time between two scans of the files. Scanning takes no GPU time.
const PERIOD: Duration = Duration::from_millis(300);

/// A changed shader, with its compiled code or the reason why it cannot be used.
pub type ShaderChange = (&'static Shader, std::result::Result<Arc<[u8]>, String>);

/// A shader's name, and the reason if its changed code is not in use.
pub type ShaderStatus = (&'static str, std::result::Result<(), String>);

/// A folder of shaders, with the state of its files at the last scan.
pub struct ShaderWatch {
    root: PathBuf,
    /// The stamp of each file at the last scan.
    seen: HashMap<PathBuf, Stamp>,
    /// The source files of each shader, by the shader's name; absent before its first compilation and after a failed
    /// one.
    sources: HashMap<&'static str, Vec<PathBuf>>,
    /// The last reported result of each shader's compilation.
    last: HashMap<&'static str, std::result::Result<Arc<[u8]>, String>>,
    /// Compiles shaders from the folder.
    compiled_from: Sources,
}

/// Modification time and length of a file; both are compared to find whether the file was written.
type Stamp = (Option<SystemTime>, u64);

impl ShaderWatch {
    /// Begins to watch a folder. Only changes from now on are reported.
    ///
    /// # Errors
    /// [`Usage`](ssct::Error::Usage) if the folder contains no shaders.
    pub fn new(root: &Path) -> Result<Self> {
        let compiled_from = Sources::open(root, "--shaders")?;
        let (sources, last) = (HashMap::new(), HashMap::new());
        Ok(Self { root: root.to_path_buf(), seen: stamps(root), sources, last, compiled_from })
    }

    /// Scans the files, compiles the shaders that may have changed since the last scan, and returns those whose result
    /// is new.
    pub fn scan(&mut self) -> Vec<ShaderChange> {
        let stamps = stamps(&self.root);
        let is_new = |path: &PathBuf, stamp: &Stamp| self.seen.get(path) != Some(stamp);
        let changed: Vec<&PathBuf> = stamps.iter().filter(|(path, s)| is_new(path, s)).map(|(path, _)| path).collect();
        if changed.is_empty() {
            return Vec::new();
        }
        let mut changes = Vec::new();
        for &shader in ALL {
            let touches = |sources: &Vec<PathBuf>| sources.iter().any(|s| changed.contains(&s));
            if self.sources.get(shader.name).is_some_and(|s| !touches(s)) {
                continue;
            }
            let compiled = self.compile(shader);
            // A shader that was never reported still has the code of the built program.
            let is_same = match (&compiled, self.last.get(shader.name)) {
                (Ok(code), None) => code[..] == *shader.spirv,
                (compiled, Some(last)) => compiled == last,
                (Err(_), None) => false,
            };
            if !is_same {
                self.last.insert(shader.name, compiled.clone());
                changes.push((shader, compiled));
            }
        }
        self.seen = stamps;
        changes
    }

    /// Compiles a shader, and records the files of which it was made. Returns its code, or the reason why it cannot be
    /// used.
    fn compile(&mut self, shader: &'static Shader) -> std::result::Result<Arc<[u8]>, String> {
        match self.compiled_from.compile(shader) {
            Ok(compiled) => {
                self.sources.insert(shader.name, compiled.files);
                code_that_fits(shader, &compiled.words)
            }
            Err(message) => {
                // Any later change may repair the shader, so its list of sources is dropped.
                self.sources.remove(shader.name);
                Err(message)
            }
        }
    }

    /// Scans repeatedly on another thread, which sends changes to the returned receiver and then calls `wake`.
    pub fn start(mut self, wake: impl Fn() + Send + 'static) -> Receiver<Vec<ShaderChange>> {
        let (sender, receiver) = channel();
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(PERIOD);
                let changes = self.scan();
                if !changes.is_empty() {
                    if sender.send(changes).is_err() {
                        return;
                    }
                    wake();
                }
            }
        });
        receiver
    }
}

/// Returns the stamps of all files below a folder.
fn stamps(folder: &Path) -> HashMap<PathBuf, Stamp> {
    let mut found = HashMap::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(stamps(&path));
        } else if let Ok(meta) = entry.metadata() {
            found.insert(path, (meta.modified().ok(), meta.len()));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::tests::copied_shaders;
    use super::*;

    #[test]
    fn a_change_is_reported_once_with_its_dependants_and_a_misfit_is_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let root = copied_shaders(folder.path());
        let mut watch = ShaderWatch::new(&root).unwrap();
        assert!(watch.scan().is_empty());
        let edit = |name: &str, from: &str, to: &str| {
            let path = root.join(name);
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains(from), "{name}: {from}");
            std::fs::write(path, text.replacen(from, to, 1)).unwrap();
        };
        let names = |changes: &[ShaderChange]| changes.iter().map(|(s, _)| s.name).collect::<Vec<_>>();

        edit("thesis/hi_z_ray_trace.glsl", "i++ >= thesis.iterations", "i++ > thesis.iterations");
        let changes = watch.scan();
        assert!(names(&changes).contains(&"thesis/ssct.frag") && !names(&changes).contains(&"thesis/hi_z.frag"));
        assert!(changes.iter().all(|(_, compiled)| compiled.is_ok()), "{changes:?}");
        assert!(watch.scan().is_empty(), "a change is reported once");

        edit("poster/cone_march.frag", "edgeHits >= poster", "edgeHits > poster");
        let changes = watch.scan();
        let with_mips = ["poster/cone_march.frag", "poster/cone_march.frag COMPUTE"];
        let with_volumes = ["poster/cone_march.frag VOLUME", "poster/cone_march.frag VOLUME COMPUTE"];
        assert_eq!(names(&changes), [with_mips, with_volumes].concat());
        let [(_, Ok(mip)), (_, Ok(_)), (_, Ok(volume)), (_, Ok(_))] = &changes[..] else { panic!("{changes:?}") };
        assert_ne!(mip, volume, "each with what is defined for it");

        edit("common/composite.frag", "color + reflectivity", "color + reflectivity * nonsense");
        let changes = watch.scan();
        let [(shader, Err(message)), (_, Err(_))] = &changes[..] else { panic!("{changes:?}") };
        let text = std::fs::read_to_string(root.join("common/composite.frag")).unwrap();
        let line = 1 + text.lines().position(|line| line.contains("nonsense")).unwrap();
        let place = format!("composite.frag:{line}");
        assert!(shader.name == "common/composite.frag" && message.contains(&place), "{place}: {message}");
        edit("common/composite.frag", " * nonsense", " * 2.0");
        assert!(matches!(&watch.scan()[..], [(_, Ok(_)), (_, Ok(_))]));

        edit("common/composite.frag", "layout(binding = 2)", "layout(binding = 3)");
        let changes = watch.scan();
        let [(_, Err(message)), (_, Err(_))] = &changes[..] else { panic!("{changes:?}") };
        assert!(message.contains("bindings changed"), "{message}");

        edit("thesis/linear.frag", "const bool HITS = false", "const int HITS = 0");
        edit("thesis/linear.frag", "if (HITS)", "if (HITS != 0)");
        edit("thesis/linear.frag", "if (HITS)", "if (HITS != 0)");
        let changes = watch.scan();
        let [(_, Err(message)), (_, Err(_))] = &changes[..] else { panic!("{changes:?}") };
        assert!(message.contains("specialization constants changed"), "{message}");
    }
}
