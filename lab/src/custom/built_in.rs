//! The project's own shaders, which methods from folders may use. A shader or an include that a folder lacks is looked
//! for among these shaders, by its path below `shaders-glsl`. Their texts are part of the program, so a folder that
//! uses them needs no copy of the project.

use std::path::{Path, PathBuf};

include!(concat!(env!("OUT_DIR"), "/built_in_shaders.rs"));

/// The beginning of the paths by which messages name the built-in shaders. No file is read by a path with this
/// beginning.
const PREFIX: &str = "shaders-glsl:";

/// Returns the path of the shader with a name, such as `thesis/ssct.frag`; `None` if there is none.
pub fn path(name: &str) -> Option<PathBuf> {
    SHADERS.iter().find(|(known, _)| *known == name).map(|(name, _)| PathBuf::from(format!("{PREFIX}{name}")))
}

/// Returns the text of the shader with a path that [`path`] gave; `None` for every other path.
pub fn text(path: &Path) -> Option<&'static str> {
    let name = path.to_str()?.strip_prefix(PREFIX)?;
    SHADERS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shader_is_found_by_its_path_alone() {
        let shader = path("thesis/ssct.frag").expect("a shader of the project");
        assert!(text(&shader).expect("its text").contains("#pragma program(Ssct)"));
        for other in ["ssct.frag", "thesis", "thesis/../thesis/ssct.frag", "thesis/ERRATA.md", ""] {
            assert_eq!(path(other), None, "{other}");
        }
        assert_eq!(text(Path::new("thesis/ssct.frag")), None);
    }
}
