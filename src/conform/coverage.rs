//! Which gate covers which GLSL function. A function under shaders/ that neither a probe row calls nor this list names fails.

use std::collections::BTreeMap;

use super::probe::Probe;
use super::report::{Gate, GateRow};
use crate::shader::source;

/// Functions (`*` before an ending), files and folders (`/` after) without a row of their own: the gate that covers them, and why it does.
const COVERED: &[(&str, u32, &str)] = &[
    ("log_core", 3, "the body of m_log and m_log1p, whose rows reach all of it"),
    ("exp2_int", 3, "scales m_exp and m_expm1"),
    ("exp_reduce", 3, "reduces m_exp and m_expm1"),
    ("expm1_core", 3, "the body of m_exp and m_expm1"),
    ("asin_core", 3, "the body of m_asin and m_acos"),
    ("texture_tap", 3, "addresses every row of texture_image"),
    ("texture_texel", 3, "reads every row of texture_image"),
    ("texture_filtered", 3, "the body of texture_image and texture_image_footprint"),
    ("texture_level", 3, "addresses every row of texture_image_footprint"),
    ("direction_from_z", 3, "the body of the uniform warps, whose rows reach all of it"),
    ("turn_of", 3, "the body of the uniform warps' inverses"),
    ("*_light_connect", 6, "reads the path's state and the scene's tables: replayed path by path"),
    ("*_light_density", 6, "as connect"),
    ("*_light_arriving", 6, "as connect"),
    ("mis_weight", 6, "weighs every light: replayed path by path"),
    ("emission_weight", 6, "as mis_weight"),
    ("light_sample_none", 6, "a constant"),
    ("light_group", 6, "reads the scene's tables: layers of light groups are replayed"),
    ("integrator/", 6, "path state and tables: replayed path by path"),
    ("kernel/", 6, "path state and tables: replayed path by path"),
    ("film/", 6, "writes slots, which replay reads"),
    ("camera/", 6, "reads the camera table: replayed path by path"),
    ("bvh/", 5, "reads the tree: compared with brute force"),
];

/// Names of the functions a GLSL text defines, in order; an overloaded name comes once for each.
pub fn functions(text: &str) -> Vec<String> {
    let word = |s: &str| s.len() - s.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_').len();
    let name = |line: &str| {
        // A definition starts a line: return type, name, an opening parenthesis; a prototype ends in a semicolon.
        let kind = word(line);
        let rest = line.get(kind..)?.trim_start();
        let length = word(rest);
        let is_definition = kind > 0
            && length > 0
            && rest[length..].starts_with('(')
            && !line.trim_end().ends_with(';')
            && !["layout", "const", "struct", "return", "else"].contains(&&line[..kind]);
        is_definition.then(|| rest[..length].to_owned())
    };
    text.lines().filter_map(name).collect()
}

/// One row: every function of every embedded shader is covered, and nothing is listed that does not exist.
pub fn rows(probes: &[Probe]) -> Vec<GateRow> {
    let mut uncovered: Vec<String> = Vec::new();
    let mut by_gate: BTreeMap<u32, usize> = BTreeMap::new();
    let mut total = 0;
    let mut used = vec![false; COVERED.len()];
    let is_called = |name: &str| probes.iter().any(|p| p.covers.contains(&name) || calls(&p.glsl, name));
    for path in source::paths() {
        for function in functions(source::get(path).unwrap_or_default()) {
            total += 1;
            let is_listed = |n: &str| match (n.strip_prefix('*'), n.strip_suffix('/')) {
                (Some(ending), _) => function.ends_with(ending),
                (_, Some(place)) => path.starts_with(place),
                _ => n == function,
            };
            let listed = COVERED.iter().position(|(n, ..)| is_listed(n));
            if is_called(&function) {
                *by_gate.entry(3).or_default() += 1;
            } else if let Some(place) = listed {
                used[place] = true;
                *by_gate.entry(COVERED[place].1).or_default() += 1;
            } else {
                uncovered.push(format!("{path} {function}"));
            }
        }
    }
    let stale = COVERED
        .iter()
        .zip(used)
        .filter(|(c, used)| !used && !c.0.ends_with('/'))
        .map(|(c, _)| format!("stale: {}", c.0));
    uncovered.extend(stale);
    let split: Vec<String> = by_gate.iter().map(|(gate, count)| format!("gate {gate}: {count}")).collect();
    let evidence = if uncovered.is_empty() {
        format!("{total} functions, {}", split.join(", "))
    } else {
        format!("{} of {total} without a gate: {}", uncovered.len(), uncovered.join("; "))
    };
    let bound = "every GLSL function has a probe row or a listed gate";
    vec![GateRow::new(Gate::Functions, "coverage", uncovered.is_empty(), evidence, bound)]
}

/// The text calls `name(`, as a whole word.
fn calls(text: &str, name: &str) -> bool {
    text.match_indices(name).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let is_word = before.is_some_and(|c| c.is_ascii_alphanumeric() || c == '_');
        !is_word && text[at + name.len()..].starts_with('(')
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_are_found_and_nothing_else() {
        let text = "const float A = f(1.0);\nfloat f(float x) {\n    return g(x);\n}\nvec3 g(vec3 a,\n       vec3 b) {\n}\n\
                    // float h(float x) {\nlayout(local_size_x = 1) in;\nuint later(uint x);\nstruct S {\n";
        assert_eq!(functions(text), ["f", "g"]);
    }

    #[test]
    fn calls_are_whole_words() {
        assert!(calls("y0 = m_log(x0);", "m_log"));
        assert!(!calls("y0 = m_log1p(x0);", "m_log"));
        assert!(!calls("y0 = xm_log(x0);", "m_log"));
    }
}
