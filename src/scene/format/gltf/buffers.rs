//! Bytes of a glTF file: buffers inside, beside or within the JSON, and typed reading through accessors.
//!
//! Every count and offset is held against the bytes that exist before memory is taken, in u64, so that nothing wraps.

use std::path::Path;

use super::document::{Accessor, Document, SparsePart};
use crate::scene::Error;

/// The file at hand: its JSON, its bytes, and words for its errors.
pub struct File<'a> {
    pub path: &'a Path,
    pub document: Document,
    pub buffers: Vec<Vec<u8>>,
}

/// Elements that may come without any bytes behind them (an accessor of zeros, patched by sparse values).
const MAX_ZERO_ELEMENTS: u64 = 1 << 24;

impl File<'_> {
    pub fn error(&self, place: impl Into<String>, reason: impl Into<String>) -> Error {
        Error::Gltf { path: self.path.to_path_buf(), place: place.into(), reason: reason.into() }
    }

    /// `list[index]`, or an error that says who asked for it.
    pub fn at<'l, T>(&self, list: &'l [T], index: usize, what: &str, asked_by: &str) -> Result<&'l T, Error> {
        list.get(index).ok_or_else(|| {
            self.error(
                asked_by,
                format!("refers to {what} {index}, and the file has {}; export the file again", list.len()),
            )
        })
    }

    /// The bytes of a buffer view.
    pub fn view(&self, index: usize, asked_by: &str) -> Result<&[u8], Error> {
        let view = self.at(&self.document.buffer_views, index, "buffer view", asked_by)?;
        let place = format!("buffer view {index}");
        let bytes = self.at(&self.buffers, view.buffer, "buffer", &place)?;
        let end = view.byte_offset.checked_add(view.byte_length);
        match end {
            Some(end) if end <= bytes.len() as u64 => Ok(&bytes[view.byte_offset as usize..end as usize]),
            _ => Err(self.error(
                place,
                format!(
                    "ends {} bytes after offset {}, and buffer {} has {} bytes; the file is cut or wrong, export it again",
                    view.byte_length,
                    view.byte_offset,
                    view.buffer,
                    bytes.len()
                ),
            )),
        }
    }

    /// Numbers of an accessor as f32, N a row. Integers become [0,1] or [-1,1] when normalised, else their value.
    pub fn floats<const N: usize>(&self, index: usize, asked_by: &str) -> Result<Vec<[f32; N]>, Error> {
        let accessor = self.at(&self.document.accessors, index, "accessor", asked_by)?;
        let (kind, normalized) = (accessor.component_type, accessor.normalized);
        self.elements(index, accessor, |bytes| component_f32(bytes, kind, normalized))
    }

    /// Vertex numbers.
    pub fn indices(&self, index: usize, asked_by: &str) -> Result<Vec<u32>, Error> {
        let accessor = self.at(&self.document.accessors, index, "accessor", asked_by)?;
        let kind = accessor.component_type;
        if !matches!(kind, 5121 | 5123 | 5125) {
            return Err(
                self.error(place(index, accessor), format!("component type {kind} cannot be an index; use 5125"))
            );
        }
        let rows: Vec<[u32; 1]> = self.elements(index, accessor, |bytes| component_u32(bytes, kind))?;
        Ok(rows.into_iter().map(|[i]| i).collect())
    }

    /// Components a row of an accessor has, from its type.
    pub fn width(&self, index: usize, asked_by: &str) -> Result<usize, Error> {
        let accessor = self.at(&self.document.accessors, index, "accessor", asked_by)?;
        match accessor.r#type.as_str() {
            "SCALAR" => Ok(1),
            "VEC2" => Ok(2),
            "VEC3" => Ok(3),
            "VEC4" => Ok(4),
            other => {
                Err(self
                    .error(place(index, accessor), format!("type \"{other}\" does not fit its use; expected a vector")))
            }
        }
    }

    fn elements<T: Copy + Default, const N: usize>(
        &self,
        index: usize,
        accessor: &Accessor,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>, Error> {
        let place = place(index, accessor);
        let width = self.width(index, &place)?;
        if width != N {
            return Err(
                self.error(place, format!("has {width} components a row where {N} are needed; export it again"))
            );
        }
        let size = component_size(accessor.component_type).ok_or_else(|| {
            self.error(&place, format!("component type {} does not exist; use 5126 (float)", accessor.component_type))
        })?;
        let row = |bytes: &[u8]| std::array::from_fn(|c| decode(&bytes[c * size..(c + 1) * size]));
        let mut rows: Vec<[T; N]> = match accessor.buffer_view {
            Some(view) => {
                let bytes = self.view(view, &place)?;
                let stride = self.document.buffer_views[view].byte_stride;
                let starts =
                    self.rows_in(&place, bytes.len(), accessor.byte_offset, accessor.count, stride, size * N)?;
                starts.map(|start| row(&bytes[start..start + size * N])).collect()
            }
            None if accessor.count > MAX_ZERO_ELEMENTS => {
                return Err(self.error(
                    place,
                    format!(
                        "claims {} rows without any bytes, and the limit is {MAX_ZERO_ELEMENTS}; export it again",
                        accessor.count
                    ),
                ));
            }
            None => vec![[T::default(); N]; accessor.count as usize],
        };
        if let Some(sparse) = &accessor.sparse {
            let numbers = self.sparse_bytes(&place, &sparse.indices, sparse.count, sparse.indices.component_type, 1)?;
            let values = self.sparse_bytes(&place, &sparse.values, sparse.count, accessor.component_type, N)?;
            let kind = sparse.indices.component_type;
            for (number, value) in numbers.into_iter().map(|b| component_u32(b, kind)).zip(values) {
                let count = rows.len();
                *rows.get_mut(number as usize).ok_or_else(|| {
                    self.error(&place, format!("sparse index {number} is beyond its {count} rows; export it again"))
                })? = row(value);
            }
        }
        Ok(rows)
    }

    fn sparse_bytes(
        &self,
        place: &str,
        part: &SparsePart,
        count: u64,
        kind: u32,
        width: usize,
    ) -> Result<Vec<&[u8]>, Error> {
        let (Some(view), Some(size)) = (part.buffer_view, component_size(kind)) else {
            return Err(
                self.error(place, "its sparse part has no buffer view or no valid component type; export it again")
            );
        };
        let bytes = self.view(view, place)?;
        let row = size * width;
        let starts = self.rows_in(place, bytes.len(), part.byte_offset, count, None, row)?;
        Ok(starts.map(|start| &bytes[start..start + row]).collect())
    }

    /// Where the rows start, after checking that the last one ends inside `length` bytes.
    fn rows_in(
        &self,
        place: &str,
        length: usize,
        offset: u64,
        count: u64,
        stride: Option<u64>,
        row: usize,
    ) -> Result<impl Iterator<Item = usize> + use<>, Error> {
        let stride = stride.unwrap_or(row as u64);
        if stride < row as u64 {
            return Err(self.error(place, format!("rows of {row} bytes stand {stride} bytes apart; export it again")));
        }
        let end = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|n| n.checked_add(offset)?.checked_add(row as u64)),
        };
        match end {
            Some(end) if end <= length as u64 => {
                Ok((0..count).map(move |i| (offset + i * stride) as usize))
            }
            _ => Err(self.error(
                place,
                format!(
                    "{count} rows of {row} bytes, {stride} apart from offset {offset}, do not fit the {length} bytes of its buffer view; the file is cut or wrong, export it again"
                ),
            )),
        }
    }
}

fn place(index: usize, accessor: &Accessor) -> String {
    match &accessor.name {
        Some(name) => format!("accessor {index} \"{name}\""),
        None => format!("accessor {index}"),
    }
}

fn component_size(kind: u32) -> Option<usize> {
    match kind {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        5125 | 5126 => Some(4),
        _ => None,
    }
}

/// glTF 2.0, section 3.6.2.2: signed values clamp at -1.
fn component_f32(b: &[u8], kind: u32, normalized: bool) -> f32 {
    let (value, top) = match kind {
        5120 => (f32::from(b[0] as i8), 127.0),
        5121 => (f32::from(b[0]), 255.0),
        5122 => (f32::from(i16::from_le_bytes([b[0], b[1]])), 32_767.0),
        5123 => (f32::from(u16::from_le_bytes([b[0], b[1]])), 65_535.0),
        5125 => (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, u32::MAX as f32),
        _ => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    };
    if normalized { (value / top).max(-1.0) } else { value }
}

fn component_u32(b: &[u8], kind: u32) -> u32 {
    match kind {
        5121 => b[0].into(),
        5123 => u16::from_le_bytes([b[0], b[1]]).into(),
        5125 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        // Signed and float indices: no vertex has this number, so that the range check speaks.
        _ => u32::MAX,
    }
}
