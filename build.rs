//! Compiles every stage under `shaders-glsl/` to SPIR-V with shaderc (glslang) for Vulkan 1.3 and
//! writes `shaders.rs`: one `Shader` per file, with the bindings found in the module, and one Rust
//! struct per uniform, storage or push-constant block. A block is thus declared once, in GLSL.

use rspirv::dr::{Module, Operand};
use rspirv::spirv::{Decoration, ExecutionMode, Op, StorageClass, Word};
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const ROOT: &str = "shaders-glsl";

fn main() {
    println!("cargo:rerun-if-changed={ROOT}");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-env=SSCT_COMMIT={}", commit());
    if let Err(message) = run() {
        eprintln!("{message}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), String> {
    let out = PathBuf::from(std::env::var("OUT_DIR").map_err(|e| e.to_string())?);
    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let mut structs = BTreeMap::new();
    let mut shaders = String::new();
    for path in stages(Path::new(ROOT))? {
        let words = compile(&compiler, &path)?;
        let name = path.strip_prefix(ROOT).map_err(|e| e.to_string())?.to_string_lossy().replace('\\', "/");
        let file = format!("{}.spv", name.replace('/', "."));
        let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
        std::fs::write(out.join(&file), bytes).map_err(|e| format!("{file}: {e}"))?;
        let (words, local_size) = take_local_size_ids(words);
        let module = rspirv::dr::load_words(&words).map_err(|e| format!("{name}: {e}"))?;
        let reflection = Reflection::new(&module, &name, local_size);
        reflection.collect_structs(&mut structs)?;
        shaders.push_str(&reflection.constant(&file)?);
    }
    let mut text = shaders;
    for (name, s) in &structs {
        text.push_str(&s.declaration(name));
    }
    std::fs::write(out.join("shaders.rs"), text).map_err(|e| e.to_string())
}

/// All files of a shader stage, sorted; `.glsl` files are only included by others.
fn stages(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|e| e.to_string())?.path();
        if path.is_dir() {
            found.extend(stages(&path)?);
        } else if kind(&path).is_some() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn kind(path: &Path) -> Option<shaderc::ShaderKind> {
    match path.extension()?.to_str()? {
        "vert" => Some(shaderc::ShaderKind::Vertex),
        "frag" => Some(shaderc::ShaderKind::Fragment),
        "comp" => Some(shaderc::ShaderKind::Compute),
        _ => None,
    }
}

fn compile(compiler: &shaderc::Compiler, path: &Path) -> Result<Vec<u32>, String> {
    let source = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut options = shaderc::CompileOptions::new().map_err(|e| format!("shaderc: {e}"))?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_warnings_as_errors();
    // Unoptimised: the driver optimises, and the module stays close to the listing.
    options.set_optimization_level(shaderc::OptimizationLevel::Zero);
    options.set_include_callback(|name, _, includer, _| {
        let beside = Path::new(includer).parent().unwrap_or(Path::new(ROOT)).join(name);
        let path = if beside.exists() { beside } else { Path::new(ROOT).join(name) };
        let content = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(shaderc::ResolvedInclude { resolved_name: path.to_string_lossy().into_owned(), content })
    });
    let stage = kind(path).ok_or("not a stage")?;
    compiler
        .compile_into_spirv(&source, stage, &path.to_string_lossy(), "main", Some(&options))
        .map(|artifact| artifact.as_binary().to_vec())
        .map_err(|e| e.to_string())
}

/// Takes OpExecutionModeId out of a module: the loader does not know it. Its one use in SPIR-V 1.6 is
/// LocalSizeId; returned are the ids of the three constants.
fn take_local_size_ids(words: Vec<u32>) -> (Vec<u32>, Option<[Word; 3]>) {
    const HEADER: usize = 5;
    let (mut kept, mut found) = (words[..HEADER].to_vec(), None);
    let mut at = HEADER;
    while at < words.len() {
        let instruction = &words[at..at + (words[at] >> 16).max(1) as usize];
        at += instruction.len();
        match *instruction {
            [head, _, mode, x, y, z]
                if head & 0xffff == Op::ExecutionModeId as u32 && mode == ExecutionMode::LocalSizeId as u32 =>
            {
                found = Some([x, y, z]);
            }
            _ => kept.extend_from_slice(instruction),
        }
    }
    (kept, found)
}

/// A block's Rust twin.
#[derive(PartialEq, Clone)]
struct Block {
    fields: Vec<(String, u32, String, u32)>, // name, offset, Rust type, size
    size: u32,
    used_in: String,
}

impl Block {
    fn declaration(&self, name: &str) -> String {
        let mut text = format!(
            "/// Twin of the block `{name}` ({} bytes), first declared for `{}`.\n#[repr(C)]\n#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]\n#[allow(missing_docs, non_snake_case)]\npub struct {name} {{\n",
            self.size, self.used_in
        );
        let (mut at, mut checks) = (0, String::new());
        for (i, (field, offset, ty, size)) in self.fields.iter().enumerate() {
            if at < *offset {
                let _ = writeln!(text, "    pub _pad{i}: [u8; {}],", offset - at);
            }
            let _ = writeln!(text, "    pub {field}: {ty},");
            let _ = writeln!(checks, "    assert!(std::mem::offset_of!({name}, {field}) == {offset});");
            at = offset + size;
        }
        if at < self.size {
            let _ = writeln!(text, "    pub _pad_end: [u8; {}],", self.size - at);
        }
        let _ = write!(
            text,
            "}}\nimpl Default for {name} {{ fn default() -> Self {{ bytemuck::Zeroable::zeroed() }} }}\nconst _: () = {{\n    assert!(std::mem::size_of::<{name}>() == {});\n{checks}}};\n",
            self.size
        );
        text
    }
}

/// A module with its names and decorations at hand.
struct Reflection<'a> {
    module: &'a Module,
    name: &'a str,
    /// Ids of the workgroup's three sides.
    local_size: Option<[Word; 3]>,
    names: HashMap<Word, String>,
    member_names: HashMap<(Word, u32), String>,
}

impl<'a> Reflection<'a> {
    fn new(module: &'a Module, name: &'a str, local_size: Option<[Word; 3]>) -> Self {
        let (mut names, mut member_names) = (HashMap::new(), HashMap::new());
        for i in &module.debug_names {
            match (i.class.opcode, i.operands.as_slice()) {
                (Op::Name, [Operand::IdRef(id), Operand::LiteralString(s)]) => {
                    names.insert(*id, s.clone());
                }
                (Op::MemberName, [Operand::IdRef(id), Operand::LiteralBit32(m), Operand::LiteralString(s)]) => {
                    member_names.insert((*id, *m), s.clone());
                }
                _ => {}
            }
        }
        Self { module, name, local_size, names, member_names }
    }

    fn decoration(&self, id: Word, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match (i.class.opcode, i.operands.as_slice()) {
            (Op::Decorate, [Operand::IdRef(target), Operand::Decoration(d), rest @ ..])
                if *target == id && *d == wanted =>
            {
                Some(match rest {
                    [Operand::LiteralBit32(v), ..] => *v,
                    _ => 0,
                })
            }
            _ => None,
        })
    }

    fn member_decoration(&self, id: Word, member: u32, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match (i.class.opcode, i.operands.as_slice()) {
            (
                Op::MemberDecorate,
                [Operand::IdRef(target), Operand::LiteralBit32(m), Operand::Decoration(d), Operand::LiteralBit32(v)],
            ) if *target == id && *m == member && *d == wanted => Some(*v),
            _ => None,
        })
    }

    fn definition(&self, id: Word) -> Option<&rspirv::dr::Instruction> {
        self.module.types_global_values.iter().find(|i| i.result_id == Some(id))
    }

    fn operand_id(&self, id: Word, at: usize) -> Result<Word, String> {
        match self.definition(id).and_then(|d| d.operands.get(at)) {
            Some(Operand::IdRef(x)) => Ok(*x),
            _ => Err(format!("{}: unexpected SPIR-V at id {id}", self.name)),
        }
    }

    fn constant_u32(&self, id: Word) -> Result<u32, String> {
        match self.definition(id).map(|d| d.operands.as_slice()) {
            Some([Operand::LiteralBit32(v)]) => Ok(*v),
            _ => Err(format!("{}: an array length that is no plain constant", self.name)),
        }
    }

    /// Every module-level variable with its storage class and pointee.
    fn variables(&self) -> Result<Vec<(Word, StorageClass, Word)>, String> {
        let mut found = Vec::new();
        for i in self.module.types_global_values.iter().filter(|i| i.class.opcode == Op::Variable) {
            if let (Some(id), Some(pointer), Some(Operand::StorageClass(class))) =
                (i.result_id, i.result_type, i.operands.first())
            {
                found.push((id, *class, self.operand_id(pointer, 1)?));
            }
        }
        Ok(found)
    }

    fn constant(&self, file: &str) -> Result<String, String> {
        let mut bindings = Vec::new();
        let mut push_size = 0;
        for (id, class, pointee) in self.variables()? {
            if class == StorageClass::PushConstant {
                push_size = self.struct_of(pointee)?.size;
                continue;
            }
            let Some(binding) = self.decoration(id, Decoration::Binding) else { continue };
            let definition = self.definition(pointee).ok_or("no type")?;
            let kind = match (class, definition.class.opcode) {
                (StorageClass::UniformConstant, Op::TypeSampledImage) => "SampledImage",
                (StorageClass::UniformConstant, Op::TypeImage) => "StorageImage",
                (StorageClass::Uniform, _) => "UniformBuffer",
                (StorageClass::StorageBuffer, _) => "StorageBuffer",
                other => return Err(format!("{}: binding {binding} has an unknown kind {other:?}", self.name)),
            };
            let own = self.names.get(&id).filter(|n| !n.is_empty());
            let name = own.or_else(|| self.names.get(&pointee)).cloned().unwrap_or_default();
            bindings.push((binding, name, kind));
        }
        bindings.sort();
        let [x, y, z] = match self.local_size {
            Some([x, y, z]) => [self.constant_u32(x)?, self.constant_u32(y)?, self.constant_u32(z)?],
            None => [1; 3],
        };
        let local = [x, y, z];
        let mut text = format!(
            "/// `{ROOT}/{}`.\npub static {}: Shader = Shader {{\n    name: {:?},\n    spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}\")),\n    push_constant_size: {push_size},\n    local_size: {local:?},\n    bindings: &[\n",
            self.name,
            constant_name(self.name),
            self.name
        );
        for (binding, name, kind) in bindings {
            let _ =
                writeln!(text, "        Binding {{ name: {name:?}, binding: {binding}, kind: BindingKind::{kind} }},");
        }
        text.push_str("    ],\n};\n");
        Ok(text)
    }

    fn collect_structs(&self, structs: &mut BTreeMap<String, Block>) -> Result<(), String> {
        for (_, class, pointee) in self.variables()? {
            let is_block = matches!(class, StorageClass::Uniform | StorageClass::PushConstant);
            if is_block && self.definition(pointee).is_some_and(|d| d.class.opcode == Op::TypeStruct) {
                self.collect(pointee, structs)?;
            }
        }
        Ok(())
    }

    fn collect(&self, id: Word, structs: &mut BTreeMap<String, Block>) -> Result<(), String> {
        for member in self.members(id) {
            let mut ty = member;
            while self.definition(ty).is_some_and(|d| d.class.opcode == Op::TypeArray) {
                ty = self.operand_id(ty, 0)?;
            }
            if self.definition(ty).is_some_and(|d| d.class.opcode == Op::TypeStruct) {
                self.collect(ty, structs)?;
            }
        }
        let name = self.names.get(&id).cloned().unwrap_or_default();
        let block = self.struct_of(id)?;
        match structs.get(&name) {
            Some(known) if known.fields != block.fields => {
                Err(format!("{}: block {name} differs from its declaration for {}", self.name, known.used_in))
            }
            Some(_) => Ok(()),
            None => {
                structs.insert(name, block);
                Ok(())
            }
        }
    }

    fn members(&self, id: Word) -> Vec<Word> {
        let operands = self.definition(id).map(|d| d.operands.as_slice()).unwrap_or_default();
        operands.iter().filter_map(|o| if let Operand::IdRef(x) = o { Some(*x) } else { None }).collect()
    }

    fn struct_of(&self, id: Word) -> Result<Block, String> {
        let mut fields = Vec::new();
        let (mut end, mut align) = (0, 4);
        for (m, ty) in self.members(id).into_iter().enumerate() {
            let m = m as u32;
            let offset = self.member_decoration(id, m, Decoration::Offset).unwrap_or(0);
            let (rust, size, a) = self.rust_type(ty)?;
            fields.push((self.member_names.get(&(id, m)).cloned().unwrap_or_default(), offset, rust, size));
            end = end.max(offset + size);
            align = align.max(a);
        }
        let size = end.div_ceil(align) * align;
        Ok(Block { fields, size, used_in: self.name.to_owned() })
    }

    /// A type's Rust spelling, its size, and the alignment that its GLSL block has.
    fn rust_type(&self, id: Word) -> Result<(String, u32, u32), String> {
        let d = self.definition(id).ok_or("no type")?;
        let wrong = || format!("{}: a block member of type {:?} has no Rust twin", self.name, d.class.opcode);
        Ok(match d.class.opcode {
            Op::TypeFloat => ("f32".into(), 4, 4),
            Op::TypeInt => {
                (if d.operands.get(1) == Some(&Operand::LiteralBit32(1)) { "i32" } else { "u32" }.into(), 4, 4)
            }
            Op::TypeVector | Op::TypeMatrix => {
                let (inner, size, align) = self.rust_type(self.operand_id(id, 0)?)?;
                let Some(Operand::LiteralBit32(n)) = d.operands.get(1) else { return Err(wrong()) };
                if d.class.opcode == Op::TypeMatrix && size != 16 {
                    return Err(wrong());
                }
                let align = if d.class.opcode == Op::TypeMatrix { align } else { n.next_power_of_two() * 4 };
                (format!("[{inner}; {n}]"), n * size, align)
            }
            Op::TypeArray => {
                let (inner, size, align) = self.rust_type(self.operand_id(id, 0)?)?;
                let n = self.constant_u32(self.operand_id(id, 1)?)?;
                if self.decoration(id, Decoration::ArrayStride) != Some(size) {
                    return Err(format!("{}: an array whose stride is not its element's size", self.name));
                }
                (format!("[{inner}; {n}]"), n * size, align.max(16))
            }
            Op::TypeStruct => {
                let block = self.struct_of(id)?;
                let size = block.size.div_ceil(16) * 16;
                if size != block.size {
                    return Err(format!("{}: pad the nested struct to 16 bytes", self.name));
                }
                (self.names.get(&id).cloned().unwrap_or_default(), size, 16)
            }
            _ => return Err(wrong()),
        })
    }
}

/// `thesis/hi_z.frag` → `THESIS_HI_Z_FRAG`.
fn constant_name(path: &str) -> String {
    path.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' }).collect()
}

/// The commit that is built, for records; "unknown" outside a repository, "+" after it for a
/// working tree that differs.
fn commit() -> String {
    let git = |args: &[&str]| {
        let output = std::process::Command::new("git").args(args).output().ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // The index changes with every commit and checkout; in a worktree it is not under `.git`. The
    // sources decide whether the tree differs.
    println!("cargo:rerun-if-changed=src");
    for file in ["HEAD", "index"].iter().filter_map(|f| git(&["rev-parse", "--git-path", f])) {
        println!("cargo:rerun-if-changed={file}");
    }
    match git(&["rev-parse", "--short=10", "HEAD"]) {
        None => "unknown".into(),
        Some(commit) => match git(&["status", "--porcelain", "--untracked-files=no"]) {
            Some(changes) if changes.is_empty() => commit,
            _ => commit + "+",
        },
    }
}
