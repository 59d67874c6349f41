//! Shares of the world reference's rays, each sampled by another machine: where they are kept, what lies beside them,
//! and how `ssct merge` makes one reference of them.

use super::cli::MergeOptions;
use super::run::command_line;
use crate::error::{Error, Result};
use crate::math::DefinitionsVersion;
use crate::reference::kept_samples::short;
use crate::reference::world::WorldReference;
use crate::reference::world_part::{self, MergedParts, WorldPart, named, samples_of};
use crate::reference::world_state::WorldState;
use crate::report::files;
use crate::report::run_folder::Claim;
use crate::scene::{Scene, View};
use crate::study::record::Provenance;
use crate::study::shard::Shard;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Rays a pixel between two times that they are kept.
const RAYS_AT_ONCE: u32 = 16;

/// What the name of a file ends with that says what a share is of.
const PART: &str = ".part.json";

/// What a share is of; it lies beside the file with its sums.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReferencePart {
    /// The version of docs/definitions.md.
    pub definitions: u32,
    /// Of the program.
    pub version: String,
    /// Of its source.
    pub commit: String,
    /// The command of the whole reference.
    pub command: String,
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// A digest of all that a sample depends on.
    pub fingerprint: String,
    /// Rays a pixel of the whole reference.
    pub rays: u32,
    /// Which share it is.
    pub shard: Shard,
    /// The share's samples: the first, and the one after the last.
    pub samples: [u32; 2],
}

impl ReferencePart {
    /// A share of a reference's rays.
    pub fn new(
        reference: &WorldReference,
        (scene, view): (&Scene, &View),
        definitions: DefinitionsVersion,
        shard: Shard,
        rays: u32,
    ) -> Self {
        let samples = samples_of(shard.index, shard.of, rays);
        Self {
            definitions: definitions.into(),
            version: Provenance::VERSION.to_owned(),
            commit: Provenance::COMMIT.to_owned(),
            command: command_line(),
            scene: scene.name.clone(),
            view: view.name.clone(),
            size: [reference.first_hits.width, reference.first_hits.height],
            fingerprint: short(&reference.fingerprint()),
            rays,
            shard,
            samples: [samples.start, samples.end],
        }
    }

    /// File names without what they end with.
    fn stem(&self) -> String {
        format!("{}-{}-{}", self.fingerprint, self.samples[0], self.samples[1])
    }

    /// What people call the reference.
    fn name(&self) -> String {
        let [width, height] = self.size;
        format!("{} {} {width}x{height}", self.scene, self.view)
    }

    /// What parts of one reference have in common, each with its name.
    fn in_common(&self) -> [(&'static str, String); 4] {
        [
            ("version", self.version.clone()),
            ("commit", self.commit.clone()),
            ("version of the definitions", self.definitions.to_string()),
            ("number of rays", self.rays.to_string()),
        ]
    }
}

/// Takes the samples of a share that its folder lacks, and keeps them there. `progress` is called after some of them.
pub fn sample(
    reference: &WorldReference,
    part: &ReferencePart,
    folder: &Path,
    progress: &mut dyn FnMut(&WorldState) -> Result<()>,
) -> Result<WorldState> {
    let [first, end] = part.samples;
    let kept = folder.join(format!("{}.world", part.stem()));
    if first == end {
        eprintln!("ssct: warning: shard {} has no rays: {} are too few for {}", part.shard, part.rays, part.shard.of);
        return Ok(reference.start_at(first));
    }
    files::write(&folder.join(format!("{}{PART}", part.stem())), format!("{}\n", json!(part)).as_bytes())?;
    let (mut state, unusable) = reference.resume_at(&kept, first);
    if let Some(why) = unusable {
        eprintln!("ssct: warning: {why}; sampling begins anew");
    }
    while state.samples < end {
        let rays = RAYS_AT_ONCE.min(end - state.samples);
        reference.add(&mut state, rays);
        state.save(&kept)?;
        progress(&state)?;
    }
    Ok(state)
}

/// The shares in a folder: what each is of, and its sums, once there are any.
fn parts_in(folder: &Path) -> Result<Vec<(PathBuf, ReferencePart, Option<WorldPart>)>> {
    let mut parts = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| Error::io("read", folder, e))? {
        let path = entry.map_err(|e| Error::io("read", folder, e))?.path();
        let Some(stem) = path.file_name().and_then(|n| n.to_str()).and_then(|n| n.strip_suffix(PART)) else { continue };
        let text = std::fs::read(&path).map_err(|e| Error::io("read", &path, e))?;
        let part = serde_json::from_slice(&text)
            .map_err(|e| Error::malformed(&path, Some(e.line()), format!("is no share of a reference: {e}")))?;
        let kept = folder.join(format!("{stem}.world"));
        let sums = kept.exists().then(|| WorldPart::read(&kept)).transpose()?;
        parts.push((path, part, sums));
    }
    Ok(parts)
}

/// Whether a folder holds shares of references.
pub fn has_parts(folder: &Path) -> bool {
    parts_in(folder).is_ok_and(|parts| !parts.is_empty())
}

/// Makes one reference of the shares in some folders, for each reference that they have.
pub fn merge(options: &MergeOptions) -> anyhow::Result<()> {
    let mut references: BTreeMap<String, Vec<(PathBuf, ReferencePart, Option<WorldPart>)>> = BTreeMap::new();
    for folder in &options.folders {
        for part in parts_in(folder)? {
            references.entry(part.1.fingerprint.clone()).or_default().push(part);
        }
    }
    let mut merged = Vec::new();
    let mut missing = Vec::new();
    for parts in references.into_values() {
        let (_, first, _) = &parts[0];
        let first = first.clone();
        for (path, part, _) in &parts[1..] {
            let pairs = first.in_common().into_iter().zip(part.in_common());
            if let Some(((what, a), (_, b))) = pairs.into_iter().find(|((_, a), (_, b))| a != b) {
                let message =
                    format!("is of another reference than {}: its {what} is {b} and not {a}", parts[0].0.display());
                return Err(Error::malformed(path, None, message).into());
            }
        }
        let sums = parts.into_iter().filter_map(|(_, _, sums)| sums).collect();
        let MergedParts { merged: whole, missing: lacking } = world_part::merge(sums, first.rays)?;
        missing.extend(lacking.iter().map(|samples| format!("{} of {}", named(samples), first.name())));
        merged.extend(whole.map(|whole| (first, whole)));
    }
    if !missing.is_empty() && !options.partial {
        anyhow::bail!(
            "{} are missing; name the folders of the shards that have them, or give --partial",
            missing.join(", ")
        );
    }
    let _claim = Claim::new(&options.output)?;
    for (part, whole) in &merged {
        whole.save(&options.output.join(format!("{}.world", part.fingerprint)))?;
    }
    report(options, &merged, &missing)
}

fn report(options: &MergeOptions, merged: &[(ReferencePart, WorldPart)], missing: &[String]) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    if options.json {
        let of = |(part, whole): &(ReferencePart, WorldPart)| json!({"scene": part.scene, "view": part.view, "size": part.size, "rays": whole.samples().end});
        let references: Vec<_> = merged.iter().map(of).collect();
        let (folders, output) = (&options.folders, &options.output);
        let summary = json!({"kind": "reference", "folders": folders, "output": output, "references": references, "missing": missing});
        writeln!(out, "{summary}")?;
        return Ok(());
    }
    for (part, whole) in merged {
        let (rays, name, folder) = (whole.samples().end, part.name(), options.output.display());
        writeln!(out, "{folder}: {rays} of {} rays a pixel of {name}", part.rays)?;
        writeln!(out, "to show them: {} --cache {folder} -o FILE", part.command)?;
    }
    for name in missing {
        writeln!(out, "missing: {name}")?;
    }
    Ok(())
}
