//! The table of complaints: the complaint of users, the scene and frames that show it, and the number that measures it.

use super::frames::{CaseInput, Frame, SeenFrame};
use super::measures::{
    blackened, cell_changes, change_error, change_error_at_rest, changed_from_first, error_at_last, everywhere,
    excess_of_red, near_close_surface, no_edge, no_edge_and_shown, percent_wrong_at_last, pixel_changes,
    spread_of_wrong,
};
use super::scenes;
use glam::{DVec3, Vec3};
use ssct::methods::EffectParams;
use ssct::methods::setup::HistoryUse;
use ssct_ground::math::random::Stream;
use ssct_scenes::{GBufferData, Scene};

/// A complaint, with a case that shows it.
pub struct Complaint {
    /// Name of the case.
    pub name: &'static str,
    /// The complaint, in one sentence.
    pub complaint: &'static str,
    /// Meaning of the number.
    pub measured: &'static str,
    /// Greatest number that counts as good.
    pub at_most: f64,
    /// Makes the scene and the frames of the case, at a size in pixels.
    pub input: fn([u32; 2]) -> CaseInput,
    /// Computes the number of a variant, given by its index; `None` if the variant shows too little to be judged.
    pub number: fn(&[SeenFrame], usize) -> Option<f64>,
    /// Whether the frames follow each other in a film. Otherwise they show one view under several settings.
    pub is_film: bool,
}

/// Rays a pixel of the true reflection in cases with mirrors.
const MIRROR_RAYS: u32 = 16;
/// Rays a pixel of the true reflection in cases with glossy surfaces.
const GLOSS_RAYS: u32 = 96;

/// Number of frames of a film.
const FRAMES: usize = 8;

/// Every complaint.
pub const COMPLAINTS: &[Complaint] = &[
    Complaint {
        name: "gap of sky",
        complaint: "A reflection vanishes where its ray passes over sky on its way.",
        measured: "pixels of the tower's reflection that are wrong, %",
        at_most: 5.0,
        input: |size| still(scenes::sky_gap(), size, MIRROR_RAYS),
        number: |frames, variant| {
            Some(percent_wrong_at_last(frames, variant, |seen, i| no_edge(seen, i) && seen.end_meshes[i] == "tower"))
        },
        is_film: false,
    },
    Complaint {
        name: "thin poles",
        complaint: "Thin poles leave streaks in the reflections of what is behind them.",
        measured: "pixels that are wrong where the mirrored wall shows no pole, %",
        at_most: 2.0,
        input: |size| still(scenes::poles(), size, MIRROR_RAYS),
        number: |frames, variant| {
            Some(percent_wrong_at_last(frames, variant, |seen, i| {
                no_edge_and_shown(seen, i) && seen.place(i).x > 2.99 && seen.end_meshes[i] != "poles"
            }))
        },
        is_film: false,
    },
    Complaint {
        name: "grazing floor",
        complaint: "A rough floor mirrors, or shows stripes, where it is seen at a grazing angle.",
        measured: "error of the floor's reflection over the truth's own, %",
        at_most: 20.0,
        input: |size| still(scenes::grazing(), size, GLOSS_RAYS),
        number: |frames, variant| Some(error_at_last(frames, variant, everywhere)),
        is_film: false,
    },
    Complaint {
        name: "far over near",
        complaint: "Bands appear as the far plane moves away from the near plane.",
        measured: "pixels that another pair of planes changes, at most, %",
        at_most: 0.5,
        input: planes,
        number: |frames, variant| Some(changed_from_first(frames, variant, no_edge)),
        is_film: false,
    },
    Complaint {
        name: "odd sizes",
        complaint: "Rays hit the wrong places at sizes that are not powers of two.",
        measured: "wrong pixels at the worst size less those at the best, percentage points",
        at_most: 1.0,
        input: sizes,
        number: |frames, variant| Some(spread_of_wrong(frames, variant, no_edge_and_shown)),
        is_film: false,
    },
    Complaint {
        name: "camera's distance",
        complaint: "A reflection gets shorter or longer as the camera moves away.",
        measured: "wrong pixels of the pillar's reflection at the worst distance less those at the best, percentage points",
        at_most: 5.0,
        input: distances,
        number: |frames, variant| {
            Some(spread_of_wrong(frames, variant, |seen, i| {
                no_edge_and_shown(seen, i) && seen.end_meshes[i] == "pillar"
            }))
        },
        is_film: false,
    },
    Complaint {
        name: "gloss at silhouettes",
        complaint: "The blur of a glossy reflection stops at the silhouettes of what is reflected.",
        measured: "error near silhouettes over the truth's own, %",
        at_most: 20.0,
        input: |size| still(scenes::silhouettes(), size, GLOSS_RAYS),
        number: |frames, variant| Some(error_at_last(frames, variant, |seen, i| !seen.is_alike_around(i, 5))),
        is_film: false,
    },
    Complaint {
        name: "black metal",
        complaint: "Surfaces that reflect are black in reflections.",
        measured: "pixels of the metal's reflection that are wrong with one bounce, %",
        at_most: 5.0,
        input: |size| CaseInput { bounces: 2, ..still(scenes::metal(), size, MIRROR_RAYS) },
        number: |frames, variant| Some(percent_wrong_at_last(frames, variant, reflects_metal)),
        is_film: false,
    },
    Complaint {
        name: "black metal, two bounces",
        complaint: "Surfaces that reflect are black in reflections, even where several bounces are asked for.",
        measured: "pixels of the metal's reflection that are wrong with two bounces, %",
        at_most: 20.0,
        input: |size| CaseInput {
            bounces: 2,
            change_setup: |setup| setup.with(|p: &mut EffectParams| p.bounces = 2),
            ..still(scenes::metal(), size, MIRROR_RAYS)
        },
        number: |frames, variant| Some(percent_wrong_at_last(frames, variant, reflects_metal)),
        is_film: false,
    },
    Complaint {
        name: "half resolution",
        complaint: "Reflections that are traced at half the resolution shimmer as the camera moves.",
        measured: "how far changes of a pixel from frame to frame are off the truth's, over the truth's own changes, %",
        at_most: 100.0,
        input: |size| CaseInput {
            change_setup: |setup| setup.with(|p: &mut EffectParams| p.resolution_scale = 0.5),
            // The camera turns slowly.
            ..motion(scenes::blocks("blocks", 0.0), size, MIRROR_RAYS, |n, frame| frame.view.look_at.x += 0.012 * n)
        },
        number: |frames, variant| change_error(frames, variant, pixel_changes),
        is_film: true,
    },
    Complaint {
        name: "black flicker",
        complaint: "Black spots flicker where a pixel of the colour is no number.",
        measured: "pixels that are no number, or wrongly black, in the worst frame, %",
        at_most: 0.5,
        input: |size| CaseInput {
            spoil: Some(spoil_by_nan),
            ..repeated(scenes::blocks("blocks", 0.2), size, GLOSS_RAYS, FRAMES)
        },
        number: |frames, variant| Some(blackened(frames, variant, everywhere)),
        is_film: true,
    },
    Complaint {
        name: "ghost of a thing",
        complaint: "A thing that moves leaves a ghost in reflections that are averaged over frames.",
        measured: "how much of the thing's colour is left where its reflection was in earlier frames, with a history, %",
        at_most: 1.0,
        input: |size| {
            with_history(motion(scenes::moving(), size, GLOSS_RAYS, |n, frame| {
                frame.moved = vec![("thing", 0.45 * n * Vec3::X)];
            }))
        },
        number: red_left,
        is_film: true,
    },
    Complaint {
        name: "ghost of a weapon",
        complaint: "A weapon that is held before the camera leaves a ghost around itself as the camera moves.",
        measured: "wrong pixels of the floor around the weapon, with a history, %",
        at_most: 5.0,
        input: |size| {
            with_history(motion(scenes::weapon(), size, MIRROR_RAYS, |n, frame| {
                let step = 0.1 * n * Vec3::X;
                (frame.view.eye, frame.view.look_at) = (frame.view.eye + step, frame.view.look_at + step);
                frame.moved = vec![("weapon", step)];
            }))
        },
        number: |frames, variant| {
            let is_beside = |seen: &SeenFrame, i| no_edge_and_shown(seen, i) && near_close_surface(seen, i);
            Some(percent_wrong_at_last(frames, variant, is_beside))
        },
        is_film: true,
    },
    Complaint {
        name: "jittered projection",
        complaint: "Reflections shake under a projection that is jittered from frame to frame.",
        measured: "how far changes of a pixel from frame to frame are off the truth's, over the truth's colour, %",
        at_most: 5.0,
        input: |size| {
            motion(scenes::blocks("blocks", 0.0), size, MIRROR_RAYS, |n, frame| {
                let random = Stream::new(3, n as u64);
                frame.jitter_px = [0, 1].map(|axis| random.uniform(axis) as f32 - 0.5);
            })
        },
        number: |frames, variant| change_error_at_rest(frames, variant, pixel_changes),
        is_film: true,
    },
    Complaint {
        name: "transparent colour",
        complaint: "The colour of a pane, which has no depth, leaks into reflections that do not meet the pane.",
        measured: "pixels behind the pane whose reflection is wrong, %",
        at_most: 2.0,
        input: |size| CaseInput { spoil: Some(blend_pane), ..still(scenes::pane(), size, MIRROR_RAYS) },
        number: |frames, variant| {
            Some(percent_wrong_at_last(frames, variant, |seen, i| {
                no_edge_and_shown(seen, i) && seen.place(i).z > PANE_Z && seen.place(i).x.abs() < 1.0
            }))
        },
        is_film: false,
    },
    Complaint {
        name: "fine pattern far away",
        complaint: "Fine patterns become moiré in reflections that are far away.",
        measured: "error of the stripes' reflection over the truth's own, %",
        at_most: 20.0,
        input: |size| still(scenes::stripes(), size, GLOSS_RAYS),
        number: |frames, variant| {
            Some(error_at_last(frames, variant, |seen, i| seen.end_meshes[i] == "stripes" && seen.place(i).z > 4.0))
        },
        is_film: false,
    },
    Complaint {
        name: "dynamic resolution",
        complaint: "Reflections flicker while the resolution changes from frame to frame.",
        measured: "how far changes of the picture's parts from frame to frame are off the truth's, over the truth's colour, %",
        at_most: 3.0,
        input: resolutions,
        number: |frames, variant| change_error_at_rest(frames, variant, cell_changes),
        is_film: true,
    },
];

/// Makes a number of equal frames of a scene from its first view. `size` is in pixels, and `rays` is the number of rays
/// a pixel of the true reflection.
fn repeated(scene: Scene, size: [u32; 2], rays: u32, frames: usize) -> CaseInput {
    let view = scene.views.first().cloned().unwrap_or_default();
    let frames = vec![Frame::still(view, size); frames];
    CaseInput { scene, frames, change_setup: |setup| setup, bounces: 1, rays, spoil: None }
}

/// Makes one frame of a scene from its first view.
fn still(scene: Scene, size: [u32; 2], rays: u32) -> CaseInput {
    repeated(scene, size, rays, 1)
}

/// Makes a film of a scene; `change` modifies each frame according to its number, which is counted from 0.
fn motion(scene: Scene, size: [u32; 2], rays: u32, change: fn(f32, &mut Frame)) -> CaseInput {
    varied::<FRAMES>(scene, size, rays, |n, frame| change(n as f32, frame))
}

/// Replaces the change of the methods' setup in a case by one that turns the history on.
fn with_history(input: CaseInput) -> CaseInput {
    CaseInput { change_setup: |setup| setup.with(|p: &mut EffectParams| p.history = HistoryUse::On), ..input }
}

/// Makes `N` frames of a scene; `change` modifies each frame according to its number, which is counted from 0.
fn varied<const N: usize>(scene: Scene, size: [u32; 2], rays: u32, change: impl Fn(usize, &mut Frame)) -> CaseInput {
    let mut input = repeated(scene, size, rays, N);
    input.frames.iter_mut().enumerate().for_each(|(n, frame)| change(n, frame));
    input
}

/// Makes frames whose far plane is a thousand to a thousand million times as far away as the near plane.
fn planes(size: [u32; 2]) -> CaseInput {
    const PLANES: [[f32; 2]; 4] = [[0.1, 100.0], [0.1, 10_000.0], [0.01, 100_000.0], [0.001, 1_000_000.0]];
    varied::<4>(scenes::blocks("blocks", 0.0), size, MIRROR_RAYS, |n, frame| {
        let [near, far] = PLANES[n];
        frame.view.lens = Some(scenes::lens(near, far));
    })
}

/// Makes a frame whose sides are powers of two, frames that are a pixel smaller and larger, and one that lies between
/// powers.
fn sizes(size: [u32; 2]) -> CaseInput {
    let height = 1_i32 << size[1].ilog2();
    let width = 2 * height;
    let extents = [[0, 0], [-1, -1], [1, 1], [height / 2 + 1, height / 4 + 1]]
        .map(|[more_width, more_height]| [width + more_width, height + more_height].map(|side: i32| side as u32));
    varied::<4>(scenes::blocks("blocks", 0.0), size, MIRROR_RAYS, |n, frame| frame.extent = extents[n])
}

/// Makes frames of a camera that moves back from one frame to the next.
fn distances(size: [u32; 2]) -> CaseInput {
    const BACK_M: [f32; 4] = [0.0, 4.0, 12.0, 28.0];
    varied::<4>(scenes::pillar(), size, MIRROR_RAYS, |n, frame| frame.view.eye.z -= BACK_M[n])
}

/// Makes a film of glossy surfaces, with a history, a camera at rest, and another size of the image in each frame.
fn resolutions(size: [u32; 2]) -> CaseInput {
    const SHARES: [f32; FRAMES] = [1.0, 0.9, 0.8, 0.95, 0.7, 0.85, 1.0, 0.75];
    with_history(varied::<FRAMES>(scenes::blocks("blocks", 0.15), size, GLOSS_RAYS, |n, frame| {
        frame.extent = size.map(|side| (side as f32 * SHARES[n]) as u32);
    }))
}

/// Whether a pixel reflects the metal, and its neighbours do, too.
fn reflects_metal(seen: &SeenFrame, pixel: usize) -> bool {
    no_edge(seen, pixel) && seen.end_meshes[pixel] == "metal"
}

/// Computes how much of the moving block's red is left in the last frame, in percent. The pixels that count are those
/// whose mirror ray met the block, the mesh "thing", in an earlier frame and does not in the last. `None` without
/// frames.
fn red_left(frames: &[SeenFrame], variant: usize) -> Option<f64> {
    let (last, earlier) = frames.split_last()?;
    let was_met = |i: &usize| earlier.iter().any(|seen| seen.end_meshes[*i] == "thing");
    let ghost_pixels = last.pixels(|seen, i| no_edge(seen, i) && seen.end_meshes[i] != "thing").filter(was_met);
    Some(excess_of_red(last, variant, ghost_pixels, scenes::RED))
}

/// Replaces the colour of some pixels that do not reflect by NaN, in the G-buffer of the frame with number `frame`.
fn spoil_by_nan(data: &mut GBufferData, frame: usize) {
    // Every 211th pixel is tried, and the choice moves on by 37 pixels in each frame.
    for pixel in (0..data.depth.len()).filter(|pixel| (pixel + 37 * frame).is_multiple_of(211)) {
        if !data.reflects(pixel) {
            data.color[pixel] = Vec3::NAN;
        }
    }
}

/// The plane of the pane: world z, in metres.
const PANE_Z: f64 = 3.0;
/// World x of the left and the right side of the pane, in metres.
const PANE_X: [f64; 2] = [-1.0, 1.0];
/// World y of the lower and the upper side of the pane, in metres.
const PANE_Y: [f64; 2] = [0.2, 2.6];
/// Opacity of the pane.
const PANE_OPACITY: f32 = 0.6;

/// Blends the red of a pane over the colour of each pixel that is seen through it, as renderers do that draw
/// transparent surfaces last. Depth and normals stay as they are. The frame's number is not used.
fn blend_pane(data: &mut GBufferData, _: usize) {
    let clip_to_view = data.view_to_clip().inverse();
    let view_to_world = data.camera.world_to_view.as_dmat4().inverse();
    let eye = data.camera.eye().as_dvec3();
    for i in 0..data.depth.len() {
        let [x, y] = [i as u32 % data.width, i as u32 / data.width].map(|v| f64::from(v) + 0.5);
        let depth = f64::from(data.depth[i]);
        let surface: DVec3 = view_to_world.transform_point3(data.unproject(x, y, depth, &clip_to_view));
        // The point at which the line of sight crosses the plane of the pane.
        let crossing = eye + (surface - eye) * ((PANE_Z - eye.z) / (surface.z - eye.z));
        let is_within = |range: [f64; 2], place: f64| (range[0]..range[1]).contains(&place);
        if surface.z > PANE_Z && is_within(PANE_X, crossing.x) && is_within(PANE_Y, crossing.y) {
            data.color[i] = data.color[i].lerp(scenes::RED, PANE_OPACITY);
        }
    }
}
