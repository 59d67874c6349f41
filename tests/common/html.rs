//! What tests of pages share: reading attributes off the text, and a browser that shows it.

use std::path::Path;
use std::process::Command;

/// Values of an attribute, in order.
pub fn attributes<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
    let prefix = format!(" {name}=\"");
    html.split(prefix.as_str()).skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

/// Chromium with what keeps it off the network, or a line that says why the test does nothing.
pub fn chromium(profile: &Path) -> Option<Command> {
    let on_path = std::env::var_os("PATH")
        .is_some_and(|paths| std::env::split_paths(&paths).any(|folder| folder.join("chromium").is_file()));
    if !on_path {
        println!("skipped: chromium is not on PATH");
        return None;
    }
    let mut command = Command::new("chromium");
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"]);
    command.args(["--allow-file-access-from-files", "--virtual-time-budget=4000"]);
    command.arg(format!("--user-data-dir={}", profile.display()));
    Some(command)
}
