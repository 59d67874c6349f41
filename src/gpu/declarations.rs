//! Writes the declarations in Rust of the programs, groups and blocks that GLSL declares. `build.rs` alone includes this file.

use super::glsl::{self, Group, NamedProgram};
use super::interface::{Block, Constant, Interface, StageBinding};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

/// The folder of the programs' modules, below the folder that Cargo gives to `build.rs`. A package contains it.
pub const MODULES: &str = "spirv";

/// The shader stage of a permutation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    Vertex,
    Fragment,
    Compute,
}

/// A compiled permutation of a program: one stage with its macros.
pub struct Permutation {
    /// The program's name in a source, with the macros of this permutation.
    pub named: NamedProgram,
    /// The shader stage.
    pub stage: Stage,
    /// Path of the source under `shaders-glsl/`.
    pub file: String,
    /// The file of the compiled module, without the extension.
    pub module: String,
    /// The bindings, constants, blocks and outputs of the module.
    pub interface: Interface,
    /// In a compute permutation beside fragment permutations: binding and format of an image for each output.
    pub stored: Vec<(u32, &'static str)>,
}

impl Permutation {
    /// Returns the bindings that are fields of the program's struct: all but the images that replace outputs.
    fn field_bindings(&self) -> impl Iterator<Item = &StageBinding> {
        let is_stored = |bound: &StageBinding| self.stored.iter().any(|(binding, _)| *binding == bound.binding);
        self.interface.bindings.iter().filter(move |bound| !is_stored(bound))
    }
}

/// Returns the name of a shader for labels and errors: its file and its macros, with spaces between.
pub fn title(file: &str, defines: &[String]) -> String {
    [&[file.to_owned()], defines].concat().join(" ")
}

/// Sets [`Permutation::stored`]: the images that compute permutations store to in place of the outputs of fragment
/// permutations. These are the storage images that no fragment permutation has, in the order of the outputs.
pub fn find_stored(permutations: &mut [Permutation]) -> Result<(), String> {
    let fragments: Vec<&Interface> =
        permutations.iter().filter(|p| p.stage == Stage::Fragment).map(|p| &p.interface).collect();
    let Some(output_count) = fragments.first().map(|interface| interface.outputs.len()) else { return Ok(()) };
    if fragments.iter().any(|interface| interface.outputs.len() != output_count) {
        return Err("its fragment permutations have different numbers of outputs".into());
    }
    if permutations.iter().any(|p| p.stage == Stage::Vertex) {
        return Err("a vertex shader has the name of a fragment shader".into());
    }
    let fragment_bindings: BTreeSet<String> =
        fragments.iter().flat_map(|i| &i.bindings).map(|bound| bound.name.clone()).collect();
    for Permutation { interface, file, stored, .. } in permutations.iter_mut().filter(|p| p.stage == Stage::Compute) {
        let is_output =
            |b: &&StageBinding| b.kind == "StorageImage" && !b.read_only && !fragment_bindings.contains(&b.name);
        let images = interface.bindings.iter().filter(is_output).map(|bound| {
            let found = interface.formats.get(&bound.binding).map(|format| (bound.binding, *format));
            found.ok_or_else(|| format!("{file}: the output {} has no format", bound.name))
        });
        *stored = images.collect::<Result<_, _>>()?;
        if stored.len() != output_count {
            return Err(format!(
                "{file}: it stores {} images, and the fragment permutations draw {output_count}",
                stored.len()
            ));
        }
    }
    Ok(())
}

/// Refuses a compute permutation that was made from a fragment shader's source and reads other inputs than that shader.
fn check_twins(permutations: &[Permutation]) -> Result<(), String> {
    for twin in permutations.iter().filter(|p| p.named.defines.iter().any(|define| define == glsl::COMPUTE)) {
        let source_defines = twin.named.defines.iter().take_while(|define| *define != glsl::COMPUTE);
        let is_source = |p: &&Permutation| {
            p.stage == Stage::Fragment && p.file == twin.file && p.named.defines.iter().eq(source_defines.clone())
        };
        let reads_alike = permutations.iter().find(is_source).is_some_and(|fragment| {
            twin.field_bindings().eq(fragment.field_bindings())
                && twin.interface.push == fragment.interface.push
                && twin.interface.constants == fragment.interface.constants
        });
        if !reads_alike {
            let file = &twin.file;
            return Err(format!("{file}: its fragment and its compute shader differ in more than where they write"));
        }
    }
    Ok(())
}

/// The groups of bindings or constants that GLSL sources name.
pub struct Groups {
    named: Vec<Group>,
    /// The declarations of groups that programs have, by name.
    declared: BTreeMap<String, String>,
}

impl Groups {
    /// Takes the groups that sources name, none of which is declared yet.
    pub fn new(named: Vec<Group>) -> Self {
        Self { named, declared: BTreeMap::new() }
    }

    /// Returns the declarations of all groups, as Rust code.
    ///
    /// # Errors
    /// A sentence about a group if no program has all of its members.
    pub fn text(self) -> Result<String, String> {
        match self.named.iter().find(|group| !self.declared.contains_key(&group.name)) {
            Some(Group { name, .. }) => Err(format!("no program has all members of the group {name}")),
            None => Ok(self.declared.into_values().collect()),
        }
    }

    /// Finds the group that `member` belongs to. A group counts only if `names` has all of its members.
    fn group_with(&self, member: &str, names: &BTreeSet<&str>) -> Option<&Group> {
        let has_all = |group: &&Group| group.members.iter().all(|member| names.contains(member.as_str()));
        self.named.iter().filter(has_all).find(|group| group.members.iter().any(|m| m == member))
    }

    /// Declares the struct of a group of bindings.
    fn declare(&mut self, group: &Group, members: &[&StageBinding]) -> Result<(), String> {
        let field = |bound: &&StageBinding| {
            format!("    /// The binding of this name.\n    pub {}: {},\n", bound.name, type_and_resource(bound).0)
        };
        let fields: String = members.iter().map(field).collect();
        let title = "/// Bindings that several programs have together.\n#[derive(Clone, Copy)]\n";
        self.add_declaration(&group.name, format!("{title}pub struct {}<'a> {{\n{fields}}}\n", group.name))
    }

    /// Adds the declaration `text` of the group `name`. Fails if another program declares the members differently.
    fn add_declaration(&mut self, name: &str, text: String) -> Result<(), String> {
        match self.declared.insert(name.to_owned(), text.clone()) {
            Some(known) if known != text => Err(format!("its members of {name} are not those of other programs")),
            _ => Ok(()),
        }
    }
}

/// Returns the Rust type of a binding's field, and the code that makes its `Resource`, where `{}` stands for the field.
fn type_and_resource(bound: &StageBinding) -> (String, String) {
    let StageBinding { kind, count, block, read_only, .. } = bound;
    let (ty, resource) = match (*kind, *count, *read_only) {
        ("SampledImage", 1, _) => ("Sampled<'a>".into(), "Sampled({})"),
        ("SampledImage", n, _) => (format!("[Sampled<'a>; {n}]"), "SampledArray(&{})"),
        ("StorageTexels", ..) => ("&'a TexelBuffer".into(), "Texels({})"),
        ("StorageImage", _, true) => ("ImageSlice<'a>".into(), "Loaded({})"),
        ("StorageImage", _, false) => ("ImageSlice<'a>".into(), "Storage({})"),
        ("RayStructure", ..) => ("&'a RayStructure".into(), "Rays({})"),
        ("UniformBuffer", ..) => (format!("&'a {block}"), "Uniform(bytemuck::bytes_of({}))"),
        (_, _, true) => ("&'a Buffer".into(), "ReadBuffer({})"),
        (_, _, false) => ("&'a Buffer".into(), "Buffer({})"),
    };
    (ty, resource.to_owned())
}

/// Returns two texts: the fields of a program's struct, and the match arms that find the resource of a binding by name.
/// A binding that some permutation lacks is an `Option`, and so is a group of which some permutation has no member.
fn program_fields(permutations: &[Permutation], groups: &mut Groups) -> Result<(String, String), String> {
    let mut bindings: Vec<&StageBinding> = Vec::new();
    for bound in permutations.iter().flat_map(Permutation::field_bindings) {
        match bindings.iter().find(|known| known.name == bound.name) {
            None => bindings.push(bound),
            Some(known) if type_and_resource(known) == type_and_resource(bound) => {}
            Some(_) => return Err(format!("its permutations differ in what the binding {} is", bound.name)),
        }
    }
    let names: BTreeSet<&str> = bindings.iter().map(|bound| bound.name.as_str()).collect();
    let is_everywhere = |members: &[String]| {
        let has_one = |p: &Permutation| p.field_bindings().any(|bound| members.contains(&bound.name));
        permutations.iter().all(has_one)
    };
    let (mut fields, mut arms) = (String::new(), String::new());
    let mut declared_groups: BTreeSet<String> = BTreeSet::new();
    for bound in &bindings {
        let ((ty, resource), name) = (type_and_resource(bound), &bound.name);
        let group = groups.group_with(name, &names).cloned();
        let members = group.as_ref().map_or(std::slice::from_ref(name), |group| &group.members);
        let is_option = !is_everywhere(members);
        let question = if is_option { "?" } else { "" };
        let value = match &group {
            Some(group) => format!("self.{}{question}.{name}", group.field()),
            // The arm borrows the array from the field: a copy would not outlive the function.
            None if bound.count > 1 && is_option => format!("*self.{name}.as_ref()?"),
            None => format!("self.{name}{question}"),
        };
        let _ = writeln!(arms, "            {name:?} => Resource::{},", resource.replace("{}", &value));
        let (field, ty, about) = match group {
            Some(group) if !declared_groups.insert(group.name.clone()) => continue,
            Some(group) => {
                let member_binding = |member: &String| bindings.iter().find(|bound| bound.name == *member).copied();
                groups.declare(&group, &group.members.iter().filter_map(member_binding).collect::<Vec<_>>())?;
                (group.field(), format!("{}<'a>", group.name), format!("Bindings {}", group.members.join(", ")))
            }
            None => (name.clone(), ty, format!("Binding {}", bound.binding)),
        };
        let (ty, note) = match is_option {
            true => (format!("Option<{ty}>"), ", which some permutations have"),
            false => (ty, ""),
        };
        let _ = writeln!(fields, "    /// {about}{note}.\n    pub {field}: {ty},");
    }
    Ok((fields, arms))
}

/// Declares a program's struct, with the traits through which pipelines and frames use it (`src/gpu/program.rs`).
pub fn declare_program(name: &str, permutations: &[Permutation], groups: &mut Groups) -> Result<String, String> {
    check_twins(permutations)?;
    let (mut fields, arms) = program_fields(permutations, groups)?;
    let mut pushes = permutations.iter().filter_map(|p| p.interface.push.as_ref());
    let push = pushes.next();
    if pushes.any(|other| Some(other) != push) {
        return Err("its permutations have different push constants".into());
    }
    if let Some(push) = push {
        let _ = writeln!(fields, "    /// Push constants.\n    pub {}: &'a {},", push.name, push.block);
    }
    let (generics, elided, fixed) = if fields.is_empty() { ("", "", "") } else { ("<'a>", "<'_>", "<'static>") };
    let pushed = push.map_or("&[]".to_owned(), |p| format!("bytemuck::bytes_of(self.{})", p.name));
    let (constants_type, constants) = program_constants(name, permutations, groups)?;
    let mut shader_list = String::new();
    let mut known_kinds = BTreeSet::new();
    for Permutation { file, named, stage, stored, .. } in permutations {
        if !known_kinds.insert((*stage, &named.rays, stored)) {
            return Err(format!("{file}: another permutation has the same stage and the same source of rays"));
        }
        let _ = writeln!(shader_list, "/// - `{}/{}`", glsl::FOLDER, title(file, &named.defines));
    }
    let compiled: String = permutations.iter().map(permutation_code).collect();
    let (lookup, argument) = match &arms[..] {
        "" => ("None".to_owned(), "_"),
        arms => (format!("Some(match name {{\n{arms}            _ => return None,\n        }})"), "name"),
    };
    let mut text = format!(
        "/// What these shaders read:\n///\n{shader_list}#[derive(Clone, Copy)]\n#[allow(non_snake_case)]\npub struct {name}{generics} {{\n{fields}}}\n\
         impl Program for {name}{elided} {{\n    type Kind = {name}{fixed};\n    type Constants = {constants_type};\n    \
         const PERMUTATIONS: &'static [Permutation] = &[\n{compiled}    ];\n    \
         fn resource(&self, {argument}: &str) -> Option<Resource<'_>> {{\n        {lookup}\n    }}\n    \
         fn push(&self) -> &[u8] {{ {pushed} }}\n}}\n{constants}"
    );
    let find = |stage: Stage| permutations.iter().find(|p| p.stage == stage);
    if let Some(fragment) = find(Stage::Fragment) {
        let outputs = fragment.interface.outputs.len();
        let _ = writeln!(text, "impl Fragment for {name}{elided} {{ type Outputs<T> = [T; {outputs}]; }}");
    }
    if find(Stage::Vertex).is_some() {
        let _ = writeln!(text, "impl VertexProgram for {name}{elided} {{}}");
    }
    if find(Stage::Compute).is_some() {
        let kind = if find(Stage::Fragment).is_some() { "InEitherStage" } else { "Compute" };
        let _ = writeln!(text, "impl {kind} for {name}{elided} {{}}");
    }
    Ok(text)
}

/// Returns the Rust code of one element of a program's `PERMUTATIONS`.
fn permutation_code(permutation: &Permutation) -> String {
    let Permutation { named, stage, file, module, interface, stored } = permutation;
    let (title, defines) = (title(file, &named.defines), &named.defines);
    let (push_size, local_size) = (interface.push.as_ref().map_or(0, |p| p.size), interface.local_size);
    let binding = |StageBinding { binding, name, kind, count, .. }: &StageBinding| {
        format!("Binding {{ name: {name:?}, binding: {binding}, kind: BindingKind::{kind}, count: {count} }}, ")
    };
    let bindings: String = interface.bindings.iter().map(binding).collect();
    let stored: String =
        stored.iter().map(|(binding, format)| format!("({binding}, vk::Format::{format}), ")).collect();
    let rays = named.rays.as_ref().map_or("None".to_owned(), |rays| format!("Some(RaySource::{rays})"));
    let constants: Vec<u32> = interface.constants.iter().map(|constant| constant.id).collect();
    let is_compute = *stage == Stage::Compute;
    format!(
        "        Permutation {{ rays: {rays}, is_compute: {is_compute}, constants: &{constants:?}, shader: &Shader {{\n        \
         name: {title:?},\n        file: {file:?},\n        defines: &{defines:?},\n        \
         spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{MODULES}/{module}.spv\")),\n        \
         push_constant_size: {push_size},\n        local_size: {local_size:?},\n        bindings: &[{bindings}],\n        \
         stored: &[{stored}],\n    }} }},\n"
    )
}

/// Returns name and declaration of the struct of a program's specialization constants; `()` and "" if there are none.
fn program_constants(
    program: &str,
    permutations: &[Permutation],
    groups: &mut Groups,
) -> Result<(String, String), String> {
    let mut constants: BTreeMap<u32, &Constant> = BTreeMap::new();
    for constant in permutations.iter().flat_map(|p| &p.interface.constants) {
        if constants.insert(constant.id, constant).is_some_and(|known| known != constant) {
            return Err(format!("its permutations declare the constant {} differently", constant.name));
        }
    }
    if constants.is_empty() {
        return Ok(("()".into(), String::new()));
    }
    let names: BTreeSet<&str> = constants.values().map(|constant| constant.name.as_str()).collect();
    let mut grouped: BTreeMap<String, (Group, Vec<&Constant>)> = BTreeMap::new();
    let mut ungrouped = Vec::new();
    for constant in constants.into_values() {
        match groups.group_with(&constant.name, &names) {
            Some(group) => {
                grouped.entry(group.name.clone()).or_insert_with(|| (group.clone(), Vec::new())).1.push(constant);
            }
            None => ungrouped.push(constant),
        }
    }
    let name = format!("{program}Constants");
    let title = format!("Specialization constants of [`{program}`].");
    for (group, members) in grouped.values() {
        let title = "Specialization constants that several programs have together.";
        groups.add_declaration(&group.name, constants_struct(&group.name, title, members, &[]))?;
    }
    let used_groups: Vec<&Group> = grouped.values().map(|(group, _)| group).collect();
    let text = constants_struct(&name, &title, &ungrouped, &used_groups);
    Ok((name, text))
}

/// Declares a struct of constants, and of groups of constants.
fn constants_struct(name: &str, title: &str, constants: &[&Constant], groups: &[&Group]) -> String {
    let (mut fields, mut entries) = (String::new(), String::new());
    let (mut defaults, mut group_entries) = (String::new(), String::new());
    for Constant { id, name, ty, default } in constants {
        let field = name.to_ascii_lowercase();
        let value = match *ty {
            "f32" => format!("f32::from_bits({default})"),
            "bool" => (*default != 0).to_string(),
            "i32" => default.cast_signed().to_string(),
            _ => default.to_string(),
        };
        let _ = write!(defaults, "{field}: {value}, ");
        let _ = writeln!(fields, "    /// `{name}`.\n    pub {field}: {ty},");
        let bits = match *ty {
            "f32" => format!("self.{field}.to_bits()"),
            "bool" => format!("u32::from(self.{field})"),
            "i32" => format!("self.{field}.cast_unsigned()"),
            _ => format!("self.{field}"),
        };
        let _ = write!(entries, "({id}, {bits}), ");
    }
    for group in groups {
        let (field, ty) = (group.field(), &group.name);
        let _ = writeln!(fields, "    /// `{}`.\n    pub {field}: {ty},", group.members.join("`, `"));
        let _ = write!(defaults, "{field}: {ty}::default(), ");
        let _ = write!(group_entries, ", self.{field}.entries()");
    }
    format!(
        "/// {title}\n#[derive(Debug, Clone, Copy, PartialEq)]\npub struct {name} {{\n{fields}}}\n\
         impl Constants for {name} {{\n    fn entries(&self) -> Vec<(u32, u32)> {{ [vec![{entries}]{group_entries}].concat() }}\n}}\n\
         /// The values that the shader gives them.\nimpl Default for {name} {{\n    fn default() -> Self {{ Self {{ {defaults}}} }}\n}}\n"
    )
}

/// Declares the Rust struct that has the layout of a block.
pub fn block_struct(block: &Block, name: &str) -> String {
    let mut text = format!(
        "/// Twin of the block `{name}` ({} bytes), first declared for `{}`.\n#[repr(C)]\n#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n#[allow(missing_docs, non_snake_case)]\npub struct {name} {{\n",
        block.size, block.used_in
    );
    let (mut end, mut checks) = (0, String::new());
    for (i, (field, offset, ty, size)) in block.fields.iter().enumerate() {
        if end < *offset {
            let _ = writeln!(text, "    pub _pad{i}: [u8; {}],", offset - end);
        }
        let _ = writeln!(text, "    pub {field}: {ty},");
        let _ = writeln!(checks, "    assert!(std::mem::offset_of!({name}, {field}) == {offset});");
        end = offset + size;
    }
    if end < block.size {
        let _ = writeln!(text, "    pub _pad_end: [u8; {}],", block.size - end);
    }
    let _ = write!(
        text,
        "}}\nimpl Default for {name} {{ fn default() -> Self {{ bytemuck::Zeroable::zeroed() }} }}\nconst _: () = {{\n    assert!(std::mem::size_of::<{name}>() == {});\n{checks}}};\n",
        block.size
    );
    text
}
