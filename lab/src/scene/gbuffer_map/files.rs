//! The files that a map names, each read once: OpenEXR with all its parts, and PNG. Their names are those beside the
//! main file, the one that the command names.

use super::numbers::AttributeName;
use super::source::ChannelSource;
use crate::error::{Error, Result};
use crate::scene::exr_parts::{self, ExrChannel, ExrPart};
use crate::scene::gbuffer_file::MAX_BYTES;
use crate::scene::{bounded, texture};
use exr::meta::attribute::AttributeValue;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The first bytes of an OpenEXR file.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// At most so many names are listed in an error.
const MOST_NAMES: usize = 80;

/// The files of one frame.
pub(super) struct MapFiles<'a> {
    map: &'a Path,
    main: &'a Path,
    bottom_up: bool,
    open: BTreeMap<PathBuf, Vec<ExrPart>>,
    size: Option<([u32; 2], String)>,
    main_is_used: bool,
}

impl<'a> MapFiles<'a> {
    /// `map` is the map's own path, for errors; `bottom_up` says whether the first row of the files is the lowest.
    pub fn new(map: &'a Path, main: &'a Path, bottom_up: bool) -> Self {
        Self { map, main, bottom_up, open: BTreeMap::new(), size: None, main_is_used: false }
    }

    /// An error at a line of the map.
    pub fn error(&self, line: usize, message: impl Into<String>) -> Error {
        Error::malformed(self.map, Some(line), message)
    }

    /// The path of a file that the map names.
    pub fn path(&self, file: Option<&str>) -> PathBuf {
        match file {
            Some(name) => self.main.parent().unwrap_or(Path::new("")).join(name),
            None => self.main.to_owned(),
        }
    }

    /// Width and height of the image, once a channel was read.
    pub fn size(&self) -> [u32; 2] {
        self.size.as_ref().map_or([0; 2], |(size, _)| *size)
    }

    /// The values of a channel, rows from the top. `exact` refuses values that a compression rounded.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line of the map for a file, part or channel that is not there, with the names of
    /// those that are; for a channel that several parts have; for one that was rounded but must not be; for an image of
    /// another size than those before; those of the file itself.
    pub fn channel(&mut self, source: &ChannelSource, name: &str, exact: bool) -> Result<Vec<f32>> {
        self.open(source.file.as_deref(), source.line)?;
        let path = self.path(source.file.as_deref());
        let shown = path.display().to_string();
        let wrong = |message: String| Error::malformed(self.map, Some(source.line), message);
        let parts = self.open.get(&path).map_or(&[][..], Vec::as_slice);
        let (part, channel) = find(parts, source.part.as_deref(), name, &shown).map_err(wrong)?;
        if let Some(compression) = channel.rounded_by.filter(|_| exact) {
            return Err(wrong(format!(
                "channel {name} of {shown} was rounded by {compression}; depth, normals and sky must \
                 be \
                 compressed without loss"
            )));
        }
        let [width, height] = part.size;
        if channel.values.len() != width as usize * height as usize {
            return Err(wrong(format!("channel {name} of {shown} has fewer values than pixels")));
        }
        match &self.size {
            Some(([w, h], first)) if [*w, *h] != part.size => {
                return Err(wrong(format!("{shown} has {width}x{height} pixels, and {first} has {w}x{h}")));
            }
            _ => {}
        }
        let values = if self.bottom_up {
            channel.values.chunks_exact(width as usize).rev().flatten().copied().collect()
        } else {
            channel.values.clone()
        };
        self.size.get_or_insert(([width, height], shown));
        Ok(values)
    }

    /// An attribute. Without a part it is that of any part, in their order in the file.
    ///
    /// # Errors
    /// [`Error::Malformed`] with the line of the map for an attribute that is not there, with the names of those that
    /// are; those of the file itself.
    pub fn attribute(&mut self, wanted: &AttributeName, line: usize, key: &str) -> Result<AttributeValue> {
        self.open(wanted.file.as_deref(), line)?;
        let path = self.path(wanted.file.as_deref());
        let parts = self.open.get(&path).map_or(&[][..], Vec::as_slice);
        let of_part = |part: &&ExrPart| wanted.part.is_none() || part.name == wanted.part;
        let searched: Vec<&ExrPart> = parts.iter().filter(of_part).collect();
        if let Some(value) = searched.iter().find_map(|part| part.attributes.get(&wanted.name)) {
            return Ok(value.clone());
        }
        let shown = path.display();
        let message = if searched.is_empty() {
            no_part(parts, wanted.part.as_deref().unwrap_or_default(), &shown.to_string())
        } else {
            let mut names: Vec<&str> =
                searched.iter().flat_map(|part| part.attributes.keys()).map(String::as_str).collect();
            names.sort_unstable();
            names.dedup();
            format!("there is no attribute {:?} in {shown}, which has {}", wanted.name, list(&names))
        };
        Err(self.error(line, format!("{key}: {message}")))
    }

    /// # Errors
    /// [`Error::Malformed`] if nothing of the main file was used.
    pub fn finish(&self) -> Result<()> {
        if self.main_is_used {
            return Ok(());
        }
        let message = format!(
            "the map takes nothing from {}: what is in the file of the command is named without `file`",
            self.main.display()
        );
        Err(Error::malformed(self.map, None, message))
    }

    /// Reads a file if it was not read before.
    fn open(&mut self, file: Option<&str>, line: usize) -> Result<()> {
        let path = self.path(file);
        self.main_is_used |= path == self.main;
        if self.open.contains_key(&path) {
            return Ok(());
        }
        let bytes = match bounded::read(&path, "an image", MAX_BYTES) {
            Err(Error::Io { source, .. }) if file.is_some() && source.kind() == ErrorKind::NotFound => {
                return Err(self.error(line, format!("there is no file {}", path.display())));
            }
            read => read?,
        };
        let parts = if bytes.starts_with(&EXR_MAGIC) {
            exr_parts::decode(&bytes, &path)?
        } else if bytes.starts_with(b"\x89PNG") {
            vec![png(&bytes, &path)?]
        } else {
            return Err(Error::malformed(&path, None, "is neither an OpenEXR nor a PNG image"));
        };
        self.open.insert(path, parts);
        Ok(())
    }
}

/// A PNG of 8 or 16 bits as channels `R`, `G`, `B` and `A` from 0 to 1; grey ones have the same in R, G and B.
fn png(bytes: &[u8], path: &Path) -> Result<ExrPart> {
    let ([width, height], rgba) = texture::unit_values(bytes, path)?;
    let of = |k: usize| rgba.iter().skip(k).step_by(4).copied().collect();
    let channel = |(k, name): (usize, &str)| (name.to_owned(), ExrChannel { values: of(k), rounded_by: None });
    let channels = ["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect();
    Ok(ExrPart { name: None, size: [width, height], channels, attributes: BTreeMap::new() })
}

/// A channel by its name in its part, or by the names of part and channel with a point between them.
///
/// # Errors
/// A sentence if there is none, or more than one.
fn find<'a>(
    parts: &'a [ExrPart],
    part: Option<&str>,
    name: &str,
    file: &str,
) -> std::result::Result<(&'a ExrPart, &'a ExrChannel), String> {
    let searched = || parts.iter().filter(|p| part.is_none() || p.name.as_deref() == part);
    if searched().next().is_none() {
        return Err(no_part(parts, part.unwrap_or_default(), file));
    }
    let is_it = |p: &ExrPart, channel: &str| {
        let below = |long: &str, short: &str| {
            let of = p.name.as_deref().and_then(|of| long.strip_prefix(of)?.strip_prefix('.'));
            of == Some(short)
        };
        channel == name || below(name, channel) || (part.is_some() && below(channel, name))
    };
    let found: Vec<_> = searched()
        .flat_map(|p| p.channels.iter().map(move |(channel, values)| (p, channel, values)))
        .filter(|(p, channel, _)| is_it(p, channel))
        .collect();
    match found[..] {
        [(part, _, values)] => Ok((part, values)),
        [] => {
            let names: Vec<String> = searched().flat_map(|p| p.channels.keys().map(|c| full_name(p, c))).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            Err(format!("there is no channel {name} in {file}, which has {}", list(&names)))
        }
        _ => {
            let names: Vec<&str> = found.iter().map(|(p, ..)| p.name.as_deref().unwrap_or("")).collect();
            Err(format!("channel {name} is in several parts of {file}: say which by part, one of {}", list(&names)))
        }
    }
}

/// The name of a channel, with that of its part if it does not begin with it.
fn full_name(part: &ExrPart, channel: &str) -> String {
    match &part.name {
        Some(name) if !channel.strip_prefix(name.as_str()).is_some_and(|rest| rest.starts_with('.')) => {
            format!("{name}.{channel}")
        }
        _ => channel.to_owned(),
    }
}

fn no_part(parts: &[ExrPart], part: &str, file: &str) -> String {
    let names: Vec<&str> = parts.iter().filter_map(|p| p.name.as_deref()).collect();
    let which = if names.is_empty() { "no parts with a name".to_owned() } else { list(&names) };
    format!("there is no part {part:?} in {file}, which has {which}")
}

/// Names with commas between them, the first ones of many.
fn list(names: &[&str]) -> String {
    let first = names[..names.len().min(MOST_NAMES)].join(", ");
    match names.len().checked_sub(MOST_NAMES) {
        Some(more) if more > 0 => format!("{first} and {more} more"),
        _ => first,
    }
}
