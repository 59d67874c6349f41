//! Helpers for tests of HTML pages: they read attributes from the text, or show a page in Chromium.

use super::folder::Folder;
use std::path::Path;
use std::process::Command;

/// Returns the values of an attribute in an HTML text, in order of their places.
pub fn attributes<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
    let prefix = format!(" {name}=\"");
    html.split(prefix.as_str()).skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

/// Returns a command that runs Chromium with a profile folder and without network access. If Chromium is not installed,
/// it prints that the test is skipped and returns `None`.
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

/// Returns the HTML of a page in a folder after Chromium has run its scripts, or `None` if there is no Chromium.
pub fn dom(folder: &Folder, page: &str) -> Option<String> {
    let profile = tempfile::tempdir().unwrap();
    let url = format!("file://{}", folder.path(page).display());
    let arguments = ["--hide-scrollbars", "--dump-dom", "--window-size=1400,1000", &url];
    let output = chromium(profile.path())?.args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Runs a script in a page of a folder, and returns the lines that the script pushed to its array `lines`, or `None` if
/// there is no Chromium.
///
/// The script is the body of an async function. It can call `show(page, width, sandbox)` to show another page of the
/// folder in a frame, without that page's own scripts if `sandbox` is set.
pub fn probe(folder: &Folder, script: &str) -> Option<String> {
    let page = format!(
        r#"<!DOCTYPE html><body><pre id="found"></pre><script>
const lines = [];
function show(page, width, sandbox) {{
  const frame = document.createElement("iframe");
  frame.style = `width: ${{width}}px; height: 900px; border: 0`;
  if (sandbox) frame.sandbox = "allow-same-origin";
  frame.src = page;
  return new Promise(done => {{ frame.onload = () => done(frame); document.body.append(frame); }});
}}
(async () => {{
  {script}
  document.getElementById("found").textContent = lines.join("\n");
}})();
</script>"#
    );
    folder.write("probe.html", page);
    let dom = dom(folder, "probe.html")?;
    let found = dom.split("<pre id=\"found\">").nth(1).and_then(|s| s.split("</pre>").next());
    Some(found.unwrap_or_default().to_owned())
}
