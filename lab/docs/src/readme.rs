//! Makes the file of the README's numbers by view (`lab/src/study/readme.csv`), with which `ssct gpu-study` compares
//! the numbers of a device.

use crate::devices::device_kind;
use crate::pages::{definitions, quotations, read_page};
use crate::queries::Queries;
use std::path::Path;

/// The queries of the tables of numbers, each with the README's link definitions that name the folders of its records.
const TABLES: [(&str, &[&str]); 3] = [
    ("readme triangles", &["triangles"]),
    ("readme screen", &["bars", "bars-errors"]),
    ("readme hits", &["bars-errors"]),
];

/// Returns the text of `readme.csv`. First come the numbers of the README's tables, on the views that the study
/// measures. Then come the numbers that only the README's text has, with the command that measures each.
pub(crate) fn csv(queries: &Queries, root: &Path) -> Result<String, String> {
    let readme = read_page(root, "README.md")?;
    let links = definitions(&readme);
    let folder =
        |name: &&str| Ok(root.join(links.get(*name).ok_or_else(|| format!("the README has no link [{name}]"))?));
    let mut rows = Vec::new();
    for (name, labels) in TABLES {
        let folders = labels.iter().map(folder).collect::<Result<Vec<_>, String>>()?;
        let table = queries.table(name, &folders).map_err(|e| e.words)?;
        // All tables have the same captions, which are the columns of the file.
        rows.extend(table.into_iter().skip(usize::from(!rows.is_empty())));
    }
    for quotation in quotations(root, "README.md", &readme)?.0 {
        let (query, _) = queries.find(quotation.query).map_err(|e| e.words)?;
        let (Some([place, command]), [folder]) = (&query.readme, &quotation.folders[..]) else { continue };
        let says = queries.answer(quotation.query, &quotation.folders)?;
        // The columns are place, row, column, says, measured_on, figure, variant, over, command, roughness, scene, view
        // and value.
        let cells =
            [place, "", quotation.query, &says, device_kind(folder)?, "elsewhere", "", "", command, "", "", "", ""];
        rows.push(cells.map(str::to_owned).to_vec());
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.write_record(row)).map_err(|e| e.to_string())?;
    String::from_utf8(writer.into_inner().map_err(|e| e.to_string())?).map_err(|e| e.to_string())
}
