//! The program behind `make docs`: writes the files of the repository that are made from records or from tables in the
//! code.

use std::path::Path;
use std::process::ExitCode;

/// Writes each file whose text differs from the text that it should have, and prints its name.
fn write(root: &Path) -> Result<(), String> {
    for (name, text) in ssct_docs::files(root)? {
        if ssct_docs::difference(root, &name, &text).is_some() {
            std::fs::write(root.join(&name), text).map_err(|e| format!("{name}: {e}"))?;
            println!("{name}");
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    match write(Path::new(".")) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("ssct-docs: {message}");
            ExitCode::FAILURE
        }
    }
}
