//! The table of the requests that an effect refuses, from which errors, the help of parameters and the page of options
//! are made. The functions that make captures and triangles also refuse requests without the scene that they need.

use super::setup::{BeyondScreen, CaptureCount, Setup, Tracer};
use super::{EffectParams, METHODS, MethodInfo};
use crate::error::{Error, Result};
use crate::passes::trace_normals::TraceNormals;

/// A request for an effect, as [`check`] looks at it.
pub struct EffectRequest<'a> {
    /// The method.
    pub info: &'a MethodInfo,
    /// The method's setup.
    pub setup: &'a Setup,
    /// The parameters of the effect around the method.
    pub effect: EffectParams,
    /// Whether the scene is known, and not a G-buffer alone.
    pub has_scene: bool,
    /// Whether rays can be followed through captures.
    pub has_captures: bool,
    /// Whether rays are traced among triangles.
    pub has_triangles: bool,
    /// The part of the scene that the caller gives beside a G-buffer.
    pub given_part: Option<GivenPart>,
}

/// A part of the scene that a caller gives beside a G-buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GivenPart {
    /// Captures: images of the scene from other places.
    Captures,
    /// The triangles of the scene with their tree.
    Triangles,
}

impl<'a> EffectRequest<'a> {
    /// Makes the request for a G-buffer without its scene, beside which the caller gives a part of the scene.
    pub fn beside_gbuffer(info: &'a MethodInfo, setup: &'a Setup, part: GivenPart) -> Self {
        Self {
            info,
            setup,
            effect: setup.effect(),
            has_scene: false,
            has_captures: part == GivenPart::Captures,
            has_triangles: part == GivenPart::Triangles,
            given_part: Some(part),
        }
    }

    /// Whether a method has all that it must see: the screen, the scene, or captures or triangles that it takes.
    fn suffices_for(&self, method: &MethodInfo) -> bool {
        let has_part = (method.takes_captures && self.has_captures) || (method.takes_triangles && self.has_triangles);
        self.has_scene || method.is_screen_space() || has_part
    }
}

/// A kind of request that is refused.
pub struct Exclusion {
    /// The parameter whose value is refused, or "method".
    pub parameter: &'static str,
    /// The case in which the value is refused, in the words of the page of options.
    pub refused: &'static str,
    /// Whether a request is of this kind.
    pub applies: fn(&EffectRequest) -> bool,
    message: fn(&EffectRequest) -> String,
}

const DRAWN_ANEW: &str = "captures without their scene cannot be drawn anew in frames";

/// The kinds of requests that are refused. If a request is of several kinds, the error is that of the first kind.
pub const EXCLUSIONS: &[Exclusion] = &[
    Exclusion {
        parameter: "captures",
        refused: "for captures that are given beside a G-buffer, if neither the method nor its fallback follows rays in captures",
        applies: |asked| {
            let fallback_takes_captures = asked.effect.fallback.method().is_some_and(|m| m.takes_captures);
            let is_any_taker = asked.info.takes_captures || fallback_takes_captures;
            asked.given_part == Some(GivenPart::Captures) && !is_any_taker
        },
        message: |asked| {
            format!(
                "the method {} follows no rays in captures; the methods unified and captures do, and the fallback \
                 captures behind every screen-space method",
                asked.info.name
            )
        },
    },
    Exclusion {
        parameter: "captures",
        refused: "as `camera` for captures that are given beside a G-buffer",
        applies: |asked| {
            asked.given_part == Some(GivenPart::Captures) && asked.effect.captures_wanted() == CaptureCount::Camera
        },
        message: |_| DRAWN_ANEW.into(),
    },
    Exclusion {
        parameter: "captures_per_frame",
        refused: "above 0 for captures that are given beside a G-buffer",
        applies: |asked| asked.given_part == Some(GivenPart::Captures) && asked.effect.captures_per_frame > 0,
        message: |_| DRAWN_ANEW.into(),
    },
    Exclusion {
        parameter: "captures_per_frame",
        refused: "for the capture at the camera",
        applies: |asked| {
            asked.has_captures
                && asked.given_part.is_none()
                && asked.effect.captures_wanted() == CaptureCount::Camera
                && asked.effect.captures_per_frame > 0
        },
        message: |_| {
            "captures per frame are for captures that stand: the one at the camera is drawn anew in each frame".into()
        },
    },
    Exclusion {
        parameter: "method",
        refused: "for triangles that are given beside a G-buffer, if the method follows no rays among triangles",
        applies: |asked| asked.given_part == Some(GivenPart::Triangles) && !asked.info.takes_triangles,
        message: |asked| {
            format!("the method {} follows no rays among triangles; the methods unified and traced do", asked.info.name)
        },
    },
    Exclusion {
        parameter: "beyond",
        refused: "as `none` and `captures` for triangles that are given beside a G-buffer",
        applies: |asked| {
            let excludes_triangles = matches!(asked.effect.beyond, BeyondScreen::None | BeyondScreen::Captures);
            asked.given_part == Some(GivenPart::Triangles) && excludes_triangles
        },
        message: |_| "triangles are given, and the parameter beyond says that no ray is followed among them".into(),
    },
    Exclusion {
        parameter: "tracer",
        refused: "as `query` for triangles that are given beside a G-buffer",
        applies: |asked| asked.given_part == Some(GivenPart::Triangles) && asked.effect.tracer == Tracer::Query,
        message: |_| {
            "triangles are given with their tree, and no ray query is asked among them: the tracer must be tree".into()
        },
    },
    Exclusion {
        parameter: "method",
        refused: "for a G-buffer alone, if the method needs the scene",
        applies: |asked| !asked.suffices_for(asked.info),
        message: |asked| format!("the method {} needs the scene; a G-buffer alone does not show it", asked.info.name),
    },
    Exclusion {
        parameter: "method",
        refused: "for an orthographic camera, if the method's formulas are made for a perspective",
        applies: |asked| asked.setup.projection.is_orthographic() && !asked.info.takes_orthographic,
        message: |asked| {
            let others: Vec<&str> = METHODS.iter().filter(|m| m.takes_orthographic).map(|m| m.name).collect();
            format!(
                "the method {} needs a perspective, which its published formulas are made for, and the camera is \
                 orthographic; these take both: {}",
                asked.info.name,
                others.join(", ")
            )
        },
    },
    Exclusion {
        parameter: "resolution_scale",
        refused: "below 1 for a method that is no screen-space method",
        applies: |asked| asked.effect.divisor() != 1 && !asked.info.is_screen_space(),
        message: |asked| {
            format!("a lower resolution scale is for screen-space methods, and {} is none", asked.info.name)
        },
    },
    Exclusion {
        parameter: "layers",
        refused: "as 2 for a G-buffer alone",
        applies: |asked| asked.info.takes_second_layer(asked.setup) && !asked.has_scene,
        message: |_| "a second layer of depth is drawn from the scene; a G-buffer alone does not have one".into(),
    },
    Exclusion {
        parameter: "trace_normals",
        refused: "as `geometric` and `up` for a method that is no screen-space method",
        applies: |asked| asked.effect.trace_normals != TraceNormals::Shading && !asked.info.is_screen_space(),
        message: |asked| {
            format!("other normals for rays are for screen-space methods, and {} is none", asked.info.name)
        },
    },
    Exclusion {
        parameter: "bounces",
        refused: "above 1 for a method that is no screen-space method",
        applies: |asked| asked.effect.bounces != 1 && !asked.info.is_screen_space(),
        message: |asked| format!("several bounces are for screen-space methods, and {} is none", asked.info.name),
    },
    Exclusion {
        parameter: "bounces",
        refused: "above 1 where rays go among triangles",
        applies: |asked| asked.effect.bounces != 1 && asked.has_triangles,
        message: |_| {
            "several bounces are for rays that end on the screen or in captures: what rays meet among triangles does not \
             reflect"
                .into()
        },
    },
    Exclusion {
        parameter: "bump_after",
        refused: "above 0 if rays are reflected at the normals of shading",
        applies: |asked| asked.effect.bump_after > 0.0 && asked.effect.trace_normals == TraceNormals::Shading,
        message: |_| {
            "bumps after the tracing need rays that were reflected at normals without them: trace-normals geometric or up"
                .into()
        },
    },
    Exclusion {
        parameter: "fallback",
        refused: "behind a method that is no screen-space method",
        applies: |asked| asked.effect.fallback.method().is_some() && !asked.info.is_screen_space(),
        message: |asked| {
            format!(
                "the fallback {}: only screen-space methods have a fallback, and {} is none",
                fallback_name(asked),
                asked.info.name
            )
        },
    },
    Exclusion {
        parameter: "fallback",
        refused: "for a G-buffer alone, if the fallback needs the scene",
        applies: |asked| asked.effect.fallback.method().is_some_and(|method| !asked.suffices_for(method)),
        message: |asked| {
            format!("the fallback {} needs the scene; a G-buffer alone does not show it", fallback_name(asked))
        },
    },
];

/// Returns the name of the method that is the fallback; "none" without a fallback.
fn fallback_name(asked: &EffectRequest) -> &'static str {
    asked.effect.fallback.method().map_or("none", |method| method.name)
}

/// Refuses a request that is of a kind in [`EXCLUSIONS`].
///
/// # Errors
/// [`Error::Usage`] with the message of the first such kind.
pub fn check(asked: &EffectRequest) -> Result<()> {
    match EXCLUSIONS.iter().find(|exclusion| (exclusion.applies)(asked)) {
        Some(exclusion) => Err(Error::Usage((exclusion.message)(asked))),
        None => Ok(()),
    }
}
