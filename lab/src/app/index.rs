//! `ssct index`: one page over many runs.

use super::compare::check_threshold;
use super::printed;
use crate::error::{Error, Result};
use crate::report::html::{LIBRARY_TITLE, LibraryPage};
use crate::report::library;
use crate::study::compare::THRESHOLD;
use crate::study::library::changes::changes;
use crate::study::library::trends::trends;
use crate::study::names::{count_text, one_line};
use clap::Args;
use ssct::methods;
use ssct_scenes::inside::PathInFolder;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The page's file.
const PAGE: &str = "index.html";

/// Options of `ssct index`.
#[derive(Debug, Args)]
pub struct IndexOptions {
    /// Folder with the folders of runs
    ///
    /// A folder whose name begins with a date (YYYY-MM-DD) dates the runs in it.
    folder: PathBuf,
    /// Folder for index.html; by default the runs' own
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Method over whose times others are given
    #[arg(long, value_name = "NAME", default_value = "ssct")]
    base: String,
    /// Change of a time that counts, as a share
    #[arg(long, value_name = "T", default_value_t = THRESHOLD)]
    threshold: f64,
}

/// Reads the runs of a folder, writes the page over them, and prints how much the page shows.
pub fn run(options: &IndexOptions) -> anyhow::Result<()> {
    check_threshold(options.threshold)?;
    methods::find(&options.base)?;
    let output = options.output.as_deref().unwrap_or(&options.folder);
    let page = PathInFolder::folder(output).join(PAGE);
    check_is_library_page(&page)?;
    let library = library::scan(&options.folder)?;
    if library.runs.is_empty() {
        let why: String =
            library.unreadable.iter().map(|(folder, why)| format!("; {folder} cannot be read: {why}")).collect();
        anyhow::bail!("{}: no folder in it holds records of the studies{why}", options.folder.display());
    }
    let (trends, changes) = (trends(&library.runs, &options.base), changes(&library.runs, options.threshold));
    let path_to_runs = relative_path(output, &options.folder)?;
    let html = LibraryPage {
        command: &command(options),
        library: &library,
        trends: &trends,
        changes: &changes,
        base: &options.base,
        threshold: options.threshold,
        path_to_runs: path_to_runs.as_deref(),
    };
    let html = html.render().map_err(|e| anyhow::anyhow!("cannot draw the plots of {}: {e}", page.path().display()))?;
    page.write(html.as_bytes())?;
    let mut out = printed::out();
    for (folder, why) in &library.unreadable {
        writeln!(out, "left out: {}: {}", one_line(folder), one_line(why))?;
    }
    writeln!(
        out,
        "{}: {}, {} over runs, {} left out ({:.1} MB)",
        page.path().display(),
        count_text(library.runs.len(), "run"),
        count_text(trends.iter().map(|t| t.lines.len()).sum(), "figure"),
        count_text(library.unreadable.len(), "folder"),
        html.len() as f64 / 1e6
    )?;
    Ok(())
}

/// Refuses to overwrite a page that shows no library, such as the page of a study.
fn check_is_library_page(page: &PathInFolder) -> Result<()> {
    let is_library = |text: &str| text.contains(&format!("<title>ssct {LIBRARY_TITLE}</title>"));
    match page.read()? {
        Some(existing) if !is_library(&String::from_utf8_lossy(&existing)) => {
            let page = page.path();
            Err(Error::usage(format!("{} is no page of a library: name another folder with -o", page.display())))
        }
        _ => Ok(()),
    }
}

/// The path from the page's folder to the library's: empty, or with a slash at its end. `None` if the library is not
/// below the page's folder.
fn relative_path(output: &Path, library: &Path) -> Result<Option<String>> {
    PathInFolder::folder(output).make()?;
    let absolute = |path: &Path| std::fs::canonicalize(path).map_err(|e| Error::io("read", path, e));
    let (output, library) = (absolute(output)?, absolute(library)?);
    let with_slashes =
        |path: &Path| path.components().map(|part| format!("{}/", part.as_os_str().to_string_lossy())).collect();
    Ok(library.strip_prefix(&output).ok().map(with_slashes))
}

/// The command as the page shows it, with the values of all options.
fn command(options: &IndexOptions) -> String {
    let output = options.output.as_ref().map(|o| format!(" -o {}", o.display())).unwrap_or_default();
    format!("ssct index {}{output} --base {} --threshold {}", options.folder.display(), options.base, options.threshold)
}
