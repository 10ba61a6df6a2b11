//! Generated GLSL of the AOVs that a kernel fills: their sums in the tally, what the first surface and the finished path add, and
//! their rows in the slot. Names and expressions come from `film::aov::AOVS`.

use crate::film::aov::layout::Entry;
use crate::film::aov::{AOVS, Aovs, Layout, Source};

/// `struct AovSums`, before the path state; it holds a slot's vectors. Ids go to the slot sample by sample.
pub fn sums(aovs: Aovs) -> String {
    let vectors: Vec<String> = Layout::of(aovs).entries.iter().filter(|e| e.width > 0).map(member).collect();
    let members: String = vectors.iter().map(|name| format!("    vec4 {name};\n")).collect();
    // A struct needs a member.
    let members = if members.is_empty() { "    uint none;\n".to_owned() } else { members };
    let zeros: String = vectors.iter().map(|name| format!("    a.{name} = vec4(0.0);\n")).collect();
    let zeros = if zeros.is_empty() { "    a.none = 0u;\n".to_owned() } else { zeros };
    format!("struct AovSums {{\n{members}}};\n\nAovSums aov_new() {{\n    AovSums a;\n{zeros}    return a;\n}}\n")
}

/// Name of an entry's sum, and of a light group's part of the path state.
fn member(e: &Entry) -> String {
    let aov = &AOVS[e.index];
    if let Source::Groups = aov.source { format!("group_{}", e.part) } else { aov.name.to_owned() }
}

/// `aov_surface` at every surface of a path, `aov_path` at its end, `aov_write` at the end of the slot; after the shading functions.
pub fn functions(aovs: Aovs) -> String {
    let layout = Layout::of(aovs);
    let (mut surface, mut path, mut write) = (String::new(), String::new(), String::new());
    for e in &layout.entries {
        let name = member(e);
        match &AOVS[e.index].source {
            Source::Surface { glsl, .. } => {
                surface += &format!("    a.{name} += is_first ? vec4({glsl}, 1.0) : vec4(0.0);\n");
            }
            Source::Path { glsl, .. } => path += &format!("    a.{name} += is_bad ? vec4(0.0) : vec4({glsl}, 0.0);\n"),
            Source::Groups => path += &format!("    a.{name} += is_bad ? vec4(0.0) : vec4(s.{name}, 0.0);\n"),
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

/// `const uint AOV_ROWS`; as macros the path state's members for ids and light groups (AOV_MEMBERS), their start (AOV_START) and what
/// adds `light` to that of `group` (AOV_GATHER); and LIGHT_GROUP, which is 0 where no groups are kept.
pub fn head(aovs: Aovs) -> String {
    let layout = Layout::of(aovs);
    let (mut members, mut start, mut gather) = (String::new(), String::new(), String::new());
    for e in &layout.entries {
        let name = member(e);
        match AOVS[e.index].source {
            Source::Ids { .. } => {
                members += &format!(" uint first_{name};");
                start += &format!(" s.first_{name} = NONE;");
            }
            Source::Groups => {
                members += &format!(" Spectrum {name};");
                start += &format!(" s.{name} = Spectrum(0.0);");
                gather += &match aovs.group_count() {
                    1 => format!(" s.{name} += light;"),
                    _ => format!(" s.{name} += group == {}u ? light : Spectrum(0.0);", e.part),
                };
            }
            _ => {}
        }
    }
    let group = if aovs.group_count() > 0 { "x" } else { "0u" };
    format!(
        "const uint AOV_ROWS = {}u;\n#define AOV_MEMBERS{members}\n#define AOV_START{start}\n#define AOV_GATHER{gather}\n\
         #define LIGHT_GROUP(x) {group}\n",
        layout.rows
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::aov::GROUPS;

    #[test]
    fn what_is_not_asked_for_is_not_in_the_text() {
        let usual = functions(Aovs::usual()) + &sums(Aovs::usual()) + &head(Aovs::usual());
        for word in ["first_object", "s.direct", "uv0", "surface.p", "group_"] {
            assert!(!usual.contains(word), "{word} in\n{usual}");
        }
        assert!(usual.contains("a.albedo += is_first ? vec4(bsdf_albedo(shading.lobes), 1.0)"), "{usual}");
        let all = functions(Aovs::ALL) + &head(Aovs::ALL);
        assert!(all.contains("AOV_MEMBERS uint first_object; uint first_material;"), "{all}");
        // As many light groups as the scene has.
        let two = Aovs::NONE.with(GROUPS).with_groups(2);
        let text = head(two) + &functions(two);
        for words in [
            "AOV_MEMBERS Spectrum group_0; Spectrum group_1;\n",
            "AOV_GATHER s.group_0 += group == 0u ? light : Spectrum(0.0); s.group_1 +=",
            "LIGHT_GROUP(x) x",
            "const uint AOV_ROWS = 2u;",
        ] {
            assert!(text.contains(words), "{words} in\n{text}");
        }
        assert!(head(Aovs::ALL).contains("#define LIGHT_GROUP(x) 0u") && !text.contains("group_2"));
        assert!(functions(Aovs::NONE).contains("void aov_write(AovSums a, uint row) {\n}"));
    }
}
