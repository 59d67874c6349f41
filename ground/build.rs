//! Declares in Rust the constants of `constants.glsl`, which shaders and host share, so that no number is declared twice. In the
//! repository the file is a link to `shaders-glsl/common/constants.glsl`; in a package it is a file.

use std::fmt::Write as _;
use std::path::PathBuf;

const CONSTANTS: &str = "constants.glsl";

fn main() -> Result<(), String> {
    println!("cargo:rerun-if-changed={CONSTANTS}");
    println!("cargo:rerun-if-changed=build.rs");
    let out = PathBuf::from(std::env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let source = std::fs::read_to_string(CONSTANTS).map_err(|e| format!("{CONSTANTS}: {e}"))?;
    std::fs::write(out.join("constants.rs"), declared(&source)?).map_err(|e| format!("constants.rs: {e}"))
}

/// Returns Rust declarations of the constants in a source of GLSL, with their comments. A number with a decimal point
/// becomes an f64, which keeps the decimal as it is written; code that computes in f32 rounds it once, as GLSL does.
fn declared(source: &str) -> Result<String, String> {
    let (mut text, mut comment) = (String::new(), String::new());
    for (index, line) in source.lines().enumerate() {
        if let Some(words) = line.strip_prefix("// ") {
            let _ = writeln!(comment, "/// {words}");
            continue;
        }
        if let Some(declaration) = line.strip_prefix("const ") {
            let (ty, name_and_value) = declaration.split_once(' ').unwrap_or_default();
            let (name, value) = name_and_value.split_once(" = ").unwrap_or_default();
            let (value, comment_beside) = value.split_once(';').unwrap_or_default();
            let (ty, value) = match ty {
                "int" => ("i32", value),
                "uint" => ("u32", value.trim_end_matches('u')),
                "float" => ("f64", value),
                _ => ("", ""), // refused below, as every declaration without a value is
            };
            let comment_beside = comment_beside.trim().trim_start_matches("// ");
            if value.is_empty() || (comment.is_empty() && comment_beside.is_empty()) {
                let wanted = "`const int|uint|float NAME = VALUE;` with a comment above or beside it";
                return Err(format!("{CONSTANTS}:{}: {line:?} should be {wanted}", index + 1));
            }
            if !comment_beside.is_empty() {
                comment = format!("/// {comment_beside}\n");
            }
            let _ = writeln!(text, "{comment}pub const {name}: {ty} = {value};");
        }
        comment.clear();
    }
    Ok(text)
}
