//! The values of a section of a map: where they come from (channels of a file, or constants), and how they are decoded.

use super::files::{ChannelSource, MapFiles};
use super::keys::MapKeys;
use ssct_ground::math;
use ssct_ground::{Error, Result};
use std::path::Path;

/// Where the values of a section come from, one or several for each pixel, and how they are decoded.
#[derive(Debug, Clone)]
pub(super) struct MapSource {
    /// The name of the section, for errors.
    section: String,
    line: usize,
    from: SourceFrom,
    is_srgb: bool,
    /// Factor on each decoded value.
    scale: Option<f64>,
    /// Number that is added after the factor.
    offset: Option<f64>,
    /// True if files whose compression rounds values are refused.
    exact: bool,
}

/// The place of the values: in channels of a file, or as constants in the map.
#[derive(Debug, Clone)]
enum SourceFrom {
    Channels(ChannelSource),
    Constants(Vec<f64>),
}

/// Rules for the source of a section.
#[derive(Debug, Clone, Copy)]
pub(super) struct SourceRules {
    /// Allowed numbers of channels or constants.
    pub counts: &'static [usize],
    /// True if constants may replace channels.
    pub may_be_constant: bool,
    /// True if the values may be encoded as sRGB.
    pub may_be_srgb: bool,
    /// True if the key `offset` is allowed beside `scale`.
    pub has_offset: bool,
    /// True if files whose compression rounds values are refused.
    pub exact: bool,
}

impl SourceRules {
    /// Rules for one channel, which no compression may have rounded.
    pub const EXACT: Self =
        Self { counts: &[1], may_be_constant: false, may_be_srgb: false, has_offset: true, exact: true };
    /// Rules for one value of a material, a channel or a constant.
    pub const MATERIAL: Self = Self { may_be_constant: true, exact: false, ..Self::EXACT };
    /// Rules for a colour, with three channels or with one, which is grey.
    pub const COLOUR: Self = Self { counts: &[1, 3], may_be_srgb: true, has_offset: false, ..Self::MATERIAL };
}

/// One value for each pixel: the pixels of a channel, or a constant for all.
enum MapPlane {
    Pixels(Vec<f32>),
    Constant(f64),
}

impl MapPlane {
    /// Returns the stored value of a pixel; `pixel` counts row by row.
    fn value(&self, pixel: usize) -> f64 {
        match self {
            Self::Pixels(values) => f64::from(values[pixel]),
            Self::Constant(value) => *value,
        }
    }
}

/// The values of a section as stored in the files.
pub(super) struct MapPlanes<'a> {
    source: &'a MapSource,
    /// One, two or three planes.
    planes: Vec<MapPlane>,
    /// The path of the map, for errors.
    map: &'a Path,
    /// Names of the channels and the path of their file, for errors.
    place: String,
    /// The width of the image in pixels.
    width: usize,
}

impl MapSource {
    /// Takes the keys of a section that has only the keys of a source.
    pub fn take_section(mut keys: MapKeys, rules: SourceRules) -> Result<Self> {
        let source = Self::take(&mut keys, rules)?;
        keys.finish()?;
        Ok(source)
    }

    /// Takes the keys of a source from a section that also has other keys.
    pub fn take(keys: &mut MapKeys, rules: SourceRules) -> Result<Self> {
        let line = keys.line;
        let [file, part] = ["file", "part"].map(|key| keys.text(key));
        let [file, part] = [file?, part?];
        let allowed_counts = rules.counts.iter().map(ToString::to_string).collect::<Vec<_>>().join(" or ");
        let one_name = if rules.counts.contains(&1) { keys.names("channel")? } else { None };
        let names = if rules.counts == [1] { one_name } else { one_name.or(keys.names("channels")?) };
        let constants = if rules.may_be_constant { keys.one_or_three("value")? } else { None };
        let encodings = [("linear", false), ("srgb", true)];
        let is_srgb = rules.may_be_srgb && keys.word("encoding", &encodings)?.unwrap_or(false);
        let scale = keys.number("scale", false)?;
        let offset = if rules.has_offset { keys.number("offset", false)? } else { None };
        let from = match (names, constants) {
            (Some((names, line)), None) => {
                if !rules.counts.contains(&names.len()) {
                    return Err(keys.error(line, format!("{} channels are named, not {allowed_counts}", names.len())));
                }
                SourceFrom::Channels(ChannelSource { file, part, names, line })
            }
            (None, Some(constants)) => {
                if !rules.counts.contains(&constants.len()) {
                    let message = format!("value has {} numbers, not {allowed_counts}", constants.len());
                    return Err(keys.error(line, message));
                }
                if file.is_some() || part.is_some() {
                    return Err(keys.error(line, "file and part go with channels, not with a value"));
                }
                SourceFrom::Constants(constants)
            }
            (Some(_), Some(_)) => return Err(keys.error(line, "there is a channel and a value; one of them is enough")),
            (None, None) => {
                let alternative = if rules.may_be_constant { ", or give a value" } else { "" };
                let key = if rules.counts == [1] { "channel" } else { "channels" };
                return Err(
                    keys.error(line, format!("{key} is missing: name {allowed_counts} {key} of the file{alternative}"))
                );
            }
        };
        Ok(Self { section: keys.name.clone(), line, from, is_srgb, scale, offset, exact: rules.exact })
    }

    /// Returns the number of values of a pixel.
    pub fn count(&self) -> usize {
        match &self.from {
            SourceFrom::Channels(channels) => channels.names.len(),
            SourceFrom::Constants(values) => values.len(),
        }
    }

    /// Reads the channels, or repeats the constants.
    ///
    /// # Errors
    /// The errors of [`MapFiles::channel`].
    pub fn read<'a>(&'a self, files: &mut MapFiles<'a>) -> Result<MapPlanes<'a>> {
        let (planes, place) = match &self.from {
            SourceFrom::Channels(channels) => {
                let read_channel = |name: &String| files.channel(channels, name, self.exact).map(MapPlane::Pixels);
                let planes = channels.names.iter().map(read_channel).collect::<Result<_>>()?;
                let path = files.path(channels.file.as_deref());
                (planes, format!("{} of {}", channels.names.join(", "), path.display()))
            }
            SourceFrom::Constants(values) => {
                (values.iter().map(|value| MapPlane::Constant(*value)).collect(), String::new())
            }
        };
        Ok(MapPlanes { source: self, planes, map: files.map, place, width: files.size()[0] as usize })
    }
}

impl MapPlanes<'_> {
    /// Returns the value of a pixel in a plane, as stored in the file.
    pub fn raw(&self, plane: usize, pixel: usize) -> f64 {
        // A single plane, which is grey, serves for all three values of a colour.
        self.planes[plane.min(self.planes.len() - 1)].value(pixel)
    }

    /// Returns the value of a pixel in a plane: decoded, multiplied by `scale`, and with `offset` added.
    pub fn value(&self, plane: usize, pixel: usize) -> f64 {
        let raw = self.raw(plane, pixel);
        let decoded = if self.source.is_srgb { f64::from(math::srgb_to_linear(raw as f32)) } else { raw };
        decoded * self.source.scale.unwrap_or(1.0) + self.source.offset.unwrap_or(0.0)
    }

    /// Returns three values of a pixel; if there is one plane, all three are equal.
    pub fn three(&self, pixel: usize) -> [f64; 3] {
        [0, 1, 2].map(|plane| self.value(plane, pixel))
    }

    /// Makes an error about a pixel with a wrong value. `value` is what [`Self::value`] returns, and `must` says what
    /// is required of it, as in "be finite".
    pub fn error(&self, pixel: usize, value: f64, must: &str) -> Error {
        let location = match self.source.from {
            SourceFrom::Constants(_) => String::new(),
            SourceFrom::Channels(_) => {
                format!(" at pixel {}, {} ({})", pixel % self.width, pixel / self.width, self.place)
            }
        };
        let message = format!("{}: it is {value}{location}; it must {must}", self.source.section);
        Error::malformed(self.map, Some(self.source.line), message)
    }
}
