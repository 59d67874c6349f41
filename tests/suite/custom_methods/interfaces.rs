//! Tests shaders that people bring along: shaders that OpenGL allows run, and a shader that does not fit its manifest
//! gets a sentence before a driver sees it. Each shader is as small as it can be; if it runs, it halves the lit colour.

use super::*;
use std::sync::OnceLock;

/// A method of one pass in the folder `m`: the file and the text of its shader, the lines of its manifest's sections
/// `[inputs]` and `[values]`, further sections, and the format of its result.
struct SmallMethod {
    file: &'static str,
    shader: String,
    inputs: String,
    values: String,
    sections: String,
    format: &'static str,
}

impl SmallMethod {
    /// Returns a method with a fragment shader that reads the image `picture`.
    fn fragment(shader: &str) -> Self {
        Self {
            file: "a.frag",
            shader: shader.to_owned(),
            inputs: "picture = \"lit-colour\"\n".to_owned(),
            values: String::new(),
            sections: String::new(),
            format: "rgba16f",
        }
    }

    /// Returns a method with a fragment shader that has some declarations and shows an expression of `colour`, the lit
    /// colour of the pixel.
    fn with(declarations: &str, shown: &str) -> Self {
        Self::fragment(&format!(
            "#version 330\nin vec2 at;\nout vec4 shown;\nuniform sampler2D picture;\n{declarations}\n\
             void main() {{ vec4 colour = texture(picture, at); shown = {shown}; }}\n"
        ))
    }

    /// Returns a method with a compute shader that stores to the image `made`.
    fn compute(shader: &str) -> Self {
        let inputs = "picture = \"lit-colour\"\nmade = \"result\"\n".to_owned();
        Self { file: "a.comp", inputs, ..Self::fragment(shader) }
    }

    /// Returns the method with other lines in the section `[values]`.
    fn values(self, values: &str) -> Self {
        Self { values: values.to_owned(), ..self }
    }

    /// Returns the method with other lines in the section `[inputs]`.
    fn inputs(self, inputs: &str) -> Self {
        Self { inputs: inputs.to_owned(), ..self }
    }

    /// Makes a folder with the room, and with the method in `m`.
    fn folder(&self) -> Folder {
        let Self { file, shader, inputs, values, sections, format } = self;
        let folder = Folder::new();
        folder.write("room.obj", ROOM);
        std::fs::create_dir(folder.path("m")).unwrap();
        folder.write(&format!("m/{file}"), shader);
        let reach = if *file == "a.comp" { "threads = \"result\"" } else { "targets = [\"result\"]" };
        folder.write(
            "m/method.toml",
            format!(
                "name = \"small\"\nsummary = \"small\"\n[image.result]\nformat = \"{format}\"\n[[pass]]\nname = \"p\"\n\
                 shader = \"{file}\"\n{reach}\n[inputs]\n{inputs}[values]\n{values}\
                 [output]\nreflection = \"result\"\nalpha = \"none\"\n{sections}"
            ),
        );
        folder
    }

    /// Renders the room by the method, and returns the values of the reflection.
    fn pixels(&self) -> Vec<f32> {
        let folder = self.folder();
        folder.succeed(&on_room("render", &["--method", "m", "--reflection-only", "-o", "r.exr"]));
        ssct_lab::report::images::read_exr_channels(&folder.path("r.exr"), ["R", "G", "B"], None).unwrap().values
    }

    /// Renders by the method, which must be refused, and returns the sentence.
    fn refused(&self) -> String {
        sentence(&self.folder(), &on_room("render", &["--method", "m", "-o", "x.png"]))
    }
}

/// Checks that the reflection of a method is half of the lit colour.
fn assert_halves_lit_colour(small: &SmallMethod) {
    static LIT_COLOR: OnceLock<Vec<f32>> = OnceLock::new();
    let lit = LIT_COLOR.get_or_init(|| SmallMethod::with("", "colour").pixels());
    let halved = small.pixels();
    assert!(lit.iter().any(|v| *v > 0.1));
    for (lit_value, found_value) in lit.iter().zip(&halved) {
        assert!((0.5 * lit_value - found_value).abs() < 1e-3, "{lit_value} became {found_value}:\n{}", small.shader);
    }
}

/// In OpenGL, samplers, blocks and images have bindings of their own, so that one number may occur in each kind. In
/// Vulkan one number is one binding, so that the program must count anew.
#[test]
fn bindings_are_counted_apart_as_opengl_does() {
    assert_halves_lit_colour(
        &SmallMethod::fragment(
            "#version 450\nin vec2 at;\nout vec4 shown;\nlayout(binding = 0) uniform sampler2D picture;\n\
             layout(std140, binding = 0) uniform Numbers { float gain; };\nvoid main() { shown = texture(picture, at) * gain; }\n",
        )
        .values("gain = 0.5\n"),
    );
    assert_halves_lit_colour(&SmallMethod::compute(
        "#version 450\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(binding = 0) uniform sampler2D picture;\n\
         layout(binding = 0, rgba16f) uniform writeonly image2D made;\n\
         void main() { ivec2 p = ivec2(gl_GlobalInvocationID.xy); imageStore(made, p, 0.5 * texelFetch(picture, p, 0)); }\n",
    ));
    // Two samplers and a storage image without a format may share one binding number.
    assert_halves_lit_colour(
        &SmallMethod::compute(
            "#version 450\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(binding = 1) uniform sampler2D picture;\n\
             layout(binding = 1) uniform sampler2D other;\nlayout(binding = 1) uniform writeonly image2D made;\n\
             void main() { ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n\
             imageStore(made, p, 0.25 * (texelFetch(picture, p, 0) + texelFetch(other, p, 0))); }\n",
        )
        .inputs("picture = \"lit-colour\"\nother = \"lit-colour\"\nmade = \"result\"\n"),
    );
}

/// Uniforms outside of blocks are read as GLSL means them: with preprocessor conditions, default values, arrays,
/// matrices, structs and comments. Vulkan has no such uniforms: the program finds them in the text and puts them into a
/// block.
#[test]
fn loose_uniforms_are_read_by_what_they_mean() {
    for (declarations, values) in [
        ("#ifdef GRAIN\nuniform float grain;\n#endif\nuniform float gain;", "gain = 0.5\n"),
        ("uniform float gain;\n#ifdef GRAIN\nuniform float grain;\n#endif", "gain = 0.5\n"),
        ("#if 0\nuniform float gain = 9.0;\n#else\nuniform float gain;\n#endif", "gain = 0.5\n"),
        ("uniform float\n    gain;", "gain = 0.5\n"),
        ("uniform float gain = 0.5;", ""),
        ("#define HALF (1.0 / 2.0)\nuniform float gain = HALF;", ""),
        ("uniform float other = 3.0, gain = 0.5;", ""),
        ("uniform float gain = 9.0;", "gain = 0.5\n"),
        ("// uniform float no;\n/* uniform float neither; */ uniform /* a */ float gain; // end", "gain = 0.5\n"),
        ("uniform float unused;\nuniform float gain;", "gain = 0.5\n"),
        ("layout(location = 7) uniform highp float gain;", "gain = 0.5\n"),
        ("const int N = 2;\nuniform float gain;\nuniform float unused[N];", "gain = 0.5\n"),
    ] {
        assert_halves_lit_colour(&SmallMethod::with(declarations, "colour * gain").values(values));
    }
    for (declarations, shown, values) in [
        ("uniform float gains[4];", "colour * gains[2]", "gains = [1, 1, 0.5, 1]\n"),
        ("uniform float[4] gains = float[](1.0, 1.0, 0.5, 1.0);", "colour * gains[2]", ""),
        ("uniform vec3 tint = vec3(0.5);", "colour * vec4(tint, 0.5)", ""),
        ("uniform vec3 tints[2];", "colour * tints[1].y", "tints = [1, 1, 1, 1, 0.5, 1]\n"),
        ("uniform mat2 turn;", "colour * turn[1][0]", "turn = [1, 1, 0.5, 1]\n"),
        ("uniform mat3 turn = mat3(0.5);", "vec4(turn * colour.rgb, 1.0)", ""),
        ("uniform mat4x3 turn;", "colour * turn[3][1]", "turn = [1,1,1, 1,1,1, 1,1,1, 1,0.5,1]\n"),
        (
            "uniform bool on = true; uniform int many = 2; uniform uint few = 4u;",
            "on ? colour * float(many) / float(few) : colour",
            "",
        ),
        (
            "struct Light { vec3 c; float gain; };\nuniform B { Light lights[2]; };",
            "colour * lights[1].gain",
            "\"lights[1].gain\" = 0.5\n\"lights[1].c\" = [1, 1, 1]\n\"lights[0].c\" = [1, 1, 1]\n\"lights[0].gain\" = 1\n",
        ),
        ("layout(row_major) uniform B { mat2x3 turn; };", "colour * turn[1][2]", "turn = [1, 1, 1, 1, 1, 0.5]\n"),
        ("uniform B { float gain; float unused; };", "colour * gain", "gain = 0.5\n"),
    ] {
        assert_halves_lit_colour(&SmallMethod::with(declarations, shown).values(values));
    }
}

/// A uniform may stand in an included file, and an error has the file and the line in which the mistake stands, though
/// the compiler sees one text.
#[test]
fn loose_uniforms_may_be_in_includes() {
    let small = SmallMethod::with("uniform float gain;\n#include \"b.glsl\"", "colour * gain * twice()");
    let small = small.values("gain = 0.5\nother = 0.5\n");
    let folder = small.folder();
    folder.write("m/b.glsl", "uniform float other;\nfloat twice() { return 2.0 * other; }\n");
    folder.succeed(&on_room("render", &["--method", "m", "-o", "a.png"]));
    // A mistake in an included file has that file's name and line. A mistake after the include has the line of the
    // including file.
    folder.write("m/b.glsl", "uniform float other;\nfloat twice() { return 2.0 * here; }\n");
    let render = on_room("render", &["--method", "m", "-o", "a.png"]);
    assert!(sentence(&folder, &render).contains("m/b.glsl:2: 'here' : undeclared identifier"));
    folder.write("m/b.glsl", "uniform float other;\nfloat once() { return other; }\n");
    assert!(sentence(&folder, &render).contains("m/a.frag:7: 'twice'"), "{}", sentence(&folder, &render));
}

/// If the default value of a uniform is an expression, the manifest must give a value, since nothing evaluates GLSL on
/// the host. A uniform without a value, or with too few numbers, is refused.
#[test]
fn values_of_their_own_that_are_more_than_numbers_are_asked_for() {
    let small = SmallMethod::with("uniform float gain = sin(0.5);", "colour * gain");
    assert!(small.refused().contains("the value that gain of a.frag has of its own is more than numbers"));
    assert_halves_lit_colour(
        &SmallMethod::with("uniform float gain = sin(0.5);", "colour * gain").values("gain = 0.5\n"),
    );
    let unfed = SmallMethod::with("uniform float gain;", "colour * gain").refused();
    assert!(
        unfed.contains("m/method.toml:5: pass \"p\": nothing feeds the field LooseUniforms.gain of a.frag"),
        "{unfed}"
    );
    let few = SmallMethod::with("uniform float gains[4];", "colour * gains[2]").values("gains = [1]\n").refused();
    assert!(few.contains("m/method.toml:12: ") && few.contains("the field has 4 numbers"), "{few}");
}

/// A sampler that is fed an image of another kind (cube, integers, array, three dimensions) is refused with both kinds
/// in the sentence. A driver would read anything, or crash.
#[test]
fn images_of_another_kind_are_refused() {
    let refused_sampler = |sampler: &str, expression: &str, image: &str| {
        let small = SmallMethod::fragment(&format!(
            "#version 450\nin vec2 at;\nout vec4 shown;\nuniform {sampler} picture;\nvoid main() {{ shown = vec4({expression}); }}\n"
        ));
        small.inputs(&format!("picture = \"{image}\"\n")).refused()
    };
    for (sampler, expression, image, expected) in [
        (
            "samplerCube",
            "texture(picture, vec3(at, 1.0))",
            "lit-colour",
            "a samplerCube, and is fed lit-colour, which is a sampler2D",
        ),
        ("sampler2D", "texture(picture, at)", "sky", "a sampler2D, and is fed sky, which is a samplerCube"),
        (
            "isampler2D",
            "texture(picture, at)",
            "lit-colour",
            "a isampler2D, and is fed lit-colour, which is a sampler2D",
        ),
        (
            "usampler2D",
            "texture(picture, at)",
            "depth:linear",
            "a usampler2D, and is fed depth:linear, which is a sampler2D",
        ),
        ("sampler2DArray", "texture(picture, vec3(at, 0.0))", "lit-colour", "a sampler2DArray, and is fed lit-colour"),
        ("sampler3D", "texture(picture, vec3(at, 0.0))", "lit-colour", "a sampler3D, and is fed lit-colour"),
        ("sampler1D", "texture(picture, at.x)", "blue-noise", "a sampler1D, and is fed blue-noise"),
        ("sampler2DMS", "texelFetch(picture, ivec2(0), 0)", "lit-colour", "a sampler2DMS, and is fed lit-colour"),
        (
            "sampler2DShadow",
            "texture(picture, vec3(at, 0.0))",
            "depth:standard",
            "a sampler2DShadow, which compares with a depth",
        ),
        ("samplerBuffer", "texelFetch(picture, 0)", "lit-colour", "a samplerBuffer, and is fed lit-colour"),
        ("sampler2D", "texture(picture, at)", "captures:colour", "which is a samplerCubeArray"),
    ] {
        let message = refused_sampler(sampler, expression, image);
        assert!(
            message.contains("m/method.toml:10: pass \"p\": picture of a.frag is ") && message.contains(expected),
            "{message}"
        );
    }
    let array = SmallMethod::with("uniform sampler2D more[2];", "colour + texture(more[0], at)");
    let array = array.inputs("picture = \"lit-colour\"\nmore = \"lit-colour\"\n").refused();
    assert!(array.contains("more of a.frag is an array of images or blocks"), "{array}");
}

/// A storage image whose declared format is not that of the manifest is refused. A driver would store bits of the wrong
/// format.
#[test]
fn images_for_storage_of_another_kind_are_refused() {
    let refused_store = |layout: &str, what: &str, format: &'static str| {
        let small = SmallMethod::compute(&format!(
            "#version 450\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout({layout}) uniform writeonly {what};\n\
             void main() {{ imageStore(made, ivec2(gl_GlobalInvocationID.xy), {}vec4(1)); }}\n",
            what.split("image").next().unwrap()
        ));
        SmallMethod { format, ..small }.inputs("made = \"result\"\n").refused()
    };
    let other = refused_store("rgba8", "image2D made", "rgba16f");
    assert!(other.contains("made of a.comp is declared rgba8, and result is rgba16f"), "{other}");
    let integers = refused_store("rgba32ui", "uimage2D made", "rgba16f");
    assert!(integers.contains("made of a.comp is an uimage2D, and result is an image2D"), "{integers}");
    let unknown = refused_store("rgba16i", "iimage2D made", "r32i");
    assert!(unknown.contains("declared of another format, and result is r32i"), "{unknown}");
}

/// A fragment shader may read one `in vec2` of texture coordinates. Other inputs that it reads are refused, since
/// nothing writes them; unread ones are allowed.
#[test]
fn inputs_of_other_names_and_kinds_are_refused() {
    let reading = |inputs: &str, shown: &str| {
        SmallMethod::fragment(&format!(
            "#version 330\n{inputs}\nout vec4 shown;\nuniform sampler2D picture;\nvoid main() {{ shown = {shown}; }}\n"
        ))
    };
    let message = reading("in vec3 ray;\nin vec2 at;", "texture(picture, at) * abs(ray.z)").refused();
    assert!(message.contains("a.frag reads `ray`; only texture coordinates are given"), "{message}");
    let message = reading("in vec2 at;\nin vec2 more;", "texture(picture, at + more)").refused();
    assert!(message.contains("a.frag reads `more`; only texture coordinates are given"), "{message}");
    let message = reading("in vec4 at;", "texture(picture, at.xy)").refused();
    assert!(message.contains("a.frag reads `at`; only texture coordinates are given, as one `in vec2`"), "{message}");
    let message = reading("flat in int which;", "vec4(which) * texture(picture, vec2(0.5))").refused();
    assert!(message.contains("a.frag reads `which`"), "{message}");
    // Texture coordinates may have any location, and inputs that a shader declares and does not read are allowed.
    assert_halves_lit_colour(&reading(
        "#extension GL_ARB_separate_shader_objects : enable\nlayout(location = 5) in vec2 at;",
        "0.5 * texture(picture, at)",
    ));
    assert_halves_lit_colour(&reading("in vec3 unread;\nin vec2 at;", "0.5 * texture(picture, at)"));
    assert_halves_lit_colour(&reading("", "0.5 * texelFetch(picture, ivec2(gl_FragCoord.xy), 0)"));
}

/// Outputs of a wrong type or location are refused, and so are shaders that exceed limits: threads, shared memory,
/// doubles, push constants and the size of a block.
#[test]
fn outputs_and_limits_are_checked() {
    let integers =
        SmallMethod::fragment("#version 330\nin vec2 at;\nout ivec4 shown;\nvoid main() { shown = ivec4(at.xyxy); }\n");
    let message = integers.inputs("").refused();
    assert!(message.contains("a.frag writes `shown` as signed integers, and result has floats"), "{message}");
    let gap = SmallMethod::fragment(
        "#version 330\nin vec2 at;\nlayout(location = 1) out vec4 shown;\nvoid main() { shown = at.xyxy; }\n",
    );
    let message = gap.inputs("").refused();
    assert!(message.contains("a.frag writes `shown` at location 1; targets are 0, 1 and so on"), "{message}");
    let compute = |head: &str, body: &str| {
        let shader = format!(
            "#version 450\n{head}\nlayout(rgba16f) uniform writeonly image2D made;\nvoid main() {{ {body} }}\n"
        );
        SmallMethod::compute(&shader).inputs("made = \"result\"\n").refused()
    };
    let store = "imageStore(made, ivec2(gl_GlobalInvocationID.xy), vec4(1.0));";
    let message = compute("layout(local_size_x = 64, local_size_y = 32) in;", store);
    assert!(message.contains("the workgroups of a.comp have 64x32x1 threads; at most 1024"), "{message}");
    let message =
        compute("layout(local_size_x = 8) in;\nshared vec4 kept[4096];", &format!("kept[0] = vec4(1.0); {store}"));
    assert!(message.contains("the workgroups of a.comp share 65536 bytes, more than 32768"), "{message}");
    let doubles = SmallMethod::fragment(
        "#version 450\nin vec2 at;\nout vec4 shown;\nuniform sampler2D picture;\n\
         void main() { shown = vec4(float(double(texture(picture, at).x) * 2.0lf)); }\n",
    )
    .refused();
    assert!(doubles.contains("needs 64-bit floats, which this program does not turn on"), "{doubles}");
    let push = SmallMethod::fragment(
        "#version 450\nin vec2 at;\nout vec4 shown;\nlayout(push_constant) uniform P { vec4 many[12]; };\n\
         void main() { shown = many[0] + at.xyxy; }\n",
    );
    let message = push.inputs("").refused();
    assert!(message.contains("the push constants P of a.frag have 192 bytes, more than 128"), "{message}");
    let large = SmallMethod::with("layout(std140) uniform B { vec4 many[5000]; };", "colour * many[0]").refused();
    assert!(large.contains("has a block in which many lies beyond the 65536 bytes"), "{large}");
}

/// GLSL of version 140 and later, and of 310 es, runs; older versions are refused, as the page about methods from
/// folders says.
#[test]
fn versions_are_what_the_page_says() {
    for version in ["140", "150", "330 core", "460", "310 es"] {
        let precision = if version.ends_with("es") { "precision highp float;\n" } else { "" };
        assert_halves_lit_colour(&SmallMethod::fragment(&format!(
            "#version {version}\n{precision}in vec2 at;\nout vec4 shown;\nuniform sampler2D picture;\n\
             void main() {{ shown = 0.5 * texture(picture, at); }}\n"
        )));
    }
    for version in ["#version 110\n", "#version 130\n", ""] {
        let message = SmallMethod::fragment(&format!(
            "{version}in vec2 at;\nout vec4 shown;\nuniform sampler2D picture;\nvoid main() {{ shown = texture(picture, at); }}\n"
        ))
        .refused();
        assert!(message.contains("m/a.frag"), "{message}");
    }
}

/// A buffer that is smaller than the shader's block is refused, and one of the same size is accepted. A shader would
/// write past the end of a smaller one.
#[test]
fn storage_blocks_must_fit_their_buffers() {
    let small = SmallMethod::compute(
        "#version 450\nlayout(local_size_x = 8, local_size_y = 8) in;\nlayout(std430) buffer Kept { vec4 first[64]; } kept;\n\
         layout(rgba16f) uniform writeonly image2D made;\n\
         void main() { kept.first[63] = vec4(1.0); imageStore(made, ivec2(gl_GlobalInvocationID.xy), kept.first[0]); }\n",
    );
    let small = small.inputs("kept = \"list\"\nmade = \"result\"\n");
    let section = |bytes: u32| format!("[buffer.list]\nbytes = {bytes}\n");
    let with_buffer = |bytes: u32| SmallMethod { sections: section(bytes), ..copied(&small) };
    let message = with_buffer(512).refused();
    assert!(message.contains("the shader's block has 1024 bytes, and the buffer list has 512"), "{message}");
    let folder = with_buffer(1024).folder();
    folder.succeed(&on_room("render", &["--method", "m", "-o", "a.png"]));
}

/// Returns a copy of a method.
fn copied(small: &SmallMethod) -> SmallMethod {
    let SmallMethod { file, shader, inputs, values, sections, format } = small;
    SmallMethod {
        file,
        shader: shader.clone(),
        inputs: inputs.clone(),
        values: values.clone(),
        sections: sections.clone(),
        format,
    }
}
