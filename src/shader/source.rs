//! The GLSL files of `shaders/`, embedded in the binary by the build script (src/link_shaderc.rs).

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// Text of an embedded file by its path under `shaders/`: `get("bsdf/lambert.glsl")`.
pub fn get(path: &str) -> Option<&'static str> {
    FILES.binary_search_by_key(&path, |(name, _)| name).ok().map(|i| FILES[i].1)
}

/// Paths of all embedded files, sorted.
pub fn paths() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(path, _)| *path)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn every_file_on_disk_is_embedded() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
        let mut folders = vec![root.clone()];
        let mut count = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    let name = path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned();
                    assert_eq!(super::get(&name), Some(&*std::fs::read_to_string(&path).unwrap()), "{name}");
                    count += 1;
                }
            }
        }
        assert_eq!(count, super::paths().count());
        assert_eq!(super::get("bsdf/missing.glsl"), None);
    }

    /// Drivers may be off by 1e-4 in these; core/exp.glsl and core/trig.glsl have ours, with bounds.
    const DRIVERS: [&str; 13] =
        ["pow", "exp", "exp2", "log", "log2", "sin", "cos", "tan", "asin", "acos", "atan", "tanh", "sinh"];

    fn driver_calls(text: &str) -> Vec<&str> {
        let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
        let words = code.flat_map(|line| line.split_inclusive('(')).filter_map(|part| {
            let word = part.strip_suffix('(')?;
            let start = word.rfind(|c: char| !c.is_ascii_alphanumeric() && c != '_').map_or(0, |at| at + 1);
            Some(&word[start..])
        });
        words.filter(|word| DRIVERS.contains(word)).collect()
    }

    #[test]
    fn shaders_leave_the_drivers_elementary_functions_alone() {
        assert_eq!(driver_calls("float y = m_pow(x, 2.0) * pow(x, 3.0); // sin(x)\n"), ["pow"]);
        for path in super::paths() {
            let found = driver_calls(super::get(path).unwrap());
            assert!(found.is_empty(), "{path} calls {found:?}: use m_{} of core/exp.glsl or core/trig.glsl", found[0]);
        }
    }
}
