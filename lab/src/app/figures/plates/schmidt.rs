//! The figures of Schmidt 2013.

use crate::app::figures::draw;
use crate::app::figures::plate::{Document, Plate, QHD, Size};

/// The figures of Schmidt's thesis.
pub const PLATES: &[Plate] = &[
    Plate {
        source: Document::Schmidt,
        number: "27",
        title: "the G-buffer",
        print: "Positions and normals in world space (a) and view space (b), albedo and reflectance (c), the lit scene (d).",
        differs: "The generated street. Positions are not stored but recomputed from depth; each picture spans its own range.",
        prints: None,
        size: QHD,
        panels: &[("the frame", "--scene street --view street --dump inside")],
        make: draw::gbuffer,
    },
    Plate {
        source: Document::Schmidt,
        number: "28",
        title: "the scenes",
        print: "(a) The simple test scene, (b) the museum, (c) the cathedral.",
        differs: "The generated scenes, lit, without reflections; the street stands for the first.",
        prints: None,
        size: QHD,
        panels: &[
            ("(a) the street", "--scene street --view street --reflectivity 0"),
            ("(b) the museum", "--scene museum --view museum --reflectivity 0"),
            ("(c) the cathedral", "--scene cathedral --view nave --reflectivity 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "29",
        title: "a cube map as it is, and corrected for parallax",
        print: "Left: a common cube map, whose reflections do not meet the things that they show. Right: corrected for parallax. \
                The pictures are of others.",
        differs: "The generated corridor as a mirror without normal mapping, with the same captured maps on both sides.",
        prints: None,
        size: QHD,
        panels: &[
            (
                "left: local-map",
                "--scene corridor --view corridor --method local-map --roughness 0 --normal-deviation 0",
            ),
            ("right: pccm", "--scene corridor --view corridor --method pccm --roughness 0 --normal-deviation 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "32",
        title: "parallax-corrected cube maps in the street",
        print: "Left: without normal mapping; things inside the scene, such as the car, are not reflected. Right: close-up \
                with normal mapping.",
        differs: "The generated street; its maps are captured by this renderer at the scene's probes.",
        prints: None,
        size: QHD,
        panels: &[
            ("left: without normal mapping", "--scene street --view street --method pccm --normal-deviation 0"),
            ("right: with it, close up", "--scene street --view puddles --method pccm --normal-deviation 1"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "33",
        title: "parallax-corrected cube maps in the cathedral",
        print: "Left: a box is too simple a proxy for pillars and the walls behind them. Right: small errors of parallax at \
                clerestory and rose window.",
        differs: "The generated cathedral.",
        prints: None,
        size: QHD,
        panels: &[
            ("left: the nave", "--scene cathedral --view pillars --method pccm"),
            ("right: the clerestory", "--scene cathedral --view clerestory --method pccm"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "39",
        title: "billboard reflections in the street",
        print: "(a) Only the reflections, (b) without and (c) with normal mapping; below, details.",
        differs: "The generated street with its impostors; the details are parts of (c), enlarged.",
        prints: None,
        size: QHD,
        panels: &[
            (
                "(a) only the reflections",
                "--scene street --view street --method billboard --normal-deviation 0 --reflection-only",
            ),
            ("(b) without normal mapping", "--scene street --view street --method billboard --normal-deviation 0"),
            ("(c) with normal mapping", "--scene street --view street --method billboard --normal-deviation 1"),
        ],
        make: draw::with_details,
    },
    Plate {
        source: Document::Schmidt,
        number: "40",
        title: "billboard reflections in the museum",
        print: "The exit sign is reflected by the wall.",
        differs: "The generated museum, whose sign stands above a door in the polished wall.",
        prints: None,
        size: QHD,
        panels: &[("the hall", "--scene museum --view exit-sign --method billboard")],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "41",
        title: "missing occlusion",
        print: "A billboard's reflection on the street that the parked car should block.",
        differs: "The generated street. Beside it, what this program adds as an option: a billboard is hidden by what the \
                  depth buffer shows; and below, the ground truth, 16 rays a pixel.",
        prints: None,
        size: QHD,
        panels: &[
            ("left: billboards", "--scene street --view car --method billboard --roughness 0"),
            (
                "right: with a test against the depth buffer",
                "--scene street --view car --method billboard --roughness 0 --billboard-occlusion depth",
            ),
            ("below: world reference", "--scene street --view car --method reference --max-rays 16 --roughness 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "47",
        title: "screen-space reflections beside a ray traced image",
        print: "Left: ray traced off line with Mental Ray, about 10 minutes. Right: the optimised march with normal mapping, \
                about 20 frames a second at 1000 × 1000.",
        differs: "The ray traced image is this program's world reference, 16 rays a pixel, of mirrors, as the march knows no \
                  other surfaces.",
        prints: None,
        size: Size::Print([1000, 1000]),
        panels: &[
            ("left: world reference", "--scene street --view car --method reference --max-rays 16 --roughness 0"),
            ("right: ssr-fast", "--scene street --view car --method ssr-fast --roughness 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "48",
        title: "pixel steps of the march",
        print: "The brute-force march with growing steps: ribbons and holes.",
        differs: "Steps of 1, 5, 10 and 20 pixels, as the caption gives none; without normal mapping, so that the ribbons show.",
        prints: None,
        size: QHD,
        panels: &[
            ("step 1", "--scene street --view puddles --method ssr --roughness 0 --normal-deviation 0 --pixel-step 1"),
            ("step 5", "--scene street --view puddles --method ssr --roughness 0 --normal-deviation 0 --pixel-step 5"),
            (
                "step 10",
                "--scene street --view puddles --method ssr --roughness 0 --normal-deviation 0 --pixel-step 10",
            ),
            (
                "step 20",
                "--scene street --view puddles --method ssr --roughness 0 --normal-deviation 0 --pixel-step 20",
            ),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "49",
        title: "fading at the screen's border",
        print: "Left: reflections are clipped where the screen ends. Right: they fade out.",
        differs: "The generated museum; no line marks the edges.",
        prints: None,
        size: QHD,
        panels: &[
            ("left: clipped", "--scene museum --view museum --method ssr-fast --roughness 0 --fade off"),
            ("right: faded", "--scene museum --view museum --method ssr-fast --roughness 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "50",
        title: "the optimised march in the cathedral",
        print: "Above with normal mapping, below without.",
        differs: "The generated cathedral; here they stand left and right.",
        prints: None,
        size: QHD,
        panels: &[
            (
                "left: with normal mapping",
                "--scene cathedral --view nave --method ssr-fast --roughness 0 --normal-deviation 1",
            ),
            ("right: without", "--scene cathedral --view nave --method ssr-fast --roughness 0 --normal-deviation 0"),
        ],
        make: draw::place_side_by_side,
    },
    Plate {
        source: Document::Schmidt,
        number: "51",
        title: "what reflects in the scenes",
        print: "(a) The street, (b) the museum, (c) the cathedral: how much of each scene reflects, on which the time depends.",
        differs: "The generated scenes; a pixel is as bright as it reflects.",
        prints: None,
        size: QHD,
        panels: &[
            ("(a) the street", "--scene street --view street --dump inside"),
            ("(b) the museum", "--scene museum --view museum --dump inside"),
            ("(c) the cathedral", "--scene cathedral --view nave --dump inside"),
        ],
        make: draw::reflectivity,
    },
];
