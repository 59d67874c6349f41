//! `ssct error --plan`: predicts how long a study takes on some machines, and what bounds that time; nothing is
//! measured.

use super::error_cells::{Plan, PricedCell, reference_rays};
use super::error_options::ErrorOptions;
use crate::error::{Error, Result};
use crate::gpu::DeviceInfo;
use crate::report::devices::name_among;
use crate::report::error_report::COSTS;
use crate::report::tables::aligned;
use crate::study::cost::CellCost;
use crate::study::cost_model::{CostModel, CostParts, kept_cells};
use crate::study::schedule::{Schedule, Simulated, Trouble, enough, total_s};
use crate::study::shard::{RaysOfShard, Share};
use serde::Serialize;
use std::io::Write;
use std::ops::Range;
use std::path::Path;

/// Runs of a simulation.
const RUNS: usize = 500;
/// Its seed.
const SEED: u64 = 24;

/// The plan for a number of machines.
#[derive(Debug, Serialize)]
struct MachinePlan {
    kind: &'static str,
    /// How many machines.
    machines: u32,
    /// How many cells.
    cells: usize,
    /// Seconds of all cells, one after the other.
    total_s: f64,
    /// Seconds until the last machine is done, as `--shard` divides the cells.
    makespan_s: f64,
    /// Seconds until the last machine is done if digests alone divided the cells.
    makespan_by_digest_s: f64,
    /// No division is faster than this: all cells over the machines, or the dearest cell.
    bound_s: f64,
    /// The dearest cell.
    dearest: DearestCell,
    /// More machines than these do not help.
    enough: u32,
    /// The study in two steps: first the rays of the world references, then the rest.
    in_two_steps: TwoSteps,
    /// The most bytes that a process holds, if they can be predicted.
    memory_bytes: Option<u64>,
    /// The makespan where some machines are slow and some attempts fail.
    #[serde(skip_serializing_if = "Option::is_none")]
    simulated: Option<SimulatedPlan>,
    /// Where the costs were measured.
    costs: CostsOf,
}

#[derive(Debug, Serialize)]
struct SimulatedPlan {
    #[serde(flatten)]
    trouble: Trouble,
    #[serde(flatten)]
    simulated: Simulated,
}

#[derive(Debug, Clone, Serialize)]
struct DearestCell {
    cell: String,
    total_s: f64,
    #[serde(flatten)]
    parts: CostParts,
}

/// The study in two steps, of which the first divides the rays of the world references whatever the cells are.
#[derive(Debug, Clone, Copy, Serialize)]
struct TwoSteps {
    /// Seconds of the first step, `ssct error --only-references`.
    references_s: f64,
    /// Seconds of the second step, `ssct error --references`.
    rest_s: f64,
    /// Seconds of both steps.
    makespan_s: f64,
    /// More machines than these do not help the second step.
    enough: u32,
}

/// Where costs were measured.
#[derive(Debug, Clone, Serialize)]
struct CostsOf {
    /// How many cells were measured.
    cells: usize,
    /// The devices.
    devices: Vec<String>,
    /// The numbers of threads of the hosts.
    threads: Vec<usize>,
}

/// Prints the plan for each number of machines.
pub fn run(options: &ErrorOptions, plan: &Plan) -> anyhow::Result<()> {
    let measured = match &options.costs {
        Some(folder) => read_costs(folder)?,
        None => kept_cells(),
    };
    let model = CostModel::fit(&measured);
    // The study is divided by the costs that are part of the program, whatever the costs of the machines are.
    let (kept, cells) = (plan.priced(CostModel::kept()), plan.priced(&model));
    let costs = costs_of(&measured);
    let of = |machines: &u32| {
        let rays = reference_rays(&kept, *machines);
        machine_plan(*machines, (&cells, &kept, &rays), &costs, options.simulate)
    };
    let plans: Vec<MachinePlan> = options.plan.iter().map(of).collect();
    let mut out = std::io::stdout().lock();
    if options.run.json {
        let lines: Vec<String> = plans.iter().map(serde_json::to_string).collect::<std::result::Result<_, _>>()?;
        writeln!(out, "[{}]", lines.join(",\n "))?;
    } else {
        out.write_all(text(&plans).as_bytes())?;
    }
    Ok(())
}

fn machine_plan(
    machines: u32,
    (cells, kept, rays): (&[PricedCell], &[PricedCell], &[RaysOfShard]),
    costs: &CostsOf,
    simulate: bool,
) -> MachinePlan {
    let shares: Vec<Share> = cells.iter().map(|c| c.share.clone()).collect();
    let divided_by: Vec<Share> = kept.iter().map(|c| c.share.clone()).collect();
    let schedule = Schedule::divided_by(&shares, &divided_by, machines);
    let dearest = cells.iter().max_by(|a, b| a.share.cost.total_cmp(&b.share.cost));
    let dearest = dearest.map_or_else(
        || DearestCell { cell: String::new(), total_s: 0.0, parts: CostParts::default() },
        |c| DearestCell { cell: c.name.clone(), total_s: c.share.cost, parts: c.parts },
    );
    let total_s = total_s(&shares);
    let memory = cells.iter().filter_map(|c| c.memory_bytes).max_by(f64::total_cmp);
    MachinePlan {
        kind: "plan",
        machines,
        cells: cells.len(),
        total_s,
        makespan_s: schedule.makespan(),
        makespan_by_digest_s: Schedule::by_digest(&shares, machines).makespan(),
        bound_s: (total_s / f64::from(machines)).max(dearest.total_s),
        dearest,
        enough: enough(&shares),
        in_two_steps: two_steps(cells, &divided_by, rays, machines),
        memory_bytes: memory.map(|bytes| bytes.ceil() as u64),
        simulated: simulate.then(|| {
            let trouble = Trouble::default();
            SimulatedPlan { trouble, simulated: schedule.simulate(&trouble, RUNS, SEED) }
        }),
        costs: costs.clone(),
    }
}

/// In the first step each shard draws the cells whose rays it takes; the second is divided as the whole study would be.
fn two_steps(cells: &[PricedCell], divided_by: &[Share], rays: &[RaysOfShard], machines: u32) -> TwoSteps {
    let load = |shard: &RaysOfShard| -> f64 {
        let cost = |(n, rays): &(usize, Range<u32>)| {
            let of = &cells[*n];
            of.parts.world_s * rays.len() as f64 / f64::from(of.rays.max(1)) + of.drawn_s
        };
        shard.iter().map(cost).sum()
    };
    let references_s = rays.iter().map(load).fold(0.0, f64::max);
    let without = |c: &PricedCell| Share { cost: c.share.cost - c.parts.world_s, ..c.share.clone() };
    let rest: Vec<Share> = cells.iter().map(without).collect();
    let rest_s = Schedule::divided_by(&rest, divided_by, machines).makespan();
    TwoSteps { references_s, rest_s, makespan_s: references_s + rest_s, enough: enough(&rest) }
}

/// The measured cells of a run.
fn read_costs(folder: &Path) -> Result<Vec<CellCost>> {
    let path = folder.join(COSTS);
    let text = std::fs::read(&path).map_err(|e| Error::io("read", &path, e))?;
    let cells: Vec<CellCost> = serde_json::from_slice(&text)
        .map_err(|e| Error::malformed(&path, Some(e.line()), format!("holds no costs of cells: {e}")))?;
    if cells.iter().all(|c| c.partial) {
        return Err(Error::malformed(&path, None, "holds no cost of a cell that one run measured from its beginning"));
    }
    Ok(cells)
}

fn costs_of(measured: &[CellCost]) -> CostsOf {
    let all: Vec<&DeviceInfo> = measured.iter().map(|c| &c.device).collect();
    let mut devices: Vec<String> = all.iter().map(|device| name_among(device, &all)).collect();
    let mut threads: Vec<usize> = measured.iter().map(|c| c.threads).collect();
    devices.sort();
    devices.dedup();
    threads.sort_unstable();
    threads.dedup();
    CostsOf { cells: measured.len(), devices, threads }
}

/// The plans as text.
fn text(plans: &[MachinePlan]) -> String {
    let Some(first) = plans.first() else { return String::new() };
    let mut header = vec!["machines", "done after", "by digests alone", "bound", "in two steps"];
    let is_simulated = plans.iter().any(|p| p.simulated.is_some());
    if is_simulated {
        header.extend(["with trouble, median", "95 % of runs"]);
    }
    let mut rows = vec![header.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    for plan in plans {
        let mut row = vec![plan.machines.to_string()];
        row.extend(
            [plan.makespan_s, plan.makespan_by_digest_s, plan.bound_s, plan.in_two_steps.makespan_s].map(duration),
        );
        if let Some(SimulatedPlan { simulated, .. }) = &plan.simulated {
            row.extend([simulated.median_s, simulated.p95_s].map(duration));
        }
        rows.push(row);
    }
    let DearestCell { cell, total_s, parts } = &first.dearest;
    let mut text = format!(
        "{} cells, {} on one machine like the one whose costs are known ({}; {} measured cells)\n\n",
        first.cells,
        duration(first.total_s),
        first.costs.devices.join(", "),
        first.costs.cells
    );
    text += &aligned(&rows);
    text += &format!(
        "\ndearest cell: {cell}, {}: frames {}, set-up {}, references of the screen {}, of the world {}, judging {}\n",
        duration(*total_s),
        duration(parts.frames_s),
        duration(parts.setup_s),
        duration(parts.screen_s),
        duration(parts.world_s),
        duration(parts.judged_s)
    );
    text += &format!(
        "more than {} machines do not help: the dearest cell is the last\n\
         in two steps, with the rays of the world references divided first: more than {} do not help the rest\n",
        first.enough, first.in_two_steps.enough
    );
    if let Some(bytes) = first.memory_bytes {
        text += &format!("memory of a process: {:.1} GiB\n", bytes as f64 / f64::from(1_u32 << 30));
    }
    if let Some(SimulatedPlan { trouble, simulated }) = &first.simulated {
        text += &format!(
            "with trouble: of {} simulated runs; {} % of the machines take {} times as long, {} % of the attempts fail and \
             begin again after {} s\n",
            simulated.runs,
            100.0 * trouble.stragglers,
            trouble.slowdown,
            100.0 * trouble.failures,
            trouble.restart_s
        );
    }
    text
}

/// A duration in the unit that fits.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{s:.2} s"),
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 5400.0 => format!("{:.1} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_said_in_the_unit_that_fits() {
        let said = [0.5, 99.0, 120.0, 7200.0].map(duration);
        assert_eq!(said, ["0.50 s", "99.0 s", "2.0 min", "2.0 h"]);
    }
}
