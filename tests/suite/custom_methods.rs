//! Tests methods from folders, as a user has them: the examples run as any other method, and each mistake gets a
//! sentence with file and line.

mod interfaces;
mod published;

use crate::common::folder::Folder;
use crate::common::repository;
use serde_json::Value;

/// An OBJ file with a floor and a wall.
const ROOM: &str = "o floor\nv -4 0 -8\nv 4 0 -8\nv 4 0 0\nv -4 0 0\nf 1 4 3 2\n\
                    o wall\nv -4 0 -6\nv 4 0 -6\nv 4 4 -6\nv -4 4 -6\nf 5 6 7 8\n";

/// Returns a folder with the room, and with a copy of an example method in its folder `m`.
fn with_example(name: &str) -> Folder {
    let folder = Folder::new();
    folder.write("room.obj", ROOM);
    std::fs::create_dir(folder.path("m")).unwrap();
    let from = repository().join("examples/methods").join(name);
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path("m").join(path.file_name().unwrap())).unwrap();
    }
    folder
}

/// Returns the arguments of a command on the room at a size of 66×37 pixels.
fn on_room<'a>(command: &'a str, args: &[&'a str]) -> Vec<&'a str> {
    let place = ["--scene", "room.obj", "--eye", "0,1.5,0", "--look-at", "0,1,6", "--size", "66x37"];
    [&[command], &place[..], args].concat()
}

/// Replaces a text in a file. Panics if the file does not have this text.
fn change(folder: &Folder, file: &str, from: &str, to: &str) {
    let text = folder.text(file);
    assert!(text.contains(from), "{file} has no {from:?}");
    folder.write(file, text.replace(from, to));
}

/// Runs a command that must fail with status 1, and returns its one sentence without the prefix `ssct: `.
fn sentence(folder: &Folder, args: &[&str]) -> String {
    let output = folder.run(args);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert_eq!(text.lines().count(), 1, "{text}");
    text.strip_prefix("ssct: ").expect("our own sentence").trim_end().to_owned()
}

/// Two examples are rendered, timed and judged. Each reflects, has its own pass, and has its parameter as an option and
/// in the records, as a built-in method has. The table of methods is fixed, so that each command must add these by
/// itself.
#[test]
fn examples_run_as_methods_of_the_table_do() {
    for (name, pass, parameter) in [("march", "march", "view_steps"), ("three-pass", "intersect", "tile_steps")] {
        let folder = with_example(name);
        folder.succeed(&on_room("render", &["--method", "m", "--validation", "-o", "a.png", "--roughness", "0"]));
        folder.succeed(&on_room("render", &["--method", "m", "-o", "b.png", "--reflectivity", "0"]));
        assert!(folder.image("a.png") != folder.image("b.png"), "{name} reflects");
        let flag = format!("--{}=77", parameter.replace('_', "-"));
        let timed = on_room("time", &["--method", "m,linear", "--samples", "1", "--warmup", "0", &flag, "--json"]);
        let rows: Value = serde_json::from_str(&folder.succeed(&timed)).unwrap();
        let row = &rows.as_array().unwrap()[0];
        assert_eq!((row["method"].as_str(), row["setup"][parameter].as_u64()), (Some(name), Some(77)), "{row}");
        let passes = row["passes"].to_string();
        assert!(passes.contains(&format!("\"{pass}\"")), "{passes}");
        let judged = on_room(
            "error",
            &["--method", "./m", "--rays", "4", "--samples", "1", "--roughness", "0", "--no-sweep", "--json"],
        );
        let rows: Value = serde_json::from_str(&folder.succeed(&judged)).unwrap();
        let errors = rows.as_array().unwrap().iter().filter(|r| r["method"] == name);
        assert!(errors.count() > 0, "{rows}");
        folder.succeed(&["stress", "--method", "m", "--help"]);
    }
}

/// Two variants of one folder differ by the value of a parameter, which the records have. The folder is loaded once,
/// although its path is written in two ways. A path with blanks stands in quotes.
#[test]
fn a_variant_may_be_a_folder_and_names_are_known_once() {
    let folder = with_example("march");
    std::fs::create_dir(folder.path("my methods")).unwrap();
    let variants = ["--variant", "m --view-steps 10", "--variant", "'my methods/../m' --view-steps 20"];
    let args = [&variants[..], &["--rays", "4", "--samples", "1", "--roughness", "0", "--json"]].concat();
    let rows: Value = serde_json::from_str(&folder.succeed(&on_room("error", &args))).unwrap();
    let steps = |r: &Value| r["setup"]["view_steps"].as_u64();
    let found: Vec<u64> = rows.as_array().unwrap().iter().filter_map(steps).collect();
    assert!(found.contains(&10) && found.contains(&20), "{found:?}");
}

/// A method whose shaders read every source of images and values is rendered and timed without a message of the layers.
/// Each source has passes and barriers of its own.
#[test]
fn every_kind_of_input_is_made_and_passes_the_validation_layers() {
    let sources = [
        "lit-colour-chain",
        "lit-colour-chain:gaussian",
        "depth:reversed",
        "depth:standard",
        "depth:linear",
        "normal:view",
        "normal:view:octahedral-unorm",
        "normal:world:unorm",
        "position:view",
        "position:world",
        "material",
        "hi-z:min:reversed",
        "hi-z:max:linear",
        "hi-z:min:standard:padded",
        "thesis-hi-z",
        "visibility",
        "pyramid",
        "blue-noise",
        "motion",
        "previous:lit-colour",
        "previous:depth:reversed",
        "previous:depth:standard",
        "previous:normal:view",
        "previous:normal:world",
        "previous:material",
    ];
    let folder = Folder::new();
    folder.write("room.obj", ROOM);
    std::fs::create_dir(folder.path("m")).unwrap();
    // Several shaders share the images, since some devices allow 16 images in a stage.
    let (mut manifest, mut inputs) = (String::from("name = \"all\"\nsummary = \"all\"\n"), String::from("[inputs]\n"));
    for (n, chunk) in sources.chunks(8).enumerate() {
        let mut shader = String::from("#version 450\nlayout(location = 0) out vec4 result;\n");
        let mut sum = String::from("vec4(0.0)");
        for (index, source) in chunk.iter().enumerate() {
            shader += &format!("uniform sampler2D image_{n}_{index};\n");
            sum += &format!(" + texelFetch(image_{n}_{index}, ivec2(0), 0)");
            inputs += &format!("image_{n}_{index} = \"{source}\"\n");
        }
        shader += "layout(std140) uniform B { mat4 m; mat3 turn; vec4 size; vec3 eye; int frame; bool first; };\n";
        shader += &format!("void main() {{ result = {sum} + m[0] + size * turn[0].x * eye.x + float(frame); }}\n");
        folder.write(&format!("m/{n}.frag"), shader);
        manifest += &format!("[[pass]]\nname = \"pass {n}\"\nshader = \"{n}.frag\"\ntargets = [\"result\"]\n");
    }
    manifest += &inputs;
    manifest += "[image.result]\nformat = \"rgba16f\"\n[output]\nreflection = \"result\"\nalpha = \"none\"\n[values]\n\
        m = \"previous-world-to-clip\"\nturn = \"view-to-world\"\nsize = \"size\"\neye = \"eye\"\nframe = \"frame\"\n\
        first = \"is-first-frame\"\n";
    folder.write("m/method.toml", manifest);
    folder.succeed(&on_room("render", &["--method", "m", "--validation", "-o", "a.png"]));
    // Several frames: each after the first reads images of the frame before.
    let timed = on_room("time", &["--method", "m", "--samples", "2", "--warmup", "1", "--validation", "--json"]);
    folder.succeed(&timed);
}

/// A shader reads the sky as a cube and captures as an array of cubes. Without captures, the run is refused with a
/// sentence.
#[test]
fn captures_and_the_sky_are_cubes() {
    let folder = Folder::new();
    folder.write("room.obj", ROOM);
    std::fs::create_dir(folder.path("m")).unwrap();
    let shader = "#version 450\nlayout(location = 0) out vec4 result;\nuniform samplerCube sky;\n\
        uniform samplerCubeArray cubes;\nuniform sampler2D normals;\n\
        layout(std140) uniform B { vec4 places[8]; int count; };\nvoid main() {\n\
        vec3 n = texelFetch(normals, ivec2(gl_FragCoord.xy), 0).xyz;\n\
        vec4 seen = textureLod(sky, n, 0.0) + textureLod(cubes, vec4(n, 0.0), 0.0);\n\
        result = vec4(seen.rgb + 1e-3 * places[0].y * float(count), 1.0);\n}\n";
    folder.write("m/a.frag", shader);
    let manifest = "name = \"cubes\"\nsummary = \"cubes\"\ncaptures = true\n[image.result]\nformat = \"rgba16f\"\n\
        [[pass]]\nname = \"look\"\nshader = \"a.frag\"\ntargets = [\"result\"]\n[inputs]\nsky = \"sky\"\n\
        cubes = \"captures:colour\"\nnormals = \"normal:world\"\n[values]\nplaces = \"capture-places\"\n\
        count = \"capture-count\"\n[output]\nreflection = \"result\"\n";
    folder.write("m/method.toml", manifest);
    let captured = ["--method", "m", "--validation", "--captures", "1", "--capture-side", "128", "-o", "a.png"];
    folder.succeed(&on_room("render", &captured));
    let without = on_room("render", &["--method", "m", "-o", "b.png"]);
    let output = folder.run(&without);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && text.contains("captures:colour, and there are no captures"), "{text}");
}

/// Each mistake in a good manifest is refused with a sentence that has the manifest's line, where there is one. Each
/// case is a text of the manifest, the text that replaces it, and words of the sentence.
#[test]
fn mistakes_in_a_manifest_get_its_line() {
    let render = on_room("render", &["--method", "m", "-o", "x.png"]);
    let cases = [
        ("name = \"march\"", "name = \"My March\"", "m/method.toml:2: the name \"My March\" must consist of"),
        ("name = \"march\"\ns", "name = \"ssct\"\ns", "m/method.toml: there is a method ssct already"),
        ("view = \"right\"", "view = \"up\"", "m/method.toml:7: unknown variant `up`"),
        ("view = \"right\"", "views = \"right\"", "m/method.toml:7: unknown field `views`"),
        ("default = 200", "default = 5000", "m/method.toml:11: parameter view-steps: 5000 is outside whole numbers"),
        ("range = [1, 4096]\n", "", "m/method.toml:11: parameter view-steps: a number needs a range"),
        ("[output]", "[buffer.b]\nbytes = 9223372036854775807\n[output]", "buffer b: bytes must be at most"),
        ("rgba16f", "rgb9", "image result: no format \"rgb9\"; there is: r8, rg8"),
        ("depth:linear", "depth:deep", "\"depth:deep\" is no image that there is: lit-colour"),
        ("colour = \"lit-colour\"\n", "", "nothing feeds the image colour of march.frag"),
        ("stride = \"parameter:view-stride\"\n", "", "nothing feeds the field LooseUniforms.stride of march.frag"),
        ("\"half-view\"", "\"near\"", "LooseUniforms.tangents of march.frag: the field has 2 numbers"),
        ("\"half-view\"", "\"half\"", "tangents: \"half\" is no value that there is: view-to-clip"),
        ("steps = \"parameter:view-steps\"", "steps = 1\nother = 2", "no shader reads other"),
        ("parameter:view-steps", "parameter:steps", "steps: there is no [parameter.steps]"),
        ("targets = [\"result\"]", "targets = [\"other\"]", "there is no [image.other]"),
        ("targets = [\"result\"]", "threads = \"result\"", "a fragment pass has targets"),
        ("reflection = \"result\"", "reflection = \"other\"", "output: there is no [image.other]"),
        (
            "format = \"rgba16f\"",
            "format = \"rgba16f\"\nhistory = true",
            "image result has a history that no pass reads",
        ),
        ("shader = \"march.frag\"", "shader = \"other.frag\"", "m/other.frag"),
        ("[output]\nreflection = \"result\"", "[output]", "m/method.toml: output.reflection is missing"),
        (
            "name = \"march\"\nsummary = \"a march in view space with a constant stride\"\n",
            "",
            "m/method.toml: name, summary are missing",
        ),
        ("targets = [\"result\"]", "targets = [\"result\"]\ninterleaved = true", "an interleaved pass has levels"),
        (
            "reflection = \"result\"",
            "reflection = \"result\"\nhits = \"result\"\nhits-are = \"uv-depth-path\"",
            "the format rgba32f and the scale 1",
        ),
    ];
    for (from, to, expected) in cases {
        let folder = with_example("march");
        change(&folder, "m/method.toml", from, to);
        let message = sentence(&folder, &render);
        assert!(message.contains(expected), "{to:?}: {message}");
    }
}

/// A parameter with the name of an option, of whatever command, is refused with the line of its section. Two options of
/// one name would end the program without a sentence of its own.
#[test]
fn a_parameter_takes_no_name_of_an_option() {
    let render = on_room("render", &["--method", "m", "-o", "x.png"]);
    for name in ["scale", "texture-size", "method", "preset", "include", "json", "samples", "help", "version", "file"] {
        let folder = with_example("march");
        change(&folder, "m/method.toml", "view-steps", name);
        let expected = format!("m/method.toml:11: parameter {name}: the option of this name belongs to the program");
        let message = sentence(&folder, &render);
        assert!(message.contains(&expected), "{message}");
    }
}

/// Each mistake in a good shader is refused with a sentence that has the shader's line, where there is one. The program
/// rewrites shaders before it compiles them, so that the compiler counts other lines.
#[test]
fn mistakes_in_a_shader_get_its_line() {
    let render = on_room("render", &["--method", "m", "-o", "x.png"]);
    let cases = [
        ("vec2 ndc = position_uv", "vec2 ndc = here", "m/march.frag:16: 'here' : undeclared identifier"),
        ("out vec4 reflection;", "out vec4 reflection; out vec4 more;", "writes 2 colours, and the pass has 1 targets"),
        ("uniform sampler2D colour;", "#include \"none.glsl\"\nuniform sampler2D colour;", "none.glsl"),
        ("#version 330 core", "", "m/march.frag"),
        ("texture(normals, uv)", "texture2D(normals, uv)", "texture2D is old GLSL; write texture"),
    ];
    for (from, to, expected) in cases {
        let folder = with_example("march");
        change(&folder, "m/march.frag", from, to);
        let message = sentence(&folder, &render);
        assert!(message.contains(expected), "{to:?}: {message}");
    }
    let folder = with_example("march");
    change(&folder, "m/method.toml", "shader = \"march.frag\"", "shader = \"march.spv\"\nstage = \"fragment\"");
    folder.write("m/march.spv", b"not words");
    assert!(sentence(&folder, &render).ends_with("march.spv: is not SPIR-V"));
}

/// A frame whose shader loops without end is given up after the half second that the manifest allows. Otherwise one
/// method would stop a whole study.
#[test]
fn a_shader_that_never_ends_is_given_up() {
    let folder = with_example("march");
    change(&folder, "m/method.toml", "summary =", "patience-s = 0.5\nsummary =");
    // The loop changes variables that the result depends on, so that no compiler may leave the loop out.
    change(&folder, "m/march.frag", "++i) {", "i = (i + 1) % steps) { place -= along; reflection.x += stride;");
    let message = sentence(&folder, &on_room("render", &["--method", "m", "-o", "x.png", "--view-steps", "1000"]));
    assert!(message.contains("not done in 0.5 s") && message.contains("march"), "{message}");
}

/// Returns the example `march` with a line added below `#version`, and with more files beside it, each a name and a
/// text.
fn including(line: &str, files: &[(&str, &str)]) -> Folder {
    let folder = with_example("march");
    let text = folder.text("m/march.frag");
    let (version, rest) = text.split_once('\n').unwrap();
    folder.write("m/march.frag", format!("{version}\n{line}\n{rest}"));
    for (name, text) in files {
        folder.write(name, text);
    }
    folder
}

/// Includes in a circle, too many, too deep or too large are refused. A file outside the method's folder is refused
/// unless `--include` allows its folder, since a method of somebody else could read the user's files.
#[test]
fn includes_end_and_stay_where_they_may_be() {
    let render = on_room("render", &["--method", "m", "-o", "x.png"]);
    let sentence_of = |line: &str, files: &[(&str, &str)]| sentence(&including(line, files), &render);
    // A file that includes itself, directly or through others.
    let itself = sentence_of("#include \"march.frag\"", &[]);
    assert!(itself.starts_with("m/march.frag:") && itself.ends_with("m/march.frag includes itself"), "{itself}");
    let circle = [("m/a.glsl", "#include \"b.glsl\"\n"), ("m/b.glsl", "#include \"a.glsl\"\n")];
    assert!(sentence_of("#include \"a.glsl\"", &circle).ends_with(".glsl includes itself"));
    // Each file includes the next one twice, so that there are over four thousand includes after twelve files.
    let twice: Vec<(String, String)> =
        (0..30).map(|n| (format!("m/{n}.glsl"), format!("#include \"{}.glsl\"\n", n + 1).repeat(2))).collect();
    let twice: Vec<(&str, &str)> = twice.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    assert!(sentence_of("#include \"0.glsl\"", &twice).contains("more than 4096 includes"));
    let deep: Vec<(String, String)> =
        (0..80).map(|n| (format!("m/{n}.glsl"), format!("#include \"{}.glsl\"\n", n + 1))).collect();
    let deep: Vec<(&str, &str)> = deep.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    assert!(sentence_of("#include \"0.glsl\"", &deep).contains("more than 64 includes"));
    let large = format!("// {}\n", "x".repeat(9 << 20));
    let large = [("m/a.glsl", large.as_str()), ("m/b.glsl", &large)];
    assert!(
        sentence_of("#include \"a.glsl\"\n#include \"b.glsl\"", &large).contains("more than 16777216 bytes together")
    );
    // Files of other folders are read only where the user allows them.
    let out = "#include \"../shared.glsl\"";
    let outside = sentence_of(out, &[("shared.glsl", "const float SHARED = 1.0;\n")]);
    assert!(outside.contains("shared.glsl is outside of the method's folder m"), "{outside}");
    let folder = including(out, &[("shared.glsl", "const float SHARED = 1.0;\n")]);
    folder.succeed(&[&render[..], &["--include", "."]].concat());
    folder.succeed(&[&render[..], &["--include=none", "--include=."]].concat());
    change(&folder, "m/method.toml", "shader = \"march.frag\"", "shader = \"../march.frag\"");
    std::fs::rename(folder.path("m/march.frag"), folder.path("march.frag")).unwrap();
    assert!(sentence(&folder, &render).contains("march.frag is outside of the method's folder m"));
    // With a guard, a file is empty when it is included for the second time, so that a circle ends.
    let guard = "#ifndef A\n#define A\n#include \"b.glsl\"\nconst float TWO = 2.0;\n#endif\n";
    let guarded = [("m/a.glsl", guard), ("m/b.glsl", "#include \"a.glsl\"\n")];
    including("#include \"a.glsl\"\n#include \"a.glsl\"", &guarded).succeed(&render);
}

/// A symbolic link in the method's folder that leads out of the folder is refused. A check of the path alone would not
/// notice it.
#[cfg(unix)]
#[test]
fn a_link_brings_no_file_into_a_method() {
    let folder = including("#include \"a.glsl\"", &[("secret.glsl", "const float SECRET = 1.0;\n")]);
    std::os::unix::fs::symlink("../secret.glsl", folder.path("m/a.glsl")).unwrap();
    let message = sentence(&folder, &on_room("render", &["--method", "m", "-o", "x.png"]));
    assert!(message.contains("m/a.glsl is outside of the method's folder m"), "{message}");
}

/// The preset of the author's values is refused for a method from a folder, whose manifest has its values. It would
/// change nothing, and the user would not know.
#[test]
fn a_preset_is_not_for_a_folder() {
    let folder = with_example("ssct");
    let commands = [
        on_room("render", &["--method", "./m", "--preset", "author", "-o", "a.png"]),
        on_room("time", &["--preset", "author", "--variant", "ssct", "--variant", "./m", "--samples", "1"]),
    ];
    for args in commands {
        let output = folder.run(&args);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("the preset author does not change") && message.contains("manifest"), "{message}");
    }
}
