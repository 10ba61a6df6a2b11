//! The device under the validation layer: both table bodies, dispatch, push constants, limits, fall-backs.

use ash::vk;

use super::*;
use crate::gpu_record;
use crate::shader::cache::Cache;
use crate::shader::compile::{CompileError, Source, Spirv, compile};
use crate::shader::record::GpuRecord;
use crate::shader::reflect::BindingKind;

/// A device with validation; `close` checks that the layer said nothing.
fn open() -> Device {
    let options = Options { validation: true, max_memory: None };
    Device::open(&Choice::Auto, &options).expect("tests need a Vulkan device and the validation layer: run ./x once")
}

fn close(device: Device) {
    assert_eq!(device.messages(), Vec::<String>::new(), "the validation layer objects");
}

fn kernel(name: &str, text: &str) -> Spirv {
    compile(&Source::new(name).part("test.glsl", text), &Cache::off()).unwrap()
}

fn out_of(buffer: &Buffer) -> Vec<u32> {
    buffer.read(0..buffer.bytes() as usize / 4).unwrap()
}

const OUT: &str = "layout(set = 0, binding = 0, std430) buffer OUT_block { uint words[]; } OUT;\n";

gpu_record! {
    pub struct ProbeRecord { a: f32, b: [f32; 2], c: u32, d: [f32; 3], e: [u32; 2], f: [u32; 3], g: [f32; 4], h: [u32; 4], i: [u32; 4] }
}

#[test]
fn every_word_of_a_record_goes_through_both_bodies() {
    let device = open();
    let words = size_of::<ProbeRecord>() / 4;
    let count = 7;
    let values: Vec<u32> = (0..(count * words) as u32).collect();
    let records: &[ProbeRecord] = bytemuck::cast_slice(&values);
    for body in [TableBody::Texel, TableBody::Storage] {
        // The floats are the integers' bits: denormals, which no load may flush.
        let mut store = String::new();
        for f in ProbeRecord::FIELDS {
            for k in 0..f.word_count {
                let component = if f.word_count == 1 { String::new() } else { format!("[{k}]") };
                let value = format!("r.{}{component}", f.name);
                let bits = if f.glsl.starts_with('u') { value } else { format!("floatBitsToUint({value})") };
                store += &format!("    OUT.words[base + {}u] = {bits};\n", f.word + k);
            }
        }
        let text = format!(
            "layout(local_size_x = 1) in;\n{OUT}{}{}{}void main() {{\n    uint i = gl_WorkGroupID.x;\n    \
             uint base = i * {words}u;\n    ProbeRecord r = ProbeRecord_load_probes(i);\n{store}}}\n",
            body.glsl("probes", 3),
            ProbeRecord::glsl_struct(),
            ProbeRecord::glsl_loader("probes"),
        );
        let pipeline = device.pipeline(&kernel("records", &text), &[]).unwrap();
        let table = device.table("probes", records, body).unwrap();
        let out = device.buffer("OUT", values.len() as u64 * 4).unwrap();
        device.dispatch(&pipeline, &[out.binding(), table.binding()], &[], [count as u32, 1, 1]).unwrap();
        assert_eq!(out_of(&out)[..values.len()], values, "{body:?}");
    }
    close(device);
}

#[test]
fn push_and_specialisation_constants_arrive_at_their_reflected_offsets() {
    let device = open();
    let text = format!(
        "layout(local_size_x_id = 0) in;\nlayout(constant_id = 5) const uint FACTOR = 3u;\n{OUT}\
         layout(push_constant) uniform Push {{ uint first; float scale; uvec2 pair; }} push;\nvoid main() {{\n    \
         uint i = gl_LocalInvocationID.x;\n    \
         OUT.words[i] = FACTOR * push.first + floatBitsToUint(push.scale) + push.pair.y + i;\n}}\n"
    );
    let spirv = kernel("push", &text);
    let r = spirv.reflection();
    let members: Vec<_> = r.push_members.iter().map(|m| (m.name.as_str(), m.offset, m.bytes)).collect();
    assert_eq!(members, [("first", 0, 4), ("scale", 4, 4), ("pair", 8, 8)]);
    assert_eq!(r.push_bytes, 16);
    assert_eq!(r.constants.iter().map(|c| c.0).collect::<Vec<_>>(), [0, 5]);
    let pipeline = device.pipeline(&spirv, &[(0, 4), (5, 1000)]).unwrap();
    let out = device.buffer("OUT", 16).unwrap();
    let push = [2u32, 0x100_0000, 9, 30];
    device.dispatch(&pipeline, &[out.binding()], bytemuck::cast_slice(&push), [1, 1, 1]).unwrap();
    let expected: Vec<u32> = (0..4).map(|i| 2000 + 0x100_0000 + 30 + i).collect();
    assert_eq!(out_of(&out), expected);

    let short = device.dispatch(&pipeline, &[out.binding()], &[0; 12], [1, 1, 1]).unwrap_err();
    assert_eq!(short.to_string(), "kernel \"push\" takes 16 bytes of push constants, but got 12");
    close(device);
}

#[test]
fn a_pass_sees_what_its_earlier_commands_wrote() {
    let device = open();
    let text = format!(
        "layout(local_size_x = 64) in;\n{OUT}void main() {{\n    uint i = gl_GlobalInvocationID.x;\n    \
         OUT.words[i] = OUT.words[i ^ 1u] * 2u + 1u;\n}}\n"
    );
    let step = device.pipeline(&kernel("step", &text.replace("i ^ 1u", "i")), &[]).unwrap();
    let out = device.buffer("OUT", 1 << 16).unwrap();
    out.write(0, &vec![7u32; 1 << 14]).unwrap();
    let bindings = [out.binding()];
    let elapsed = device
        .submit("ten steps", |pass| {
            pass.clear(&out)?;
            (0..10).try_for_each(|_| pass.dispatch(&step, &bindings, &[], [1 << 8, 1, 1]))
        })
        .unwrap();
    assert!(out_of(&out).iter().all(|&w| w == 1023));
    assert!(elapsed.wall.as_nanos() > 0 && elapsed.device.is_none_or(|d| d <= elapsed.wall * 2), "{elapsed:?}");
    close(device);
}

#[test]
fn bindings_are_matched_by_name_and_kind() {
    let device = open();
    let text = format!(
        "layout(local_size_x = 1) in;\n{OUT}{}{}void main() {{\n    OUT.words[0] = used_row(0u).w;\n}}\n",
        TableBody::Storage.glsl("used", 4),
        TableBody::Texel.glsl("unused", 2),
    );
    let spirv = kernel("match", &text);
    let found: Vec<_> =
        spirv.reflection().bindings.iter().map(|b| (b.binding, b.name.as_str(), b.kind, b.is_read_only)).collect();
    use BindingKind::StorageBuffer;
    assert_eq!(found, [(0, "OUT", StorageBuffer, false), (4, "used", StorageBuffer, true)], "unused ones are gone");
    let pipeline = device.pipeline(&spirv, &[]).unwrap();
    let out = device.buffer("OUT", 16).unwrap();
    let used = device.table("used", &[[1u32, 2, 3, 4]], TableBody::Storage).unwrap();
    let other = device.table("other", &[[0u32; 4]], TableBody::Texel).unwrap();
    device.dispatch(&pipeline, &[other.binding(), used.binding(), out.binding()], &[], [1, 1, 1]).unwrap();
    assert_eq!(out_of(&out)[0], 4);

    let missing = device.dispatch(&pipeline, &[out.binding()], &[], [1, 1, 1]).unwrap_err();
    assert_eq!(missing.to_string(), "kernel \"match\" reads binding \"used\", which was not given");
    let texel = device.table("used", &[[0u32; 4]], TableBody::Texel).unwrap();
    let wrong = device.dispatch(&pipeline, &[out.binding(), texel.binding()], &[], [1, 1, 1]).unwrap_err();
    let said =
        "kernel \"match\" declares binding \"used\" as a readonly storage buffer, but got a table with a texel body";
    assert_eq!(wrong.to_string(), said);
    let as_out = Binding { name: "OUT", resource: Resource::Table(&used) };
    assert!(device.dispatch(&pipeline, &[as_out, used.binding()], &[], [1, 1, 1]).is_err(), "tables are not written");
    let elsewhere = open();
    let foreign = elsewhere.buffer("OUT", 16).unwrap();
    let error = device.dispatch(&pipeline, &[foreign.binding(), used.binding()], &[], [1, 1, 1]).unwrap_err();
    assert!(matches!(error, GpuError::ForeignDevice { .. }), "{error}");
    close(device);
}

#[test]
fn reads_past_the_end_stay_inside() {
    let device = open();
    let out = device.buffer("OUT", 16).unwrap();
    assert!(matches!(out.read::<u32>(3..5), Err(GpuError::OutsideBuffer { first: 12, last: 20, bytes: 16, .. })));
    assert!(matches!(out.write(usize::MAX, &[1u32]), Err(GpuError::OutsideBuffer { .. })));
    assert_eq!(device.table::<[u32; 4]>("empty", &[], TableBody::Texel).unwrap().row_count(), 0);
    close(device);
}

#[test]
fn memory_is_counted_and_limited() {
    let options = Options { validation: true, max_memory: Some(1 << 20) };
    let device = Device::open(&Choice::Auto, &options).unwrap();
    assert_eq!(device.allocated_bytes(), 0);
    let half = device.buffer("half", 1 << 19).unwrap();
    let error = device.buffer("two thirds", 700_000).err().unwrap();
    assert_eq!(
        error.to_string(),
        "out of device memory: \"two thirds\" needs 700000 bytes, 524288 of 1048576 bytes are taken; raise --max-memory \
         or reduce the scene"
    );
    drop(half);
    assert_eq!((device.allocated_bytes(), device.peak_bytes()), (0, 1 << 19));
    device.buffer("two thirds", 700_000).unwrap();
    close(device);
}

#[test]
fn a_body_is_chosen_by_size_and_device() {
    let device = open();
    let mut info = device.info().clone();
    (info.is_software, info.limits.max_texel_elements) = (true, 65536);
    (info.limits.max_storage_range, info.limits.max_allocation) = (1 << 27, 1 << 30);
    let choose = |info: &DeviceInfo, rows| TableBody::choose(info, "triangles", rows);
    assert_eq!(choose(&info, 65536).unwrap(), TableBody::Texel);
    assert_eq!(choose(&info, 65537).unwrap(), TableBody::Storage);
    assert_eq!(choose(&info, 1 << 23).unwrap(), TableBody::Storage);
    assert_eq!(choose(&info, (1 << 23) + 1).unwrap(), TableBody::Paged { page_shift: 23, pages: 2 });
    assert_eq!(
        choose(&info, (1 << 26) + 1).unwrap_err().to_string(),
        "\"triangles\" needs 1073741840 bytes, more than the device's maxMemoryAllocationSize of 1073741824 bytes; reduce \
         the scene or use another device"
    );
    info.limits.max_allocation = 1 << 34;
    assert_eq!(
        choose(&info, (1 << 27) + 1).unwrap_err().to_string(),
        "\"triangles\" needs 2147483664 bytes, more than the device's maxStorageBufferRange, in 16 pages, of 2147483648 \
         bytes; reduce the scene or use another device"
    );
    info.limits.max_allocation = 1 << 30;
    info.limits.max_texel_elements = 1 << 27;
    assert_eq!(choose(&info, (1 << 23) + 1).unwrap(), TableBody::Texel);
    info.is_software = false;
    assert_eq!(choose(&info, 1 << 23).unwrap(), TableBody::Storage);
    assert!(matches!(choose(&info, 1 << 27), Err(GpuError::TooLarge { limit_name: "maxMemoryAllocationSize", .. })));
    close(device);
}

#[test]
fn every_row_is_read_through_pages() {
    let device = open();
    let rows: Vec<[u32; 4]> = (0..1000u32).map(|i| [i, i * i, !i, 7 * i]).collect();
    let body = TableBody::Paged { page_shift: 8, pages: 4 };
    let text = format!(
        "layout(local_size_x = 8) in;\n{OUT}{}void main() {{\n    uint i = gl_GlobalInvocationID.x;\n    \
         uvec4 r = paged_row(999u - i);\n    OUT.words[4u * i] = r.x;\n    OUT.words[4u * i + 1u] = r.y;\n    \
         OUT.words[4u * i + 2u] = r.z;\n    OUT.words[4u * i + 3u] = r.w;\n}}\n",
        body.glsl("paged", 2)
    );
    let spirv = kernel("pages", &text);
    assert_eq!(spirv.reflection().bindings.iter().map(|b| b.count).collect::<Vec<_>>(), [1, 4]);
    let pipeline = device.pipeline(&spirv, &[]).unwrap();
    let table = device.table("paged", &rows, body).unwrap();
    let out = device.buffer("OUT", 16_000).unwrap();
    device.dispatch(&pipeline, &[out.binding(), table.binding()], &[], [125, 1, 1]).unwrap();
    let expected: Vec<u32> = rows.iter().rev().flatten().copied().collect();
    assert_eq!(out_of(&out)[..4000], expected);
    let whole = device.table("paged", &rows, TableBody::Storage).unwrap();
    let error = device.dispatch(&pipeline, &[out.binding(), whole.binding()], &[], [125, 1, 1]).unwrap_err();
    let said = "kernel \"pages\" declares binding \"paged\" as 4 pages of a storage buffer, but got a table with a storage body";
    assert_eq!(error.to_string(), said);
    close(device);
}

/// A device whose storage range is 16 KiB and that has no texel buffers to speak of renders the same picture, from tables in pages.
#[test]
fn a_render_kernel_reads_its_tables_in_pages() {
    use crate::film::Tile;
    use crate::integrator::Settings;
    use crate::prepare::features::Features;
    use crate::shader::assemble;
    let device = open();
    let settings = Settings { max_depth: 4, ..Settings::default() };
    let prepared = crate::prepare::prepare(&crate::reference::scenes::textured(8), &settings).unwrap();
    let options = renderer::KernelOptions::default();
    let mut renderer = renderer::Renderer::new(&device, &prepared, &settings, &options).unwrap();
    let (expected, _) = renderer.render_tile(Tile { x: 0, y: 0, width: 8, height: 8 }, 0..1).unwrap();

    let mut small = device.info().clone();
    (small.limits.max_storage_range, small.limits.max_texel_elements) = (16384, 1);
    let features = Features::of(&prepared, &settings);
    let rows: Vec<_> = features.tables().map(|t| (t.name, (t.rows)(&prepared))).collect();
    let size = |name: &str| rows.iter().find(|r| r.0 == name).map_or(0, |r| r.1.len());
    let program = assemble::assemble(&features, &settings, &prepared, &small, size).unwrap();
    let paged = program.tables.iter().filter(|t| matches!(t.1, TableBody::Paged { .. })).count();
    assert!(paged >= 1, "{:?}", program.tables);
    let pipeline = device.pipeline(&compile(&program.source, &Cache::off()).unwrap(), &program.constants).unwrap();
    let tables: Vec<_> = rows.iter().zip(&program.tables).map(|(r, t)| device.table(r.0, &r.1, t.1).unwrap()).collect();
    let slots = device.buffer("slots", expected.len() as u64 * 16).unwrap();
    let mut bindings: Vec<_> = tables.iter().map(Table::binding).collect();
    bindings.push(slots.binding());
    let push = assemble::Push {
        tile_x: 0,
        tile_y: 0,
        tile_width: 8,
        tile_pixels: 64,
        first_block: 0,
        block_count: 1,
        block_samples: 16,
        seed: settings.seed,
    };
    device.dispatch(&pipeline, &bindings, bytemuck::bytes_of(&push), [1, 1, 1]).unwrap();
    // Texts that differ in their loads only round alike.
    assert_eq!(slots.read::<[u32; 4]>(0..expected.len()).unwrap(), expected);
    close(device);
}

#[test]
fn the_render_kernel_is_valid() {
    use crate::film::Tile;
    use crate::integrator::Settings;
    use crate::reference::scenes;
    let device = open();
    for scene in [scenes::cornell(8), scenes::textured(8)] {
        let settings = Settings { max_depth: 4, ..Settings::default() };
        let prepared = crate::prepare::prepare(&scene, &settings).unwrap();
        let options = renderer::KernelOptions::default();
        let mut renderer = renderer::Renderer::new(&device, &prepared, &settings, &options).unwrap();
        let (rows, _) = renderer.render_tile(Tile { x: 0, y: 0, width: 8, height: 8 }, 0..2).unwrap();
        assert!(rows.iter().any(|r| *r != [0; 4]), "{}: every slot is black", scene.name);
    }
    close(device);
}

#[test]
fn the_validation_layer_is_active() {
    let device = open();
    let nothing = vk::BufferCreateInfo::default().size(0).usage(vk::BufferUsageFlags::STORAGE_BUFFER);
    // SAFETY: deliberately wrong (a size of 0): lavapipe makes an object of it all the same, and it is destroyed.
    unsafe {
        if let Ok(buffer) = device.shared.raw.create_buffer(&nothing, None) {
            device.shared.raw.destroy_buffer(buffer, None);
        }
    }
    let messages = device.messages();
    assert!(messages.iter().any(|m| m.contains("VUID-VkBufferCreateInfo-size-00912")), "{messages:?}");
    device.clear_messages();
    close(device);
}

#[test]
fn without_a_loader_auto_falls_back_and_others_say_so() {
    let options = Options::default();
    let missing = Device::open_with_loader(&Choice::Auto, &options, Some("/nowhere/libvulkan.so.1")).err().unwrap();
    assert!(matches!(missing, GpuError::NoLoader));
    assert!(missing.to_string().contains("--device cpu"));
    assert!(matches!(select(&Choice::Cpu, &options), Ok(Selected::Cpu { reason: None })));
}

#[test]
fn a_word_picks_a_device() {
    let device = open();
    let mut software = device.info().clone();
    (software.kind, software.index, software.name) = (DeviceKind::Software, 0, "llvmpipe (LLVM)".to_owned());
    software.driver = "llvmpipe".to_owned();
    let mut card = software.clone();
    (card.kind, card.index, card.name) = (DeviceKind::Discrete, 1, "Radeon X".to_owned());
    card.driver = "radv".to_owned();
    let mut old = card.clone();
    (old.index, old.name, old.problem) = (2, "Old card".to_owned(), Some("it offers Vulkan 1.1.0".to_owned()));
    let all = [software, card, old];
    let pick = |word: &str| choose(&all, &Choice::from(word)).map_err(|e| e.to_string());
    assert_eq!(pick("auto"), Ok(1));
    assert_eq!(pick("0"), Ok(0));
    assert_eq!(pick("LAVApipe"), Ok(0));
    assert_eq!(pick("radeon"), Ok(1));
    assert_eq!(pick("old"), Err("device \"Old card\" cannot be used: it offers Vulkan 1.1.0".to_owned()));
    let unknown = "no device matches \"geforce\"; there are: 0 llvmpipe (LLVM); 1 Radeon X; 2 Old card; cpu";
    assert_eq!(pick("geforce"), Err(unknown.to_owned()));
    assert!(pick("9").is_err());
    assert_eq!(choose(&all[..1], &Choice::Auto).ok(), Some(0));
    assert!(matches!(choose(&[], &Choice::Auto), Err(GpuError::NoDevice)));
    close(device);
}

#[test]
fn a_compile_error_names_the_part_and_its_line() {
    let source = Source::new("broken")
        .define("HAS_SKY", true)
        .part("core/a.glsl", "#if HAS_SKY\nfloat a() { return 1.0; }\n#endif")
        .part("bsdf/x.glsl", "layout(local_size_x = 1) in;\n\nvoid main() { float y = b(); }");
    let Err(CompileError::Glsl { log, .. }) = compile(&source, &Cache::off()) else { panic!("it compiled") };
    assert!(log.contains("bsdf/x.glsl:3: error: 'b'"), "{log}");
}

#[test]
fn a_cached_module_is_the_compiled_one() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let source = Source::new("cached")
        .part("test.glsl", format!("layout(local_size_x = 8) in;\n{OUT}void main() {{ OUT.words[0] = 1u; }}"));
    let first = compile(&source, &cache).unwrap();
    let second = compile(&source, &cache).unwrap();
    assert_eq!((first.was_cached(), second.was_cached()), (false, true));
    assert_eq!((first.words(), first.reflection()), (second.words(), second.reflection()));
    assert_eq!(first.reflection().local_size, [8, 1, 1]);
    let other = compile(&source.define("X", 0u32), &cache).unwrap();
    assert!(!other.was_cached() && other.key() != first.key());
}
