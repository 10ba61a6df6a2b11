//! SPIR-V on disk: `$XDG_CACHE_HOME/steradian/KEY.spv`, or `~/.cache/steradian`.
//!
//! The key hashes text, options and compiler. A file holds a checksum, so that a truncated one is no hit; it is written beside and
//! renamed, so that concurrent writers leave one whole file. Whatever goes wrong with the disk, rendering goes on.

use std::io::Write;
use std::path::{Path, PathBuf};

/// First bytes of a file; the digit is the layout's version.
const MAGIC: &[u8; 8] = b"sterspv1";

#[derive(Clone, Debug, Default)]
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// Never hits and never stores: `--no-cache`.
    pub fn off() -> Cache {
        Cache { folder: None }
    }

    /// The user's cache folder; off where there is none.
    pub fn user() -> Cache {
        let variable = |name| std::env::var_os(name).map(PathBuf::from).filter(|p: &PathBuf| p.is_absolute());
        let base = variable("XDG_CACHE_HOME").or_else(|| variable("HOME").map(|home| home.join(".cache")));
        Cache { folder: base.map(|base| base.join("steradian")) }
    }

    pub fn in_folder(folder: impl Into<PathBuf>) -> Cache {
        Cache { folder: Some(folder.into()) }
    }

    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// 32 hexadecimal digits of the texts, told apart from each other.
    pub fn key(texts: &[&str]) -> String {
        let mut hash = FNV_OFFSET;
        for text in texts {
            hash = fnv1a(fnv1a(hash, &(text.len() as u64).to_le_bytes()), text.as_bytes());
        }
        format!("{hash:032x}")
    }

    /// The stored words, if the file is there and whole.
    pub fn load(&self, key: &str) -> Option<Vec<u32>> {
        let bytes = std::fs::read(self.path(key)?).ok()?;
        let (head, body) = bytes.split_at_checked(HEAD_BYTES)?;
        if head != header(key, body) || !body.len().is_multiple_of(4) {
            tracing::debug!("cache entry {key} is damaged and will be written again");
            return None;
        }
        Some(body.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }

    /// Stores, or logs why it could not.
    pub fn store(&self, key: &str, words: &[u32]) {
        let Some(path) = self.path(key) else { return };
        let body: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
        let write = || -> std::io::Result<()> {
            let folder = path.parent().unwrap_or(&path);
            std::fs::create_dir_all(folder)?;
            let mut file = tempfile::NamedTempFile::new_in(folder)?;
            file.write_all(&header(key, &body))?;
            file.write_all(&body)?;
            file.persist(&path)?;
            Ok(())
        };
        if let Err(e) = write() {
            tracing::debug!("cache entry {} was not written: {e}", path.display());
        }
    }

    fn path(&self, key: &str) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(format!("{key}.spv")))
    }
}

const HEAD_BYTES: usize = 8 + 32 + 8 + 16;

/// Magic, key, length and checksum.
fn header(key: &str, body: &[u8]) -> Vec<u8> {
    let mut head = MAGIC.to_vec();
    head.extend_from_slice(key.as_bytes());
    head.extend_from_slice(&(body.len() as u64).to_le_bytes());
    head.extend_from_slice(&fnv1a(FNV_OFFSET, body).to_le_bytes());
    head
}

/// FNV-1a, 128 bits (Fowler, Noll, Vo; RFC 9923): no protection against an attacker, who could write the folder anyway.
pub(crate) const FNV_OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
pub(crate) const FNV_PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

pub(super) fn fnv1a(hash: u128, bytes: &[u8]) -> u128 {
    bytes.iter().fold(hash, |hash, &byte| (hash ^ u128::from(byte)).wrapping_mul(FNV_PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_words_come_back_and_damage_is_no_hit() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path().join("new"));
        let key = Cache::key(&["text", "options"]);
        assert_eq!(cache.load(&key), None);
        cache.store(&key, &[1, 2, 3]);
        assert_eq!(cache.load(&key), Some(vec![1, 2, 3]));

        let path = cache.path(&key).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert_eq!(cache.load(&key), None, "truncated to {length} bytes");
        }
        for at in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[at] ^= 1;
            std::fs::write(&path, flipped).unwrap();
            assert_eq!(cache.load(&key), None, "bit flipped at {at}");
        }
        cache.store(&key, &[4]);
        assert_eq!(cache.load(&key), Some(vec![4]));
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "nothing is left beside");
    }

    #[test]
    fn keys_tell_texts_apart() {
        assert_ne!(Cache::key(&["ab", "c"]), Cache::key(&["a", "bc"]));
        // RFC 9923, test vector of FNV-1a 128 for "a".
        assert_eq!(fnv1a(FNV_OFFSET, b"a"), 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_survived() {
        let cache = Cache::in_folder("/proc/no/such/folder");
        cache.store("0123", &[1]);
        assert_eq!(cache.load("0123"), None);
        assert_eq!(Cache::off().load("0123"), None);
    }
}
