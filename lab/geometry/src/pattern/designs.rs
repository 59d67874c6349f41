//! The formulas of the patterns: each makes a function that gives the relief in metres and the linear albedo at a texel
//! of the image. One height function determines both the picture and the normal map.

use super::{SIZE, Texel};
use glam::{IVec2, Vec2, Vec3};
use ssct_ground::math::noise::{VoronoiCells, fractal_image, smoothstep, unit};
use std::f32::consts::TAU;

/// [`SIZE`], as a number of elements.
const SIDE: usize = SIZE as usize;

/// A pattern at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Height of the relief above an arbitrary plane, in metres.
    pub height_m: f32,
    /// Linear albedo, 0…1.
    pub albedo: Vec3,
}

/// A pattern: a function of a texel.
pub type Design = Box<dyn Fn(Texel) -> Sample + Sync>;

/// A function that gives a number for each texel.
pub type Grain = Box<dyn Fn(Texel) -> f32 + Sync>;

/// Makes noise from 0 to 1 over the whole image. `frequency` is the number of lattice cells along the width and the
/// height, and each further octave has twice the frequency and half the weight.
fn grain(frequency: [i32; 2], octaves: u32, seed: u32) -> Grain {
    let image = fractal_image((frequency.into(), octaves, seed), SIDE, 0..SIDE, 0..SIDE);
    Box::new(move |texel| image[texel.index])
}

/// Makes noise like [`grain`], with a seed that depends on the texture coordinates, so that each tile or plank has
/// noise of its own. Noise is computed at once for a run of texels with the same seed in one row.
fn grain_with_seeds(frequency: [i32; 2], octaves: u32, seed: impl Fn(Vec2) -> u32) -> Grain {
    let seeds: Vec<u32> = (0..SIZE * SIZE).map(|index| seed(Texel::new(index, [SIZE, SIZE]).uv)).collect();
    let mut image = Vec::with_capacity(seeds.len());
    for (row, seeds) in seeds.chunks_exact(SIDE).enumerate() {
        for run in seeds.chunk_by(|a, b| a == b) {
            let columns = image.len() % SIDE..image.len() % SIDE + run.len();
            image.extend(fractal_image((frequency.into(), octaves, run[0]), SIDE, row..row + 1, columns));
        }
    }
    Box::new(move |texel| image[texel.index])
}

/// Irregular stones in mortar; the image is `size_m` metres wide. `face` is 0 in the mortar and 1 on a stone, and
/// `dome` rises from the border of a stone to its middle.
pub fn stones(size_m: f32) -> Design {
    let wobble_x = grain([20, 20], 3, 11);
    let wobble_y = grain([20, 20], 3, 17);
    let roughness = grain([24, 24], 4, 29);
    let sand = grain([64, 64], 2, 41);
    let grid = IVec2::new(8, 14);
    let cells = VoronoiCells::new(Vec2::splat(size_m) / grid.as_vec2(), grid, 0.75, 23);
    Box::new(move |texel| {
        let uv = texel.uv;
        let wobble = Vec2::new(wobble_x(texel), wobble_y(texel)) - 0.5;
        let cell = cells.cell(uv * size_m + wobble * 0.045);
        let face = smoothstep(0.004, 0.022, cell.border);
        let dome = 1.0 - (1.0 - (cell.border / 0.07).min(1.0)).powi(2);
        let rough = roughness(texel);
        let tone = unit(cell.id, 31);
        let warm = Vec3::new(0.34, 0.26, 0.18);
        let cool = Vec3::new(0.25, 0.245, 0.235);
        let shade = 0.65 + 0.6 * unit(cell.id, 37);
        let stone = warm.lerp(cool, tone) * shade * (0.65 + 0.7 * rough);
        let mortar = Vec3::new(0.30, 0.28, 0.25) * (0.6 + 0.4 * sand(texel));
        Sample {
            height_m: face * (0.006 + 0.004 * dome + 0.005 * rough) + 0.001 * rough,
            albedo: mortar.lerp(stone, face),
        }
    })
}

/// The parameters of a kind of square tile.
pub struct TileLook {
    /// Number of tiles along each side of the image.
    pub count: i32,
    /// Whether odd rows are shifted by half a tile; `count` must then be even.
    pub staggered: bool,
    /// Linear albedo of the palest and the darkest tile.
    pub tones: [Vec3; 2],
    /// Linear albedo between the tiles.
    pub grout: Vec3,
}

/// Square tiles with flat faces, which reflect like clear mirrors, and rounded edges; the image is `size_m` metres
/// wide. `face` is 0 in the grout and 1 on a tile.
pub fn tiles(size_m: f32, look: &'static TileLook) -> Design {
    // Returns the point in units of a tile, measured from the corner of the first tile of its row.
    let to_tile_units = |uv: Vec2| {
        let row = (uv.y * look.count as f32).floor();
        let shift = if look.staggered && row.rem_euclid(2.0) == 1.0 { 0.5 } else { 0.0 };
        uv * look.count as f32 + Vec2::new(shift, 0.0)
    };
    let tile_id = |in_tiles: Vec2| in_tiles.floor().as_ivec2().rem_euclid(IVec2::splat(look.count));
    // Makes noise whose seed differs by `column_step` from one column of tiles to the next, and by 1 between rows.
    let grain_by_tile = |frequency, octaves, seed: u32, column_step: i32| {
        let tile = |uv| tile_id(to_tile_units(uv));
        grain_with_seeds(frequency, octaves, |uv| seed + (tile(uv).x * column_step + tile(uv).y) as u32)
    };
    let [veining, cloudiness] = [grain_by_tile([5, 5], 5, 43, 7), grain_by_tile([9, 9], 4, 45, 5)];
    let specks = grain([96, 96], 2, 47);
    Box::new(move |texel| {
        let in_tiles = to_tile_units(texel.uv);
        let (id, inside) = (tile_id(in_tiles), in_tiles - in_tiles.floor());
        // The distance to the edge of the tile, in metres.
        let edge = (0.5 - (inside - 0.5).abs()).min_element() * size_m / look.count as f32;
        let face = smoothstep(0.003, 0.012, edge);
        let veins = (veining(texel) - 0.5).abs();
        let clouds = cloudiness(texel);
        let speckle = specks(texel);
        let tone = 0.75 * unit(id, 53) + 0.25 * speckle;
        let tile = look.tones[0].lerp(look.tones[1], tone)
            * (1.0 - 0.13 * smoothstep(0.04, 0.0, veins))
            * (0.62 + 0.3 * clouds + 0.4 * speckle);
        Sample { height_m: 0.004 * face, albedo: look.grout.lerp(tile, face) }
    })
}

/// Bricks in running bond, six across and eighteen up; the image is `size_m` metres wide. `face` is 0 in the mortar and
/// 1 on a brick.
pub fn bricks(size_m: f32) -> Design {
    let wobble_x = grain([30, 30], 2, 59);
    let wobble_y = grain([30, 30], 2, 61);
    let roughness = grain([40, 40], 4, 67);
    let sand = grain([80, 80], 2, 79);
    Box::new(move |texel| {
        let uv = texel.uv;
        let count = IVec2::new(6, 18);
        let wobble = Vec2::new(wobble_x(texel), wobble_y(texel)) - 0.5;
        let in_bricks = uv * count.as_vec2() + wobble * Vec2::new(0.03, 0.08);
        let row = in_bricks.y.floor();
        let shifted = in_bricks + Vec2::new(if row.rem_euclid(2.0) == 1.0 { 0.5 } else { 0.0 }, 0.0);
        let id = shifted.floor().as_ivec2().rem_euclid(count);
        // The distances to the nearest upright and the nearest level edge, in metres.
        let to_edge = (0.5 - (shifted - shifted.floor() - 0.5).abs()) * size_m / count.as_vec2();
        let face = smoothstep(0.004, 0.011, to_edge.min_element());
        let rough = roughness(texel);
        let red = Vec3::new(0.33, 0.13, 0.075);
        let ochre = Vec3::new(0.36, 0.21, 0.12);
        let burnt = 0.6 + 0.6 * unit(id, 73);
        let brick = red.lerp(ochre, unit(id, 71)) * burnt * (0.6 + 0.8 * rough);
        let mortar = Vec3::new(0.33, 0.30, 0.26) * (0.6 + 0.5 * sand(texel));
        let lift = 0.001 * unit(id, 83);
        Sample { height_m: face * (0.005 + lift) + 0.0012 * rough, albedo: mortar.lerp(brick, face) }
    })
}

/// Ten planks along the image's width, with one joint in each; the image is `size_m` metres wide, and `tone` is the
/// linear albedo of pale grain. `face` is 0 in the seams and joints and 1 on a plank.
pub fn wood(size_m: f32, tone: Vec3) -> Design {
    let planks = 10;
    let to_plank_units = move |uv: Vec2| uv.y * planks as f32;
    let plank_id = move |in_planks: f32| (in_planks.floor() as i32).rem_euclid(planks);
    let grain_by_plank = |frequency, octaves, seed: u32| {
        grain_with_seeds(frequency, octaves, |uv| seed + 97 * plank_id(to_plank_units(uv)) as u32)
    };
    let [bending, streakiness] = [grain_by_plank([3, 10], 3, 89), grain_by_plank([6, 150], 2, 96)];
    Box::new(move |texel| {
        let uv = texel.uv;
        let in_planks = to_plank_units(uv);
        let id = IVec2::new(0, plank_id(in_planks));
        let from_joint = uv.x - unit(id, 101);
        let to_joint = (from_joint - from_joint.round()).abs() * size_m;
        let across = in_planks - in_planks.floor();
        let to_seam = (0.5 - (across - 0.5).abs()) * size_m / planks as f32;
        let face = smoothstep(0.001, 0.006, to_seam.min(to_joint));
        let bend = bending(texel);
        let rings = 0.5 + 0.5 * (TAU * (across * 2.5 + 3.5 * bend)).sin();
        let streaks = streakiness(texel);
        let dark = 0.45 * rings * rings + 0.55 * streaks;
        let brightness = 0.75 + 0.5 * unit(id, 107);
        let albedo = tone.lerp(tone * Vec3::new(0.42, 0.34, 0.28), dark) * brightness;
        Sample { height_m: 0.0014 * face - 0.0003 * streaks, albedo: albedo * (0.25 + 0.75 * face) }
    })
}

/// Pale cut stone with faint clouds and pits, for columns, arches and vases.
pub fn limestone() -> Design {
    let cloudiness = grain([4, 4], 5, 109);
    let roughness = grain([72, 72], 2, 113);
    Box::new(move |texel| {
        let clouds = cloudiness(texel);
        // Pits lie where the noise is low; the falling limits make them 1 there.
        let pits = smoothstep(0.27, 0.15, roughness(texel));
        let warm = Vec3::new(0.46, 0.40, 0.31);
        let albedo = warm * (0.65 + 0.6 * clouds) * (1.0 - 0.25 * pits);
        Sample { height_m: 0.010 * clouds - 0.0012 * pits, albedo }
    })
}

/// Hand-smoothed plaster with stains.
pub fn plaster() -> Design {
    let smoothing = grain([8, 8], 4, 127);
    let dampness = grain([3, 3], 4, 131);
    Box::new(move |texel| {
        let strokes = smoothing(texel);
        let stains = smoothstep(0.45, 0.75, dampness(texel));
        let clean = Vec3::new(0.50, 0.44, 0.34);
        let albedo = clean.lerp(Vec3::new(0.36, 0.30, 0.22), 0.7 * stains) * (0.85 + 0.3 * strokes);
        Sample { height_m: 0.006 * strokes, albedo }
    })
}

/// Plaster that was smoothed and painted evenly.
pub fn stucco() -> Design {
    let smoothing = grain([10, 10], 4, 223);
    Box::new(move |texel| {
        let strokes = smoothing(texel);
        Sample { height_m: 0.003 * strokes, albedo: Vec3::new(0.51, 0.49, 0.45) * (0.94 + 0.12 * strokes) }
    })
}

/// Woven cloth of the linear albedo `dye`, with a golden ornament: the rim and the heart of four by four lozenges.
pub fn cloth(dye: Vec3) -> Design {
    let fading = grain([6, 6], 3, 137);
    Box::new(move |texel| {
        let uv = texel.uv;
        let threads = 64.0;
        let warp = (TAU * uv.x * threads).cos();
        let weft = (TAU * uv.y * threads).cos();
        let weave = 0.5 + 0.25 * (warp + weft);
        let lozenge = ((uv * 4.0).fract_gl() - 0.5).abs();
        let rim = (lozenge.x + lozenge.y - 0.36).abs();
        let heart = 0.12 - (lozenge.x + lozenge.y);
        let ornament = smoothstep(0.06, 0.03, rim).max(smoothstep(0.0, 0.03, heart));
        let gold = Vec3::new(0.42, 0.31, 0.13);
        let wear = 0.8 + 0.4 * fading(texel);
        let albedo = dye.lerp(dye.lerp(gold, 0.6), ornament) * wear * (0.75 + 0.25 * weave);
        Sample { height_m: 0.0006 * weave + 0.0008 * ornament, albedo }
    })
}

/// Overlapping leaves; the image is `size_m` metres wide. Each leaf is a Voronoi cell, darkest and lowest at its
/// border.
pub fn foliage(size_m: f32) -> Design {
    let wobble_x = grain([20, 20], 2, 139);
    let wobble_y = grain([20, 20], 2, 149);
    let grid = IVec2::new(18, 22);
    let cells = VoronoiCells::new(Vec2::splat(size_m) / grid.as_vec2(), grid, 0.9, 151);
    Box::new(move |texel| {
        let uv = texel.uv;
        let wobble = Vec2::new(wobble_x(texel), wobble_y(texel)) - 0.5;
        let cell = cells.cell(uv * size_m + wobble * 0.03);
        let depth = smoothstep(0.0, 0.012, cell.border);
        let tone = unit(cell.id, 157);
        let leaf = Vec3::new(0.06, 0.17, 0.03).lerp(Vec3::new(0.20, 0.30, 0.07), tone);
        Sample { height_m: 0.005 * depth + 0.003 * tone, albedo: leaf * (0.35 + 0.65 * depth) }
    })
}

/// Makes the factor on the reflectivity of a wet road: from 0.85 to 1 in a puddle, and from 0.2 to 0.35 elsewhere.
pub fn wetness() -> Grain {
    let (damp, puddle) = (grain([12, 12], 3, 163), puddle());
    Box::new(move |texel| 0.2 + 0.15 * damp(texel) + 0.65 * puddle(texel))
}

/// Makes the function that is 1 in a puddle and 0 outside, with soft shores.
fn puddle() -> Grain {
    let (hollows, shores) = (grain([3, 2], 4, 167), grain([10, 10], 2, 169));
    Box::new(move |texel| smoothstep(0.53, 0.58, 0.8 * hollows(texel) + 0.2 * shores(texel)))
}

/// Wet asphalt: chippings in bitumen, level and darker under puddles.
pub fn asphalt() -> Design {
    let stones = grain([120, 120], 2, 173);
    let wear = grain([5, 5], 4, 179);
    let unevenness = grain([8, 8], 2, 181);
    let puddle = puddle();
    Box::new(move |texel| {
        let chips = stones(texel);
        let water = puddle(texel);
        let tone = 0.8 + 0.35 * wear(texel);
        let dry = Vec3::new(0.062, 0.062, 0.066) * tone * (0.55 + 0.9 * chips);
        let height_m = (1.0 - water) * (0.0035 * chips + 0.004 * unevenness(texel));
        Sample { height_m, albedo: dry.lerp(Vec3::new(0.022, 0.024, 0.028), 0.85 * water) }
    })
}

/// Polished marble: four by four squares of white and black with veins; the image is `size_m` metres wide. `face` is 0
/// in the joints and 1 on a square.
pub fn marble(size_m: f32) -> Design {
    // The column and row of a square.
    let square_id = |uv: Vec2| (uv * 4.0).floor().as_ivec2().rem_euclid(IVec2::splat(4));
    let bending = grain_with_seeds([8, 8], 4, |uv| 191 + (3 * square_id(uv).x + 5 * square_id(uv).y) as u32);
    let cloudiness = grain([12, 12], 4, 193);
    Box::new(move |texel| {
        let uv = texel.uv;
        let scaled = uv * 4.0;
        let (id, inside) = (square_id(uv), scaled - scaled.floor());
        let edge = (0.5 - (inside - 0.5).abs()).min_element() * size_m / 4.0;
        let face = smoothstep(0.0012, 0.004, edge);
        let bend = bending(texel) - 0.5;
        let vein = smoothstep(0.045, 0.0, bend.abs());
        let clouds = cloudiness(texel);
        let square = if (id.x + id.y) % 2 == 0 {
            Vec3::new(0.50, 0.48, 0.44) * (0.9 + 0.2 * clouds) * (1.0 - 0.3 * vein)
        } else {
            Vec3::new(0.045, 0.05, 0.055) * (0.7 + 0.6 * clouds) + 0.10 * vein
        };
        Sample { height_m: 0.0008 * face, albedo: Vec3::splat(0.10).lerp(square, face) }
    })
}

/// Terrazzo: chips of stone in four colours in grey cement, with brass strips between two by two fields; the image is
/// `size_m` metres wide.
pub fn terrazzo(size_m: f32) -> Design {
    const CHIPS: [Vec3; 4] = [
        Vec3::new(0.30, 0.27, 0.22),
        Vec3::new(0.08, 0.08, 0.08),
        Vec3::new(0.22, 0.12, 0.08),
        Vec3::new(0.17, 0.17, 0.15),
    ];
    let stains = grain([20, 20], 3, 211);
    let grid = IVec2::new(140, 140);
    let cells = VoronoiCells::new(Vec2::ONE, grid, 0.95, 197);
    Box::new(move |texel| {
        let uv = texel.uv;
        let cell = cells.cell(uv * grid.as_vec2());
        let chip = CHIPS[(unit(cell.id, 199) * 4.0) as usize % 4];
        let cement = Vec3::new(0.19, 0.185, 0.17) * (0.9 + 0.2 * stains(texel));
        let stone = cement.lerp(chip, smoothstep(0.08, 0.2, cell.border));
        let edge = (0.5 - ((uv * 2.0).fract_gl() - 0.5).abs()).min_element() * 0.5 * size_m;
        let strip = smoothstep(0.006, 0.003, edge);
        Sample { height_m: 0.0005 * strip, albedo: stone.lerp(Vec3::new(0.36, 0.26, 0.10), strip) }
    })
}
