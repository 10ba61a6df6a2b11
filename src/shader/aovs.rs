//! Generated GLSL of the AOVs that a kernel fills: their sums in the tally, what the first surface and the finished path add, and
//! their rows in the slot. Names and expressions come from `film::aov::AOVS`.

use crate::film::aov::{AOVS, Aovs, Layout, Source};

/// `struct AovSums`, before the path state; it holds a slot's vectors. Ids go to the slot sample by sample.
pub fn sums(aovs: Aovs) -> String {
    let vectors: Vec<&str> = vectors(aovs).map(|(_, name, _)| name).collect();
    let members: String = vectors.iter().map(|name| format!("    vec4 {name};\n")).collect();
    // A struct needs a member.
    let members = if members.is_empty() { "    uint none;\n".to_owned() } else { members };
    let zeros: String = vectors.iter().map(|name| format!("    a.{name} = vec4(0.0);\n")).collect();
    let zeros = if zeros.is_empty() { "    a.none = 0u;\n".to_owned() } else { zeros };
    format!("struct AovSums {{\n{members}}};\n\nAovSums aov_new() {{\n    AovSums a;\n{zeros}    return a;\n}}\n")
}

/// `aov_surface` at every surface of a path, `aov_path` at its end, `aov_write` at the end of the slot; after the shading functions.
pub fn functions(aovs: Aovs) -> String {
    let layout = Layout::of(aovs);
    let (mut surface, mut path, mut write) = (String::new(), String::new(), String::new());
    for e in &layout.entries {
        let aov = &AOVS[e.index];
        let name = aov.name;
        match &aov.source {
            Source::Surface { glsl, .. } => {
                surface += &format!("    a.{name} += is_first ? vec4({glsl}, 1.0) : vec4(0.0);\n");
            }
            Source::Path { glsl, .. } => path += &format!("    a.{name} += is_bad ? vec4(0.0) : vec4({glsl}, 0.0);\n"),
            Source::Ids { glsl, .. } => {
                surface += &format!("    s.first_{name} = is_first ? {glsl} : s.first_{name};\n");
                path += &format!("    slots.rows[row + {}u + in_block / 4u][in_block % 4u] = s.first_{name};\n", e.row);
                continue;
            }
            Source::Film(_) => continue,
        }
        write += &format!("    slots.rows[row + {}u] = floatBitsToUint(a.{name});\n", e.row);
    }
    format!(
        "void aov_surface(inout AovSums a, inout PathState s, Surface surface, Shading shading, Hit hit) {{\n\
         \x20   bool is_first = s.edge == 1u;\n{surface}}}\n\n\
         // `row`: the slot's first AOV row; `in_block`: the sample's place in its block.\n\
         void aov_path(inout AovSums a, PathState s, bool is_bad, uint row, uint in_block) {{\n{path}}}\n\n\
         void aov_write(AovSums a, uint row) {{\n{write}}}\n"
    )
}

/// `const uint AOV_ROWS`, and the path state's members for ids as `#define AOV_ID_MEMBERS` and `AOV_ID_START`.
pub fn head(aovs: Aovs) -> String {
    let ids = || aovs.iter().filter(|(_, a)| matches!(a.source, Source::Ids { .. })).map(|(_, a)| a.name);
    let members: String = ids().map(|name| format!(" uint first_{name};")).collect();
    let start: String = ids().map(|name| format!(" s.first_{name} = NONE;")).collect();
    format!(
        "const uint AOV_ROWS = {}u;\n#define AOV_ID_MEMBERS{members}\n#define AOV_ID_START{start}\n",
        Layout::of(aovs).rows
    )
}

fn vectors(aovs: Aovs) -> impl Iterator<Item = (usize, &'static str, &'static Source)> {
    let is_vector = |s: &Source| matches!(s, Source::Surface { .. } | Source::Path { .. });
    aovs.iter().filter(move |(_, a)| is_vector(&a.source)).map(|(index, a)| (index, a.name, &a.source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_asked_for_is_not_in_the_text() {
        let usual = functions(Aovs::usual()) + &sums(Aovs::usual()) + &head(Aovs::usual());
        for word in ["first_object", "s.direct", "uv0", "surface.p"] {
            assert!(!usual.contains(word), "{word} in\n{usual}");
        }
        assert!(usual.contains("a.albedo += is_first ? vec4(bsdf_albedo(shading.lobes), 1.0)"), "{usual}");
        let all = functions(Aovs::ALL) + &head(Aovs::ALL);
        assert!(all.contains("AOV_ID_MEMBERS uint first_object; uint first_material;"), "{all}");
        assert!(functions(Aovs::NONE).contains("void aov_write(AovSums a, uint row) {\n}"));
    }
}
