//! Values for the fields of a shader's uniform blocks and push constants, and for its specialization constants.

use super::conventions::Conventions;
use super::reflect::{BlockField, Component};
use glam::{DMat4, DVec3, Vec3};
use ssct::gpu::image::{full_chain, level_extent};
use ssct::passes::hi_z;
use ssct_ground::conventions::{Axes, ClipDepth, ClipY, MatrixOrder};
use ssct_ground::parameter::{Domain, Parameter, Value, Values};
use ssct_scenes::Camera;

/// The value that a manifest gives to a field: numbers, the name of a value that changes, or a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Feed {
    /// Numbers, as many as the field has.
    Numbers(Vec<f64>),
    /// A name of [`NAMES`].
    Named(&'static str),
    /// A parameter of the method.
    Parameter(String),
}

/// The names of values, each with its meaning.
pub const NAMES: [(&str, &str); 36] = [
    ("view-to-clip", "matrix: view space to clip space"),
    ("clip-to-view", "matrix: its inverse"),
    ("view-to-clip-reversed", "matrix: view space to clip space with reversed depth, whatever clip-depth says"),
    ("clip-to-view-reversed", "matrix: its inverse"),
    ("world-to-view", "matrix: world space to view space"),
    ("view-to-world", "matrix: its inverse"),
    ("world-to-clip", "matrix: world space to clip space"),
    ("clip-to-world", "matrix: its inverse"),
    ("previous-world-to-view", "matrix: the same of the frame before"),
    ("previous-view-to-world", "matrix: its inverse"),
    ("previous-world-to-clip", "matrix: the same of the frame before"),
    ("previous-clip-to-world", "matrix: its inverse"),
    ("view-to-pixels", "matrix: view space to pixels; x and y after division by w, from the upper left corner"),
    ("eye", "3 numbers: the camera in world space, in metres"),
    ("size", "2 numbers: width and height of the frame in pixels; 4: and one over each"),
    ("inverse-size", "2 numbers: one over width and height"),
    ("pass-size", "2 or 4 numbers: the same of what the pass writes"),
    ("inverse-pass-size", "2 numbers: one over width and height of what the pass writes"),
    (
        "step-right",
        "2 numbers: from a texel of what the pass writes to the next one to the right, in texture coordinates",
    ),
    ("step-down", "2 numbers: the same to the next one below"),
    ("level-count", "levels of an image of the frame's size, down to one texel"),
    ("last-level", "the coarsest of these levels: their number less one"),
    (
        "hi-z-offset",
        "2 numbers: Offset of the thesis's Eq. 4.1: along each side 1 where the level below is even, else 2",
    ),
    ("near", "near plane, metres"),
    ("far", "far plane, metres"),
    ("fov-y", "vertical field of view, radians; perspectives only"),
    ("aspect", "width over height"),
    ("half-view", "2 numbers: tangents of half the horizontal and half the vertical field of view; perspectives only"),
    ("frame", "frames since the first"),
    ("is-first-frame", "1 in the first frame, whose history is empty, else 0"),
    ("level", "the level that the pass is recorded for"),
    ("greatest-roughness", "the greatest roughness of the scene's materials; 1 where they are not known"),
    ("fade", "1 if reflections fade at the screen's border (--fade), else 0"),
    ("hits", "1 if hits are wanted, else 0"),
    ("capture-count", "how many captures there are"),
    ("capture-places", "4 numbers a capture: its place in world space, and 0; those that are not there are 0"),
];

impl Feed {
    /// Reads a value of the manifest; `parameters` has the names of the manifest's parameters. The error is a clause
    /// that says what is wrong.
    pub fn parse(value: &toml::Value, parameters: &[String]) -> Result<Self, String> {
        let number = |v: &toml::Value| match v {
            toml::Value::Integer(n) => Some(*n as f64),
            toml::Value::Float(n) => Some(*n),
            toml::Value::Boolean(on) => Some(f64::from(u8::from(*on))),
            _ => None,
        };
        match value {
            toml::Value::String(name) => match name.strip_prefix("parameter:") {
                Some(parameter) if parameters.iter().any(|p| p == parameter) => {
                    Ok(Self::Parameter(parameter.replace('-', "_")))
                }
                Some(parameter) => Err(format!("there is no [parameter.{parameter}]")),
                None => {
                    NAMES.iter().find(|(known, _)| known == name).map(|(name, _)| Self::Named(name)).ok_or_else(|| {
                        let names = NAMES.map(|(name, _)| name).join(", ");
                        format!("{name:?} is no value that there is: {names}, or parameter:…")
                    })
                }
            },
            toml::Value::Array(elements) => {
                let numbers: Option<Vec<f64>> = elements.iter().map(number).collect();
                numbers.map(Self::Numbers).ok_or_else(|| "an array must have numbers alone".to_owned())
            }
            other => number(other)
                .map(|n| Self::Numbers(vec![n]))
                .ok_or_else(|| "a value is a number, an array of numbers, or a name".to_owned()),
        }
    }

    /// True if the value has the name `wanted`.
    pub fn is_named(&self, wanted: &str) -> bool {
        matches!(self, Self::Named(name) if *name == wanted)
    }
}

/// The data of a frame from which values are made.
pub struct FrameState<'a> {
    /// The camera of the frame.
    pub camera: &'a Camera,
    /// The camera of the frame before.
    pub before: &'a Camera,
    /// Width and height in pixels of the frame.
    pub extent: [u32; 2],
    /// Width and height in pixels of what the pass writes.
    pub pass_extent: [u32; 2],
    /// The level that the pass is recorded for.
    pub level: u32,
    /// The number of frames before this one.
    pub frame: u32,
    /// True in the first frame, whose history is empty.
    pub is_first: bool,
    /// The greatest roughness of the scene's materials.
    pub roughness: f32,
    /// True if reflections fade at the screen's border.
    pub fade: bool,
    /// True if hits are wanted.
    pub hits: bool,
    /// The places of the captures in this program's world space, in metres.
    pub captures: &'a [Vec3],
    /// The conventions of the method's shaders.
    pub conventions: Conventions,
    /// The values of the method's parameters.
    pub values: &'a Values,
    /// The method's parameters.
    pub parameters: &'a [Parameter],
}

/// A field of a block, with the value that fills it.
#[derive(Debug, Clone)]
pub struct FilledField {
    field: BlockField,
    feed: Feed,
}

impl FilledField {
    /// Makes a field with the value that fills it.
    ///
    /// # Errors
    /// A clause that says that the field's numbers do not fit the value.
    pub fn new(field: &BlockField, feed: Feed) -> Result<Self, String> {
        let filled = Self { field: field.clone(), feed };
        filled.check()?;
        Ok(filled)
    }

    /// Checks that the field's numbers fit the value.
    fn check(&self) -> Result<(), String> {
        let [elements, columns, rows] = self.field.shape;
        let numbers = self.field.places.len();
        let fits = match &self.feed {
            Feed::Numbers(given) => given.len() == numbers,
            Feed::Parameter(_) => numbers == 1,
            Feed::Named(name) => match *name {
                "eye" => numbers == 3 || numbers == 4,
                "size" | "pass-size" => numbers == 2 || numbers == 4,
                "inverse-size" | "half-view" | "inverse-pass-size" | "step-right" | "step-down" | "hi-z-offset" => {
                    numbers == 2
                }
                "capture-places" => numbers.is_multiple_of(4),
                name if is_matrix(name) => elements == 1 && columns >= 3 && rows >= 3,
                _ => numbers == 1,
            },
        };
        if fits { Ok(()) } else { Err(format!("the field has {numbers} numbers, and what feeds it has others")) }
    }

    /// Writes the field's numbers into `bytes`, the bytes of its block.
    pub fn write(&self, bytes: &mut [u8], state: &FrameState) {
        let mut numbers = self.feed.numbers(state, self.field.places.len());
        if let (Feed::Named(name), [_, columns, rows]) = (&self.feed, self.field.shape)
            && is_matrix(name)
        {
            // A smaller matrix takes the first rows and columns of the matrix of four rows and columns.
            let entry = |n: u32| numbers.get(((n / rows) * 4 + n % rows) as usize).copied().unwrap_or(0.0);
            numbers = (0..columns * rows).map(entry).collect();
        }
        numbers.resize(self.field.places.len(), 0.0);
        for (place, number) in self.field.places.iter().zip(numbers) {
            let word = match self.field.component {
                Component::Float => (number as f32).to_le_bytes(),
                Component::Int => (number as i32).to_le_bytes(),
                Component::Uint => (number as u32).to_le_bytes(),
            };
            // The place lies within `bytes`, since the size of the block covers its last number.
            bytes[*place as usize..][..4].copy_from_slice(&word);
        }
    }
}

/// True if the value of a name is a matrix.
fn is_matrix(name: &str) -> bool {
    NAMES.iter().any(|(known, help)| *known == name && help.starts_with("matrix"))
}

impl Feed {
    /// Returns the numbers of the value in a frame, for a field of `wanted` numbers. They may be more than that.
    pub fn numbers(&self, state: &FrameState, wanted: usize) -> Vec<f64> {
        let [width, height] = state.extent.map(f64::from);
        let [pass_width, pass_height] = state.pass_extent.map(f64::from);
        let flag = |on: bool| vec![f64::from(u8::from(on))];
        match self {
            Self::Numbers(numbers) => numbers.clone(),
            Self::Parameter(name) => vec![state.parameter(name)],
            Self::Named(name) => match *name {
                "eye" => state.eye().to_array().to_vec(),
                "size" => vec![width, height, 1.0 / width, 1.0 / height],
                "inverse-size" => vec![1.0 / width, 1.0 / height],
                "pass-size" => vec![pass_width, pass_height, 1.0 / pass_width, 1.0 / pass_height],
                "inverse-pass-size" => vec![1.0 / pass_width, 1.0 / pass_height],
                "step-right" => vec![1.0 / pass_width, 0.0],
                "step-down" => vec![0.0, 1.0 / pass_height],
                "level-count" => vec![f64::from(full_chain(state.extent))],
                "last-level" => vec![f64::from(full_chain(state.extent) - 1)],
                "hi-z-offset" => {
                    let below = level_extent(state.extent, state.level.saturating_sub(1));
                    below.map(|side| f64::from(hi_z::offset(side))).to_vec()
                }
                "near" => vec![f64::from(state.camera.lens.near_m)],
                "far" => vec![f64::from(state.camera.lens.far_m)],
                "fov-y" => vec![state.camera.lens.fov_y_radians().unwrap_or_default().into()],
                "aspect" => vec![width / height],
                "half-view" => {
                    let [x, y] = projection_factors(state.camera);
                    vec![1.0 / x, 1.0 / y]
                }
                "frame" => vec![f64::from(state.frame)],
                "is-first-frame" => flag(state.is_first),
                "level" => vec![f64::from(state.level)],
                "greatest-roughness" => vec![f64::from(state.roughness)],
                "fade" => flag(state.fade),
                "hits" => flag(state.hits),
                "capture-count" => vec![state.captures.len() as f64],
                "capture-places" => {
                    let place = |p: &Vec3| state.to_shader_world(p.as_dvec3()).extend(0.0).to_array();
                    state.captures.iter().flat_map(place).take(wanted).collect()
                }
                matrix => state.matrix(matrix),
            },
        }
    }
}

impl FrameState<'_> {
    /// The value of a parameter as a number; 0 if there is no parameter of this name.
    fn parameter(&self, name: &str) -> f64 {
        let Some(row) = self.parameters.iter().find(|p| p.name == name) else { return 0.0 };
        match self.values.value(row) {
            Value::Switch(on) => f64::from(u8::from(on)),
            Value::Count(n) => f64::from(n),
            Value::Number(n) => f64::from(n),
            // A choice is given by its number.
            Value::Choice(chosen) => match &row.domain {
                Domain::Choices(all) => all.iter().position(|c| c.name == chosen).unwrap_or(0) as f64,
                _ => 0.0,
            },
        }
    }

    /// Converts a place in this program's world space into the shader's world space.
    fn to_shader_world(&self, place: DVec3) -> DVec3 {
        to_axes(self.conventions.world).transform_vector3(place)
    }

    /// The place of the camera in the shader's world space.
    fn eye(&self) -> DVec3 {
        self.to_shader_world(self.camera.eye().as_dvec3())
    }

    /// The matrix from world to view space of a camera, in the shader's spaces.
    fn world_to_view(&self, camera: &Camera) -> DMat4 {
        // The inverse of a matrix of axes is its transpose.
        to_axes(self.conventions.view) * camera.world_to_view.as_dmat4() * to_axes(self.conventions.world).transpose()
    }

    /// The matrix from view to clip space of a camera, in the shader's spaces.
    pub fn view_to_clip(&self, camera: &Camera) -> DMat4 {
        self.view_to_clip_with(camera, self.conventions.clip_depth)
    }

    /// The matrix from view to clip space of a camera, in the shader's spaces, but with the given kind of depth in clip
    /// space.
    fn view_to_clip_with(&self, camera: &Camera, depth: ClipDepth) -> DMat4 {
        let to_clip = match depth {
            ClipDepth::Reversed => camera.view_to_clip_reversed().as_dmat4(),
            ClipDepth::Standard => camera.view_to_clip().as_dmat4(),
            // z' = 2 z − w maps depths from 0…1 to −1…1.
            ClipDepth::MinusOneToOne => {
                let mut stretched = DMat4::from_scale(DVec3::new(1.0, 1.0, 2.0));
                stretched.w_axis.z = -1.0;
                stretched * camera.view_to_clip().as_dmat4()
            }
        };
        let to_clip = to_clip * to_axes(self.conventions.view).transpose();
        match self.conventions.clip_y {
            ClipY::Up => to_clip,
            ClipY::Down => DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)) * to_clip,
        }
    }

    /// Returns the 16 numbers of the matrix with a name of [`NAMES`], in the order of the shader's convention.
    fn matrix(&self, name: &str) -> Vec<f64> {
        let camera = if name.starts_with("previous-") { self.before } else { self.camera };
        let (view, clip) = (self.world_to_view(camera), self.view_to_clip(camera));
        let matrix = match name.trim_start_matches("previous-") {
            "view-to-clip" => clip,
            "clip-to-view" => clip.inverse(),
            "view-to-clip-reversed" => self.view_to_clip_with(camera, ClipDepth::Reversed),
            "clip-to-view-reversed" => self.view_to_clip_with(camera, ClipDepth::Reversed).inverse(),
            "world-to-view" => view,
            "view-to-world" => view.inverse(),
            "world-to-clip" => clip * view,
            "clip-to-world" => (clip * view).inverse(),
            // `view-to-pixels`: x and y of clip space from −1…1 to pixels, y downwards.
            _ => {
                let [width, height] = self.extent.map(|v| 0.5 * f64::from(v));
                let down = if self.conventions.clip_y == ClipY::Up { -height } else { height };
                let mut to_pixels = DMat4::from_scale(DVec3::new(width, down, 1.0));
                (to_pixels.w_axis.x, to_pixels.w_axis.y) = (width, height);
                to_pixels * clip
            }
        };
        let matrix = if self.conventions.matrices == MatrixOrder::Rows { matrix.transpose() } else { matrix };
        matrix.to_cols_array().to_vec()
    }
}

/// Returns the factors of a camera's projection on x and on y, M_00 and M_11. In a perspective, they are one over the
/// tangents of half the horizontal and half the vertical angle of view.
fn projection_factors(camera: &Camera) -> [f64; 2] {
    let projection = camera.view_to_clip().as_dmat4();
    [projection.x_axis.x, projection.y_axis.y]
}

/// Returns the matrix from this program's axes, which are left-handed with y up, to the axes `to`.
pub fn to_axes(to: Axes) -> DMat4 {
    DMat4::from_mat3(to.to_ours().transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ssct_scenes::Lens;

    /// Returns the state of a frame of 200 × 100 pixels, in which a pass writes level 3 of 100 × 50 texels.
    fn state<'a>(camera: &'a Camera, values: &'a Values, conventions: Conventions) -> FrameState<'a> {
        FrameState {
            camera,
            before: camera,
            extent: [200, 100],
            pass_extent: [100, 50],
            level: 3,
            frame: 7,
            is_first: false,
            roughness: 0.25,
            fade: true,
            hits: false,
            captures: &[],
            conventions,
            values,
            parameters: &[],
        }
    }

    /// Returns the matrix with a name of [`NAMES`], its numbers taken column by column.
    fn matrix(state: &FrameState, name: &'static str) -> DMat4 {
        let numbers = Feed::Named(name).numbers(state, 16);
        DMat4::from_cols_slice(&numbers)
    }

    #[test]
    fn matrices_agree_in_every_convention() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, -3.0), Vec3::new(0.5, 0.5, 4.0), Lens::default(), 2.0);
        let values = Values::default();
        let ours = state(&camera, &values, Conventions::default());
        let place = DVec3::new(0.3, 1.0, 2.0);
        let seen = matrix(&ours, "world-to-clip").project_point3(place);
        let right = Conventions { view: Axes::Right, world: Axes::Right, ..Conventions::default() };
        let theirs = state(&camera, &values, right);
        let mirrored = place * DVec3::new(1.0, 1.0, -1.0);
        assert!(matrix(&theirs, "world-to-clip").project_point3(mirrored).distance(seen) < 1e-9);
        assert!(matrix(&theirs, "world-to-view").transform_point3(mirrored).z < 0.0, "it looks along −z");
        let up = Conventions { view: Axes::RightZUp, world: Axes::RightZUp, ..Conventions::default() };
        let z_up = state(&camera, &values, up);
        let swapped = DVec3::new(place.x, place.z, place.y);
        assert!(matrix(&z_up, "world-to-clip").project_point3(swapped).distance(seen) < 1e-9);
        assert!(matrix(&z_up, "world-to-view").transform_point3(swapped).y > 0.0, "it looks along +y");
        let gl = Conventions { clip_depth: ClipDepth::MinusOneToOne, clip_y: ClipY::Down, ..right };
        let in_gl = matrix(&state(&camera, &values, gl), "world-to-clip").project_point3(mirrored);
        assert!(in_gl.distance(DVec3::new(seen.x, -seen.y, 2.0 * seen.z - 1.0)) < 1e-9, "{in_gl} {seen}");
        let rows = state(&camera, &values, Conventions { matrices: MatrixOrder::Rows, ..Conventions::default() });
        assert_eq!(matrix(&rows, "view-to-clip"), matrix(&ours, "view-to-clip").transpose());
        let pixel =
            matrix(&ours, "view-to-pixels").project_point3(matrix(&ours, "world-to-view").transform_point3(place));
        let wanted = (0.5 + 0.5 * seen.x) * 200.0;
        assert!((pixel.x - wanted).abs() < 1e-9 && (pixel.y - (0.5 - 0.5 * seen.y) * 100.0).abs() < 1e-9, "{pixel}");
        for name in NAMES.map(|(name, _)| name).into_iter().filter(|name| is_matrix(name)) {
            assert!(matrix(&ours, name).determinant() != 0.0, "{name}");
        }
    }

    /// Makes a field of a block that a shader reads; `shape` and `places` are as in [`BlockField`].
    fn field(component: Component, shape: [u32; 3], places: &[u32]) -> BlockField {
        BlockField { name: "f".to_owned(), component, shape, places: places.to_vec(), is_read: true }
    }

    #[test]
    fn a_field_takes_as_many_numbers_as_it_has() {
        let three = field(Component::Float, [1, 1, 3], &[4, 8, 12]);
        assert!(FilledField::new(&three, Feed::Numbers(vec![1.0, 2.0, 3.0])).is_ok());
        assert!(FilledField::new(&three, Feed::Numbers(vec![1.0])).is_err());
        assert!(FilledField::new(&field(Component::Float, [1, 1, 1], &[0]), Feed::Named("size")).is_err());
        assert!(
            FilledField::new(&field(Component::Float, [1, 2, 2], &[0, 4, 16, 20]), Feed::Named("view-to-clip"))
                .is_err()
        );
        let camera = Camera::new(Vec3::ZERO, Vec3::Z, Lens::default(), 2.0);
        let values = Values::default();
        let state = state(&camera, &values, Conventions::default());
        let mut bytes = [0; 12];
        let two = field(Component::Int, [1, 1, 2], &[4, 8]);
        FilledField::new(&two, Feed::Named("pass-size")).unwrap().write(&mut bytes, &state);
        assert_eq!(bytes, [0, 0, 0, 0, 100, 0, 0, 0, 50, 0, 0, 0]);
        // The elements of an array lie 16 bytes apart.
        let mut bytes = [0; 32];
        let array = field(Component::Uint, [2, 1, 1], &[0, 16]);
        FilledField::new(&array, Feed::Numbers(vec![1.0, 2.0])).unwrap().write(&mut bytes, &state);
        assert_eq!((bytes[0], bytes[16], bytes.iter().map(|b| u32::from(*b)).sum::<u32>()), (1, 2, 3));
    }

    #[test]
    fn a_matrix_of_three_columns_has_the_first_of_four() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, -3.0), Vec3::new(0.5, 0.5, 4.0), Lens::default(), 2.0);
        let values = Values::default();
        let state = state(&camera, &values, Conventions::default());
        let places: Vec<u32> = (0..3).flat_map(|c| (0..3).map(move |r| 16 * c + 4 * r)).collect();
        let mut bytes = [0; 48];
        let filled =
            FilledField::new(&field(Component::Float, [1, 3, 3], &places), Feed::Named("world-to-view")).unwrap();
        filled.write(&mut bytes, &state);
        let whole = matrix(&state, "world-to-view");
        for (k, place) in places.iter().enumerate() {
            let offset = *place as usize;
            let number = f32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap());
            assert_eq!(number, whole.col(k / 3)[k % 3] as f32);
        }
    }

    #[test]
    fn the_documentation_lists_every_name_of_a_value_with_its_meaning() {
        let page = include_str!("../../../docs/custom-methods.md");
        for (name, help) in NAMES {
            assert!(page.contains(&format!("| `{name}` | {help} |")), "{name}");
        }
    }

    #[test]
    fn numbers_names_and_parameters_are_read_and_other_values_refused() {
        // Reads a value of a method that has one parameter, `a-b`.
        let parse = |text: &str| {
            Feed::parse(&toml::from_str::<toml::Table>(&format!("v = {text}")).unwrap()["v"], &["a-b".into()])
        };
        assert_eq!(parse("[1, 2.5]"), Ok(Feed::Numbers(vec![1.0, 2.5])));
        assert_eq!(parse("true"), Ok(Feed::Numbers(vec![1.0])));
        assert_eq!(parse("\"near\""), Ok(Feed::Named("near")));
        assert_eq!(parse("\"parameter:a-b\""), Ok(Feed::Parameter("a_b".into())));
        assert!(parse("\"parameter:c\"").unwrap_err().contains("[parameter.c]"));
        assert!(parse("\"nearer\"").unwrap_err().contains("no value"));
        assert!(parse("[\"near\"]").is_err() && parse("{ a = 1 }").is_err());
    }
}
