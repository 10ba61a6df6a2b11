//! Opening a file: .glb or JSON text, then the buffers it names.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::buffers::File;
use super::document::Document;
use crate::scene::Error;
use crate::scene::format::read_bytes;

/// The file with all its buffers in memory.
pub fn open(path: &Path) -> Result<File<'_>, Error> {
    let bytes = read_bytes(path)?;
    let fail = |place: &str, reason: String| Error::Gltf { path: path.to_path_buf(), place: place.into(), reason };
    if bytes.is_empty() {
        return Err(fail("file", "is empty (0 bytes); export it again".into()));
    }
    let is_glb = bytes.starts_with(b"glTF");
    if !is_glb && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
        return Err(fail("file", "does not begin with `glTF`, so it is no .glb; export it again".into()));
    }
    let (json, mut binary) = if is_glb {
        let (json, binary) = split_glb(&bytes).map_err(|reason| fail("container", reason))?;
        (json, binary.map(|b| b.into_owned()))
    } else {
        (Cow::Borrowed(&bytes[..]), None)
    };
    let text = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&json);
    let document: Document = serde_json::from_slice(text).map_err(|e| {
        let words = e.to_string();
        let reason = words.split(" at line ").next().unwrap_or(&words);
        if is_glb {
            return fail("JSON chunk", format!("is not valid glTF JSON: {reason}; export it again"));
        }
        Error::Text {
            path: path.to_path_buf(),
            line: e.line(),
            column: e.column(),
            reason: format!("this is not valid glTF JSON: {reason}; export it again"),
        }
    })?;
    check_version(&document).map_err(|reason| fail("asset", reason))?;
    let mut file = File { path, document, buffers: Vec::new() };
    for index in 0..file.document.buffers.len() {
        let buffer = &file.document.buffers[index];
        let place = format!("buffer {index}");
        let bytes = match &buffer.uri {
            Some(uri) => resolve(path, uri).map_err(|reason| fail(&place, reason))?,
            None => binary.take().unwrap_or_default(),
        };
        if buffer.byte_length > bytes.len() as u64 {
            let reason = format!(
                "should have {} bytes and has {}; the file is cut, export it again",
                buffer.byte_length,
                bytes.len()
            );
            return Err(fail(&place, reason));
        }
        file.buffers.push(bytes);
    }
    Ok(file)
}

/// The bytes behind a URI: base64 in the text, or a file beside `path`.
pub fn resolve(path: &Path, uri: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err("has a data URI that is not base64; export the file again".into());
        };
        return base64(text)
            .ok_or_else(|| "has a data URI with letters that are not base64; export the file again".into());
    }
    if uri.contains("://") {
        return Err(format!(
            "lies at {}, and nothing is fetched from the network; put it beside the file",
            shorten(uri)
        ));
    }
    let target: PathBuf = path.parent().unwrap_or(Path::new("")).join(percent_decode(uri));
    read_bytes(&target).map_err(|e| e.to_string())
}

/// A URI short enough for a message.
pub fn shorten(uri: &str) -> String {
    if uri.chars().count() > 60 { format!("{}...", uri.chars().take(57).collect::<String>()) } else { uri.to_string() }
}

/// JSON and binary chunk.
type Chunks<'a> = (Cow<'a, [u8]>, Option<Cow<'a, [u8]>>);

/// Headers that the gltf crate would subtract below zero from are refused first.
fn split_glb(bytes: &[u8]) -> Result<Chunks<'_>, String> {
    let length = bytes.get(8..12).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if length < 20 || length as usize > bytes.len() {
        return Err(format!("says {length} bytes and has {}: a truncated .glb; copy or export it again", bytes.len()));
    }
    match ::gltf::Glb::from_slice(bytes) {
        Ok(glb) => Ok((glb.json, glb.bin)),
        Err(error) => Err(format!("{error}: a damaged .glb; export it again as glTF 2.0")),
    }
}

fn check_version(document: &Document) -> Result<(), String> {
    let asset = &document.asset;
    if let Some(minimum) = &asset.min_version
        && minimum != "2.0"
    {
        return Err(format!("needs a reader of glTF {minimum}, and this one reads 2.0; export it as 2.0"));
    }
    match asset.version.split('.').next() {
        Some("2") => Ok(()),
        Some("") | None => Err("has no version, so this is no glTF 2.0 file; export it again".into()),
        Some(_) => Err(format!("is glTF {}, and only 2.0 is read; convert it", asset.version)),
    }
}

/// RFC 4648; white space and padding are skipped.
fn base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut word, mut bits) = (0u32, 0);
    for c in text.bytes() {
        let six = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' | b' ' | b'\n' | b'\r' | b'\t' => continue,
            _ => return None,
        };
        word = (word << 6) | u32::from(six);
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((word >> bits) as u8);
        }
    }
    Some(bytes)
}

fn percent_decode(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let code = (bytes[i] == b'%').then(|| bytes.get(i + 1..i + 3)).flatten();
        match code.and_then(|h| u8::from_str_radix(std::str::from_utf8(h).ok()?, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    #[test]
    fn uris_decode() {
        assert_eq!(super::base64("TWFueQ=="), Some(b"Many".to_vec()));
        assert_eq!(super::base64("*"), None);
        assert_eq!(super::percent_decode("a%20b%zz%4"), "a b%zz%4");
    }
}
