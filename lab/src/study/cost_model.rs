//! What a cell of the error study will cost, from what others did: by its methods, size, rays and scene
//! (docs/many-machines.md, "Costs"). The coefficients are fitted to measured cells whenever they are asked for; the
//! cells of the machine that the project measures on are part of the program.
//!
//! Only sums, products and quotients are used, which are the same on every machine, so that all machines divide a study
//! in the same way.

use super::cost::CellCost;
use super::error::ErrorSpec;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// The measured cells that are part of the program (benches/runs/README.md says of which command).
const KEPT: &str = include_str!("../../../benches/runs/2026-11-25-lavapipe/cost/costs.json");

/// How often frames of methods and of scenes are fitted to each other.
const ROUNDS: usize = 8;

/// What a cell is, as far as its cost goes.
#[derive(Debug, Clone, PartialEq)]
pub struct CellShape<'a> {
    /// Scene.
    pub scene: &'a str,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Rays a pixel of the references.
    pub rays: u32,
    /// Frames of each variant, those that warm up included.
    pub frames: usize,
    /// The method of each variant.
    pub methods: Vec<&'a str>,
}

impl<'a> CellShape<'a> {
    /// Of a cell that will be measured.
    pub fn of(spec: &ErrorSpec<'a>) -> Self {
        Self {
            scene: &spec.scene.name,
            size: spec.extent,
            rays: spec.rays,
            frames: spec.warmup + spec.samples,
            methods: spec.variants.iter().map(|v| v.method.name).collect(),
        }
    }

    /// Of a cell that was measured.
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
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct CostParts {
    /// What methods make before their first frames.
    pub setup_s: f64,
    /// The frames.
    pub frames_s: f64,
    /// The images beside the references, and what else is done once.
    pub judged_s: f64,
    /// The reference of the screen.
    pub screen_s: f64,
    /// The reference of the world, whose rays can be divided.
    pub world_s: f64,
}

impl CostParts {
    /// All of it.
    pub fn total_s(&self) -> f64 {
        self.setup_s + self.frames_s + self.judged_s + self.screen_s + self.world_s
    }

    /// The parts of a measured cell.
    pub fn measured(cost: &CellCost) -> Self {
        let sum = |of: fn(&super::cost::VariantCost) -> f64| cost.variants.iter().map(of).sum::<f64>();
        Self {
            setup_s: sum(|v| v.setup_s),
            frames_s: sum(|v| v.frames_s),
            judged_s: sum(|v| v.judged_s) + cost.rest_s,
            screen_s: cost.screen_s,
            world_s: cost.world_s,
        }
    }
}

/// Seconds of a method: before its first frame, whatever the number of its variants, which share what the first of them
/// made; of a frame, and of a pixel of it; and of a pixel that is judged.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct MethodCost {
    setup_s: f64,
    frame_s: f64,
    frame_pixel_s: f64,
    judged_pixel_s: f64,
}

/// What a scene's frames cost over those of all, and seconds of a ray of either reference.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SceneCost {
    frames: f64,
    screen_ray_s: f64,
    world_ray_s: f64,
}

/// Predicts what cells cost.
#[derive(Debug, Clone, PartialEq)]
pub struct CostModel {
    methods: BTreeMap<String, MethodCost>,
    /// Of a method that was not measured: the mean of those that were.
    other_method: MethodCost,
    scenes: BTreeMap<String, SceneCost>,
    /// Of a scene that was not measured: all of them as one.
    other_scene: SceneCost,
    rest_pixel_s: f64,
    /// Bytes of a process, and of each pixel of each variant on top of them.
    memory: Option<(f64, f64)>,
}

impl CostModel {
    /// The model of the measured cells that are part of the program.
    pub fn kept() -> &'static Self {
        static MODEL: LazyLock<CostModel> = LazyLock::new(|| CostModel::fit(&kept_cells()));
        &MODEL
    }

    /// Fits a model to measured cells; those that an earlier run had begun are left out. Of none, everything costs
    /// nothing.
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
            other_method: mean_method(methods.values()),
            methods,
            scenes: names.iter().map(|name| ((*name).to_owned(), scene(Some(name)))).collect(),
            other_scene: scene(None),
            rest_pixel_s: ratio(cells.iter().map(|c| (c.rest_s, pixels(c.size)))),
            memory: memory(&cells),
        }
    }

    /// What it is predicted to cost to draw a cell of a size, and to find its first hits.
    pub fn drawn_s(&self, size: [u32; 2]) -> f64 {
        self.rest_pixel_s * pixels(size)
    }

    /// The bytes that a process is predicted to hold for a cell, if measured ones say it.
    pub fn memory_bytes(&self, cell: &CellShape) -> Option<f64> {
        self.memory.map(|(process, variant)| process + variant * cell.pixels() * cell.methods.len() as f64)
    }

    /// What a cell is predicted to cost.
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
    let all: std::collections::BTreeSet<&str> = names.collect();
    all.into_iter().collect()
}

/// The sum of the first over the sum of the second; 0 of nothing.
fn ratio(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (a, b) = pairs.fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    if b > 0.0 { a / b } else { 0.0 }
}

fn mean_method<'a>(methods: impl Iterator<Item = &'a MethodCost>) -> MethodCost {
    let mut all = MethodCost::default();
    let mut count: f64 = 0.0;
    for m in methods {
        all.setup_s += m.setup_s;
        all.frame_s += m.frame_s;
        all.frame_pixel_s += m.frame_pixel_s;
        all.judged_pixel_s += m.judged_pixel_s;
        count += 1.0;
    }
    let n = count.max(1.0);
    MethodCost {
        setup_s: all.setup_s / n,
        frame_s: all.frame_s / n,
        frame_pixel_s: all.frame_pixel_s / n,
        judged_pixel_s: all.judged_pixel_s / n,
    }
}

/// Each method's cost over all variants of it, with frames by what their scenes' frames cost over those of all.
fn fit_methods(cells: &[&CellCost], factors: &BTreeMap<&str, f64>) -> BTreeMap<String, MethodCost> {
    let names = unique(cells.iter().flat_map(|c| c.variants.iter().map(|v| v.method.as_str())));
    let fit = |name: &str| {
        let of = |c: &&CellCost| {
            let factor = factors.get(c.scene.as_str()).copied().unwrap_or(1.0);
            let (cell_pixels, frames) = (pixels(c.size), c.frames.max(1) as f64);
            let variants = c.variants.iter().filter(|v| v.method == name);
            let frame = move |v: &super::cost::VariantCost| v.frames_s / frames / factor.max(f64::MIN_POSITIVE);
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

/// How many cells have a method.
fn in_cells(cells: &[&CellCost], method: &str) -> f64 {
    cells.iter().filter(|c| c.variants.iter().any(|v| v.method == method)).count().max(1) as f64
}

/// What a scene's frames took over what they are predicted to take.
fn scene_factor<'a>(cells: impl Iterator<Item = &'a &'a CellCost>, methods: &BTreeMap<String, MethodCost>) -> f64 {
    let of = |c: &&CellCost| {
        let predicted =
            |method: &str| methods.get(method).map_or(0.0, |m| m.frame_s + m.frame_pixel_s * pixels(c.size));
        let frames = c.frames as f64;
        c.variants.iter().map(|v| (v.frames_s, frames * predicted(&v.method))).collect::<Vec<_>>()
    };
    ratio(cells.flat_map(of))
}

/// The line through some points (x, y), neither of whose numbers is below 0: least squares of the errors relative to x.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let slope_alone = (0.0, ratio(points.iter().map(|(x, y)| (*y, *x))));
    let sums = points.iter().fold([0.0; 5], |s, (x, y)| {
        let w = 1.0 / (x * x).max(1.0);
        [s[0] + w, s[1] + w * x, s[2] + w * x * x, s[3] + w * y, s[4] + w * x * y]
    });
    let [w, x, xx, y, xy] = sums;
    let determinant = w * xx - x * x;
    // All of one size, but for rounding.
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
    use crate::study::cost::VariantCost;

    /// A cell that costs what the numbers below say.
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
        // Two variants of a method make once what they need before their first frames.
        let twice = CellShape { scene: "dear", size: [64, 36], rays: 4, frames: 2, methods: vec!["a", "a", "b"] };
        assert_eq!(model.predict(&twice).setup_s, 0.5);
        let memory = model.memory_bytes(&CellShape::measured(&cell("dear", [480, 270], 1, 1)));
        assert!(memory.is_some_and(|bytes| (bytes - 1e8 - 20.0 * 480.0 * 270.0 * 2.0).abs() < 1e4), "{memory:?}");
        // What was never measured costs as much as the others do on the average, and not nothing.
        let unknown = CellShape { scene: "new", size: [64, 36], rays: 4, frames: 2, methods: vec!["c"] };
        let parts = model.predict(&unknown);
        assert!(parts.frames_s > 0.0 && parts.world_s > 0.0 && parts.setup_s == 0.25, "{parts:?}");
        // A cell that was begun by another run says nothing of frames.
        let partial = CellCost { partial: true, ..cell("dear", [999, 999], 1, 1) };
        assert_eq!(CostModel::fit(&[&measured[..], &[partial]].concat()), model);
        assert_eq!(CostModel::fit(&[]).predict(&unknown), CostParts::default());
    }

    #[test]
    fn the_cells_that_are_part_of_the_program_can_be_read() {
        let cells = kept_cells();
        assert!(cells.len() >= 12, "{}", cells.len());
        // Each by the others: what was measured is within a factor of two of what is predicted for it.
        for (n, cell) in cells.iter().enumerate() {
            let others: Vec<CellCost> =
                cells.iter().enumerate().filter(|(m, _)| *m != n).map(|(_, c)| c.clone()).collect();
            let predicted = CostModel::fit(&others).predict(&CellShape::measured(cell)).total_s();
            let ratio = predicted / cell.total_s();
            assert!((0.5..=2.0).contains(&ratio), "{} {}: {ratio}", cell.scene, cell.view);
        }
    }
}
