//! The JSON of a glTF 2.0 file as plain structs: numbers f64, indices as written, extensions that are shaded by name.
//!
//! The gltf crate opens .glb containers; its own JSON types hold transforms in f32 and its reader refuses files whose
//! required extensions it does not know (gltf-rs issue 472), so that this reads the JSON itself. Nothing here is checked:
//! every index is looked up through `at`, which says what was out of range.

use std::collections::BTreeMap;

use serde::Deserialize;

macro_rules! document {
    ($($(#[$meta:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty $(= $default:expr)?),* $(,)? })*) => {
        $(
            $(#[$meta])*
            #[derive(Clone, Debug, Deserialize)]
            #[serde(rename_all = "camelCase", default)]
            pub struct $name { $($(#[$field_meta])* pub $field: $type),* }

            impl Default for $name {
                fn default() -> Self {
                    Self { $($field: document!(@default $($default)?)),* }
                }
            }
        )*
    };
    (@default) => { Default::default() };
    (@default $default:expr) => { $default };
}

type Index = Option<usize>;

document! {
    Document {
        asset: Asset,
        scene: Index,
        scenes: Vec<SceneList>,
        nodes: Vec<Node>,
        meshes: Vec<Mesh>,
        materials: Vec<Material>,
        textures: Vec<Texture>,
        images: Vec<Image>,
        samplers: Vec<Sampler>,
        accessors: Vec<Accessor>,
        buffer_views: Vec<BufferView>,
        buffers: Vec<Buffer>,
        cameras: Vec<Camera>,
        animations: Vec<serde::de::IgnoredAny>,
        skins: Vec<serde::de::IgnoredAny>,
        extensions: DocumentExtensions,
        extensions_used: Vec<String>,
        extensions_required: Vec<String>,
    }
    DocumentExtensions {
        #[serde(rename = "KHR_materials_variants")]
        variants: Option<Variants>,
        #[serde(rename = "KHR_lights_punctual")]
        lights: Option<PunctualLights>,
    }
    PunctualLights { lights: Vec<PunctualLight> }
    PunctualLight {
        name: Option<String>,
        r#type: String,
        color: [f64; 3] = [1.0; 3],
        intensity: f64 = 1.0,
        range: Option<f64>,
        spot: Option<SpotCone>,
    }
    SpotCone { inner_cone_angle: f64, outer_cone_angle: f64 = std::f64::consts::FRAC_PI_4 }
    NodeLight { light: usize }
    Variants { variants: Vec<Variant> }
    Variant { name: String }
    Asset { version: String, min_version: Option<String> }
    SceneList { name: Option<String>, nodes: Vec<usize> }
    Node {
        name: Option<String>,
        children: Vec<usize>,
        matrix: Option<[f64; 16]>,
        translation: [f64; 3],
        rotation: [f64; 4] = [0.0, 0.0, 0.0, 1.0],
        scale: [f64; 3] = [1.0; 3],
        mesh: Index,
        skin: Index,
        camera: Index,
        extensions: NodeExtensions,
    }
    NodeExtensions {
        #[serde(rename = "EXT_mesh_gpu_instancing")]
        instancing: Option<Instancing>,
        #[serde(rename = "KHR_lights_punctual")]
        light: Option<NodeLight>,
        #[serde(rename = "KHR_node_visibility")]
        visibility: Option<Visibility>,
    }
    Instancing { attributes: BTreeMap<String, usize> }
    Visibility { visible: bool = true }
    Mesh { name: Option<String>, primitives: Vec<Primitive> }
    Primitive {
        attributes: BTreeMap<String, usize>,
        indices: Index,
        material: Index,
        mode: u32 = 4,
        targets: Vec<serde::de::IgnoredAny>,
        extensions: PrimitiveExtensions,
    }
    PrimitiveExtensions {
        #[serde(rename = "KHR_materials_variants")]
        variants: Option<VariantMappings>,
    }
    VariantMappings { mappings: Vec<VariantMapping> }
    VariantMapping { material: usize, variants: Vec<usize> }
    Camera { r#type: String, perspective: Option<Perspective>, orthographic: Option<Orthographic> }
    Perspective { yfov: f64 }
    Orthographic { xmag: f64, ymag: f64 }
    Accessor {
        name: Option<String>,
        buffer_view: Index,
        byte_offset: u64,
        component_type: u32,
        normalized: bool,
        count: u64,
        r#type: String,
        sparse: Option<Sparse>,
    }
    Sparse { count: u64, indices: SparsePart, values: SparsePart }
    SparsePart { buffer_view: Index, byte_offset: u64, component_type: u32 }
    BufferView { buffer: usize, byte_offset: u64, byte_length: u64, byte_stride: Option<u64> }
    Buffer { uri: Option<String>, byte_length: u64 }
    Image { name: Option<String>, uri: Option<String>, buffer_view: Index }
    Sampler { mag_filter: Option<u32>, min_filter: Option<u32>, wrap_s: u32 = 10497, wrap_t: u32 = 10497 }
    Texture { sampler: Index, source: Index, extensions: TextureExtensions }
    TextureExtensions {
        #[serde(rename = "EXT_texture_webp")]
        webp: Option<WebpSource>,
    }
    WebpSource { source: Index }
    Material {
        name: Option<String>,
        pbr_metallic_roughness: MetallicRoughness,
        normal_texture: Option<TextureInfo>,
        emissive_texture: Option<TextureInfo>,
        emissive_factor: [f64; 3],
        alpha_mode: Option<String>,
        alpha_cutoff: f64 = 0.5,
        double_sided: bool,
        extensions: MaterialExtensions,
    }
    MetallicRoughness {
        base_color_factor: [f64; 4] = [1.0; 4],
        base_color_texture: Option<TextureInfo>,
        metallic_factor: f64 = 1.0,
        roughness_factor: f64 = 1.0,
        metallic_roughness_texture: Option<TextureInfo>,
    }
    TextureInfo { index: usize, tex_coord: u32, scale: f64 = 1.0, extensions: TextureInfoExtensions }
    TextureInfoExtensions {
        #[serde(rename = "KHR_texture_transform")]
        transform: Option<TextureTransform>,
    }
    TextureTransform { offset: [f64; 2], rotation: f64, scale: [f64; 2] = [1.0; 2], tex_coord: Option<u32> }
    MaterialExtensions {
        #[serde(rename = "KHR_materials_emissive_strength")]
        emissive_strength: Option<EmissiveStrength>,
        #[serde(rename = "KHR_materials_ior")]
        ior: Option<Ior>,
        #[serde(rename = "KHR_materials_transmission")]
        transmission: Option<Transmission>,
        #[serde(rename = "KHR_materials_unlit")]
        unlit: Option<Unlit>,
        #[serde(rename = "KHR_materials_volume")]
        volume: Option<Volume>,
        #[serde(rename = "KHR_materials_specular")]
        specular: Option<Specular>,
        #[serde(rename = "KHR_materials_anisotropy")]
        anisotropy: Option<Anisotropy>,
        #[serde(rename = "KHR_materials_clearcoat")]
        clearcoat: Option<Clearcoat>,
    }
    Specular {
        specular_factor: f64 = 1.0,
        specular_texture: Option<TextureInfo>,
        specular_color_factor: [f64; 3] = [1.0; 3],
        specular_color_texture: Option<TextureInfo>,
    }
    Anisotropy { anisotropy_strength: f64, anisotropy_rotation: f64, anisotropy_texture: Option<TextureInfo> }
    Clearcoat {
        clearcoat_factor: f64,
        clearcoat_texture: Option<TextureInfo>,
        clearcoat_roughness_factor: f64,
        clearcoat_roughness_texture: Option<TextureInfo>,
        clearcoat_normal_texture: Option<TextureInfo>,
    }
    Unlit {}
    EmissiveStrength { emissive_strength: f64 = 1.0 }
    Ior { ior: f64 = 1.5 }
    Transmission { transmission_factor: f64, transmission_texture: Option<TextureInfo> }
    Volume {
        thickness_factor: f64,
        thickness_texture: Option<TextureInfo>,
        attenuation_distance: Option<f64>,
        attenuation_color: [f64; 3] = [1.0; 3],
    }
}

impl TextureInfo {
    /// The coordinate set, the transform's own when it names one.
    pub fn uv_set(&self) -> u32 {
        self.extensions.transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(self.tex_coord)
    }
}

impl Material {
    /// Something of it has a direction along the surface.
    pub fn follows_tangent(&self) -> bool {
        self.normal_texture.is_some()
            || self.extensions.anisotropy.as_ref().is_some_and(|a| a.anisotropy_strength > 0.0)
    }

    pub fn texture_infos(&self) -> impl Iterator<Item = &TextureInfo> {
        let e = &self.extensions;
        let transmission = e.transmission.as_ref().and_then(|t| t.transmission_texture.as_ref());
        let specular = e.specular.as_ref().map(|s| [s.specular_texture.as_ref(), s.specular_color_texture.as_ref()]);
        let clearcoat =
            e.clearcoat.as_ref().map(|c| [c.clearcoat_texture.as_ref(), c.clearcoat_roughness_texture.as_ref()]);
        [
            self.pbr_metallic_roughness.base_color_texture.as_ref(),
            self.pbr_metallic_roughness.metallic_roughness_texture.as_ref(),
            self.normal_texture.as_ref(),
            self.emissive_texture.as_ref(),
            transmission,
            e.anisotropy.as_ref().and_then(|a| a.anisotropy_texture.as_ref()),
        ]
        .into_iter()
        .chain(specular.into_iter().flatten())
        .chain(clearcoat.into_iter().flatten())
        .flatten()
    }
}
