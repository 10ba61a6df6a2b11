//! Records: the f32 and u32 structs that Rust uploads and GLSL reads, declared once by `gpu_record!`.
//!
//! A record is whole rows of 16 bytes. GLSL decodes word k as `row[k/4][k%4]`; struct text, loader and decoder are generated
//! from the Rust type, so no offset is typed twice. Gate 1 (src/conform) compares every word through both loader bodies.

/// GLSL type and place of one field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    pub name: &'static str,
    pub glsl: &'static str,
    /// Offset in 4-byte words.
    pub word: usize,
    pub word_count: usize,
}

/// A Rust type that can be a field.
pub trait FieldType {
    const GLSL: &'static str;
    const WORDS: usize;
}

macro_rules! field_type {
    ($($rust:ty, $glsl:literal, $words:literal;)*) => { $(impl FieldType for $rust {
        const GLSL: &'static str = $glsl;
        const WORDS: usize = $words;
    })* };
}

field_type! {
    f32, "float", 1;
    u32, "uint", 1;
    [f32; 2], "vec2", 2;
    [f32; 3], "vec3", 3;
    [f32; 4], "vec4", 4;
    [u32; 2], "uvec2", 2;
    [u32; 3], "uvec3", 3;
    [u32; 4], "uvec4", 4;
}

/// Implemented by `gpu_record!`.
pub trait GpuRecord: bytemuck::Pod {
    const NAME: &'static str;
    const FIELDS: &'static [Field];
    const ROWS: usize = size_of::<Self>() / 16;

    /// `struct NAME { ... };`
    fn glsl_struct() -> String {
        let mut text = format!("struct {} {{\n", Self::NAME);
        for f in Self::FIELDS {
            text += &format!("    {} {};\n", f.glsl, f.name);
        }
        text + "};\n"
    }

    /// `NAME NAME_load_TABLE(uint index)`, which reads record `index` of the table whose rows `TABLE_row(uint)` returns.
    fn glsl_loader(table: &str) -> String {
        let mut text = format!("{0} {0}_load_{table}(uint index) {{\n", Self::NAME);
        for row in 0..Self::ROWS {
            text += &format!("    uvec4 r{row} = {table}_row(index * {}u + {row}u);\n", Self::ROWS);
        }
        let word = |k: usize| format!("r{}.{}", k / 4, ["x", "y", "z", "w"][k % 4]);
        let fields: Vec<String> = Self::FIELDS
            .iter()
            .map(|f| {
                let words: Vec<String> = (f.word..f.word + f.word_count).map(word).collect();
                let is_float = !f.glsl.starts_with('u');
                let words: Vec<String> =
                    if is_float { words.iter().map(|w| format!("uintBitsToFloat({w})")).collect() } else { words };
                if f.word_count == 1 { words[0].clone() } else { format!("{}({})", f.glsl, words.join(", ")) }
            })
            .collect();
        text + &format!("    return {}({});\n}}\n", Self::NAME, fields.join(", "))
    }
}

/// Declares a `#[repr(C)]` record of `f32`, `u32` and short arrays of them, a whole number of 16-byte rows.
#[macro_export]
macro_rules! gpu_record {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$fmeta:meta])* $field:ident : $type:ty),* $(,)? }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$fmeta])* pub $field: $type),* }

        impl $crate::shader::record::GpuRecord for $name {
            const NAME: &'static str = stringify!($name);
            const FIELDS: &'static [$crate::shader::record::Field] = &[$($crate::shader::record::Field {
                name: stringify!($field),
                glsl: <$type as $crate::shader::record::FieldType>::GLSL,
                word: std::mem::offset_of!($name, $field) / 4,
                word_count: <$type as $crate::shader::record::FieldType>::WORDS,
            }),*];
        }

        const _: () = assert!(size_of::<$name>() % 16 == 0, "a record is whole rows of 16 bytes");
    };
}
