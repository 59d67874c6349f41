//! Says what feeds the fields of the project's own shaders, for the message about a manifest that leaves fields out.
//! The message names the field's option with its published value, or the name of a value that every method has.

use ssct::methods;
use ssct_ground::parameter::{Domain, Parameter, Value};

/// The source that feeds a field.
#[derive(Clone, Copy)]
enum Source {
    /// The value of a parameter, by its name in records.
    Setting(&'static str),
    /// A name of [`NAMES`](super::values::NAMES).
    Named(&'static str),
}

use Source::{Named, Setting};

/// The blocks of published shaders, each with its fields and their sources.
const BLOCKS: [(&str, &[(&str, Source)]); 8] = [
    (
        "ThesisBlock",
        &[
            ("projection", Named("view-to-clip")),
            ("inverse_projection", Named("clip-to-view")),
            ("resolution", Named("size")),
            ("near_plane", Named("near")),
            ("far_plane", Named("far")),
            ("reflection_offset", Named("near")),
            ("view_direction_epsilon", Setting("direction_tolerance")),
            ("cross_offset", Setting("cross_offset")),
            ("start_level", Setting("start_level")),
            ("max_level", Named("last-level")),
            ("iterations", Setting("iterations")),
            ("linear_march_stride", Setting("march_stride")),
            ("binary_search_first", Setting("search_first")),
            ("cone_samples", Setting("cone_samples")),
            ("cone_lengthened", Setting("cone_lengthened")),
            ("cone_interpolated", Setting("cone_angle")),
            ("cone_alpha_min", Setting("cone_alpha_min")),
            ("cone_alpha_max", Setting("cone_alpha_max")),
            ("cone_xi", Setting("cone_xi")),
            ("cone_mirror_alpha", Setting("cone_mirror_alpha")),
            ("fade_start", Setting("fade_start")),
            ("fade_end", Setting("fade_end")),
            ("fade_towards_camera", Setting("camera_fade")),
            ("fade", Named("fade")),
            ("uniform_stride_min", Setting("uniform_stride_min")),
            ("uniform_stride_max", Setting("uniform_stride_max")),
            ("uniform_march_back", Setting("uniform_back")),
        ],
    ),
    ("HiZBlock", &[("Offset", Named("hi-z-offset"))]),
    ("VisibilityBlock", &[("near_plane", Named("near")), ("far_plane", Named("far"))]),
    ("BlurBlock", &[("invSize", Named("inverse-pass-size")), ("direction", Named("step-right"))]),
    (
        "MaskedBlurBlock",
        &[
            ("invSize", Named("inverse-pass-size")),
            ("direction", Named("step-right")),
            ("near", Named("near")),
            ("far", Named("far")),
            ("tolerance", Setting("chain_mask_tolerance")),
        ],
    ),
    (
        "SslrReflectionBlock",
        &[
            ("resolution", Named("size")),
            ("mipCount", Named("level-count")),
            ("spreadingFactor", Setting("spreading_factor")),
        ],
    ),
    (
        "SchmidtBlock",
        &[
            ("user_pixelStepSize", Setting("pixel_step")),
            ("fadeToEdges", Named("fade")),
            ("toggleBlur", Setting("distance_blur")),
        ],
    ),
    (
        "CameraBlock",
        &[
            ("view_to_clip", Named("view-to-clip")),
            ("clip_to_view", Named("clip-to-view")),
            ("view_to_clip_reversed", Named("view-to-clip-reversed")),
            ("clip_to_view_reversed", Named("clip-to-view-reversed")),
            ("world_to_view", Named("world-to-view")),
            ("view_to_world", Named("view-to-world")),
            ("resolution", Named("size")),
            ("near_plane", Named("near")),
            ("far_plane", Named("far")),
        ],
    ),
];

/// Returns what feeds a field of a published block, as a part of a message; `None` for every other field.
pub fn hint(block: &str, field: &str) -> Option<String> {
    let (_, fields) = BLOCKS.iter().find(|(name, _)| *name == block)?;
    match fields.iter().find(|(name, _)| *name == field)?.1 {
        Named(name) => Some(format!("{name:?}")),
        Setting(name) => {
            let (parameter, _) = methods::parameters().into_iter().find(|(parameter, _)| parameter.name == name)?;
            let number = published_number(&parameter);
            Some(format!("--{}, published {number}", parameter.name.replace('_', "-")))
        }
    }
}

/// Returns the published value of a parameter as a shader takes it: 1 or 0 for a switch, and for a choice its number,
/// counted from 0.
fn published_number(parameter: &Parameter) -> String {
    match (parameter.published, &parameter.domain) {
        (Value::Switch(on), _) => u8::from(on).to_string(),
        (Value::Choice(chosen), Domain::Choices(all)) => {
            all.iter().position(|choice| choice.name == chosen).unwrap_or(0).to_string()
        }
        (value, _) => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{built_in, values::Feed};
    use super::*;

    #[test]
    fn every_field_of_a_published_block_has_a_source_that_there_is() {
        let shaders = [
            ("ThesisBlock", "thesis/parameters.glsl"),
            ("HiZBlock", "thesis/hi_z.frag"),
            ("VisibilityBlock", "thesis/visibility.frag"),
            ("BlurBlock", "thesis/sslr_blur.frag"),
            ("MaskedBlurBlock", "thesis/gaussian_blur.frag"),
            ("SslrReflectionBlock", "thesis/sslr_reflection.frag"),
            ("SchmidtBlock", "schmidt/screen_space_reflections.frag"),
            ("CameraBlock", "common/camera.glsl"),
        ];
        assert_eq!(shaders.len(), BLOCKS.len());
        for (block, file) in shaders {
            let text = built_in::text(&built_in::path(file).expect(file)).expect(file);
            let (_, rest) = text.split_once(&format!("uniform {block} {{\n")).expect(block);
            let (fields, _) = rest.split_once('}').expect("an end");
            for line in fields.lines() {
                let declared = line.split(';').next().and_then(|text| text.split_whitespace().nth(1)).expect("a field");
                assert!(hint(block, declared).is_some(), "{block}.{declared}");
            }
        }
        for (name, source) in BLOCKS.iter().flat_map(|(_, fields)| fields.iter()) {
            if let Named(source) = source {
                assert!(Feed::parse(&toml::Value::from(*source), &[]).is_ok(), "{name}: {source}");
            }
        }
        assert_eq!(
            hint("ThesisBlock", "view_direction_epsilon").as_deref(),
            Some("--direction-tolerance, published 0.00001")
        );
        assert_eq!((hint("ThesisBlock", "other"), hint("Other", "fade")), (None, None));
    }
}
