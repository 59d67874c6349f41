//! Shares of a world reference's rays, each sampled by another machine (docs/many-machines.md, "Rays"): the files of a
//! share, and how `ssct merge` makes one reference of several shares.

use super::cli::MergeOptions;
use super::printed;
use super::run::command_line;
use crate::error::{Error, Result};
use crate::report::files;
use crate::report::run_folder::FolderClaim;
use crate::study::merge::difference_of_properties;
use crate::study::names::one_line;
use crate::study::record::{DEFINITIONS, Provenance};
use crate::study::shard::Shard;
use serde::{Deserialize, Serialize};
use serde_json::json;
use ssct_scenes::inside::{FolderEntry, PathInFolder};
use ssct_scenes::{Scene, View};
use ssct_truth::reference::kept_samples::{part_file, short_name, whole_file};
use ssct_truth::reference::world::WorldReference;
use ssct_truth::reference::world::state::WorldState;
use ssct_truth::reference::world_part::{self, MergedParts, WorldPart, samples_of, samples_text};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Rays a pixel after which the file of the sums is written again.
const RAYS_AT_ONCE: u32 = 16;

/// The ending of files that describe a share.
const PART: &str = "part.json";

/// The description of a share, which lies beside the file with the sums.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReferencePart {
    /// The version of docs/definitions.md.
    pub definitions: u32,
    /// The version of the program.
    pub version: String,
    /// The commit of the program's source.
    pub commit: String,
    /// The command of the whole reference.
    pub command: String,
    /// The name of the scene.
    pub scene: String,
    /// The name of the view.
    pub view: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// A digest of everything that a sample depends on.
    pub fingerprint: String,
    /// Rays a pixel of the whole reference.
    pub rays: u32,
    /// The shard that this share is.
    pub shard: Shard,
    /// The numbers of the share's samples: the first, and the one after the last.
    pub samples: [u32; 2],
}

impl ReferencePart {
    /// Describes the share that `shard` samples of the `rays` rays a pixel of a reference.
    pub fn new(reference: &WorldReference, (scene, view): (&Scene, &View), shard: Shard, rays: u32) -> Self {
        let samples = samples_of(shard.index, shard.count, rays);
        Self {
            definitions: DEFINITIONS,
            version: Provenance::VERSION.to_owned(),
            commit: Provenance::commit(),
            command: command_line(),
            scene: scene.name.clone(),
            view: view.name.clone(),
            size: [reference.first_hits.width, reference.first_hits.height],
            fingerprint: short_name(&reference.fingerprint()),
            rays,
            shard,
            samples: [samples.start, samples.end],
        }
    }

    /// The path of the file in `folder` that keeps the sums of the share's samples.
    fn sums_file(&self, folder: &Path) -> PathBuf {
        part_file(folder, &self.fingerprint, &(self.samples[0]..self.samples[1]))
    }

    /// The name of the reference in messages: scene, view and size.
    fn name(&self) -> String {
        let [width, height] = self.size;
        format!("{} {} {width}x{height}", self.scene, self.view)
    }

    /// Returns the names and values of the properties that must be equal in all shares of one reference. The
    /// fingerprint is not among them, since shares are grouped by it.
    fn shared_properties(&self) -> [(&'static str, String); 4] {
        [
            ("version", self.version.clone()),
            ("commit", self.commit.clone()),
            ("version of the definitions", self.definitions.to_string()),
            ("number of rays", self.rays.to_string()),
        ]
    }
}

/// Takes the samples of a share that `folder` does not have yet, and keeps them there. Returns the sums of the share.
/// `progress` is called after every [`RAYS_AT_ONCE`] rays a pixel, and its error ends the sampling.
pub fn sample(
    reference: &WorldReference,
    part: &ReferencePart,
    folder: &Path,
    progress: &mut dyn FnMut(&WorldState) -> Result<()>,
) -> Result<WorldState> {
    let [first, end] = part.samples;
    let sums_file = part.sums_file(folder);
    if first == end {
        eprintln!(
            "ssct: warning: shard {} has no rays: {} are too few for {}",
            part.shard, part.rays, part.shard.count
        );
        return Ok(reference.start_at(first));
    }
    files::write(&sums_file.with_extension(PART), format!("{}\n", json!(part)).as_bytes())?;
    let (mut state, why_unusable) = reference.resume_at(&sums_file, first);
    if let Some(why) = why_unusable {
        eprintln!("ssct: warning: {why}; sampling begins anew");
    }
    while state.samples() < end {
        let rays = RAYS_AT_ONCE.min(end - state.samples());
        reference.add(&mut state, rays);
        state.save(&sums_file)?;
        progress(&state)?;
    }
    Ok(state)
}

/// A share as files keep it.
struct KeptPart {
    /// The file of the description.
    path: PathBuf,
    description: ReferencePart,
    /// The sums of the samples; `None` before the first of them are kept.
    sums: Option<WorldPart>,
}

/// Reads the shares that a folder holds. A share whose description cannot be right is an error.
fn parts_in(folder: &Path) -> Result<Vec<KeptPart>> {
    let mut parts = Vec::new();
    let inside = PathInFolder::folder(folder);
    for entry in inside.list()?.into_iter().filter(is_part) {
        let place = inside.join(&entry.name);
        let path = place.path();
        let wrong = |line: Option<usize>, why: String| {
            Error::malformed(&path, line, format!("is no share of a reference: {why}"))
        };
        let text = place.bytes()?;
        let description: ReferencePart =
            serde_json::from_slice(&text).map_err(|e| wrong(Some(e.line()), e.to_string()))?;
        // The digest becomes part of a file's name, so it may have hexadecimal digits only.
        let digest = &description.fingerprint;
        if digest.is_empty() || !digest.chars().all(|c| c.is_ascii_hexdigit()) {
            return Err(wrong(None, format!("its digest is {digest:?}")));
        }
        let sums_file = description.sums_file(folder);
        let has_sums = inside.join(sums_file.file_name().unwrap_or_default()).open()?.is_some();
        let sums = has_sums.then(|| WorldPart::read(&sums_file)).transpose()?;
        parts.push(KeptPart { path, description, sums });
    }
    Ok(parts)
}

/// True if a folder holds shares of references, readable or not.
pub fn has_parts(folder: &Path) -> bool {
    PathInFolder::folder(folder).list().is_ok_and(|all| all.iter().any(is_part))
}

/// True if a file of a folder describes a share, by its name.
fn is_part(entry: &FolderEntry) -> bool {
    entry.name.ends_with(&format!(".{PART}"))
}

/// Merges the shares in some folders into one reference for each fingerprint, and writes the references into the output
/// folder. Missing samples are an error unless the options allow them.
pub fn merge(options: &MergeOptions) -> anyhow::Result<()> {
    let mut references: BTreeMap<String, Vec<KeptPart>> = BTreeMap::new();
    for folder in &options.folders {
        for part in parts_in(folder)? {
            references.entry(part.description.fingerprint.clone()).or_default().push(part);
        }
    }
    let mut merged = Vec::new();
    let mut missing = Vec::new();
    for parts in references.into_values() {
        let first = parts[0].description.clone();
        for KeptPart { path, description, .. } in &parts[1..] {
            let difference = difference_of_properties(first.shared_properties(), description.shared_properties());
            if let Some(difference) = difference {
                let message = format!("is of another reference than {}: {difference}", parts[0].path.display());
                return Err(Error::malformed(path, None, message).into());
            }
        }
        let sums = parts.into_iter().filter_map(|part| part.sums).collect();
        let MergedParts { merged: whole, missing: gaps } = world_part::merge(sums, first.rays)?;
        missing.extend(gaps.iter().map(|samples| format!("{} of {}", samples_text(samples), first.name())));
        merged.extend(whole.map(|whole| (first, whole)));
    }
    if !missing.is_empty() && !options.partial {
        anyhow::bail!(
            "{} are missing; name the folders of the shards that have them, or give --partial",
            missing.join(", ")
        );
    }
    let _claim = FolderClaim::new(&options.output)?;
    for (part, whole) in &merged {
        whole.save(&whole_file(&options.output, &part.fingerprint))?;
    }
    print_summary(options, &merged, &missing)
}

/// Prints the rays of each merged reference with the command that shows it, and the samples that are missing.
fn print_summary(
    options: &MergeOptions,
    merged: &[(ReferencePart, WorldPart)],
    missing: &[String],
) -> anyhow::Result<()> {
    let mut out = printed::out();
    if options.json {
        let entry = |(part, whole): &(ReferencePart, WorldPart)| {
            let rays = whole.samples().end;
            json!({"scene": part.scene, "view": part.view, "size": part.size, "rays": rays})
        };
        let references: Vec<_> = merged.iter().map(entry).collect();
        let (folders, output) = (&options.folders, &options.output);
        let summary = json!({"kind": "reference", "folders": folders, "output": output, "references": references, "missing": missing});
        return Ok(printed::json(&summary)?);
    }
    for (part, whole) in merged {
        let (rays, name, folder) = (whole.samples().end, one_line(&part.name()).into_owned(), options.output.display());
        writeln!(out, "{folder}: {rays} of {} rays a pixel of {name}", part.rays)?;
        writeln!(out, "to show them: {} --cache {folder} -o FILE", one_line(&part.command))?;
    }
    for name in missing {
        writeln!(out, "missing: {}", one_line(name))?;
    }
    Ok(())
}
