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
}
