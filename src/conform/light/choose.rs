//! Alias tables: the words' choice is the same integer in both languages, and the pmf is the record's.

use std::sync::LazyLock;

use super::super::probe::Probe;
use crate::light::alias::{AliasTable, choose_record};
use crate::prepare::records::{AliasRecord, LightRecord};
use crate::shader::record::GpuRecord;

/// An odd number of lights with powers from 0 to 1e12.
static TABLE: LazyLock<AliasTable> = LazyLock::new(|| {
    let weight = |k: i32| if k % 7 == 3 { 0.0 } else { 10f64.powi(k % 13) * f64::from(1 + k % 5) };
    AliasTable::new(&(0..1237).map(weight).collect::<Vec<_>>()).expect("the weights above are positive")
});

static RECORDS: LazyLock<Vec<AliasRecord>> = LazyLock::new(|| TABLE.records());

fn rows<T: bytemuck::Pod>(records: &[T]) -> Vec<[u32; 4]> {
    bytemuck::cast_slice(records).to_vec()
}

pub fn probes() -> Vec<Probe> {
    let lights: Vec<LightRecord> =
        TABLE.pmf.iter().map(|&p| LightRecord { pmf: p as f32, ..LightRecord::default() }).collect();
    let prelude = format!(
        "const uint LIGHT_COUNT = {}u;\n{}{}",
        lights.len(),
        LightRecord::glsl_struct(),
        LightRecord::glsl_loader("lights")
    );
    let glsl = "m0 = light_choose(vec3(0.0), vec3(0.0, 0.0, 1.0), n0, n1); m1 = alias_choose_light(n0, n1); \
        m2 = floatBitsToUint(light_pmf(vec3(0.0), vec3(0.0, 0.0, 1.0), m0));";
    let choose = Probe::bits(
        "light_choose",
        glsl,
        |r| [r.word_or_edge(), r.word_or_edge()],
        |[index, fraction]| {
            let light = choose_record(&RECORDS, TABLE.entries.len() as u32, index, fraction);
            [light, light, (TABLE.pmf[light as usize] as f32).to_bits()]
        },
    );
    vec![
        choose
            .prelude(&prelude)
            .table("lights", rows(&lights))
            .table("light_alias", rows(&RECORDS))
            .files(&["light/alias.glsl", "light/choose.glsl"])
            .covers(&["alias_entry", "alias_pick"]),
    ]
}
