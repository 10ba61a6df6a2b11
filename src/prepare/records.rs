//! The rows of the tables. One record type a table; layouts never depend on features.

use crate::gpu_record;

/// No light, no medium, no row.
pub const NONE: u32 = u32::MAX;

/// `Hit.kind` of the traversal, and the kind of a leaf word.
pub const HIT_TRIANGLE: u32 = 0;
pub const HIT_SPHERE: u32 = 1;
pub const HIT_DISC: u32 = 2;

gpu_record! {
    /// The camera, at the origin; shared by all kinds (src/camera), which say what they read. Film position (x, y) in pixels, row 0 on
    /// top, is `(x * inv_width - 1) * right + (1 - y * inv_height) * up` on the camera's plane.
    pub struct CameraRecord {
        forward: [f32; 3],
        /// 2 / width.
        inv_width: f32,
        /// As long as half the plane's width.
        right: [f32; 3],
        /// 2 / height.
        inv_height: f32,
        /// As long as half the plane's height.
        up: [f32; 3],
        /// Medium the camera stands in, a row of `media`, or NONE.
        medium: u32,
        /// Radius of the lens in units of `right` and of `up`.
        lens: [f32; 2],
        /// Of the plane of focus along the view, m.
        focus_distance: f32,
        /// Position in `camera::MODELS`.
        kind: u32,
        /// Ray cone of a pixel: diameter where rays start, m, and what it grows by a metre.
        cone: [f32; 2],
        reserved: [u32; 2],
        /// Entries of the media the camera stands in, the newest last (shaders/integrator/media.glsl).
        media: [u32; 4],
    }
}

gpu_record! {
    /// A triangle or sphere of a surface meter, front counter-clockwise, outside.
    pub struct SensorElementRecord {
        /// Triangle: vertex 0. Sphere, disc: centre.
        a: [f32; 3],
        /// HIT_TRIANGLE, HIT_SPHERE or HIT_DISC.
        kind: u32,
        /// Triangle: vertex 1. Sphere: radius in x. Disc: one radius.
        b: [f32; 3],
        /// Its share of the area over the probability that the table chooses it: 1 up to rounding.
        weight: f32,
        /// Triangle: vertex 2. Disc: another radius, b x c towards the front.
        c: [f32; 3],
        /// 1: the front is measured, -1: the back.
        side: f32,
    }
}

gpu_record! {
    /// One triangle, leaf order. Front is counter-clockwise.
    pub struct TriangleRecord {
        v0: [f32; 3],
        v1: [f32; 3],
        v2: [f32; 3],
        /// Row of `faces`: the primitive's number, stable under BVH changes.
        face: u32,
        /// Row of `lights`, or NONE.
        light: u32,
        /// Row of `materials`.
        material: u32,
    }
}

gpu_record! {
    /// One analytic sphere, leaf order. Front is outside.
    pub struct SphereRecord {
        center: [f32; 3],
        radius: f32,
        /// World to local rotation as a unit quaternion (x, y, z, w), for uv: local = handedness * rotated.
        rotation: [f32; 4],
        /// The primitive's number: face count + number of the sphere.
        primitive: u32,
        light: u32,
        material: u32,
        /// 1, or -1 where the transform mirrors.
        handedness: f32,
    }
}

gpu_record! {
    /// One flat disc, leaf order. Front is the side that `normal` points to.
    pub struct DiscRecord {
        center: [f32; 3],
        radius: f32,
        normal: [f32; 3],
        /// The primitive's number: after all faces and spheres.
        primitive: u32,
        /// Unit, in the plane, towards growing u.
        tangent: [f32; 3],
        /// +1 or -1: v falls along `handedness` normal x tangent.
        handedness: f32,
        light: u32,
        material: u32,
        instance: u32,
        reserved: u32,
    }
}

gpu_record! {
    /// Vertex numbers of a face (rows of normals, uvs, ...), and flags.
    pub struct FaceRecord {
        vertices: [u32; 3],
        /// FACE_* bits.
        flags: u32,
    }
}
/// The vertices carry normals.
pub const FACE_SMOOTH: u32 = 1;
/// The vertices carry tangents.
pub const FACE_TANGENTS: u32 = 2;

gpu_record! {
    /// World-space unit normal; `handedness` is the bitangent's sign.
    pub struct NormalRecord { normal: [f32; 3], handedness: f32 }
}
gpu_record! {
    /// World-space tangent (not needed to be orthogonal to the normal); the fourth word is unused.
    pub struct TangentRecord { tangent: [f32; 3], reserved: f32 }
}
gpu_record! {
    pub struct UvRecord { uv0: [f32; 2], uv1: [f32; 2] }
}
gpu_record! {
    pub struct ColorRecord { rgba: [f32; 4] }
}

gpu_record! {
    /// Which generated functions evaluate the surface, and where their constants begin in `material_data`.
    pub struct MaterialRecord {
        /// Number of the structure that fills the BSDF's inputs, and first row of its constants.
        pattern: u32,
        data: u32,
        /// The same for emission, alpha and normal map; NONE where the material has none.
        emission_pattern: u32,
        emission_data: u32,
        alpha_pattern: u32,
        alpha_data: u32,
        normal_pattern: u32,
        normal_data: u32,
        /// Position in `bsdf::MODELS`.
        bsdf: u32,
        /// MATERIAL_* bits.
        flags: u32,
        /// For MATERIAL_MASK.
        alpha_cutoff: f32,
        /// Factor on x and y of the normal map.
        normal_scale: f32,
        /// Medium behind the surface, a row of `media`, or NONE.
        interior: u32,
        /// Rank of the priority among those of the scene.
        priority: u32,
        /// Light group of what it emits.
        group: u32,
        reserved: u32,
    }
}
pub const MATERIAL_EMITS: u32 = 1;
pub const MATERIAL_EMITS_TWO_SIDED: u32 = 2;
pub const MATERIAL_MASK: u32 = 4;
pub const MATERIAL_BLEND: u32 = 8;
/// The model transmits: the shading frame keeps the outside.
pub const MATERIAL_TRANSMITS: u32 = 16;
pub const MATERIAL_NORMAL_MAP: u32 = 32;
/// Lets light through without a medium behind it.
pub const MATERIAL_THIN: u32 = 64;
/// The shading frame follows the surface's tangent: a normal map, or a brushed metal. Others take the frame of the normal alone,
/// so that their samples do not depend on what else a scene holds.
pub const MATERIAL_TANGENT: u32 = 128;

gpu_record! {
    pub struct TextureRecord {
        width: u32,
        height: u32,
        /// First row in `texels`.
        first_row: u32,
        /// TEXTURE_* bits.
        flags: u32,
    }
}
pub const TEXTURE_WRAP_U_SHIFT: u32 = 0; // 2 bits: 0 repeat, 1 mirror, 2 clamp
pub const TEXTURE_WRAP_V_SHIFT: u32 = 2;
pub const TEXTURE_NEAREST: u32 = 16;
pub const TEXTURE_SRGB: u32 = 32;
/// Texels are RGBA16F, 2 a row; else RGBA8, 4 a row.
pub const TEXTURE_HALF: u32 = 64;
/// Texels are RGBA16 (unsigned, normalised), 2 a row.
pub const TEXTURE_WIDE: u32 = 128;
/// The four rows before `first_row` hold how many rows after it each level begins (texture/mip.rs).
pub const TEXTURE_MIPS: u32 = 256;
/// The nearest level is read; else the two around are mixed.
pub const TEXTURE_MIP_NEAREST: u32 = 512;
/// The nearest texel where the footprint is larger than one; TEXTURE_NEAREST says it for smaller ones.
pub const TEXTURE_MIN_NEAREST: u32 = 1024;

gpu_record! {
    /// One light. Triangles and spheres copy their geometry, so that sampling reads one record. Front is counter-clockwise, outside.
    /// Suns come first in the table. What a kind without surface keeps where is said in its file under src/light.
    pub struct LightRecord {
        /// Triangle: vertex 0. Sphere: centre. Point, spot: position. Sun: 1 - cos of its half angle in x.
        a: [f32; 3],
        /// Place in `light::KINDS`.
        kind: u32,
        /// Triangle: vertex 1. Sphere: radius in x. Spot: axis. Directional, sun: towards it.
        b: [f32; 3],
        /// Row of `materials` (emission), or NONE.
        material: u32,
        /// Triangle: vertex 2. Point, spot: intensity, W/sr. Directional: irradiance, W/m2. Sun: radiance.
        c: [f32; 3],
        /// Face number, or row of `spheres` or `discs`; of what no surface carries its light group.
        shape: u32,
        /// Probability of being chosen, exactly that of the integer alias table.
        pmf: f32,
        /// Spot: scale, offset and exponent.
        falloff: [f32; 3],
    }
}

gpu_record! {
    /// Two entries of an alias table (light/alias.rs). An entry is kept when the fraction word < threshold, else its alias is
    /// taken; a full entry is its own alias.
    pub struct AliasRecord {
        threshold0: u32,
        alias0: u32,
        threshold1: u32,
        alias1: u32,
    }
}

gpu_record! {
    pub struct SkyRecord {
        /// Uniform radiance, or the factor on the texels.
        scale: [f32; 3],
        /// 0: uniform or none.
        width: u32,
        /// cos and sin of the rotation about +y.
        rotation: [f32; 2],
        height: u32,
        /// The sky's row of `lights`, or NONE.
        light: u32,
    }
}
gpu_record! {
    /// Linear radiance of a texel before `SkyRecord::scale`, and the sampling density of directions in its cell, 1/sr.
    pub struct SkyTexelRecord { radiance: [f32; 3], cell_pdf: f32 }
}
gpu_record! {
    /// Absorption in 1/m and index of refraction; the index is 1 where media do not nest, for models then know their own.
    pub struct MediumRecord { absorption: [f32; 3], eta: f32 }
}
gpu_record! {
    /// A mesh placed in the world, upper leaf order. Row 0 is the world itself: the identity, where flat geometry lies.
    pub struct InstanceRecord {
        /// Rows of the 3x4 object-to-world matrix, rebased to the camera in f64. The f32 numbers are the truth.
        to_world0: [f32; 4],
        to_world1: [f32; 4],
        to_world2: [f32; 4],
        /// Its inverse, from f64.
        to_object0: [f32; 4],
        to_object1: [f32; 4],
        to_object2: [f32; 4],
        /// Root of the mesh's tree, a node of `bvh`.
        first_node: u32,
        /// Row of `materials`; that of the mesh's triangles does not count.
        material: u32,
        /// INSTANCE_MIRRORED; bits 8..=15 are kept for a visibility mask (all set), bits 16..=31 for a light group (0).
        flags: u32,
        /// Added to a face's number (wrapping), gives the placed triangle's own: no two have the same unless there are more than 2^32.
        primitive_offset: u32,
        /// Number in the scene's list of instances.
        object: u32,
        /// Kept for motion: a row with a time range and a second matrix. NONE: at rest.
        motion: u32,
        /// Kept for the media outside and inside. NONE: as the material says.
        media: [u32; 2],
    }
}
/// The determinant is negative: the bitangent turns round.
pub const INSTANCE_MIRRORED: u32 = 1;
pub const INSTANCE_VISIBLE_TO_ALL: u32 = 0xff << 8;
