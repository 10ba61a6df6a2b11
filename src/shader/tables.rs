//! Every table a kernel can read: name, record, rows, and the feature it belongs to. A table that is not needed has no binding.

use std::borrow::Cow;
use std::slice::from_ref;

use crate::bsdf;
use crate::film::{filter, slot};
use crate::integrator::path::ALPHA_LAYERS;
use crate::light;
use crate::prepare::Prepared;
use crate::prepare::features::Features;
use crate::prepare::records::*;
use crate::shader::cache::{FNV_OFFSET, fnv1a};
use crate::shader::record::{Field, GpuRecord};

/// One table as text and data see it.
pub struct TableEntry {
    pub name: &'static str,
    /// Struct and loader of its record; None for tables of bare rows.
    pub loader: Option<fn(&str) -> String>,
    /// Name and fields of its record; none for tables of bare rows.
    pub record: &'static str,
    pub fields: &'static [Field],
    pub is_needed: fn(&Features) -> bool,
    /// Borrowed, so that nothing of a scene is in memory a third time while it is uploaded.
    pub rows: fn(&Prepared) -> Cow<'_, [[u32; 4]]>,
}

fn loader<R: GpuRecord>(table: &str) -> String {
    R::glsl_struct() + &R::glsl_loader(table)
}

fn rows_of<R: bytemuck::Pod>(records: &[R]) -> Cow<'_, [[u32; 4]]> {
    Cow::Borrowed(bytemuck::cast_slice(records))
}

/// A table of the models' own, the same for every scene.
fn constant_rows(name: &str) -> Cow<'static, [[u32; 4]]> {
    Cow::Owned(bsdf::table_rows(name).unwrap_or_default().into_iter().map(|row| row.map(f32::to_bits)).collect())
}

macro_rules! table {
    ($name:literal, $record:ty, $needed:expr, $rows:expr) => {
        TableEntry {
            name: $name,
            loader: Some(loader::<$record>),
            record: <$record as GpuRecord>::NAME,
            fields: <$record as GpuRecord>::FIELDS,
            is_needed: $needed,
            rows: $rows,
        }
    };
    ($name:literal, $needed:expr, $rows:expr) => {
        TableEntry { name: $name, loader: None, record: "", fields: &[], is_needed: $needed, rows: $rows }
    };
}

pub const TABLES: &[TableEntry] = &[
    table!("camera", CameraRecord, |_| true, |p| rows_of(from_ref(&p.camera))),
    table!("sensor_elements", SensorElementRecord, |f| f.sensor_elements(), |p| rows_of(&p.sensor_elements)),
    table!("sensor_alias", |f| f.sensor_elements(), |p| rows_of(&p.sensor_alias)),
    table!("filter_cells", |f| f.filter, |p| match p.filter.is_empty() {
        true => Cow::Owned(filter::PixelFilter::BOX.cells()),
        false => rows_of(&p.filter),
    }),
    table!("bvh", |_| true, |p| rows_of(&p.bvh.nodes)),
    table!("triangles", TriangleRecord, |f| f.triangles, |p| rows_of(&p.triangles)),
    table!("spheres", SphereRecord, |f| f.spheres, |p| rows_of(&p.spheres)),
    table!("discs", DiscRecord, |f| f.discs, |p| rows_of(&p.discs)),
    table!("instances", InstanceRecord, |f| f.instances, |p| rows_of(p.instances_or_world())),
    table!("faces", FaceRecord, |f| f.triangles, |p| rows_of(&p.faces)),
    table!("normals", NormalRecord, |f| f.smooth_normals, |p| rows_of(&p.normals)),
    table!("tangents", TangentRecord, |f| f.tangents, |p| rows_of(&p.tangents)),
    table!("uvs", UvRecord, |f| f.uvs && f.triangles, |p| rows_of(&p.uvs)),
    table!("colors", ColorRecord, |f| f.colors, |p| rows_of(&p.colors)),
    table!("materials", MaterialRecord, |_| true, |p| rows_of(&p.materials)),
    table!("material_data", |_| true, |p| rows_of(&p.material_data)),
    table!("textures", TextureRecord, |f| f.image_textures, |p| rows_of(&p.textures)),
    table!("texels", |f| f.image_textures, |p| rows_of(&p.texels)),
    table!("lights", LightRecord, |f| f.next_event() || f.suns, |p| rows_of(&p.lights)),
    table!("light_alias", |f| f.next_event(), |p| rows_of(&p.light_alias)),
    table!("sky", SkyRecord, |f| f.sky, |p| rows_of(from_ref(&p.sky))),
    table!("sky_texels", SkyTexelRecord, |f| f.sky && f.sky_image, |p| rows_of(&p.sky_texels)),
    table!("sky_alias", |f| f.samples_light(light::LIGHT_SKY) && f.sky_image, |p| rows_of(&p.sky_alias)),
    table!("media", MediumRecord, |f| f.media, |p| rows_of(&p.media)),
    table!("dielectric_deficit", |f| f.bsdf_table("dielectric_deficit"), |_| constant_rows("dielectric_deficit")),
    table!("ggx_albedo", |f| f.bsdf_table("ggx_albedo"), |_| constant_rows("ggx_albedo")),
];

impl Features {
    /// A model in the text reads the constant table `name`.
    pub fn bsdf_table(&self, name: &str) -> bool {
        self.shared_bsdf_files().any(|s| s.table == Some(name))
    }

    /// Files of functions that the models in the text share; a file may come up more than once.
    pub fn shared_bsdf_files(&self) -> impl Iterator<Item = &'static bsdf::Shared> {
        let is_on = |name: &str| self.bsdf_macros.iter().any(|&(n, on)| n == name && on);
        self.bsdfs.iter().flat_map(move |&b| bsdf::MODELS[b].shared_with(is_on))
    }

    /// The tables of the kernel, in binding order.
    pub fn tables(&self) -> impl Iterator<Item = &'static TableEntry> {
        TABLES.iter().filter(|t| (t.is_needed)(self))
    }
}

/// A hash of everything that a scene's image depends on besides the settings: all tables, the patterns' structures, the size. 32
/// hexadecimal digits. Two scenes with the same one are the same to a kernel.
pub fn fingerprint(p: &Prepared) -> String {
    let mut hash = fnv1a(FNV_OFFSET, format!("{}x{} {:?}", p.width, p.height, p.structures).as_bytes());
    for table in TABLES {
        let rows = (table.rows)(p);
        hash = fnv1a(fnv1a(hash, table.name.as_bytes()), bytemuck::cast_slice(&rows));
    }
    format!("{hash:032x}")
}

/// `const uint NAME = VALUEu;` for the constants that records share with GLSL.
pub fn shared_constants() -> String {
    macro_rules! constants {
        ($($name:ident),* $(,)?) => { [$((stringify!($name), $name)),*] };
    }
    let list = constants![
        NONE,
        FACE_SMOOTH,
        FACE_TANGENTS,
        INSTANCE_MIRRORED,
        MATERIAL_EMITS,
        MATERIAL_EMITS_TWO_SIDED,
        MATERIAL_MASK,
        MATERIAL_BLEND,
        MATERIAL_TRANSMITS,
        MATERIAL_NORMAL_MAP,
        MATERIAL_THIN,
        MATERIAL_TANGENT,
        TEXTURE_WRAP_U_SHIFT,
        TEXTURE_WRAP_V_SHIFT,
        TEXTURE_NEAREST,
        TEXTURE_SRGB,
        TEXTURE_HALF,
        TEXTURE_WIDE,
        TEXTURE_MIPS,
        TEXTURE_MIP_NEAREST,
        TEXTURE_MIN_NEAREST,
        ALPHA_LAYERS,
        HIT_TRIANGLE,
        HIT_SPHERE,
        HIT_DISC,
    ];
    let mut text: String = list.iter().map(|(name, value)| format!("const uint {name} = {value}u;\n")).collect();
    for (number, kind) in light::KINDS.iter().enumerate() {
        text += &format!("const uint {} = {number}u;\n", kind.constant);
    }
    for (number, model) in bsdf::MODELS.iter().enumerate() {
        text += &format!("const uint BSDF_{} = {number}u;\n", model.keyword.to_uppercase());
    }
    text + &slot::glsl() + &filter::glsl()
}
