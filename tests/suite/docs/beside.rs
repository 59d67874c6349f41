//! Methods that see more than the screen beside each other, scene by scene: a folder of records for each scene.

use super::figures::{Result, figures, json, median, ratio, shortest, table};
use std::path::Path;

/// The medians over a scene's views of the error against the world, and of the time over the last method's. Methods,
/// scenes and roughness values have commas between them.
pub fn beside(folder: &Path, methods: &str, scenes: &str, roughness: &str) -> Result<String> {
    let methods: Vec<&str> = methods.split(',').collect();
    let last = *methods.last().ok_or("no methods")?;
    let mut rows = Vec::new();
    for scene in scenes.split(',') {
        let records = json(&folder.join(scene), "error.json")?;
        for roughness in roughness.split(',') {
            let of = |method, field| median(&figures(&records, method, "world", roughness, field));
            let mut row = vec![format!("`{scene}`"), shortest(roughness)];
            for method in &methods {
                row.push(format!("{:.4}", of(method, "rmse")?));
            }
            for method in &methods[..methods.len() - 1] {
                row.push(ratio(of(method, "time_ms")? / of(last, "time_ms")?));
            }
            rows.push(row);
        }
    }
    let errors = methods.iter().map(|m| format!("error, `{m}`"));
    let times = methods[..methods.len() - 1].iter().map(|m| format!("time over `{last}`, `{m}`"));
    let head: Vec<String> = ["scene".to_owned(), "ϱ".to_owned()].into_iter().chain(errors).chain(times).collect();
    table(&head.iter().map(String::as_str).collect::<Vec<_>>(), rows)
}
