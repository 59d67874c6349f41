//! The figures of Hermanns 2015 and of the poster that preceded it.

use crate::app::figures::draw;
use crate::app::figures::plate::{Document, HD, Plate, PrintedScene, QHD, Size};

/// The note shared by all figures of the thesis's chapter 5.
const COMPARISON: &str = "The generated stand-in of the scene. The thesis gives no roughness for this figure; here \
    roughness and normal deviation are 0.1, those of table 5.8's rougher rows.";

/// The printed scene of figures in the author's rooms, and how such a figure differs from print if it is drawn in a
/// file of these rooms.
const IN_ROOMS: Option<(PrintedScene, &str)> = Some((
    PrintedScene::Rooms,
    "The scene of the print, from its file. Its images were never published: tiles, bricks, stone and wood are generated. \
     The place of the camera is chosen after the caption's words, and roughness and normal deviation are 0.1, as the thesis \
     gives neither.",
));

/// The printed scene of figures in Sponza, and how such a figure differs from print if it is drawn in a file of Sponza.
const IN_SPONZA: Option<(PrintedScene, &str)> = Some((
    PrintedScene::Sponza,
    "The scene of the print, from its file, with the light, the materials and the view of this file. The thesis gives \
     neither the place of the camera nor the roughness; roughness and normal deviation are 0.1.",
));

/// The figures of the thesis.
pub const PLATES: &[Plate] = &[
    Plate {
        source: Document::Thesis,
        number: "2.3",
        title: "specular and glossy reflections",
        print: "A corridor in a shiny environment with perfect specular reflections, and with glossy ones; the microfacets are \
                drawn beside them.",
        differs: "The rooms' corridor, by the world reference with 16 rays a pixel, roughness 0 and 0.3; no microfacets.",
        prints: None,
        size: QHD,
        panels: &[
            (
                "left: specular",
                "--scene rooms --view corridor --method reference --max-rays 16 --roughness 0 --normal-deviation 0",
            ),
            (
                "right: glossy",
                "--scene rooms --view corridor --method reference --max-rays 16 --roughness 0.3 --normal-deviation 0",
            ),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "2.4",
        title: "direct light, and direct and indirect light",
        print: "The Cornell box, path traced: (a) direct light, (b) direct and indirect light.",
        differs: "The box is generated after the published measures, with two blocks. 128 paths a pixel between diffuse \
                  surfaces, in which light is passed on up to six times.",
        prints: None,
        size: Size::Print([400, 400]),
        panels: &[
            (
                "(a) direct light, left",
                "--scene cornell-box --view box --method reference --diffuse-bounces 0 --max-rays 128",
            ),
            (
                "(b) with indirect light, right",
                "--scene cornell-box --view box --method reference --diffuse-bounces 6 --max-rays 128",
            ),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "3.1",
        title: "reflections of area lights",
        print: "Two analytic area lights above a floor that reflects them; of others.",
        differs: "The lamps of the generated corridor, whose highlights alone are drawn.",
        prints: None,
        size: QHD,
        panels: &[(
            "the floor",
            "--scene corridor --view corridor --method area-light --roughness 0.1 --normal-deviation 0",
        )],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "3.2",
        title: "a planar mirror",
        print: "A mirror in Quake III Arena that shows the player and the game's logo.",
        differs: "The floor of the generated museum.",
        prints: None,
        size: QHD,
        panels: &[("the floor", "--scene museum --view museum --method planar --roughness 0 --normal-deviation 0")],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "3.7",
        title: "the poster's method in the Sponza atrium",
        print: "(a) Specular reflections without roughness, (b) glossy ones of high roughness.",
        differs: "The generated atrium; roughness 0 and 0.3, as none is printed.",
        prints: Some((
            PrintedScene::Sponza,
            "The scene of the print, from its file, with the light and the view of this file; roughness 0 and 0.3, as none is \
             printed.",
        )),
        size: QHD,
        panels: &[
            ("(a) specular, left", "--scene atrium --view atrium --method poster --roughness 0 --normal-deviation 0"),
            ("(b) glossy, right", "--scene atrium --view atrium --method poster --roughness 0.3 --normal-deviation 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "4.1",
        title: "how a Hi-Z buffer is made of minima",
        print: "A depth buffer of numbers; four texels at a time become one with the least of them.",
        differs: "The numbers are the real chain of a view of the rooms at 8 × 8 pixels.",
        prints: None,
        size: Size::Fixed([8, 8]),
        panels: &[("depth and its chain", "--scene rooms --view cylinder --dump inside")],
        make: draw::even_chain,
    },
    Plate {
        source: Document::Thesis,
        number: "4.2",
        title: "odd sizes, without Eq. 4.1",
        print: "Always two by two texels: of an odd size the last row or column is lost, on every level anew.",
        differs: "The real depth of a view at 7 × 5 pixels, reduced by two by two. Red says what each cell lost.",
        prints: None,
        size: Size::Fixed([7, 5]),
        panels: &[("the depth", "--scene rooms --view cylinder --dump inside")],
        make: draw::undersized_chain,
    },
    Plate {
        source: Document::Thesis,
        number: "4.3",
        title: "odd sizes, with Eq. 4.1",
        print: "The second texel is taken one further where a side is odd: a wider range is captured.",
        differs: "The chain that the pass makes of the same depth. The edge is read now, but on an odd side every other \
                  texel inside is not: what is crossed out is an erratum of Alg. 3 (see ERRATA.md).",
        prints: None,
        size: Size::Fixed([7, 5]),
        panels: &[("depth and its chain", "--scene rooms --view cylinder --dump inside")],
        make: draw::odd_chain,
    },
    Plate {
        source: Document::Thesis,
        number: "4.4",
        title: "the chain of the visibility buffer",
        print: "All levels for 512 × 512 but level 0, which is white.",
        differs: "The corridor of the rooms.",
        prints: None,
        size: Size::Print([512, 512]),
        panels: &[("visibility", "--scene rooms --view corridor --figure 4.4")],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "4.5",
        title: "which rays take which way",
        print: "Rays away from the camera, by Hi-Z, in green; rays towards it, by the linear march, in red.",
        differs: "The same colours over the lit scene, darker where a ray met nothing.",
        prints: None,
        size: QHD,
        panels: &[("paths", "--scene rooms --view corridor --figure 4.5")],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "4.6",
        title: "a ray's way through the hierarchy",
        print: "A sketch: bars of the Hi-Z buffer, cell boundaries, the ray, and its level going up and down.",
        differs: "No sketch: the iterations of Alg. 4 for one pixel of the rooms at 96 × 54, by the shader's twin on the \
                  CPU, which a test holds against the GPU. Below, the level over the iterations, and the cells on \
                  the screen.",
        prints: None,
        size: Size::Fixed([96, 54]),
        panels: &[(
            "chain, normals and hits",
            "--scene rooms --view corridor --roughness 0 --normal-deviation 0 --dump inside",
        )],
        make: draw::ray,
    },
    Plate {
        source: Document::Thesis,
        number: "4.7",
        title: "the cone as a triangle with circles",
        print: "A sketch: an isosceles triangle with circles that touch, whose radii say the mip level.",
        differs: "The circles of Alg. 5 for one pixel and its hit, over the picture that they sample; roughness 0.2. The \
                  algorithm's unit is the screen's sides, so that circles are ellipses on a wide screen.",
        prints: None,
        size: QHD,
        panels: &[(
            "picture and hits",
            "--scene rooms --view corridor --roughness 0.2 --normal-deviation 0 --dump inside",
        )],
        make: draw::cone,
    },
    Plate {
        source: Document::Thesis,
        number: "4.8",
        title: "fading at the screen's border",
        print: "(a) Off: reflections end at sharp edges on the floor. (b) On: they fade out.",
        differs: "The floor before the window, a mirror.",
        prints: None,
        size: QHD,
        panels: &[
            ("(a) off, left", "--scene rooms --view window-floor --roughness 0 --normal-deviation 0 --fade off"),
            ("(b) on, right", "--scene rooms --view window-floor --roughness 0 --normal-deviation 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "4.9",
        title: "the chain of SSLR's ray trace colour",
        print: "The first five mip levels of the ray trace colour buffer.",
        differs: "The corridor of the rooms, roughness 0.1.",
        prints: None,
        size: QHD,
        panels: &[(
            "colour",
            "--scene rooms --view corridor --method sslr --figure 4.9 --roughness 0.1 --normal-deviation 0.1",
        )],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "4.10",
        title: "the chain of SSLR's mask",
        print: "The first five mip levels of the mask buffer.",
        differs: "The same frame as figure 4.9.",
        prints: None,
        size: QHD,
        panels: &[(
            "mask",
            "--scene rooms --view corridor --method sslr --figure 4.10 --roughness 0.1 --normal-deviation 0.1",
        )],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "5.1",
        title: "a cylinder that reflects the tiles",
        print: "SSCT beside HZCT, looking down at a wooden cylinder on the floor.",
        differs: COMPARISON,
        prints: IN_ROOMS,
        size: QHD,
        panels: &[
            (
                "(a) SSCT, left",
                "--scene rooms --eye=3.1,0.15,2.95 --look-at=2.97,-0.8,2.12 --method ssct --roughness 0.1 --normal-deviation 0.1",
            ),
            (
                "(b) HZCT, right",
                "--scene rooms --eye=3.1,0.15,2.95 --look-at=2.97,-0.8,2.12 --method hzct --roughness 0.1 --normal-deviation 0.1",
            ),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "5.2",
        title: "a window reflected by the floor",
        print: "HZCT catches a little of the window, SSCT more of it, and the floor in the front wall too; 2.25 against \
                1.12 ms.",
        differs: COMPARISON,
        prints: IN_ROOMS,
        size: QHD,
        panels: &[
            (
                "(a) SSCT, left",
                "--scene rooms --view window-floor --method ssct --roughness 0.1 --normal-deviation 0.1",
            ),
            (
                "(b) HZCT, right",
                "--scene rooms --view window-floor --method hzct --roughness 0.1 --normal-deviation 0.1",
            ),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "5.3",
        title: "the corridor",
        print: "SSCT beside SSLR along the corridor, and a part of the left wall enlarged, where SSCT keeps more detail.",
        differs: "The generated stand-in of the scene; roughness and normal deviation 0.1, as the thesis gives none. The \
                  enlarged part is framed; here it is four times as large, pixel by pixel.",
        prints: Some((
            PrintedScene::Rooms,
            "The scene of the print, from its file. Its images were never published: tiles, bricks, stone and wood are \
             generated. Roughness and normal deviation are 0.1, as the thesis gives none. The enlarged part is framed; here it \
             is four times as large, pixel by pixel.",
        )),
        size: QHD,
        panels: &[
            ("(a) SSCT, left", "--scene rooms --view corridor --method ssct --roughness 0.1 --normal-deviation 0.1"),
            ("(b) SSLR, right", "--scene rooms --view corridor --method sslr --roughness 0.1 --normal-deviation 0.1"),
        ],
        make: draw::corridor_with_wall,
    },
    Plate {
        source: Document::Thesis,
        number: "5.4",
        title: "two cylinders",
        print: "Many rays of the floor point towards the camera: SSCT is slower here, 3.94 against 1.30 ms of SSLR.",
        differs: COMPARISON,
        prints: IN_ROOMS,
        size: QHD,
        panels: &[
            (
                "(a) SSCT, left",
                "--scene rooms --view two-cylinders --method ssct --roughness 0.1 --normal-deviation 0.1",
            ),
            (
                "(b) SSLR, right",
                "--scene rooms --view two-cylinders --method sslr --roughness 0.1 --normal-deviation 0.1",
            ),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "5.5",
        title: "the window and its surrounding, with the difference",
        print: "SSCT is more precise and, at 1920 × 1080, faster: 6.83 against 9.08 ms; (c) is the differential image.",
        differs: "The generated stand-in of the scene, roughness and normal deviation 0.1. (c) is the absolute difference of the\
                  displayed values, times 2; the thesis does not say how it is scaled.",
        prints: Some((
            PrintedScene::Rooms,
            "The scene of the print, from its file, with generated images in place of those that were never published; roughness \
             and normal deviation 0.1. (c) is the absolute difference of the displayed values, times 2; the thesis does not say \
             how it is scaled.",
        )),
        size: HD,
        panels: &[
            ("(a) SSCT, left", "--scene rooms --view window --method ssct --roughness 0.1 --normal-deviation 0.1"),
            (
                "(b) SSLR, right; (c) below: |a − b| · 2",
                "--scene rooms --view window --method sslr --roughness 0.1 --normal-deviation 0.1",
            ),
        ],
        make: draw::with_difference,
    },
    Plate {
        source: Document::Thesis,
        number: "5.6",
        title: "the Sponza atrium",
        print: "Only the stone floor reflects; SSCT and SSLR take 1.20 ms each.",
        differs: COMPARISON,
        prints: IN_SPONZA,
        size: QHD,
        panels: &[
            ("(a) SSCT, left", "--scene atrium --view atrium --method ssct --roughness 0.1 --normal-deviation 0.1"),
            ("(b) SSLR, right", "--scene atrium --view atrium --method sslr --roughness 0.1 --normal-deviation 0.1"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "5.7",
        title: "the lion's head above a rough floor",
        print: "The head reflected on a rough surface; 0.74 ms for SSCT, 0.83 for SSLR.",
        differs: COMPARISON,
        prints: IN_SPONZA,
        size: QHD,
        panels: &[
            ("(a) SSCT, left", "--scene atrium --view lion --method ssct --roughness 0.1 --normal-deviation 0.1"),
            ("(b) SSLR, right", "--scene atrium --view lion --method sslr --roughness 0.1 --normal-deviation 0.1"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "5.8",
        title: "floor and walls of the atrium",
        print: "For long rays SSLR shows artefacts on the walls, from its constant step; table 5.8 times this view.",
        differs: COMPARISON,
        prints: IN_SPONZA,
        size: HD,
        panels: &[
            ("(a) SSCT, left", "--scene atrium --view hall --method ssct --roughness 0.1 --normal-deviation 0.1"),
            ("(b) SSLR, right", "--scene atrium --view hall --method sslr --roughness 0.1 --normal-deviation 0.1"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Thesis,
        number: "5.9",
        title: "the corridor beside the ground truth",
        print: "SSCT (2.87 ms) beside Mitsuba (04:05 min); SSCT's shading was dimmed, as Mitsuba's scene had no other light.",
        differs: "The ground truth is this program's own world reference: 16 rays a pixel of the same lobe against the \
                  triangles, lit as the G-buffer is, so that nothing needs dimming; a ray that leaves the scene is black.",
        prints: Some((
            PrintedScene::Rooms,
            "The scene of the print, from its file, with generated images in place of those that were never published. The \
             ground truth is this program's own world reference: 16 rays a pixel of the same lobe against the triangles, lit \
             as the G-buffer is, so that nothing needs dimming.",
        )),
        size: Size::Print([1280, 720]),
        panels: &[
            ("(a) SSCT, left", "--scene rooms --view corridor --method ssct --roughness 0.1 --normal-deviation 0.1"),
            (
                "(b) world reference, right",
                "--scene rooms --view corridor --method reference --max-rays 16 --roughness 0.1 --normal-deviation 0.1",
            ),
        ],
        make: draw::place_side_by_side,
    },
];

/// The figure of the poster.
pub const POSTER: &[Plate] = &[Plate {
    source: Document::Poster,
    number: "2",
    title: "the cone march through a pre-filtered G-buffer",
    print: "(a) Filtering by mip-mapping may cause artifacts; (b) the Gaussian filter is smoother; (c) with fading at \
                the screen's edge.",
    differs: "The corridor of the rooms, roughness 0.3.",
    prints: None,
    size: QHD,
    panels: &[
        ("(a) mip-mapping", "--scene rooms --view corridor --figure poster-2a --roughness 0.3"),
        ("(b) Gaussian filter", "--scene rooms --view corridor --figure poster-2b --roughness 0.3"),
        ("(c) with fading", "--scene rooms --view corridor --figure poster-2c --roughness 0.3"),
    ],
    make: draw::place_side_by_side,
}];
