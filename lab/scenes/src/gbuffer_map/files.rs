//! The files that a map names, OpenEXR with all parts or PNG, each of which is read once. The command names the main
//! file; the other files lie in its folder.

use crate::exr_parts::{self, ExrChannel, ExrPart};
use crate::gbuffer_file::MAX_BYTES;
use exr::meta::attribute::AttributeValue;
use exr::meta::magic_number;
use ssct_geometry::{bounded, texture};
use ssct_ground::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Greatest number of names that an error lists.
const MOST_NAMES: usize = 80;

/// The name of an attribute, and where to look for it.
#[derive(Debug, Clone)]
pub(super) struct AttributeName {
    pub name: String,
    /// File with the attribute; `None` for the main file.
    pub file: Option<String>,
    /// Part with the attribute; `None` for all parts of the file.
    pub part: Option<String>,
}

/// Channels of one part of a file.
#[derive(Debug, Clone)]
pub(super) struct ChannelSource {
    /// File with the channels; `None` for the main file.
    pub file: Option<String>,
    /// Part with the channels; `None` if the channels' names are enough.
    pub part: Option<String>,
    /// Names of the channels.
    pub names: Vec<String>,
    /// Line of the map that names the channels, for errors.
    pub line: usize,
}

/// The parts of the files that were read, by the path of the file.
pub(super) type OpenFiles = BTreeMap<PathBuf, Vec<ExrPart>>;

/// Arrangement of the image in the files of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrangement<'a> {
    /// True if the first row of the files is the lowest row of the image.
    pub bottom_up: bool,
    /// The view to read from files with several views, such as one of two eyes.
    pub view: Option<&'a str>,
}

/// The files of one frame.
pub(super) struct MapFiles<'a> {
    /// The path of the map, for errors.
    pub map: &'a Path,
    main: &'a Path,
    arrangement: Arrangement<'a>,
    open_files: OpenFiles,
    /// The size of the first channel that was read, and the path of its file.
    size: Option<([u32; 2], String)>,
    /// The width of a pixel over its height, from the header of the same file.
    pixel_aspect: f64,
    /// True once the map has asked for anything in the main file.
    main_is_used: bool,
}

impl<'a> MapFiles<'a> {
    /// Makes the files of a frame, none of which is read yet: `main` and the files in its folder. `map` is the path of
    /// the map, for errors.
    pub fn new(map: &'a Path, main: &'a Path, arrangement: Arrangement<'a>) -> Self {
        Self::with_open(map, main, arrangement, OpenFiles::new())
    }

    /// Makes the files like [`Self::new`], with `open_files` that were read before.
    pub fn with_open(map: &'a Path, main: &'a Path, arrangement: Arrangement<'a>, open_files: OpenFiles) -> Self {
        Self { map, main, arrangement, open_files, size: None, pixel_aspect: 1.0, main_is_used: false }
    }

    /// Returns the files that were read.
    pub fn into_open(self) -> OpenFiles {
        self.open_files
    }

    /// Makes an error at a line of the map.
    pub fn error(&self, line: usize, message: impl Into<String>) -> Error {
        Error::malformed(self.map, Some(line), message)
    }

    /// Returns the path of a file that the map names, or that of the main file for `None`.
    pub fn path(&self, file: Option<&str>) -> PathBuf {
        match file {
            Some(name) => self.main.parent().unwrap_or(Path::new("")).join(name),
            None => self.main.to_owned(),
        }
    }

    /// Returns width and height of the image in pixels; both are 0 until a channel was read.
    pub fn size(&self) -> [u32; 2] {
        self.size.as_ref().map_or([0; 2], |(size, _)| *size)
    }

    /// Returns the width of a pixel over its height; 1 until a channel was read.
    pub fn pixel_aspect(&self) -> f64 {
        self.pixel_aspect
    }

    /// Returns the number of pixels of the image; 0 until a channel was read.
    pub fn pixels(&self) -> usize {
        let [width, height] = self.size();
        width as usize * height as usize
    }

    /// Returns the values of the channel `name` of a source, row by row from the top of the image. With `exact`, values
    /// that a compression rounded are refused.
    ///
    /// # Errors
    /// [`Error::Malformed`], with the line of the map, for a missing file, and for a missing part or channel, with the
    /// names of the existing ones. This error is also returned for a channel that several parts have, for a rounded
    /// channel that must be exact, and for another size than before. [`Error::Io`] and [`Error::Malformed`] for a file
    /// that cannot be read.
    pub fn channel(&mut self, source: &ChannelSource, name: &str, exact: bool) -> Result<Vec<f32>> {
        self.open(source.file.as_deref(), source.line)?;
        let path = self.path(source.file.as_deref());
        let file = path.display().to_string();
        let error_at_source = |message: String| Error::malformed(self.map, Some(source.line), message);
        let parts = self.open_files.get(&path).map_or(&[][..], Vec::as_slice);
        let (part, channel) =
            find_channel(parts, source.part.as_deref(), self.arrangement.view, name, &file).map_err(error_at_source)?;
        if let Some(compression) = channel.rounded_by.filter(|_| exact) {
            return Err(error_at_source(format!(
                "channel {name} of {file} was rounded by {compression}; depth, normals and sky must be compressed \
                 without loss (in Blender, Output, Codec: ZIP)"
            )));
        }
        let [width, height] = part.size;
        if channel.values.len() != width as usize * height as usize {
            return Err(error_at_source(format!("channel {name} of {file} has fewer values than pixels")));
        }
        if let Some(([first_width, first_height], first_file)) =
            self.size.as_ref().filter(|(size, _)| *size != part.size)
        {
            return Err(error_at_source(format!(
                "{file} has {width}x{height} pixels, and {first_file} has {first_width}x{first_height}"
            )));
        }
        let values = if self.arrangement.bottom_up {
            channel.values.chunks_exact(width as usize).rev().flatten().copied().collect()
        } else {
            channel.values.clone()
        };
        if self.size.is_none() {
            self.pixel_aspect = pixel_aspect(part);
            self.size = Some(([width, height], file));
        }
        Ok(values)
    }

    /// Returns an attribute of a file. If `wanted` names no part, it comes from the first part that has it, where parts
    /// of other views come last. `key` is the key of the map that needs the attribute, in the line `line`.
    ///
    /// # Errors
    /// [`Error::Malformed`], with the line of the map, for a missing file, and for a missing attribute, with the names
    /// of the existing ones. [`Error::Io`] and [`Error::Malformed`] for a file that cannot be read.
    pub fn attribute(&mut self, wanted: &AttributeName, line: usize, key: &str) -> Result<AttributeValue> {
        self.open(wanted.file.as_deref(), line)?;
        let path = self.path(wanted.file.as_deref());
        let parts = self.open_files.get(&path).map_or(&[][..], Vec::as_slice);
        let is_searched = |part: &&ExrPart| wanted.part.is_none() || part.name == wanted.part;
        let mut searched: Vec<&ExrPart> = parts.iter().filter(is_searched).collect();
        searched.sort_by_key(|part| is_in_other_view(part, self.arrangement.view));
        if let Some(value) = searched.iter().find_map(|part| part.attributes.get(&wanted.name)) {
            return Ok(value.clone());
        }
        let file = path.display().to_string();
        let message = if searched.is_empty() {
            missing_part(parts, wanted.part.as_deref().unwrap_or_default(), &file)
        } else {
            let names = distinct(searched.iter().flat_map(|part| part.attributes.keys()).map(String::as_str));
            format!("there is no attribute {:?} in {file}, which has {}", wanted.name, list_names(&names))
        };
        Err(self.error(line, format!("{key}: {message}")))
    }

    /// Checks, once a frame is read, that the map took something from the main file.
    ///
    /// # Errors
    /// [`Error::Malformed`] if nothing was taken from the main file.
    pub fn check_main_is_used(&self) -> Result<()> {
        if self.main_is_used {
            return Ok(());
        }
        let message = format!(
            "the map takes nothing from {}, the file of the command: its channels are named without `file`",
            self.main.display()
        );
        Err(Error::malformed(self.map, None, message))
    }

    /// Reads a file if it was not read before; `None` is the main file. `line` is the line of the map that names the
    /// file.
    fn open(&mut self, file: Option<&str>, line: usize) -> Result<()> {
        let path = self.path(file);
        self.main_is_used |= path == self.main;
        if self.open_files.contains_key(&path) {
            return Ok(());
        }
        let bytes = match bounded::read(&path, "an image", MAX_BYTES) {
            Err(Error::Io { source, .. }) if file.is_some() && source.kind() == ErrorKind::NotFound => {
                return Err(self.error(line, format!("there is no file {}", path.display())));
            }
            read => read?,
        };
        let parts = if bytes.starts_with(&magic_number::BYTES) {
            exr_parts::decode(&bytes, &path)?
        } else if bytes.starts_with(b"\x89PNG") {
            vec![decode_png(&bytes, &path)?]
        } else {
            return Err(Error::malformed(&path, None, "is neither an OpenEXR nor a PNG image"));
        };
        self.open_files.insert(path, parts);
        Ok(())
    }
}

/// Returns the width of a pixel over its height, from the header of a part; 1 if it is missing, not finite or not
/// positive.
fn pixel_aspect(part: &ExrPart) -> f64 {
    match part.attributes.get("pixelAspectRatio") {
        Some(AttributeValue::F32(aspect)) if aspect.is_finite() && *aspect > 0.0 => f64::from(*aspect),
        _ => 1.0,
    }
}

/// Decodes a PNG with 8 or 16 bits to channels `R`, `G`, `B` and `A` from 0 to 1; a grey image has equal R, G and B.
fn decode_png(bytes: &[u8], path: &Path) -> Result<ExrPart> {
    let ([width, height], rgba) = texture::unit_values(bytes, path)?;
    let values_of = |component: usize| rgba.iter().skip(component).step_by(4).copied().collect();
    let named_channel = |(component, name): (usize, &str)| {
        (name.to_owned(), ExrChannel { values: values_of(component), rounded_by: None })
    };
    let channels = ["R", "G", "B", "A"].into_iter().enumerate().map(named_channel).collect();
    let (shared_by, attributes) = Default::default();
    Ok(ExrPart { name: None, view: None, shared_by, size: [width, height], channels, attributes })
}

/// Finds a channel, and returns it with its part. `wanted_part` names the part to search, or is `None` for all parts.
/// `name` is the channel's name, or the names of part and channel with a point between them. In a file with several
/// views, only `view` is searched, and parts and channels that belong to no view. `file` is for messages.
///
/// # Errors
/// A message if the file has other views, if no channel has the name, or if several parts have it.
fn find_channel<'a>(
    parts: &'a [ExrPart],
    wanted_part: Option<&str>,
    view: Option<&str>,
    name: &str,
    file: &str,
) -> std::result::Result<(&'a ExrPart, &'a ExrChannel), String> {
    let views = distinct(parts.iter().flat_map(|part| part.view.iter().chain(&part.shared_by)).map(String::as_str));
    if let Some(view) = view.filter(|view| !views.is_empty() && !views.contains(view)) {
        return Err(format!("there is no view {view:?} in {file}, which has {}", list_names(&views)));
    }
    let is_wanted_part = |part: &ExrPart| {
        let own_name = part.name.as_deref();
        let has_name_without_view = || view.is_some() && own_name.map(|own| without_view(part, own)) == wanted_part;
        wanted_part.is_none() || own_name == wanted_part || has_name_without_view()
    };
    let searched_parts = || parts.iter().filter(|part| !is_in_other_view(part, view) && is_wanted_part(part));
    if searched_parts().next().is_none() {
        return Err(missing_part(parts, wanted_part.unwrap_or_default(), file));
    }
    // A channel may be named with or without its view, and with or without its part, in the file and in the map.
    let has_name = |part: &ExrPart, channel: &str| {
        let is_full_name = |full: &str, short: &str| within_part(part, full) == Some(short);
        let is_name = |channel: &str| {
            channel == name || is_full_name(name, channel) || (wanted_part.is_some() && is_full_name(channel, name))
        };
        let channel_without_view = view.and_then(|view| without_view_inside(channel, view));
        is_name(channel) || channel_without_view.is_some_and(|channel| is_name(&channel))
    };
    // True if a channel belongs to the view, false if to another view; `None` if it belongs to no view.
    let is_of_view = |part: &ExrPart, channel: &str| match view {
        Some(view) => view_of_channel(part, channel, view).map(|own_view| own_view == view),
        None => Some(true),
    };
    let searched_channels = || {
        let channels =
            searched_parts().flat_map(|part| part.channels.iter().map(move |(name, values)| (part, name, values)));
        channels.filter(|(part, channel, _)| is_of_view(part, channel) != Some(false))
    };
    let mut found: Vec<_> = searched_channels().filter(|(part, channel, _)| has_name(part, channel)).collect();
    // A channel of the view itself counts before one that belongs to no view.
    if found.iter().any(|(part, channel, _)| is_of_view(part, channel).is_some()) {
        found.retain(|(part, channel, _)| is_of_view(part, channel).is_some());
    }
    match found[..] {
        [(part, _, values)] => Ok((part, values)),
        [] => {
            let names: Vec<String> = searched_channels().map(|(part, channel, _)| full_name(part, channel)).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            Err(format!("there is no channel {name} in {file}, which has {}", list_names(&names)))
        }
        _ => {
            let names: Vec<&str> = found.iter().map(|(part, ..)| part.name.as_deref().unwrap_or("")).collect();
            let views = distinct(found.iter().filter_map(|(part, ..)| part.view.as_deref()));
            let by_view = match views.len() {
                0 | 1 => String::new(),
                _ => format!(", or at the top of the map by view, one of {}", list_names(&views)),
            };
            Err(format!(
                "channel {name} is in several parts of {file}: say which by part, one of {}{by_view}",
                list_names(&names)
            ))
        }
    }
}

/// Returns the name of a part without its view, which Blender writes after a hyphen, as in `ViewLayer.Depth-left`.
fn without_view<'a>(part: &ExrPart, name: &'a str) -> &'a str {
    let stripped = part.view.as_deref().and_then(|view| name.strip_suffix(view)?.strip_suffix('-'));
    stripped.unwrap_or(name)
}

/// Returns the name of a channel without the view before its last component, such as `Depth.Z` for `Depth.left.Z`, or
/// `Z` for `left.Z`. The result is `None` if the name does not have the view there.
fn without_view_inside(channel: &str, view: &str) -> Option<String> {
    let (before, component) = channel.rsplit_once('.')?;
    let layer = before.strip_suffix(view)?;
    if layer.is_empty() {
        Some(component.to_owned())
    } else {
        Some(format!("{}.{component}", layer.strip_suffix('.')?))
    }
}

/// Returns true if a part states another view than `view`.
fn is_in_other_view(part: &ExrPart, view: Option<&str>) -> bool {
    part.view.as_deref().zip(view).is_some_and(|(own_view, view)| own_view != view)
}

/// Returns the view of a channel by the rules of OpenEXR; `None` if it belongs to no view. In a part that several views
/// share, the view stands before the last component, and a name without a point belongs to the default view. Some
/// programs write such names without the attribute that lists the views; then only the view `wanted` is known.
fn view_of_channel<'a>(part: &'a ExrPart, channel: &'a str, wanted: &str) -> Option<&'a str> {
    let view_in_name = channel.rsplit_once('.').and_then(|(before, _)| before.rsplit('.').next());
    match (&part.view, view_in_name) {
        (Some(view_of_part), _) => Some(view_of_part),
        (None, None) => part.shared_by.first().map(String::as_str),
        (None, Some(view_in_name)) => {
            let is_view = view_in_name == wanted || part.shared_by.iter().any(|view| view == view_in_name);
            is_view.then_some(view_in_name)
        }
    }
}

/// Returns the rest of a channel's name after the name of its part and a point; `None` if the name does not begin with
/// them.
fn within_part<'a>(part: &ExrPart, name: &'a str) -> Option<&'a str> {
    let part_name = part.name.as_deref()?;
    let rest_after = |prefix: &str| name.strip_prefix(prefix)?.strip_prefix('.');
    rest_after(part_name).or_else(|| rest_after(without_view(part, part_name)))
}

/// Returns the name of a channel with the name of its part in front, unless the channel's name begins with it.
fn full_name(part: &ExrPart, channel: &str) -> String {
    match &part.name {
        Some(name) if within_part(part, channel).is_none() => format!("{name}.{channel}"),
        _ => channel.to_owned(),
    }
}

/// Makes the message about a part that a file lacks, with the names of its parts.
fn missing_part(parts: &[ExrPart], part: &str, file: &str) -> String {
    let names: Vec<&str> = parts.iter().filter_map(|part| part.name.as_deref()).collect();
    let existing = if names.is_empty() { "no parts with a name".to_owned() } else { list_names(&names) };
    format!("there is no part {part:?} in {file}, which has {existing}")
}

/// Sorts names, and drops repeated ones.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    names.collect::<BTreeSet<_>>().into_iter().collect()
}

/// Joins names with commas; of more than [`MOST_NAMES`] names, only the first are listed, with the number of the
/// others.
fn list_names(names: &[&str]) -> String {
    let first = names[..names.len().min(MOST_NAMES)].join(", ");
    match names.len().checked_sub(MOST_NAMES) {
        Some(more) if more > 0 => format!("{first} and {more} more"),
        _ => first,
    }
}
