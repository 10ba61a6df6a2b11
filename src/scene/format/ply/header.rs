//! The text before the data: the encoding, and the elements with the types of their properties.

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Of whole numbers: what stands for 1 in a colour.
    pub fn largest(self) -> Option<f64> {
        Some(match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::I32 => 2_147_483_647.0,
            Self::U32 => 4_294_967_295.0,
            Self::F32 | Self::F64 => return None,
        })
    }
}

#[derive(Debug)]
pub struct Property {
    pub name: String,
    pub kind: Kind,
    /// Of a list: how its length is stored.
    pub list: Option<Kind>,
}

#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

/// Bytes that a header may have: comments of scanners run to a few thousand.
const MAX_HEADER: usize = 1 << 20;

/// The header, and the bytes behind it.
pub fn parse(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
    if bytes.is_empty() {
        return Err("is empty (0 bytes); export it again".into());
    }
    if !bytes.starts_with(b"ply") {
        return Err("does not begin with `ply`; it is no .ply file, or a damaged one".into());
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut rest = bytes;
    for number in 1.. {
        // Lines end in \n, \r\n, or \r alone.
        let head = &rest[..rest.len().min(MAX_HEADER)];
        let Some(end) = head.iter().position(|b| matches!(b, b'\n' | b'\r')) else {
            return Err(format!("its header ends at line {number} without `end_header`; the file is cut or no .ply"));
        };
        let line = String::from_utf8_lossy(&rest[..end]).into_owned();
        rest = &rest[end..];
        rest = rest.strip_prefix(b"\r\n").unwrap_or_else(|| &rest[1..]);
        if bytes.len() - rest.len() > MAX_HEADER {
            return Err(format!("its header is longer than {MAX_HEADER} bytes; it is damaged"));
        }
        let fail = |what: &str| {
            let shown: String = line.chars().take(60).map(|c| if c.is_control() { '?' } else { c }).collect();
            Err(format!("line {number} of its header, \"{shown}\", {what}; export it again"))
        };
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            [] | ["ply"] | ["comment", ..] | ["obj_info", ..] => {}
            ["format", name, version] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return fail("names no known encoding"),
                });
                if version != "1.0" {
                    return fail("is not of version 1.0");
                }
            }
            ["element", name, count] => {
                let Ok(count) = count.parse() else { return fail("has no count") };
                if elements.iter().any(|e| e.name == name) {
                    return fail("comes twice");
                }
                elements.push(Element { name: name.into(), count, properties: Vec::new() });
            }
            ["property", ref words @ ..] => {
                let Some(element) = elements.last_mut() else { return fail("belongs to no element") };
                let (list, kind, name) = match words {
                    ["list", length, kind, name] => (Kind::named(length).map(Some), Kind::named(kind), name),
                    [kind, name] => (Some(None), Kind::named(kind), name),
                    _ => return fail("is no property"),
                };
                let (Some(list), Some(kind)) = (list, kind) else { return fail("has an unknown type") };
                if list.is_some_and(Kind::is_float) {
                    return fail("counts with fractions");
                }
                if element.properties.iter().any(|p| p.name == *name) {
                    return fail("comes twice");
                }
                element.properties.push(Property { name: (*name).into(), kind, list });
            }
            ["end_header"] => break,
            _ => return fail("is not understood"),
        }
    }
    let Some(encoding) = encoding else { return Err("its header has no `format` line; export it again".into()) };
    if !elements.iter().any(|e| e.name == "vertex") {
        return Err("has no vertices; it is no surface".into());
    }
    Ok((Header { encoding, elements }, rest))
}
