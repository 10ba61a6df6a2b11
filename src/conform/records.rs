//! Gate 1: what Rust writes is what GLSL reads, word by word and as integers.
//!
//! Each table's record goes through its generated loader in both bodies (texel and storage); a table of bare rows through its row
//! function. The slots' records come back through their encoders. The push constants of a real kernel are compared with the
//! offsets that its SPIR-V declares.

use std::mem::offset_of;

use super::inputs::Inputs;
use super::report::{Gate, GateRow, is_wanted};
use crate::error::Error;
use crate::film::slot::{self, SlotRecord};
use crate::gpu::{Device, TableBody};
use crate::integrator::Settings;
use crate::prepare;
use crate::prepare::features::Features;
use crate::reference::scenes;
use crate::shader::assemble::{Push, assemble, slot_rows};
use crate::shader::cache::Cache;
use crate::shader::compile::{Source, compile};
use crate::shader::record::{Field, GpuRecord};
use crate::shader::tables::{TABLES, TableEntry};

/// Records a row, a multiple of the workgroup; the largest has 8 rows, so that 65,536 texels hold them.
const COUNT: usize = 4096;

const OUT: &str = "layout(set = 0, binding = 0, std430) buffer OUT_block { uvec4 rows[]; } OUT;\n";
const BARE: &[Field] = &[Field { name: "row", glsl: "uvec4", word: 0, word_count: 4 }];

pub fn rows(device: &Device, filter: &str) -> Vec<GateRow> {
    let mut rows = Vec::new();
    let mut add = |name: String, bound: &str, run: &dyn Fn(&str) -> Result<Outcome, Error>| {
        if is_wanted(Gate::Records, &name, filter) {
            let (is_equal, evidence) = run(&name).unwrap_or_else(|e| (false, e.to_string()));
            rows.push(GateRow::new(Gate::Records, name, is_equal, evidence, bound));
        }
    };
    for entry in TABLES {
        let what = if entry.loader.is_some() { entry.record } else { "rows" };
        add(format!("table {} of {what}", entry.name), "every word equal in both bodies", &|name| {
            table(device, name, entry)
        });
    }
    add("slot SlotRecord".into(), "every word equal", &|name| slot_record::<SlotRecord>(device, name));
    add("push constants".into(), "names, offsets and sizes equal", &|_| push_constants(device));
    rows
}

type Outcome = (bool, String);

/// Any word for an integer, any finite float for a float, denormals included.
fn words(name: &str, fields: &[Field]) -> Vec<u32> {
    let width = fields.iter().map(|f| f.word_count).sum::<usize>();
    let mut words = vec![0; COUNT * width];
    for (index, record) in words.chunks_mut(width).enumerate() {
        let mut random = Inputs::new(name, index as u32);
        for f in fields {
            for word in &mut record[f.word..f.word + f.word_count] {
                let any = random.word_or_edge();
                let is_finite = f.glsl.starts_with('u') || f32::from_bits(any).is_finite();
                *word = if is_finite { any } else { any ^ (1 << 30) };
            }
        }
    }
    words
}

/// Text that writes the words of `value` (a record with these fields) as rows from `OUT.rows[base]` on.
fn store(fields: &[Field], value: &str) -> String {
    let mut list: Vec<String> = Vec::new();
    for f in fields {
        for k in 0..f.word_count {
            let component = if f.word_count == 1 { String::new() } else { format!("[{k}]") };
            let word = format!("{value}.{}{component}", f.name);
            list.push(if f.glsl.starts_with('u') { word } else { format!("floatBitsToUint({word})") });
        }
    }
    list.chunks(4)
        .enumerate()
        .map(|(row, w)| format!("    OUT.rows[base + {row}u] = uvec4({});\n", w.join(", ")))
        .collect()
}

/// Runs `main` (which has `i` and `base`) over COUNT records of a table and returns what it wrote.
fn run(device: &Device, table: &str, head: &str, main: &str, body: TableBody, sent: &[u32]) -> Result<Vec<u32>, Error> {
    let rows = sent.len() / COUNT / 4;
    let text = format!(
        "layout(local_size_x = 64) in;\n{OUT}{}{head}void main() {{\n    uint i = gl_GlobalInvocationID.x;\n    \
         uint base = i * {rows}u;\n{main}}}\n",
        body.glsl(table, 1)
    );
    let source = Source::new("records").part("<records>", text);
    let spirv = compile(&source, &Cache::user()).map_err(|e| Error::Shader(e.to_string()))?;
    let pipeline = device.pipeline(&spirv, &[])?;
    let records: &[[u32; 4]] = bytemuck::cast_slice(sent);
    let table = device.table(table, records, body)?;
    let out = device.buffer("OUT", size_of_val(sent) as u64)?;
    device.dispatch(&pipeline, &[out.binding(), table.binding()], &[], [(COUNT / 64) as u32, 1, 1])?;
    Ok(out.read(0..sent.len())?)
}

/// Equal or not, with the first word that differs.
fn compare(sent: &[u32], got: &[u32], what: &str) -> Outcome {
    match sent.iter().zip(got).position(|(a, b)| a != b) {
        None => (true, format!("{} words equal, {what}", sent.len())),
        Some(at) => (false, format!("word {at}, {what}: sent {:#010x}, got {:#010x}", sent[at], got[at])),
    }
}

fn table(device: &Device, name: &str, entry: &TableEntry) -> Result<Outcome, Error> {
    let (head, fields, main) = match entry.loader {
        Some(loader) => {
            let load = format!("    {0} r = {0}_load_{1}(i);\n", entry.record, entry.name);
            (loader(entry.name), entry.fields, load + &store(entry.fields, "r"))
        }
        None => (String::new(), BARE, format!("    OUT.rows[base] = {}_row(i);\n", entry.name)),
    };
    let sent = words(name, fields);
    for body in [TableBody::Texel, TableBody::Storage] {
        let got = run(device, entry.name, &head, &main, body, &sent)?;
        let (is_equal, evidence) = compare(&sent, &got, &format!("{body:?} body"));
        if !is_equal {
            return Ok((false, evidence));
        }
    }
    Ok((true, format!("{} words through each body", sent.len())))
}

/// Loader and encoder are each other's inverse.
fn slot_record<R: GpuRecord>(device: &Device, name: &str) -> Result<Outcome, Error> {
    let head = slot::glsl() + &R::glsl_loader("written");
    let rows = (0..R::ROWS).map(|k| format!("    OUT.rows[base + {k}u] = {}_row{k}(r);\n", R::NAME));
    let main = format!("    {0} r = {0}_load_written(i);\n", R::NAME) + &rows.collect::<String>();
    let sent = words(name, R::FIELDS);
    let got = run(device, "written", &head, &main, TableBody::Storage, &sent)?;
    Ok(compare(&sent, &got, "by the loader and back by the encoder"))
}

/// Of the kernel that renders a scene.
fn push_constants(device: &Device) -> Result<Outcome, Error> {
    let settings = Settings::default();
    let prepared = prepare::prepare(&scenes::cornell(8), &settings).map_err(|e| Error::Scene(e.to_string()))?;
    let features = Features::of(&prepared, &settings);
    let rows = |name: &str| TABLES.iter().find(|t| t.name == name).map_or(0, |t| (t.rows)(&prepared).len());
    let program = assemble(&features, &settings, &prepared, device.info(), rows)?;
    let spirv = compile(&program.source, &Cache::user()).map_err(|e| Error::Shader(e.to_string()))?;
    let declared = spirv.reflection();
    let found: Vec<(&str, usize, usize)> =
        declared.push_members.iter().map(|m| (m.name.as_str(), m.offset as usize, m.bytes as usize)).collect();
    macro_rules! members {
        ($($name:ident),*) => { [$((stringify!($name), offset_of!(Push, $name), size_of::<u32>())),*] };
    }
    let wanted = members![tile_x, tile_y, tile_width, tile_pixels, first_block, block_count, block_samples, seed];
    // The slots are rows of 16 bytes from offset 0 of the block.
    let slots = declared.structs.get("slots_block").map(|m| (m[0].offset, slot_rows(&features)));
    let is_equal = found == wanted
        && declared.push_bytes as usize == size_of::<Push>()
        && slots == Some((0, slot::rows(crate::film::aov::Aovs::NONE)));
    Ok((is_equal, format!("{} bytes: {found:?}; slots (offset, rows): {slots:?}", declared.push_bytes)))
}
