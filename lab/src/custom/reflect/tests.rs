//! Tests the interfaces of small shaders and of damaged code.

use super::*;
use shaderc::{CompileOptions, Compiler, ShaderKind};

/// Compiles GLSL to the words of a module, as for a method: variables get bindings and locations where they have none.
fn compiled(text: &str, kind: ShaderKind) -> Vec<u32> {
    let mut options = CompileOptions::new().expect("options");
    options.set_auto_bind_uniforms(true);
    options.set_auto_map_locations(true);
    let made = Compiler::new().expect("a compiler").compile_into_spirv(text, kind, "a", "main", Some(&options));
    made.expect("compiles").as_binary().to_vec()
}

/// Returns the interface of a fragment shader with these declarations that writes the expression `value`. It also has
/// the input `at`, which is texture coordinates.
fn fragment(declarations: &str, value: &str) -> ShaderInterface {
    let text =
        format!("#version 450\nin vec2 at;\nout vec4 shown;\n{declarations}\nvoid main() {{ shown = {value}; }}\n");
    reflect(&compiled(&text, ShaderKind::Fragment), true).expect("an interface")
}

/// Returns the layout of the first variable, which must be a uniform block.
fn block(interface: &ShaderInterface) -> &BlockLayout {
    match &interface.variables[0].kind {
        VariableKind::Uniform(layout) => layout,
        other => panic!("{other:?}"),
    }
}

#[test]
fn numbers_lie_where_the_layout_says() {
    let declarations = "struct L { vec3 c; float g; };\n\
        layout(std140) uniform B { float a; vec2 b; float c[2]; mat2 d; mat3 e; layout(row_major) mat2x3 f; L g[2]; bool h; int i[2][2]; };";
    let interface = fragment(declarations, "vec4(a + g[1].c.x)");
    let layout = block(&interface);
    let field = |name: &str| layout.fields.iter().find(|f| f.name == name).expect(name);
    let check = |name: &str, component: Component, shape: [u32; 3], places: &[u32]| {
        let found = field(name);
        assert_eq!((found.component, found.shape, &found.places[..]), (component, shape, places), "{name}");
    };
    check("a", Component::Float, [1, 1, 1], &[0]);
    check("b", Component::Float, [1, 1, 2], &[8, 12]);
    check("c", Component::Float, [2, 1, 1], &[16, 32]);
    check("d", Component::Float, [1, 2, 2], &[48, 52, 64, 68]);
    check("e", Component::Float, [1, 3, 3], &[80, 84, 88, 96, 100, 104, 112, 116, 120]);
    // Rows of two lie 16 bytes apart.
    check("f", Component::Float, [1, 2, 3], &[128, 144, 160, 132, 148, 164]);
    check("g[0].c", Component::Float, [1, 1, 3], &[176, 180, 184]);
    check("g[1].g", Component::Float, [1, 1, 1], &[204]);
    check("h", Component::Uint, [1, 1, 1], &[208]);
    check("i", Component::Int, [4, 1, 1], &[224, 240, 256, 272]);
    assert_eq!(layout.size, 288);
    let read: Vec<&str> = layout.fields.iter().filter(|f| f.is_read).map(|f| f.name.as_str()).collect();
    assert_eq!(read, ["a", "g[0].c", "g[0].g", "g[1].c", "g[1].g"]);
}

#[test]
fn variables_have_bindings_of_their_own() {
    let declarations = "layout(binding = 3) uniform sampler2D picture;\nlayout(binding = 3) uniform samplerCube sky;\n\
        layout(std140, set = 1, binding = 0) uniform B { float a; } b;";
    let interface = fragment(declarations, "texture(picture, at) + texture(sky, at.xyx) + b.a");
    let names: Vec<(u32, &str)> = interface.variables.iter().map(|v| (v.binding, v.name.as_str())).collect();
    assert_eq!(names, [(0, "picture"), (1, "sky"), (2, "b")]);
    // The code that was written has the new bindings, too.
    let again = reflect(&interface.words, true).expect("an interface");
    let bindings: Vec<(u32, &str)> = again.variables.iter().map(|v| (v.binding, v.name.as_str())).collect();
    assert_eq!(bindings, names);
    let kinds: Vec<Dim> = interface
        .variables
        .iter()
        .filter_map(|v| if let VariableKind::Sampled(k) = v.kind { Some(k.dim) } else { None })
        .collect();
    assert_eq!(kinds, [Dim::Two, Dim::Cube]);
}

#[test]
fn inputs_outputs_constants_and_workgroups_are_found() {
    let interface =
        fragment("layout(constant_id = 4) const int many = 2;\nin vec3 unread;", "vec4(at, float(many), 1.0)");
    assert_eq!(interface.inputs.iter().map(|i| (i.name.as_str(), i.numbers)).collect::<Vec<_>>(), [("at", 2)]);
    assert_eq!(reflect(&interface.words, true).expect("an interface").inputs[0].location, 0);
    assert_eq!(interface.outputs.len(), 1);
    assert_eq!(interface.constants, [Constant { id: 4, name: "many".to_owned(), ty: "i32", default: 2 }]);
    let compute = "#version 450\nlayout(local_size_x = 8, local_size_y = 4) in;\nshared vec4 kept[16];\n\
        layout(std430, binding = 0) readonly buffer K { vec4 head; uint list[]; } k;\n\
        layout(binding = 1, r32f) uniform image2D made;\nvoid main() { kept[0] = k.head; imageStore(made, ivec2(0), kept[0]); }\n";
    let words = compiled(compute, ShaderKind::Compute);
    let compute_interface = reflect(&words, false).expect("an interface");
    assert_eq!((compute_interface.local_size, compute_interface.shared_bytes), ([8, 4, 1], 256));
    assert!(
        matches!(compute_interface.variables[0].kind, VariableKind::Storage(16))
            && compute_interface.variables[0].read_only
    );
    assert!(matches!(compute_interface.variables[1].kind, VariableKind::Stored(ImageKind { format: 3, .. })));
    assert_eq!(reflect(&words, true).unwrap_err(), "is a compute shader, and the pass is a fragment pass");
}

/// Returns the code of a shader that has every kind of declaration.
fn sample() -> Vec<u32> {
    let text = "#version 450\nin vec2 at;\nout vec4 shown;\nstruct L { vec3 c; float g; };\nuniform sampler2D picture;\n\
        layout(std140) uniform B { mat3 e; L g[2]; int i[2][2]; };\nlayout(constant_id = 1) const float k = 1.0;\n\
        layout(push_constant) uniform P { vec4 p; };\n\
        void main() { shown = texture(picture, at) * k + vec4(g[i[0][1]].c, e[0].x) + p; }\n";
    compiled(text, ShaderKind::Fragment)
}

#[test]
fn damaged_code_is_read_or_refused_without_a_panic() {
    let words = sample();
    assert!(reflect(&words, true).is_ok());
    // A random generator with a fixed seed, so that every run damages the same words.
    let mut state = 0x2545_f491_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..20_000 {
        let mut damaged = words.clone();
        for _ in 0..=random(3) {
            let index = random(damaged.len());
            damaged[index] = match random(4) {
                0 => damaged[random(damaged.len())],
                1 => random(1 << 16) as u32,
                2 => u32::MAX,
                _ => damaged[index] ^ (1 << random(32)),
            };
        }
        damaged.truncate(if random(8) == 0 { random(damaged.len()) } else { damaged.len() });
        if let Ok(interface) = reflect(&damaged, true) {
            assert!(interface.words.len() < 4 * words.len());
        }
    }
}

/// Removes the names of variables, blocks and members from a module, as a compiler does that strips them.
fn without_names(words: &[u32]) -> Vec<u32> {
    const NAME: u32 = 5;
    const MEMBER_NAME: u32 = 6;
    let mut stripped = words[..5].to_vec();
    let mut rest = &words[5..];
    while let Some(first) = rest.first() {
        // The first word of an instruction has its length in the upper half, and its opcode in the lower half.
        let (instruction, next) = rest.split_at((first >> 16) as usize);
        if ![NAME, MEMBER_NAME].contains(&(first & 0xffff)) {
            stripped.extend(instruction);
        }
        rest = next;
    }
    stripped
}

#[test]
fn a_module_without_names_has_sets_and_bindings() {
    let text = "#version 450\nlayout(location = 0) in vec2 at;\nlayout(location = 0) out vec4 shown;\n\
        layout(binding = 3) uniform sampler2D picture;\n\
        layout(std140, set = 1, binding = 2) uniform B { mat4 m; float gain; };\n\
        layout(push_constant) uniform P { vec4 tint; };\n\
        void main() { shown = gain * m * texture(picture, at) + tint; }\n";
    let words = without_names(&compiled(text, ShaderKind::Fragment));
    let found = reflect(&words, true).expect("an interface");
    let names: Vec<(&str, bool)> = found.variables.iter().map(|v| (v.name.as_str(), v.is_nameless)).collect();
    assert_eq!(names, [("0.3", true), ("1.2", true)]);
    let VariableKind::Uniform(layout) = &found.variables[1].kind else { panic!("{:?}", found.variables[1]) };
    assert_eq!(layout.fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["0", "1"]);
    assert_eq!(found.variables[1].block, "1.2");
    assert_eq!(found.push.expect("push constants").0, "push");

    let separate = "#version 450\nlayout(binding = 0) uniform texture2D picture;\nlayout(binding = 1) uniform sampler how;\n\
        layout(location = 0) in vec2 at;\nlayout(location = 0) out vec4 shown;\n\
        void main() { shown = texture(sampler2D(picture, how), at); }\n";
    let message = reflect(&without_names(&compiled(separate, ShaderKind::Fragment)), true).expect_err("it is refused");
    let expected = "binds 0.0 as a separate image or sampler (the module has no names, and \"0.0\" is set and binding; a compiler \
                    keeps names with -g); use sampler2D and the like, which are both";
    assert_eq!(message, expected);
}
