//! A scene resolved to f32 records: what the GPU reads, and what the replay oracle reads.
//!
//! The world is rebased in f64 so that the camera stands at the origin; `Prepared::origin` is what was subtracted.

pub mod lights;
pub mod records;

use glam::DVec3;

use crate::bvh::Bvh;
use records::*;

/// Everything a render needs, as plain values. Index conventions are stated at each record.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// World position of the origin of all records (the camera's position).
    pub origin: DVec3,
    pub camera: CameraRecord,
    /// Nodes and the leaf order of `triangles` and `spheres`.
    pub bvh: Bvh,
    /// In leaf order.
    pub triangles: Vec<TriangleRecord>,
    /// In leaf order.
    pub spheres: Vec<SphereRecord>,
    /// By face number (`TriangleRecord::face`).
    pub faces: Vec<FaceRecord>,
    /// By vertex number. Empty when no face has smooth normals.
    pub normals: Vec<NormalRecord>,
    /// By vertex number. Empty when no normal map needs them.
    pub tangents: Vec<TangentRecord>,
    /// By vertex number. Empty when nothing is textured.
    pub uvs: Vec<UvRecord>,
    /// By vertex number. Empty when nothing reads vertex colours.
    pub colors: Vec<ColorRecord>,
    pub materials: Vec<MaterialRecord>,
    /// Constants and texture references of the patterns, see `pattern`.
    pub material_data: Vec<[u32; 4]>,
    pub textures: Vec<TextureRecord>,
    /// Texture pages: rows of 4 RGBA8 texels or 2 RGBA16F texels.
    pub texels: Vec<[u32; 4]>,
    pub lights: Vec<LightRecord>,
    /// Alias table over `lights`, proportional to power.
    pub light_alias: Vec<AliasRecord>,
    pub sky: SkyRecord,
    /// Row-major texels of the lat-long sky, one row each. Empty for a uniform or absent sky.
    pub sky_texels: Vec<SkyTexelRecord>,
    pub sky_alias: Vec<AliasRecord>,
    pub media: Vec<MediumRecord>,
}
