//! The lines of an .obj file: numbers, faces by index, and which group and material each face belongs to.

use std::path::Path;

use super::super::polygon::MAX_CORNERS;
use crate::math::special::srgb_decode;
use crate::scene::Error;

/// A corner: places in the lists of positions, texture coordinates and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    pub position: u32,
    pub uv: Option<u32>,
    pub normal: Option<u32>,
}

/// A face: its corners in `File::corners`, and its smoothing group, 0 for none.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    pub first: usize,
    pub count: usize,
    pub smoothing: u32,
}

/// Faces of one group that wear one material.
#[derive(Debug, Default)]
pub struct Part {
    pub group: String,
    /// Empty: the default one.
    pub material: String,
    pub faces: Vec<Face>,
}

#[derive(Debug, Default)]
pub struct File {
    pub positions: Vec<[f32; 3]>,
    /// Linear; empty when no vertex has one, else one a position.
    pub colors: Vec<[f32; 3]>,
    /// v runs down.
    pub uvs: Vec<[f32; 2]>,
    pub normals: Vec<[f32; 3]>,
    pub corners: Vec<Corner>,
    pub parts: Vec<Part>,
    pub libraries: Vec<String>,
    pub notes: Vec<String>,
}

struct Line<'a> {
    path: &'a Path,
    number: usize,
    text: &'a str,
}

impl Line<'_> {
    /// An error at a word of the line, or at the line.
    fn error(&self, word: &str, reason: impl Into<String>) -> Error {
        let offset = (word.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        let column = self.text.get(..offset).map_or(1, |t| t.chars().count() + 1);
        Error::Text { path: self.path.to_path_buf(), line: self.number, column, reason: reason.into() }
    }

    fn number(&self, word: &str) -> Result<f32, Error> {
        word.parse().map_err(|_| self.error(word, format!("\"{}\" is no number; correct the line", shown(word))))
    }

    fn numbers(&self, words: &[&str], least: usize, what: &str) -> Result<Vec<f32>, Error> {
        if words.len() < least {
            let count = words.len();
            return Err(
                self.error("", format!("{what} needs {least} numbers and has {count}; the line is cut or wrong"))
            );
        }
        words.iter().map(|w| self.number(w)).collect()
    }

    /// 1 is the first, -1 the last so far.
    fn index(&self, word: &str, count: usize, what: &str) -> Result<u32, Error> {
        let index: i64 = word
            .parse()
            .map_err(|_| self.error(word, format!("\"{}\" is no index of {what}; correct the line", shown(word))))?;
        let place = if index < 0 { count as i64 + index } else { index - 1 };
        if place < 0 || place >= count as i64 {
            return Err(
                self.error(word, format!("refers to {what} {index}, and {count} stand before it; export it again"))
            );
        }
        Ok(place as u32)
    }
}

/// What of a wrong word a message can hold.
fn shown(word: &str) -> String {
    word.chars().take(40).map(|c| if c.is_control() { '?' } else { c }).collect()
}

pub fn parse(path: &Path, bytes: &[u8]) -> Result<File, Error> {
    if bytes.contains(&0) {
        let reason = "holds bytes that are no text; .obj files are text, export it again".into();
        return Err(Error::Format { path: path.to_path_buf(), reason });
    }
    // Names may be in any old encoding; numbers and keywords are ASCII.
    let text = String::from_utf8_lossy(bytes);
    if text.len() > u32::MAX as usize {
        return Err(Error::Format { path: path.to_path_buf(), reason: "is larger than 4 GiB; split it".into() });
    }
    let mut file = File::default();
    let mut state = State { object: String::new(), group: String::new(), material: String::new(), ..State::default() };
    let mut joined = String::new();
    for (k, line) in text.lines().enumerate() {
        // A backslash at its end goes on in the next line.
        if let Some(begun) = line.trim_end().strip_suffix('\\') {
            joined.push_str(begun);
            joined.push(' ');
            continue;
        }
        let whole = if joined.is_empty() {
            line
        } else {
            joined.push_str(line);
            joined.as_str()
        };
        state.line(&Line { path, number: k + 1, text: whole }, &mut file)?;
        joined.clear();
    }
    if !joined.is_empty() {
        state.line(&Line { path, number: text.lines().count(), text: &joined }, &mut file)?;
    }
    if file.colors.len() < file.positions.len() && !file.colors.is_empty() {
        file.colors.resize(file.positions.len(), [1.0; 3]);
    }
    for (count, what) in
        [(state.points, "points"), (state.lines, "lines"), (state.curves, "lines of free-form geometry")]
    {
        if count > 0 {
            file.notes.push(format!("{count} {what} left out, faces are read"));
        }
    }
    file.parts.retain(|p| !p.faces.is_empty());
    Ok(file)
}

#[derive(Default)]
struct State {
    object: String,
    group: String,
    material: String,
    smoothing: u32,
    /// Place in `File::parts` of the names above; None after one changed.
    part: Option<usize>,
    points: usize,
    lines: usize,
    curves: usize,
}

impl State {
    fn line(&mut self, line: &Line, file: &mut File) -> Result<(), Error> {
        let text = line.text.split('#').next().unwrap_or("");
        let mut words = text.split_ascii_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        // Names may hold spaces.
        let rest = text.trim_start()[keyword.len()..].trim();
        let words: Vec<&str> = words.collect();
        match keyword {
            "v" => {
                let v = line.numbers(&words, 3, "a vertex")?;
                // x y z [w] or x y z r g b.
                if v.len() >= 6 {
                    file.colors.resize(file.positions.len(), [1.0; 3]);
                    file.colors.push([v[3], v[4], v[5]].map(|c| srgb_decode(f64::from(c)) as f32));
                } else if !file.colors.is_empty() {
                    file.colors.push([1.0; 3]);
                }
                file.positions.push([v[0], v[1], v[2]]);
            }
            "vt" => {
                let v = line.numbers(&words, 1, "a texture coordinate")?;
                file.uvs.push([v[0], 1.0 - v.get(1).copied().unwrap_or(0.0)]);
            }
            "vn" => {
                let v = line.numbers(&words, 3, "a normal")?;
                file.normals.push([v[0], v[1], v[2]]);
            }
            "f" | "fo" => self.face(line, &words, file)?,
            "o" => {
                (self.object, self.group, self.part) = (rest.into(), String::new(), None);
            }
            "g" => (self.group, self.part) = (rest.into(), None),
            "s" => {
                self.smoothing = match words.first() {
                    None | Some(&"off") => 0,
                    Some(word) => word.parse().map_err(|_| {
                        line.error(word, format!("\"{}\" is no smoothing group; write a number or off", shown(word)))
                    })?,
                };
            }
            "usemtl" => (self.material, self.part) = (rest.into(), None),
            "mtllib" => file.libraries.push(rest.into()),
            "p" => self.points += 1,
            "l" => self.lines += 1,
            "vp" | "cstype" | "deg" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole" | "end" | "con" => {
                self.curves += 1;
            }
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, line: &Line, words: &[&str], file: &mut File) -> Result<(), Error> {
        let count = words.len();
        if count < 3 {
            return Err(line.error("", format!("a face needs 3 corners and has {count}; the line is cut or wrong")));
        }
        if count > MAX_CORNERS {
            let reason = format!("a face of {count} corners, and {MAX_CORNERS} are the most; cut it into smaller ones");
            return Err(line.error("", reason));
        }
        let first = file.corners.len();
        for word in words {
            let mut parts = word.split('/');
            let mut next = |count: usize, what: &str| match parts.next() {
                None | Some("") => Ok(None),
                Some(word) => line.index(word, count, what).map(Some),
            };
            let position = next(file.positions.len(), "vertex")?;
            let uv = next(file.uvs.len(), "texture coordinate")?;
            let normal = next(file.normals.len(), "normal")?;
            let position = position.ok_or_else(|| line.error(word, "a corner without a vertex; correct the line"))?;
            file.corners.push(Corner { position, uv, normal });
        }
        let part = *self.part.get_or_insert_with(|| {
            let group = if self.group.is_empty() { &self.object } else { &self.group };
            let found = file.parts.iter().rposition(|p| p.group == *group && p.material == self.material);
            found.unwrap_or_else(|| {
                file.parts.push(Part { group: group.clone(), material: self.material.clone(), faces: Vec::new() });
                file.parts.len() - 1
            })
        });
        file.parts[part].faces.push(Face { first, count, smoothing: self.smoothing });
        Ok(())
    }
}
