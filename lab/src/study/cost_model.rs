//! Predicts the cost of a cell of the error study from its methods, size, rays and scene, by the costs of measured
//! cells (docs/many-machines.md, "Costs"). The coefficients are fitted to the measured cells whenever they are needed.
//! The cells that were measured on the project's own machine are part of the program.
//!
//! The model uses only sums, products and quotients, whose results are the same on every machine, so that all machines
//! divide a study in the same way.

use super::cost::{CellCost, VariantCost};
use super::error::ErrorSpec;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// The measured cells that are part of the program (benches/runs/README.md has the command that measured them).
const KEPT: &str = include_str!("../../../benches/runs/2026-11-25-lavapipe/cost/costs.json");

/// How many times the costs of frames are fitted in turn, by method and by scene.
const ROUNDS: usize = 8;

/// The properties of a cell that its cost depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct CellShape<'a> {
    /// The name of the scene.
    pub scene: &'a str,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rays a pixel of the references.
    pub rays: u32,
    /// Frames of each variant, including those that warm up.
    pub frames: usize,
    /// The method of each variant.
    pub methods: Vec<&'a str>,
}

impl<'a> CellShape<'a> {
    /// The shape of a cell that will be measured.
    pub fn of(spec: &ErrorSpec<'a>) -> Self {
        Self {
            scene: &spec.scene.name,
            size: spec.extent,
            rays: spec.rays,
            frames: spec.warmup + spec.samples,
            methods: spec.variants.iter().map(|v| v.method.name).collect(),
        }
    }

    /// The shape of a cell that was measured.
    pub fn measured(cost: &'a CellCost) -> Self {
        Self {
            scene: &cost.scene,
            size: cost.size,
            rays: cost.rays,
            frames: cost.frames,
            methods: cost.variants.iter().map(|v| v.method.as_str()).collect(),
        }
    }

    fn pixels(&self) -> f64 {
        pixels(self.size)
    }
}

fn pixels([width, height]: [u32; 2]) -> f64 {
    f64::from(width) * f64::from(height)
}

/// The parts of a cell's cost, in seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct CostParts {
    /// For what methods make before their first frames.
    pub setup_s: f64,
    /// For the frames.
    pub frames_s: f64,
    /// For comparing images with the references, and for the rest.
    pub judged_s: f64,
    /// For the references of the screen.
    pub screen_s: f64,
    /// For the references of the world, whose rays can be divided.
    pub world_s: f64,
}

impl CostParts {
    /// The sum of all parts.
    pub fn total_s(&self) -> f64 {
        self.setup_s + self.frames_s + self.judged_s + self.screen_s + self.world_s
    }

    /// The parts of a measured cell.
    pub fn measured(cost: &CellCost) -> Self {
        let sum = |of: fn(&VariantCost) -> f64| cost.variants.iter().map(of).sum::<f64>();
        Self {
            setup_s: sum(|v| v.setup_s),
            frames_s: sum(|v| v.frames_s),
            judged_s: sum(|v| v.judged_s) + cost.rest_s,
            screen_s: cost.screen_s,
            world_s: cost.world_s,
        }
    }
}

/// The coefficients of a method, in seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct MethodCost {
    /// Before the first frame, whatever the number of variants, which share what the first of them made.
    setup_s: f64,
    /// For a frame, whatever its size.
    frame_s: f64,
    /// For each pixel of a frame.
    frame_pixel_s: f64,
    /// For each pixel that is compared with the references.
    judged_pixel_s: f64,
}

/// The coefficients of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SceneCost {
    /// The cost of a frame of this scene over that of a frame of the average scene.
    frames: f64,
    /// Seconds for each ray of the reference of the screen.
    screen_ray_s: f64,
    /// Seconds for each ray of the reference of the world.
    world_ray_s: f64,
}

/// Predicts what cells cost.
#[derive(Debug, Clone, PartialEq)]
pub struct CostModel {
    methods: BTreeMap<String, MethodCost>,
    /// For a method that was not measured: the mean of the measured ones.
    other_method: MethodCost,
    scenes: BTreeMap<String, SceneCost>,
    /// For a scene that was not measured: fitted to the cells of all scenes.
    other_scene: SceneCost,
    /// Seconds for each pixel of a cell, whatever its variants.
    rest_pixel_s: f64,
    /// Bytes of a process, and the further bytes for each pixel of each variant.
    memory: Option<(f64, f64)>,
}

impl CostModel {
    /// The model of the measured cells that are part of the program.
    pub fn kept() -> &'static Self {
        static MODEL: LazyLock<CostModel> = LazyLock::new(|| CostModel::fit(&kept_cells()));
        &MODEL
    }

    /// Fits a model to measured cells. Cells that an earlier run had begun are left out. Without any cell, every
    /// prediction is 0.
    pub fn fit(cells: &[CellCost]) -> Self {
        let cells: Vec<&CellCost> = cells.iter().filter(|c| !c.partial && !c.variants.is_empty()).collect();
        let names: Vec<&str> = unique(cells.iter().map(|c| c.scene.as_str()));
        let mut factors: BTreeMap<&str, f64> = names.iter().map(|name| (*name, 1.0)).collect();
        let mut methods = BTreeMap::new();
        for _ in 0..ROUNDS {
            methods = fit_methods(&cells, &factors);
            for (scene, factor) in &mut factors {
                *factor = scene_factor(cells.iter().filter(|c| c.scene == *scene), &methods);
            }
        }
        let scene = |name: Option<&str>| {
            let of: Vec<&&CellCost> = cells.iter().filter(|c| name.is_none_or(|name| c.scene == name)).collect();
            let rays = |c: &&&CellCost| pixels(c.size) * f64::from(c.rays);
            SceneCost {
                frames: name.and_then(|name| factors.get(name).copied()).unwrap_or(1.0),
                screen_ray_s: ratio(of.iter().map(|c| (c.screen_s, rays(c)))),
                world_ray_s: ratio(of.iter().map(|c| (c.world_s, rays(c)))),
            }
        };
        Self {
            other_method: mean_method(&methods),
            methods,
            scenes: names.iter().map(|name| ((*name).to_owned(), scene(Some(name)))).collect(),
            other_scene: scene(None),
            rest_pixel_s: ratio(cells.iter().map(|c| (c.rest_s, pixels(c.size)))),
            memory: memory(&cells),
        }
    }

    /// The predicted seconds to draw a cell of a size and to find its first hits.
    pub fn drawn_s(&self, size: [u32; 2]) -> f64 {
        self.rest_pixel_s * pixels(size)
    }

    /// The predicted bytes that a process holds for a cell; `None` if the measured cells do not say them.
    pub fn memory_bytes(&self, cell: &CellShape) -> Option<f64> {
        self.memory.map(|(process, variant)| process + variant * cell.pixels() * cell.methods.len() as f64)
    }

    /// The predicted cost of a cell.
    pub fn predict(&self, cell: &CellShape) -> CostParts {
        let scene = self.scenes.get(cell.scene).unwrap_or(&self.other_scene);
        let (pixels, frames) = (cell.pixels(), cell.frames as f64);
        let rays = pixels * f64::from(cell.rays);
        let mut parts = CostParts {
            judged_s: self.rest_pixel_s * pixels,
            screen_s: scene.screen_ray_s * rays,
            world_s: scene.world_ray_s * rays,
            ..CostParts::default()
        };
        let of = |name: &str| self.methods.get(name).unwrap_or(&self.other_method);
        parts.setup_s = unique(cell.methods.iter().copied()).into_iter().map(|name| of(name).setup_s).sum();
        for name in &cell.methods {
            let method = of(name);
            parts.frames_s += frames * scene.frames * (method.frame_s + method.frame_pixel_s * pixels);
            parts.judged_s += method.judged_pixel_s * pixels;
        }
        parts
    }
}

/// The line through the measured processes, raised so that none of them lies above it.
fn memory(cells: &[&CellCost]) -> Option<(f64, f64)> {
    let point = |c: &&CellCost| Some((pixels(c.size) * c.variants.len() as f64, c.peak_bytes? as f64));
    let points: Vec<(f64, f64)> = cells.iter().filter_map(point).collect();
    let (process, variant) = line(&points);
    let above = points.iter().map(|(x, y)| y - process - variant * x).fold(0.0, f64::max);
    (!points.is_empty()).then_some((process + above, variant))
}

/// The measured cells that are part of the program.
pub fn kept_cells() -> Vec<CellCost> {
    // A test reads it, so that a program whose own file cannot be read is never made.
    serde_json::from_str(KEPT).unwrap_or_default()
}

fn unique<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    names.collect::<BTreeSet<&str>>().into_iter().collect()
}

/// The sum of the first over the sum of the second; 0 of nothing.
fn ratio(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (a, b) = pairs.fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    if b > 0.0 { a / b } else { 0.0 }
}

fn mean_method(methods: &BTreeMap<String, MethodCost>) -> MethodCost {
    let mean = |of: fn(&MethodCost) -> f64| ratio(methods.values().map(|m| (of(m), 1.0)));
    MethodCost {
        setup_s: mean(|m| m.setup_s),
        frame_s: mean(|m| m.frame_s),
        frame_pixel_s: mean(|m| m.frame_pixel_s),
        judged_pixel_s: mean(|m| m.judged_pixel_s),
    }
}

/// Fits the cost of each method to all its variants. The seconds of their frames are divided by the factors of the
/// scenes.
fn fit_methods(cells: &[&CellCost], factors: &BTreeMap<&str, f64>) -> BTreeMap<String, MethodCost> {
    let names = unique(cells.iter().flat_map(|c| c.variants.iter().map(|v| v.method.as_str())));
    let fit = |name: &str| {
        let of = |c: &&CellCost| {
            let factor = factors.get(c.scene.as_str()).copied().unwrap_or(1.0);
            let (cell_pixels, frames) = (pixels(c.size), c.frames.max(1) as f64);
            let variants = c.variants.iter().filter(|v| v.method == name);
            let frame = move |v: &VariantCost| v.frames_s / frames / factor.max(f64::MIN_POSITIVE);
            variants.map(|v| (cell_pixels, frame(v), v.setup_s, v.judged_s)).collect::<Vec<_>>()
        };
        let all: Vec<_> = cells.iter().flat_map(of).collect();
        let (frame_s, frame_pixel_s) = line(&all.iter().map(|v| (v.0, v.1)).collect::<Vec<_>>());
        MethodCost {
            setup_s: all.iter().map(|v| v.2).sum::<f64>() / in_cells(cells, name),
            frame_s,
            frame_pixel_s,
            judged_pixel_s: ratio(all.iter().map(|v| (v.3, v.0))),
        }
    };
    names.into_iter().map(|name| (name.to_owned(), fit(name))).collect()
}

/// The number of cells that have a method, at least 1.
fn in_cells(cells: &[&CellCost], method: &str) -> f64 {
    cells.iter().filter(|c| c.variants.iter().any(|v| v.method == method)).count().max(1) as f64
}

/// The seconds that the frames of a scene took over the seconds that the methods' costs predict.
fn scene_factor<'a>(cells: impl Iterator<Item = &'a &'a CellCost>, methods: &BTreeMap<String, MethodCost>) -> f64 {
    let of = |c: &&CellCost| {
        let predicted =
            |method: &str| methods.get(method).map_or(0.0, |m| m.frame_s + m.frame_pixel_s * pixels(c.size));
        let frames = c.frames as f64;
        c.variants.iter().map(|v| (v.frames_s, frames * predicted(&v.method))).collect::<Vec<_>>()
    };
    ratio(cells.flat_map(of))
}

/// The constant and the slope, both ≥ 0, of the line through some points (x, y): least squares of the errors relative
/// to x.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let slope_alone = (0.0, ratio(points.iter().map(|(x, y)| (*y, *x))));
    let sums = points.iter().fold([0.0; 5], |s, (x, y)| {
        let w = 1.0 / (x * x).max(1.0);
        [s[0] + w, s[1] + w * x, s[2] + w * x * x, s[3] + w * y, s[4] + w * x * y]
    });
    let [w, x, xx, y, xy] = sums;
    let determinant = w * xx - x * x;
    // All points have one x, but for rounding.
    if determinant <= 1e-9 * w * xx {
        return slope_alone;
    }
    let (constant, slope) = ((y * xx - x * xy) / determinant, (w * xy - x * y) / determinant);
    if constant < 0.0 {
        slope_alone
    } else if slope < 0.0 {
        (ratio(points.iter().map(|(_, y)| (*y, 1.0))), 0.0)
    } else {
        (constant, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::DeviceInfo;

    /// A cell whose cost follows the model exactly, with the coefficients below.
    fn cell(scene: &str, size: [u32; 2], rays: u32, frames: usize) -> CellCost {
        let (factor, ray) = if scene == "dear" { (2.0, 3e-6) } else { (0.5, 1e-6) };
        let (px, n) = (pixels(size), frames as f64);
        let variant = |(method, setup_s, frame, pixel, judged): (&str, f64, f64, f64, f64)| VariantCost {
            method: method.into(),
            setup_s,
            frames_s: n * factor * (frame + pixel * px),
            judged_s: judged * px,
        };
        CellCost {
            scene: scene.into(),
            view: "v".into(),
            size,
            roughness: None,
            rays,
            frames,
            device: DeviceInfo { name: "d".into(), driver: "d".into(), api: "1.3".into(), kind: "CPU".into() },
            threads: 2,
            partial: false,
            peak_bytes: Some((1e8 + 20.0 * px * 2.0) as u64),
            variants: [("a", 0.5, 1e-3, 1e-6, 1e-7), ("b", 0.0, 0.0, 4e-6, 2e-7)].map(variant).to_vec(),
            screen_s: 2.0 * ray * px * f64::from(rays),
            world_s: ray * px * f64::from(rays),
            rest_s: 1e-8 * px,
        }
    }

    #[test]
    fn what_costs_as_the_model_says_is_predicted_for_other_sizes_rays_and_frames() {
        let measured = [cell("dear", [64, 36], 4, 3), cell("dear", [320, 180], 8, 3), cell("cheap", [64, 36], 4, 2)];
        let model = CostModel::fit(&measured);
        for scene in ["dear", "cheap"] {
            let expected = cell(scene, [480, 270], 64, 6);
            let (found, expected) = (model.predict(&CellShape::measured(&expected)), CostParts::measured(&expected));
            for (found, expected) in [
                (found.setup_s, expected.setup_s),
                (found.frames_s, expected.frames_s),
                (found.judged_s, expected.judged_s),
                (found.screen_s, expected.screen_s),
                (found.world_s, expected.world_s),
                (found.total_s(), expected.total_s()),
            ] {
                assert!((found - expected).abs() < 1e-6 * expected, "{scene}: {found} instead of {expected}");
            }
        }
        // What a method makes before its first frame is made once for its two variants.
        let twice = CellShape { scene: "dear", size: [64, 36], rays: 4, frames: 2, methods: vec!["a", "a", "b"] };
        assert_eq!(model.predict(&twice).setup_s, 0.5);
        let memory = model.memory_bytes(&CellShape::measured(&cell("dear", [480, 270], 1, 1)));
        assert!(memory.is_some_and(|bytes| (bytes - 1e8 - 20.0 * 480.0 * 270.0 * 2.0).abs() < 1e4), "{memory:?}");
        // Methods and scenes that were never measured cost as much as the others do on average.
        let unknown = CellShape { scene: "new", size: [64, 36], rays: 4, frames: 2, methods: vec!["c"] };
        let parts = model.predict(&unknown);
        assert!(parts.frames_s > 0.0 && parts.world_s > 0.0 && parts.setup_s == 0.25, "{parts:?}");
        // A cell that an earlier run had begun is left out.
        let partial = CellCost { partial: true, ..cell("dear", [999, 999], 1, 1) };
        assert_eq!(CostModel::fit(&[&measured[..], &[partial]].concat()), model);
        assert_eq!(CostModel::fit(&[]).predict(&unknown), CostParts::default());
    }

    #[test]
    fn the_cells_that_are_part_of_the_program_can_be_read() {
        let cells = kept_cells();
        assert!(cells.len() >= 12, "{}", cells.len());
        // The cost of each cell is predicted from all others, within a factor of two.
        for (n, cell) in cells.iter().enumerate() {
            let others: Vec<CellCost> =
                cells.iter().enumerate().filter(|(m, _)| *m != n).map(|(_, c)| c.clone()).collect();
            let predicted = CostModel::fit(&others).predict(&CellShape::measured(cell)).total_s();
            let ratio = predicted / cell.total_s();
            assert!((0.5..=2.0).contains(&ratio), "{} {}: {ratio}", cell.scene, cell.view);
        }
    }
}
