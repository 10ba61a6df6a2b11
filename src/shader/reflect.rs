//! What a compute module declares: bindings, push constants, struct layouts, workgroup size. Read from its SPIR-V.
//!
//! A reader of the few instructions that say so (Khronos, SPIR-V 1.5 specification, sections 2.3 and 3.42). Bindings that the
//! optimiser removed are not listed: what a kernel does not read needs not be given. Leaves out everything inside functions.

use std::collections::HashMap;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BindingKind {
    /// `usamplerBuffer`, `samplerBuffer`, `isamplerBuffer`.
    TexelBuffer,
    StorageBuffer,
    /// Something that tables and buffers cannot be bound to.
    Other,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BindingInfo {
    pub set: u32,
    pub binding: u32,
    /// The variable's name, or the block's when its instance has none.
    pub name: String,
    pub kind: BindingKind,
    pub is_read_only: bool,
    /// Descriptors: more than 1 for an array of fixed length.
    pub count: u32,
}

impl BindingInfo {
    /// The declaration in words, for errors.
    pub fn describe(&self) -> String {
        match self.kind {
            BindingKind::TexelBuffer => "a texel buffer".to_owned(),
            BindingKind::StorageBuffer if self.count > 1 => format!("{} pages of a storage buffer", self.count),
            BindingKind::StorageBuffer if self.is_read_only => "a readonly storage buffer".to_owned(),
            BindingKind::StorageBuffer => "a storage buffer".to_owned(),
            BindingKind::Other => "something else than a buffer".to_owned(),
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    pub name: String,
    pub offset: u32,
    /// 0 for an array without a fixed length.
    pub bytes: u32,
}

#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reflection {
    /// Sorted by (set, binding).
    pub bindings: Vec<BindingInfo>,
    pub push_bytes: u32,
    pub push_members: Vec<Member>,
    /// Blocks and the structs with explicit offsets inside them, by name.
    pub structs: HashMap<String, Vec<Member>>,
    /// (constant_id, name) of the specialisation constants that are left.
    pub constants: Vec<(u32, String)>,
    /// Zero where a specialisation constant sets it.
    pub local_size: [u32; 3],
    pub word_count: usize,
}

#[derive(Debug, thiserror::Error)]
#[error("not a SPIR-V module (word {word})")]
pub struct ReflectError {
    word: usize,
}

pub(super) mod op {
    pub const SOURCE_CONTINUED: u32 = 2;
    pub const SOURCE: u32 = 3;
    pub const SOURCE_EXTENSION: u32 = 4;
    pub const NAME: u32 = 5;
    pub const MEMBER_NAME: u32 = 6;
    pub const STRING: u32 = 7;
    pub const LINE: u32 = 8;
    pub const EXECUTION_MODE: u32 = 16;
    pub const TYPE_INT: u32 = 21;
    pub const TYPE_FLOAT: u32 = 22;
    pub const TYPE_VECTOR: u32 = 23;
    pub const TYPE_MATRIX: u32 = 24;
    pub const TYPE_IMAGE: u32 = 25;
    pub const TYPE_SAMPLED_IMAGE: u32 = 27;
    pub const TYPE_ARRAY: u32 = 28;
    pub const TYPE_STRUCT: u32 = 30;
    pub const TYPE_POINTER: u32 = 32;
    pub const CONSTANT: u32 = 43;
    pub const VARIABLE: u32 = 59;
    pub const DECORATE: u32 = 71;
    pub const MEMBER_DECORATE: u32 = 72;
    pub const NO_LINE: u32 = 317;
    pub const MODULE_PROCESSED: u32 = 330;
}

mod decoration {
    pub const SPEC_ID: u32 = 1;
    pub const ARRAY_STRIDE: u32 = 6;
    pub const NON_WRITABLE: u32 = 24;
    pub const BINDING: u32 = 33;
    pub const DESCRIPTOR_SET: u32 = 34;
    pub const OFFSET: u32 = 35;
}

mod storage_class {
    pub const UNIFORM_CONSTANT: u32 = 0;
    pub const PUSH_CONSTANT: u32 = 9;
    pub const STORAGE_BUFFER: u32 = 12;
}

const LOCAL_SIZE_MODE: u32 = 17;
const DIM_BUFFER: u32 = 5;
const MAGIC: u32 = 0x0723_0203;

/// Opcode and operands of each instruction.
pub(super) fn instructions(words: &[u32]) -> Result<Vec<(u32, &[u32])>, ReflectError> {
    if words.len() < 5 || words[0] != MAGIC {
        return Err(ReflectError { word: 0 });
    }
    let (mut found, mut at) = (Vec::new(), 5);
    while at < words.len() {
        let length = (words[at] >> 16) as usize;
        let operands = (length > 0).then(|| words.get(at + 1..at + length)).flatten();
        found.push((words[at] & 0xffff, operands.ok_or(ReflectError { word: at })?));
        at += length;
    }
    Ok(found)
}

/// What the module says of its ids, gathered in one walk.
#[derive(Default)]
struct Module<'a> {
    names: HashMap<u32, String>,
    member_names: HashMap<(u32, u32), String>,
    /// (id, decoration) -> first operand, 0 where it has none.
    decorations: HashMap<(u32, u32), u32>,
    member_decorations: HashMap<(u32, u32, u32), u32>,
    /// id -> (opcode, operands after the id).
    types: HashMap<u32, (u32, &'a [u32])>,
    constants: HashMap<u32, u32>,
    /// (pointer type, id, storage class).
    variables: Vec<(u32, u32, u32)>,
    local_size: [u32; 3],
}

pub fn reflect(words: &[u32]) -> Result<Reflection, ReflectError> {
    let mut module = Module::default();
    for (opcode, o) in instructions(words)? {
        module.take(opcode, o);
    }
    let mut reflection = Reflection { local_size: module.local_size, word_count: words.len(), ..Default::default() };
    for &(pointer, id, class) in &module.variables {
        let Some(&pointee) = module.operands(pointer, op::TYPE_POINTER).and_then(|o| o.get(1)) else { continue };
        if class == storage_class::PUSH_CONSTANT {
            reflection.push_members = module.members(pointee);
            reflection.push_bytes = reflection.push_members.iter().map(|m| m.offset + m.bytes).max().unwrap_or(0);
        }
        if let Some(&binding) = module.decorations.get(&(id, decoration::BINDING)) {
            reflection.bindings.push(module.binding(id, pointee, class, binding));
        }
    }
    reflection.bindings.sort_by_key(|b| (b.set, b.binding));
    for (&id, (opcode, _)) in &module.types {
        let name = module.name(id);
        if *opcode == op::TYPE_STRUCT
            && !name.is_empty()
            && module.member_decorations.contains_key(&(id, 0, decoration::OFFSET))
        {
            reflection.structs.insert(name, module.members(id));
        }
    }
    for (&(id, kind), &spec_id) in &module.decorations {
        if kind == decoration::SPEC_ID {
            reflection.constants.push((spec_id, module.name(id)));
        }
    }
    reflection.constants.sort();
    Ok(reflection)
}

impl<'a> Module<'a> {
    fn take(&mut self, opcode: u32, o: &'a [u32]) {
        match (opcode, o) {
            (op::NAME, [id, text @ ..]) => drop(self.names.insert(*id, string(text))),
            (op::MEMBER_NAME, [id, member, text @ ..]) => {
                self.member_names.insert((*id, *member), string(text));
            }
            (op::DECORATE, [id, kind, rest @ ..]) => {
                self.decorations.insert((*id, *kind), rest.first().copied().unwrap_or(0));
            }
            (op::MEMBER_DECORATE, [id, member, kind, rest @ ..]) => {
                self.member_decorations.insert((*id, *member, *kind), rest.first().copied().unwrap_or(0));
            }
            (op::EXECUTION_MODE, [_, LOCAL_SIZE_MODE, x, y, z]) => self.local_size = [*x, *y, *z],
            (op::CONSTANT, [_, id, value, ..]) => drop(self.constants.insert(*id, *value)),
            (op::VARIABLE, [pointer, id, class, ..]) => self.variables.push((*pointer, *id, *class)),
            (op::TYPE_INT..=op::TYPE_POINTER, [id, rest @ ..]) => drop(self.types.insert(*id, (opcode, rest))),
            _ => {}
        }
    }

    fn name(&self, id: u32) -> String {
        self.names.get(&id).cloned().unwrap_or_default()
    }

    fn operands(&self, id: u32, opcode: u32) -> Option<&'a [u32]> {
        self.types.get(&id).filter(|(found, _)| *found == opcode).map(|(_, o)| *o)
    }

    fn binding(&self, id: u32, pointee: u32, class: u32, binding: u32) -> BindingInfo {
        let (pointee, count) = match self.operands(pointee, op::TYPE_ARRAY) {
            Some([element, length]) => (*element, self.constants.get(length).copied().unwrap_or(0)),
            _ => (pointee, 1),
        };
        let image = self.operands(pointee, op::TYPE_SAMPLED_IMAGE).and_then(|o| o.first()).copied().unwrap_or(pointee);
        // Operands of an image type: sampled type, dimension, depth, arrayed, multisampled, sampled, format.
        let is_texel_buffer = matches!(self.operands(image, op::TYPE_IMAGE), Some([_, DIM_BUFFER, _, _, _, 1, ..]));
        let kind = match class {
            storage_class::UNIFORM_CONSTANT if is_texel_buffer => BindingKind::TexelBuffer,
            storage_class::STORAGE_BUFFER => BindingKind::StorageBuffer,
            _ => BindingKind::Other,
        };
        let member_count = self.operands(pointee, op::TYPE_STRUCT).map_or(0, <[u32]>::len) as u32;
        let is_read_only_member = |m| self.member_decorations.contains_key(&(pointee, m, decoration::NON_WRITABLE));
        let name = self.name(id);
        BindingInfo {
            set: self.decorations.get(&(id, decoration::DESCRIPTOR_SET)).copied().unwrap_or(0),
            binding,
            name: if name.is_empty() { self.name(pointee) } else { name },
            kind,
            count,
            is_read_only: kind == BindingKind::TexelBuffer
                || self.decorations.contains_key(&(id, decoration::NON_WRITABLE))
                || (member_count > 0 && (0..member_count).all(is_read_only_member)),
        }
    }

    fn members(&self, id: u32) -> Vec<Member> {
        let types = self.operands(id, op::TYPE_STRUCT).unwrap_or_default();
        let member = |(i, &member_type): (usize, &u32)| {
            let offset = self.member_decorations.get(&(id, i as u32, decoration::OFFSET)).copied().unwrap_or(0);
            let name = self.member_names.get(&(id, i as u32)).cloned().unwrap_or_default();
            Member { name, offset, bytes: self.bytes(member_type) }
        };
        types.iter().enumerate().map(member).collect()
    }

    fn bytes(&self, id: u32) -> u32 {
        match self.types.get(&id) {
            Some((op::TYPE_INT | op::TYPE_FLOAT, [bits, ..])) => bits / 8,
            Some((op::TYPE_VECTOR, [element, count])) => self.bytes(*element) * count,
            // Columns of a matrix are 16 bytes apart in every layout used here.
            Some((op::TYPE_MATRIX, [_, count])) => 16 * count,
            Some((op::TYPE_ARRAY, [_, length])) => {
                let stride = self.decorations.get(&(id, decoration::ARRAY_STRIDE)).copied().unwrap_or(0);
                stride * self.constants.get(length).copied().unwrap_or(0)
            }
            Some((op::TYPE_STRUCT, _)) => self.members(id).iter().map(|m| m.offset + m.bytes).max().unwrap_or(0),
            _ => 0,
        }
    }
}

/// A SPIR-V literal string: UTF-8, four bytes a word, zero-terminated.
fn string(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).take_while(|&b| b != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
