//! Puts uniforms outside of blocks, which OpenGL allows, into blocks, which Vulkan demands.
//!
//! The text must be preprocessed, so that it has no comments, macros, includes or lines that are switched off. Of the
//! rest, only declarations outside of braces are read, each up to its semicolon.

/// The name of the block of loose uniforms. A loose uniform whose type or array size has a name that the shader
/// declares stays where it is, in a block of its own, whose name is this name with a number from 1.
pub const LOOSE: &str = "LooseUniforms";

/// Words that may stand before the type of a declaration.
const QUALIFIERS: [&str; 12] = [
    "uniform",
    "highp",
    "mediump",
    "lowp",
    "precise",
    "invariant",
    "coherent",
    "volatile",
    "restrict",
    "readonly",
    "writeonly",
    "shared",
];

/// A text with its loose uniforms in blocks.
#[derive(Debug, Default, PartialEq)]
pub struct HoistedUniforms {
    /// The text with blocks in the place of loose uniforms. Lines stay where they are.
    pub text: String,
    /// Names of uniforms with their initial values; `None` for a value that does not consist of numbers alone.
    pub initial_values: Vec<(String, Option<Vec<f64>>)>,
}

/// Puts the loose uniforms of a text into blocks. One block, in the place of the first loose uniform, has all that may
/// stand there; each other uniform gets a block of its own in its place.
pub fn hoist(text: &str) -> HoistedUniforms {
    let mut hoisted = HoistedUniforms::default();
    let mut blocks = Blocks::default();
    // The end of the last declaration that was replaced.
    let mut end_of_last = 0;
    for (start, end) in declarations(text) {
        let Some(uniform) = LooseUniform::read(&text[start..end]) else { continue };
        hoisted.text.push_str(&text[end_of_last..start]);
        blocks.place(&uniform, &mut hoisted.text);
        // The line breaks of a declaration are kept, so that lines stay where they are.
        hoisted.text.extend(text[start..end].chars().filter(|c| *c == '\n'));
        hoisted.initial_values.extend(uniform.initial_values);
        end_of_last = end;
    }
    hoisted.text.push_str(&text[end_of_last..]);
    if !blocks.shared.is_empty() {
        let block = format!("layout(std140) uniform {LOOSE} {{ {}}};", blocks.shared);
        hoisted.text.insert_str(blocks.first, &block);
    }
    hoisted
}

/// The blocks that the loose uniforms of a text have made so far.
#[derive(Default)]
struct Blocks {
    /// The fields of the block that most uniforms share.
    shared: String,
    /// The byte of the new text at which the shared block is inserted: the place of its first uniform.
    first: usize,
    /// The number of blocks for declarations that stay where they are.
    apart: usize,
}

impl Blocks {
    /// Adds a declaration to the shared block, or writes a block for it alone at the end of `text`.
    fn place(&mut self, uniform: &LooseUniform, text: &mut String) {
        if uniform.is_plain {
            if self.shared.is_empty() {
                self.first = text.len();
            }
            self.shared.push_str(&uniform.fields);
            return;
        }
        self.apart += 1;
        text.push_str(&format!("layout(std140) uniform {LOOSE}{} {{ {}}};", self.apart, uniform.fields));
    }
}

/// Returns the byte ranges, as first byte and end, of declarations outside of braces, each with its semicolon.
/// Functions, blocks and structs are left out.
fn declarations(text: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    // The first byte of the declaration that is being read, the depth of open braces, and what the braces enclose.
    let mut start = None;
    let (mut depth, mut is_block, mut is_function) = (0_usize, false, false);
    let mut at_line_start = true;
    let mut bytes = text.bytes().enumerate();
    while let Some((offset, byte)) = bytes.next() {
        if byte == b'#' && at_line_start {
            // A directive takes its whole line.
            bytes.by_ref().find(|(_, b)| *b == b'\n');
            continue;
        }
        at_line_start = byte == b'\n' || (at_line_start && byte.is_ascii_whitespace());
        if !byte.is_ascii_whitespace() {
            start.get_or_insert(offset);
        }
        match byte {
            b'{' => {
                let before = start.map_or("", |start| text[start..offset].trim_end());
                if depth == 0 {
                    is_function = before.ends_with(')');
                    // A brace behind an equals sign opens a list of values.
                    is_block |= !is_function && !before.ends_with('=');
                }
                depth += 1;
            }
            b'}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 && is_function {
                    (start, is_block, is_function) = (None, false, false);
                }
            }
            b';' if depth == 0 => {
                found.extend(start.filter(|_| !is_block).map(|start| (start, offset + 1)));
                (start, is_block, is_function) = (None, false, false);
            }
            _ => {}
        }
    }
    found
}

/// A declaration of loose uniforms of numeric types.
struct LooseUniform {
    /// The fields of a block, each with its semicolon.
    fields: String,
    /// True if the type and the array sizes use no name of the shader, and so are known everywhere.
    is_plain: bool,
    /// Names and initial values, as in [`HoistedUniforms`].
    initial_values: Vec<(String, Option<Vec<f64>>)>,
}

impl LooseUniform {
    /// Reads a declaration; `None` if it declares something other than loose uniforms of numeric types.
    fn read(declaration: &str) -> Option<Self> {
        let mut rest = declaration.trim().strip_suffix(';')?;
        let mut is_uniform = false;
        let kind = loop {
            rest = rest.trim_start();
            let word = leading_name(rest);
            if word == "layout" {
                let inside = rest["layout".len()..].trim_start().strip_prefix('(')?;
                rest = inside.split_once(')')?.1;
            } else if QUALIFIERS.contains(&word) {
                is_uniform |= word == "uniform";
                rest = &rest[word.len()..];
            } else {
                break word;
            }
        };
        if !is_uniform || kind.is_empty() || is_opaque(kind) {
            return None;
        }
        let rest = &rest[kind.len()..];
        let mut uniform = Self { fields: String::new(), is_plain: is_built_in(kind), initial_values: Vec::new() };
        // An array may stand behind the type, as in `float[4] gains`.
        let (type_size, rest) = match rest.trim_start().strip_prefix('[').and_then(|_| rest.split_once(']')) {
            Some((size, rest)) => (format!("{size}]"), rest),
            None => (String::new(), rest),
        };
        for declarator in split_outside_brackets(rest, ',') {
            let (declared, value) = match split_outside_brackets(declarator, '=')[..] {
                [declared] => (declared.trim(), None),
                [declared, value] => (declared.trim(), Some(value.trim())),
                _ => return None,
            };
            let name = leading_name(declared);
            let sizes = format!("{}{type_size}", &declared[name.len()..]);
            uniform.is_plain &= !sizes.contains(|c: char| c.is_ascii_alphabetic() || c == '_');
            uniform.fields.push_str(&format!("{kind} {name}{sizes}; "));
            uniform
                .initial_values
                .extend(value.map(|value| (name.to_owned(), super::initial_values::evaluate(value, kind))));
        }
        Some(uniform)
    }
}

/// Returns the name at the beginning of a text; empty if the text begins with something else.
fn leading_name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// Splits a text at the separators that stand outside of brackets.
fn split_outside_brackets(text: &str, separator: char) -> Vec<&str> {
    let (mut found, mut depth, mut start) = (Vec::new(), 0_i32, 0);
    for (offset, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            c if c == separator && depth == 0 => {
                found.push(&text[start..offset]);
                start = offset + c.len_utf8();
            }
            _ => {}
        }
    }
    found.push(&text[start..]);
    found
}

/// True for a type that is no number, such as samplers and images, whose uniforms need no block in Vulkan either.
fn is_opaque(kind: &str) -> bool {
    // The letter for whole numbers is removed, as from `isampler2D` and `uimage2D`; `image2D` keeps its first letter.
    let bare = if kind.starts_with("image") { kind } else { kind.strip_prefix(['i', 'u']).unwrap_or(kind) };
    ["sampler", "image", "texture", "subpassInput", "atomic_uint", "accelerationStructure"]
        .iter()
        .any(|opaque| bare.starts_with(opaque))
}

/// True if `kind` is a type of numbers that GLSL itself defines, such as `vec3`.
fn is_built_in(kind: &str) -> bool {
    let size = |rest: &str| rest.len() == 1 && rest.starts_with(['2', '3', '4']);
    let is_vector = |prefix: &str| kind.strip_prefix(prefix).is_some_and(size);
    let matrix = |rest: &str| size(rest) || rest.split_once('x').is_some_and(|(c, r)| size(c) && size(r));
    ["float", "int", "uint", "bool"].contains(&kind)
        || ["vec", "ivec", "uvec", "bvec"].into_iter().any(is_vector)
        || kind.strip_prefix("mat").is_some_and(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniforms_that_stand_alone_become_a_block() {
        let source = "#version 330\nuniform sampler2D a;\nuniform mat4 m;\nuniform highp float x = 2.0;\n\
            layout(location = 3) uniform vec2 size, other[2];\nuniform Block { float y; };\nvoid main() {}\n";
        let hoisted = hoist(source);
        let lines: Vec<&str> = hoisted.text.lines().collect();
        assert_eq!(lines.len(), source.lines().count());
        assert_eq!(lines[2], "layout(std140) uniform LooseUniforms { mat4 m; float x; vec2 size; vec2 other[2]; };");
        assert_eq!((lines[1], lines[3], lines[4]), ("uniform sampler2D a;", "", ""));
        assert_eq!(lines[5], "uniform Block { float y; };");
        assert_eq!(hoisted.initial_values, [("x".to_owned(), Some(vec![2.0]))]);
        let plain = "#version 460\nlayout(std140, binding = 0) uniform B {\n    float x;\n} b;\nvoid main() {}\n";
        assert_eq!(hoist(plain).text, plain);
    }

    #[test]
    fn declarations_are_read_by_their_tokens() {
        // The first block in the text that is made of `source`.
        let block = |source: &str| {
            let text = hoist(source).text;
            assert_eq!(text.matches('\n').count(), source.matches('\n').count(), "lines stay: {text}");
            let from = text.find("layout(std140)").expect("a block");
            text[from..text[from..].find("};").map_or(text.len(), |end| from + end + 2)].to_owned()
        };
        let is = |source: &str, fields: &str| {
            assert_eq!(block(source), format!("layout(std140) uniform LooseUniforms {{ {fields} }};"), "{source}");
        };
        is("uniform float\n    gain;\n", "float gain;");
        is("uniform float a = 0.5, b = 0.0;", "float a; float b;");
        is("uniform float gains[4];", "float gains[4];");
        is("uniform float[4] gains;", "float gains[4];");
        is("uniform mat2 turn;uniform bool on ;", "mat2 turn; bool on;");
        is("highp uniform layout(location = 2) vec3 c;", "vec3 c;");
        is("struct S { float a; };\nvoid f() { if (true) { } }\nuniform float a;", "float a;");
        is("uniform float w[2] = { 1.0, 2.0 };", "float w[2];");
        is("uniform vec2 p = vec2(1.0, 2.0), q;", "vec2 p; vec2 q;");
        is("#extension GL_x : enable\nuniform float a;\n#line 3\nuniform float b;", "float a; float b;");
        is("uniform usampler2D s;uniform image2D i;uniform iimage2D j;uniform uint u;", "uint u;");
    }

    #[test]
    fn a_uniform_that_uses_a_name_of_the_shader_stays_behind_the_declaration_of_the_name() {
        let source = "uniform float a;\nconst int N = 3;\nuniform float w[N];\nuniform S s;\nuniform int b;\n";
        let text = hoist(source).text;
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "layout(std140) uniform LooseUniforms { float a; int b; };");
        assert_eq!(lines[2], "layout(std140) uniform LooseUniforms1 { float w[N]; };");
        assert_eq!(lines[3], "layout(std140) uniform LooseUniforms2 { S s; };");
    }
}
