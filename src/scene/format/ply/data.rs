//! The numbers behind the header, in any of the three encodings, one after the other.

use super::header::{Element, Encoding, Header, Kind, Property};

pub struct Reader<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub fn new(header: &Header, body: &'a [u8]) -> Self {
        Self { encoding: header.encoding, rest: body }
    }

    /// A count that the bytes left cannot hold is a lie, found before memory is taken for it.
    pub fn check_count(&self, element: &Element) -> Result<(), String> {
        let least = |p: &Property| match (self.encoding, p.list) {
            // A digit and what parts it from the next.
            (Encoding::Ascii, _) => 2,
            (_, Some(length)) => length.size(),
            (_, None) => p.kind.size(),
        };
        let row = element.properties.iter().map(least).sum::<usize>().max(1);
        // The last number of a text needs nothing behind it.
        let fits = element.count.checked_mul(row).is_some_and(|bytes| bytes <= self.rest.len() + 1);
        if fits {
            return Ok(());
        }
        let (name, count, left) = (&element.name, element.count, self.rest.len());
        Err(format!("says {count} of element {name}, and {left} bytes are left for them; the file is cut or damaged"))
    }

    fn cut(element: &Element, row: usize) -> String {
        format!("ends within element {} {row} of {}; the file is cut", element.name, element.count)
    }

    pub fn number(&mut self, kind: Kind, element: &Element, row: usize) -> Result<f64, String> {
        if self.encoding == Encoding::Ascii {
            let word = self.word().ok_or_else(|| Self::cut(element, row))?;
            return std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).ok_or_else(|| {
                let shown: String =
                    String::from_utf8_lossy(word).chars().take(40).filter(|c| !c.is_control()).collect();
                format!("\"{shown}\" in element {} {row} is no number; export it again", element.name)
            });
        }
        let Some((bytes, rest)) = self.rest.split_at_checked(kind.size()) else { return Err(Self::cut(element, row)) };
        self.rest = rest;
        let mut word = [0u8; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        if self.encoding == Encoding::Big {
            word[..bytes.len()].reverse();
        }
        let [a, b, c, d, ..] = word;
        Ok(match kind {
            Kind::I8 => f64::from(a as i8),
            Kind::U8 => f64::from(a),
            Kind::I16 => f64::from(i16::from_le_bytes([a, b])),
            Kind::U16 => f64::from(u16::from_le_bytes([a, b])),
            Kind::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Kind::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Kind::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Kind::F64 => f64::from_le_bytes(word),
        })
    }

    /// Next word of a text.
    fn word(&mut self) -> Option<&'a [u8]> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let text = &self.rest[start..];
        let end = text.iter().position(|b| b.is_ascii_whitespace()).unwrap_or(text.len());
        self.rest = &text[end..];
        Some(&text[..end])
    }

    pub fn list_length(&mut self, element: &Element, property: &Property, row: usize) -> Result<usize, String> {
        let kind = property.list.expect("the caller asks for the length of a list");
        let length = self.number(kind, element, row)?;
        let least = if self.encoding == Encoding::Ascii { 2 } else { property.kind.size() };
        if length >= 0.0 && length.fract() == 0.0 && length * least as f64 <= self.rest.len() as f64 + 1.0 {
            return Ok(length as usize);
        }
        let (name, list, left) = (&element.name, &property.name, self.rest.len());
        Err(format!(
            "the list {list} of {name} {row} says {length} entries, and {left} bytes are left; the file is damaged"
        ))
    }

    pub fn skip_list(&mut self, element: &Element, property: &Property, row: usize) -> Result<(), String> {
        let length = self.list_length(element, property, row)?;
        (0..length).try_for_each(|_| self.number(property.kind, element, row).map(drop))
    }

    pub fn skip_property(&mut self, element: &Element, property: &Property, row: usize) -> Result<(), String> {
        match property.list {
            Some(_) => self.skip_list(element, property, row),
            None => self.number(property.kind, element, row).map(drop),
        }
    }

    pub fn skip(&mut self, element: &Element, row: usize) -> Result<(), String> {
        element.properties.iter().try_for_each(|p| self.skip_property(element, p, row))
    }
}
