//! The tables of docs/many-machines.md: plans of the full study on several numbers of machines, by the costs that are
//! part of the program.

use super::{keep, root};
use serde_json::Value;
use std::fs;
use std::process::Command;

/// Numbers of machines.
const MACHINES: &str = "1,10,100,1000";

/// The plans of the full study with a number of rays a pixel.
fn plans(rays: &str) -> Vec<Value> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ssct"));
    let output = command.args(["error", "--plan", MACHINES, "--simulate", "--json", "--rays", rays]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn hours(seconds: &Value) -> String {
    let hours = seconds.as_f64().unwrap() / 3600.0;
    if hours < 0.995 { format!("{:.1} min", 60.0 * hours) } else { format!("{hours:.1} h") }
}

fn table(rays: &str) -> String {
    let plans = plans(rays);
    let first = &plans[0];
    let mut text = format!(
        "\n{} cells with {rays} rays, {} on one machine; the dearest takes {}. More than {} machines do not help, in two steps \
         more than {}.\n\n",
        first["cells"],
        hours(&first["total_s"]),
        hours(&first["dearest"]["total_s"]),
        first["enough"],
        first["in_two_steps"]["enough"]
    );
    text += "| machines | done after | by digests alone | no division is faster than | in two steps | with trouble, median | 95 % of runs |\n";
    text += "|---|---|---|---|---|---|---|\n";
    for plan in &plans {
        let simulated = &plan["simulated"];
        let cells = [
            &plan["makespan_s"],
            &plan["makespan_by_digest_s"],
            &plan["bound_s"],
            &plan["in_two_steps"]["makespan_s"],
            &simulated["median_s"],
            &simulated["p95_s"],
        ];
        text += &format!("| {} | {} |\n", plan["machines"], cells.map(hours).join(" | "));
    }
    text
}

#[test]
fn plans_of_the_full_study_are_what_the_costs_say() {
    let path = root().join("docs/many-machines.md");
    let mut page = fs::read_to_string(&path).unwrap();
    for rays in ["64", "4096"] {
        let (begin, end) = (format!("<!-- plan: {rays} rays -->\n"), "<!-- end of plan -->");
        let (before, after) = page.split_once(&begin).unwrap_or_else(|| panic!("no marker {begin}"));
        let (_, after) = after.split_once(end).unwrap();
        page = format!("{before}{begin}{}\n{end}{after}", table(rays));
    }
    keep(&path, &page);
}
