//! The variants of Schmidt's methods for `cargo bench --bench errata`.

use super::edited::Edits;
use super::{Change, SAME, Variant, Views, changed, edited};
use ssct::methods::billboard::BillboardParams;
use ssct::methods::ssr_fast::SsrFastParams;
use ssct::passes::billboard::{Blur, Occlusion, Order};

const SCHMIDT: &str = "schmidt/screen_space_reflections.frag";
const BILLBOARDS: &str = "schmidt/billboard_reflections.glsl";
const RIGHT_EQ_28: Edits = &[(SCHMIDT, "camera.near_plane - z *", "camera.near_plane - (2.0 * z - 1.0) *")];

/// Interpolates depth between the four texels around a place.
const LINEAR_DEPTH: Edits = &[(
    SCHMIDT,
    "    float sampledDepth = linearizeDepth(1.0 - textureLod(DepthTex, samplingPosition, 0.0).r);",
    "    vec4 four = textureGather(DepthTex, samplingPosition);\n    vec2 share = fract(samplingPosition * camera.resolution - 0.5);\n    float sampledDepth = linearizeDepth(1.0 - mix(mix(four.w, four.z, share.x), mix(four.x, four.y, share.x), share.y));",
)];

/// Chooses the order "nearest", with which other variants are compared.
const NEAREST: Change = |s| s.with(|p: &mut BillboardParams| p.billboard_order = Order::Nearest);

/// The variants, in the order of the page of errata.
pub const VARIANTS: &[Variant] = &[
    edited(
        "ssr-turned",
        "ssr",
        Views::Mirrors,
        // A point behind the camera is taken half as far away as the camera's plane instead.
        &[(
            SCHMIDT,
            "    vsReflectionVector += vsPosition;",
            "    if (vsPosition.z + vsReflectionVector.z < camera.near_plane)\n        vsReflectionVector *= -0.5 * vsPosition.z / vsReflectionVector.z;\n    vsReflectionVector += vsPosition;",
        )],
    ),
    edited("ssr-eq-28", "ssr", Views::Mirrors, RIGHT_EQ_28),
    edited("ssr-fast-eq-28", "ssr-fast", Views::Mirrors, RIGHT_EQ_28),
    edited(
        "ssr-fast-step",
        "ssr-fast",
        Views::MirrorsAndCeiling,
        &[(
            SCHMIDT,
            "float initialStep = pixelSize.y;",
            "float initialStep = pixelSize.y * min(pixelSize.x, pixelSize.y);",
        )],
    ),
    edited(
        "ssr-steps",
        "ssr",
        Views::Mirrors,
        &[(
            SCHMIDT,
            "int sampleCount = max(int(camera.resolution.x), int(camera.resolution.y));",
            "int sampleCount = 2 * max(int(camera.resolution.x), int(camera.resolution.y));",
        )],
    ),
    edited(
        "ssr-fast-behind",
        "ssr-fast",
        Views::Mirrors,
        &[(SCHMIDT, "if (delta < 0.002) {", "if (delta < 0.002 && currentDepth > sampledDepth) {")],
    ),
    edited(
        "ssr-fast-break",
        "ssr-fast",
        Views::Mirrors,
        &[(SCHMIDT, "        // 79-81: count++", "        if (hit.w == PATH_LINEAR) break;")],
    ),
    Variant {
        name: "ssr-fast-blur",
        method: "ssr-fast",
        views: Views::Mirrors,
        base: |s| s.with(|p: &mut SsrFastParams| p.distance_blur = true),
        change: SAME,
        edits: &[(SCHMIDT, "int counter = 0;", "int counter = 1;")],
    },
    edited(
        "pccm-outside",
        "pccm",
        Views::Mirrors,
        &[(
            "schmidt/pccm.frag",
            "    return wsIntersection - wsCubeMapPosition;",
            "    return distance < 0.0 ? wsReflectionVector : wsIntersection - wsCubeMapPosition;",
        )],
    ),
    changed("billboard-unbroken", "billboard", Views::Billboards, |s| {
        s.with(|p: &mut BillboardParams| p.billboard_order = Order::Unbroken)
    }),
    Variant {
        base: |s| s.with(|p: &mut BillboardParams| p.billboard_order = Order::Unbroken),
        ..changed("billboard-nearest", "billboard", Views::Billboards, NEAREST)
    },
    Variant {
        base: NEAREST,
        ..changed("billboard-occlusion", "billboard", Views::Billboards, |s| {
            s.with(|p: &mut BillboardParams| p.billboard_occlusion = Occlusion::Depth)
        })
    },
    Variant {
        base: NEAREST,
        ..changed("billboard-roughness", "billboard", Views::Billboards, |s| {
            s.with(|p: &mut BillboardParams| p.billboard_blur = Blur::Roughness)
        })
    },
    Variant {
        base: NEAREST,
        ..changed("billboard-distance", "billboard", Views::Billboards, |s| {
            s.with(|p: &mut BillboardParams| p.billboard_blur = Blur::Distance)
        })
    },
    Variant {
        base: NEAREST,
        ..changed("billboard-glow", "billboard", Views::Billboards, |s| {
            s.with(|p: &mut BillboardParams| (p.billboard_glow, p.billboard_glow_width) = (0.5, 0.5))
        })
    },
    edited("ssr-linear-depth", "ssr", Views::Mirrors, LINEAR_DEPTH),
    edited("ssr-fast-linear-depth", "ssr-fast", Views::Mirrors, LINEAR_DEPTH),
    edited(
        "ssr-no-break",
        "ssr",
        Views::Mirrors,
        &[(
            SCHMIDT,
            "                hit = vec4(currentSamplePosition, PATH_LINEAR);\n                break;",
            "                hit = vec4(currentSamplePosition, PATH_LINEAR);",
        )],
    ),
    edited(
        "billboard-corner",
        "billboard",
        Views::Billboards,
        &[(
            BILLBOARDS,
            "return IntersectTriangle(rayOrigin, rayDirect, vert2, vert0, vert1);",
            "return IntersectTriangle(rayOrigin, rayDirect, vert0, vert1, vert2);",
        )],
    ),
    edited(
        "billboard-unbounded",
        "billboard",
        Views::Billboards,
        &[(
            BILLBOARDS,
            "        if (uvt.x > 0.0 && uvt.x < 1.0 &&\n            uvt.y > 0.0 && uvt.y < 1.0)\n        {",
            "        if (uvt.x > 0.0 && uvt.y > 0.0)\n        {",
        )],
    ),
];
