//! Finds GLSL that Vulkan's compiler does not take, before that compiler runs, since its messages do not say what to
//! write instead.

use ssct_ground::{Error, Result};
use std::path::Path;

/// Names of GLSL before version 140, each with advice on what to write in its place.
pub const NAMES: [(&str, &str); 11] = [
    ("texture2DLod", "write textureLod"),
    ("texture2DProj", "write textureProj"),
    ("texture2DRect", "use a sampler2D, and write texture with coordinates from 0 to 1"),
    ("texture2D", "write texture"),
    ("texture3D", "write texture"),
    ("textureCubeLod", "write textureLod"),
    ("textureCube", "write texture"),
    ("gl_FragColor", "declare an output, as in `out vec4 shown;`"),
    ("gl_FragData", "declare outputs, as in `layout(location = 0) out vec4 shown;`"),
    ("varying", "write in"),
    ("attribute", "write in"),
];

/// Refuses GLSL that is too old for Vulkan's compiler, or made for Shadertoy.
///
/// # Errors
/// [`Malformed`](ssct_ground::Error::Malformed) for a `#version` that is too old, with its line and advice on each old name. A text
/// without `#version`, or with `mainImage` and no `main`, is refused as well.
pub fn check(path: &Path, source: &str) -> Result<()> {
    let text = without_comments(source);
    let wrong = |line: Option<usize>, message: String| Err(Error::malformed(path, line, message));
    let has_word = |name: &str| words(&text).any(|word| word == name);
    if has_word("mainImage") && !has_word("main") {
        return wrong(
            None,
            "has mainImage and no main: begin with `#version 330`, `in vec2 uv;` and `out vec4 shown;`, and end with \
             `void main() { mainImage(shown, gl_FragCoord.xy); }`"
                .to_owned(),
        );
    }
    let Some((line, (number, is_es))) = version(&text) else {
        let message = format!("has no #version; begin with `#version 330`{}", replacements(&text));
        return wrong(None, message);
    };
    let least = if is_es { 310 } else { 140 };
    if number >= least {
        return Ok(());
    }
    let advised = if is_es || number == 100 { "#version 310 es" } else { "#version 330" };
    let name = if is_es || number == 100 { "GLSL ES" } else { "GLSL" };
    let message = format!("{name} of version {number} is too old; write `{advised}`{}", replacements(&text));
    wrong(Some(line), message)
}

/// Returns advice on each old name that a text has, as the end of a sentence; empty if it has none.
fn replacements(text: &str) -> String {
    let has_name = |(name, _): &&(&str, &str)| words(text).any(|word| word == *name);
    NAMES.iter().filter(has_name).map(|(name, instead)| format!("; for {name}, {instead}")).collect()
}

/// Returns the number of the line with `#version`, and the version: its number, and whether it is of GLSL ES. `None` if
/// the text states no number.
fn version(text: &str) -> Option<(usize, (u32, bool))> {
    let stated = |(index, line): (usize, &str)| {
        let rest = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("version")?;
        let mut words = rest.split_whitespace();
        Some((index + 1, (words.next()?.parse().ok()?, words.next() == Some("es"))))
    };
    text.lines().enumerate().find_map(stated)
}

/// Returns the words of a text: its names and numbers.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// Returns the text with blanks in place of comments. Line breaks are kept, so that lines have the same numbers.
fn without_comments(source: &str) -> String {
    let mut text = String::with_capacity(source.len());
    let mut rest = source;
    while let Some(start) = rest.find("//").into_iter().chain(rest.find("/*")).min() {
        let (before, comment) = rest.split_at(start);
        text.push_str(before);
        let end = match comment.starts_with("//") {
            true => comment.find('\n').unwrap_or(comment.len()),
            // The offset counts from behind the two characters `/*`, and `*/` has two more.
            false => comment[2..].find("*/").map_or(comment.len(), |end| end + 4),
        };
        text.extend(comment[..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        rest = &comment[end..];
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the message with which a shader of this text is refused; `None` if it is not.
    fn said(source: &str) -> Option<String> {
        check(Path::new("s.frag"), source).err().map(|e| e.to_string())
    }

    #[test]
    fn newer_versions_are_left_to_the_compiler() {
        for text in [
            "#version 140\nvoid main() {}",
            "// a\n/* b\n */ # version 450 core\nvoid main() {}",
            "#version 310 es\nvoid main() {}",
            "#version 330\n// texture2D, mainImage, varying\nvoid main() {}",
            "#version 330\nvoid mainImage(out vec4 c, vec2 p) {} void main() { mainImage(a, b); }",
        ] {
            assert_eq!(said(text), None, "{text}");
        }
    }

    #[test]
    fn older_versions_are_refused_with_advice_on_what_to_write() {
        let old = "/* a\n*/\n#version 120\nvarying vec2 uv; void main() { gl_FragColor = texture2D(p, uv); }";
        let expected = "s.frag:3: GLSL of version 120 is too old; write `#version 330`; for texture2D, write texture; for \
                        gl_FragColor, declare an output, as in `out vec4 shown;`; for varying, write in";
        assert_eq!(said(old).as_deref(), Some(expected));
        let es = "s.frag:1: GLSL ES of version 300 is too old; write `#version 310 es`";
        assert_eq!(said("#version 300 es\nvoid main() {}").as_deref(), Some(es));
        let none = "s.frag: has no #version; begin with `#version 330`; for varying, write in";
        assert_eq!(said("varying vec2 uv; void main() {}").as_deref(), Some(none));
        let shadertoy = said("void mainImage(out vec4 c, in vec2 p) { c = vec4(0); }").unwrap();
        assert!(shadertoy.contains("has mainImage and no main: begin with `#version 330`"), "{shadertoy}");
        assert_eq!(said("#version 330\nvoid mainImage(out vec4 c, in vec2 p) {}"), Some(shadertoy));
    }
}
