//! A scene resolved to f32 records: what the GPU reads, and what the replay oracle reads.
//!
//! The world is rebased in f64 so that the camera stands at the origin; `Prepared::origin` is what was subtracted.

mod emitters;
pub mod features;
pub mod geometry;
pub mod instances;
pub mod lights;
pub mod materials;
pub mod media;
pub mod pattern;
pub mod records;

use glam::DVec3;

use crate::bvh::{self, Bvh, traverse};
use crate::camera;
use crate::film::aov::GROUPS;
use crate::integrator::{Estimator, Settings};
use crate::light;
use crate::scene::{Scene, groups};
use pattern::Structure;
use records::*;

/// Materials that bound a medium, where bodies of them overlap.
const MAX_NESTED_MEDIA: usize = 0xfffe;

/// Why a scene cannot be resolved.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("the transform of '{instance}' {what}")]
    Transform { instance: String, what: &'static str },
    #[error("the scene has {count} {what}, more than the limit of {limit}; split it or simplify it")]
    TooMany { what: &'static str, count: usize, limit: usize },
    /// A sentence of `camera`.
    #[error("{0}")]
    Camera(String),
    #[error("an image of {width}x{height} pixels cannot be rendered; both sides must be between 1 and 65536")]
    Film { width: u32, height: u32 },
    #[error(transparent)]
    Bvh(#[from] bvh::Error),
    #[error(transparent)]
    Light(#[from] lights::LightError),
    #[error("the settings are for {known} light groups and the scene has {count}: take them from this scene")]
    Groups { known: u32, count: usize },
}

/// Everything a render needs, as plain values. Index conventions are stated at each record.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// Image size in pixels.
    pub width: u32,
    pub height: u32,
    /// World position of the origin of all records (the camera's position).
    pub origin: DVec3,
    pub camera: CameraRecord,
    /// Inverse distribution of the pixel filter (`film::filter`); empty for the box of one pixel.
    pub filter: Vec<[u32; 4]>,
    /// Of a surface meter.
    pub sensor_elements: Vec<SensorElementRecord>,
    /// Alias table over `sensor_elements`, by area.
    pub sensor_alias: Vec<AliasRecord>,
    /// Nodes and the leaf order of `triangles`, `spheres` and `discs`.
    pub bvh: Bvh,
    /// In leaf order.
    pub triangles: Vec<TriangleRecord>,
    /// In leaf order.
    pub spheres: Vec<SphereRecord>,
    /// In leaf order.
    pub discs: Vec<DiscRecord>,
    /// Placed meshes, the world first; empty in a scene of one level.
    pub instances: Vec<InstanceRecord>,
    /// By face number (`TriangleRecord::face`). Those of placed meshes come last, and what they name is in the mesh's own space.
    pub faces: Vec<FaceRecord>,
    /// By vertex number. Empty when no face has smooth normals or tangents.
    pub normals: Vec<NormalRecord>,
    /// By vertex number. Empty when no normal map or anisotropy needs them.
    pub tangents: Vec<TangentRecord>,
    /// By vertex number. Empty when nothing is textured.
    pub uvs: Vec<UvRecord>,
    /// By vertex number. Empty when nothing reads vertex colours.
    pub colors: Vec<ColorRecord>,
    pub materials: Vec<MaterialRecord>,
    /// Constants and texture references of the patterns, see `pattern`.
    pub material_data: Vec<[u32; 4]>,
    /// The distinct pattern structures that the materials name.
    pub structures: Vec<Structure>,
    pub textures: Vec<TextureRecord>,
    /// Texture pages: rows of 4 RGBA8 texels or 2 RGBA16F texels.
    pub texels: Vec<[u32; 4]>,
    pub lights: Vec<LightRecord>,
    /// Alias table over `lights`, proportional to power.
    pub light_alias: Vec<AliasRecord>,
    /// Light groups of the scene, and which is the sky's.
    pub group_count: u32,
    pub sky_group: u32,
    /// Something shines from infinity.
    pub has_sky: bool,
    pub sky: SkyRecord,
    /// Row-major texels of the lat-long sky, one row each. Empty for a uniform or absent sky.
    pub sky_texels: Vec<SkyTexelRecord>,
    pub sky_alias: Vec<AliasRecord>,
    pub media: Vec<MediumRecord>,
    /// Bodies of media may overlap: paths keep a stack.
    pub nests: bool,
    /// Macros of the models, and whether some material switches them on.
    pub bsdf_macros: Vec<(&'static str, bool)>,
    /// Seconds spent in the BVH build.
    pub bvh_s: f64,
    /// Where the primitives of an instance begin: number of its first, and its own number in the scene. Ascending.
    pub objects: Vec<(u32, u32)>,
    /// What was dropped or repaired on the way.
    pub notes: Vec<String>,
}

/// Resolves `scene` for `settings`. Errors name the entity at fault.
pub fn prepare(scene: &Scene, settings: &Settings) -> Result<Prepared, Error> {
    let (width, height) = (scene.film.width, scene.film.height);
    if !(1..=65536).contains(&width) || !(1..=65536).contains(&height) {
        return Err(Error::Film { width, height });
    }
    let origin = scene.camera.to_world.translation;
    let groups = scene.light_groups();
    if settings.aovs.has(GROUPS) && settings.aovs.group_count() as usize != groups.len() {
        return Err(Error::Groups { known: settings.aovs.group_count(), count: groups.len() });
    }
    let mut resolved = materials::resolve(scene);
    // A path's entry is a rank and a row plus 1, 16 bits each (shaders/integrator/media_stack.glsl).
    if resolved.nests && resolved.media.len() > MAX_NESTED_MEDIA {
        let (count, limit) = (resolved.media.len(), MAX_NESTED_MEDIA);
        return Err(Error::TooMany { what: "nested media", count, limit });
    }
    resolved.wanted.uvs |= settings.aovs.has("uv");
    let emits = |material: usize| resolved.materials[material].flags & MATERIAL_EMITS != 0;
    let plan = instances::plan(scene, origin, settings.instancing, emits);
    let geometry = geometry::flatten(scene, origin, resolved.wanted, &plan, &mut resolved.notes)?;
    drop(plan);

    let start = std::time::Instant::now();
    let positions: Vec<[[f32; 3]; 3]> = geometry.triangles.iter().map(|t| [t.v0, t.v1, t.v2]).collect();
    let balls: Vec<([f32; 3], f32)> = geometry.spheres.iter().map(|s| (s.center, s.radius)).collect();
    let plate = |d: &DiscRecord| bvh::Disc { center: d.center, normal: d.normal, radius: d.radius };
    let plates: Vec<bvh::Disc> = geometry.discs.iter().map(plate).collect();
    let (flat, meshes) = positions.split_at(geometry.flat_triangle_count());
    let primitives = bvh::Primitives { triangles: flat, spheres: &balls, discs: &plates, ..Default::default() };
    let (tree, report) = if geometry.placed.is_empty() {
        bvh::build(&primitives)?
    } else {
        let meshes: Vec<_> =
            geometry.mesh_faces.iter().map(|f| &meshes[f.start - flat.len()..f.end - flat.len()]).collect();
        let placed: Vec<_> = geometry.placed.iter().map(instances::Placed::placement).collect();
        bvh::two_level::build_two_level(&primitives, &meshes, &placed)?
    };
    drop(positions);
    let bvh_s = start.elapsed().as_secs_f64();

    let mut p = Prepared {
        width,
        height,
        origin,
        filter: scene.film.filter.rows(),
        triangles: tree.triangle_order.iter().map(|&i| geometry.triangles[i as usize]).collect(),
        spheres: tree.sphere_order.iter().map(|&i| geometry.spheres[i as usize]).collect(),
        discs: tree.disc_order.iter().map(|&i| geometry.discs[i as usize]).collect(),
        instances: instances::records(&geometry, &tree),
        bvh: tree,
        faces: geometry.faces,
        normals: geometry.normals,
        tangents: geometry.tangents,
        uvs: geometry.uvs,
        colors: geometry.colors,
        materials: resolved.materials,
        material_data: resolved.data,
        structures: resolved.structures,
        textures: resolved.textures,
        texels: resolved.texels,
        media: resolved.media,
        nests: resolved.nests,
        group_count: groups.len() as u32,
        sky_group: groups::number(&groups, scene.sky_group.as_deref()),
        bsdf_macros: resolved.macros,
        bvh_s,
        objects: geometry.objects,
        notes: resolved.notes,
        ..Prepared::default()
    };
    if report.dropped() > 0 {
        p.notes.push(format!(
            "{} primitives were left out of the geometry: {} without area, {} not finite, {} out of range",
            report.dropped(),
            report.zero_area,
            report.non_finite,
            report.out_of_range
        ));
    }
    let any_face = |bit: u32| p.triangles.iter().any(|t| p.faces[t.face as usize].flags & bit != 0);
    let (is_smooth, has_face_tangents) = (any_face(FACE_SMOOTH), any_face(FACE_TANGENTS));
    // The handedness of a tangent stands beside the normal.
    if !is_smooth && !has_face_tangents {
        p.normals.clear();
    }
    if !has_face_tangents {
        p.tangents.clear();
    }
    p.camera = camera::record(scene).map_err(Error::Camera)?;
    let elements = camera::elements(scene).map_err(Error::Camera)?;
    (p.sensor_elements, p.sensor_alias) = (elements.records, elements.alias);
    (p.camera.medium, p.camera.media) = media::around_camera(&p);
    emitters::attach(&mut p, scene, &resolved.emission, settings.estimator == Estimator::Mis)?;
    if settings.estimator == Estimator::Bsdf {
        let count = p.lights.iter().filter(|l| light::kind(l).is_some_and(light::Kind::is_delta)).count();
        if count > 0 {
            p.notes.push(format!("the estimator bsdf cannot find {count} lights without size; use mis or light"));
        }
    }
    Ok(p)
}

/// `Prepared::object_of` over `Prepared::objects`.
pub fn object_of(objects: &[(u32, u32)], primitive: u32) -> u32 {
    let after = objects.partition_point(|entry| entry.0 <= primitive);
    objects[..after].last().map_or(NONE, |entry| entry.1)
}

impl Prepared {
    /// Number in the scene's list of instances of what primitive `primitive` belongs to.
    pub fn object_of(&self, primitive: u32) -> u32 {
        object_of(&self.objects, primitive)
    }

    /// The triangles that lie in the world.
    pub fn flat_triangles(&self) -> &[TriangleRecord] {
        &self.triangles[..self.bvh.flat_triangle_count()]
    }

    /// The table of instances as a kernel reads it, which knows the world in any case.
    pub fn instances_or_world(&self) -> &[InstanceRecord] {
        if self.instances.is_empty() { &[instances::WORLD_RECORD] } else { &self.instances }
    }

    /// What rays are traced against.
    pub fn geometry(&self) -> traverse::Geometry<'_> {
        let Self { bvh, triangles, spheres, discs, instances, .. } = self;
        traverse::Geometry { bvh, triangles, spheres, discs, instances }
    }

    /// Radius of a sphere about the box of all primitives, metres; 1 where there is none.
    pub fn bounding_radius(&self) -> f64 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut add = |v: [f32; 3], r: f32| {
            let v = DVec3::from(v.map(f64::from));
            low = low.min(v - f64::from(r));
            high = high.max(v + f64::from(r));
        };
        for t in self.flat_triangles() {
            [t.v0, t.v1, t.v2].into_iter().for_each(|v| add(v, 0.0));
        }
        for s in &self.spheres {
            add(s.center, s.radius);
        }
        for d in &self.discs {
            add(d.center, d.radius);
        }
        for m in self.instances.iter().skip(1) {
            // The upper tree's boxes would do but for their margin.
            let [lo, hi] = bvh::two_level::world_box(&m.to_world(), self.bvh.bounds_below(m.first_node));
            low = low.min(lo);
            high = high.max(hi);
        }
        let radius = 0.5 * (high - low).length();
        if low.x <= high.x && radius > 0.0 && radius.is_finite() { radius } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::features::Features;
    use crate::scene::format::toml;

    fn prepared(text: &str) -> Prepared {
        let scene = toml::parse(text, std::path::Path::new("test.toml")).unwrap();
        prepare(&scene, &Settings::default()).unwrap()
    }

    #[test]
    fn flat_shapes_and_lone_balls_have_tangents_where_a_material_reads_them() {
        let mapped = "normal_map = { texture = \"t\" }";
        let brushed = "type = \"conductor\"\nroughness = 0.3\nroughness_y = 0.1";
        for (shape, material, is_wanted) in [
            ("sphere", mapped, true),
            ("sphere", brushed, true),
            ("sphere", "", false),
            ("disc", mapped, true),
            ("disc", brushed, true),
            ("rectangle", mapped, true),
            ("rectangle", "", false),
        ] {
            let p = prepared(&format!(
                "[[texture]]\nname = \"t\"\ntype = \"constant\"\ncolor = [0.5, 0.6, 1]\n[[material]]\nname = \"m\"\n{material}\n\
                 [[shape]]\ntype = \"{shape}\"\nmaterial = \"m\"\n[camera]\nposition = [0, 0, 5]\n"
            ));
            let has_tangents = Features::of(&p, &Settings::default()).tangents;
            assert_eq!(has_tangents, is_wanted, "{shape} {material}");
            // The kernel reads a tangent's handedness beside the normal.
            assert_eq!(p.normals.len(), p.tangents.len(), "{shape} {material}");
        }
    }

    #[test]
    fn shapes_without_vertices_have_texture_coordinates_where_a_pattern_reads_them() {
        for shape in ["sphere", "disc", "rectangle"] {
            for (albedo, is_wanted) in [("{ texture = \"t\" }", true), ("0.5", false)] {
                let p = prepared(&format!(
                    "[[texture]]\nname = \"t\"\ntype = \"checker\"\n[[material]]\nname = \"m\"\nalbedo = {albedo}\n\
                     [[shape]]\ntype = \"{shape}\"\nmaterial = \"m\"\n[camera]\nposition = [0, 0, 5]\n"
                ));
                assert_eq!(Features::of(&p, &Settings::default()).uvs, is_wanted, "{shape} {albedo}");
            }
        }
    }

    #[test]
    fn a_camera_behind_a_pane_inside_glass_is_in_the_glass() {
        let text = r#"
            camera = { position = [0, 0, 5] }
            [[material]]
            name = "glass"
            type = "dielectric"
            absorption = [1, 2, 3]
            [[material]]
            name = "pane"
            type = "thin_dielectric"
            [[shape]]
            type = "sphere"
            radius = 9
            material = "glass"
            [[shape]]
            type = "sphere"
            center = [0, 0, 5]
            radius = 0.5
            material = "pane"
            "#;
        let mut scene = toml::parse(text, std::path::Path::new("test.toml")).unwrap();
        // No scene file can say so: nothing is inside a pane.
        scene.materials[1].interior = Some(crate::scene::Medium { absorption: DVec3::splat(7.0) });
        let p = prepare(&scene, &Settings::default()).unwrap();
        assert_eq!((p.media.len(), p.media[0].absorption, p.camera.medium), (1, [1.0, 2.0, 3.0], 0));
    }
}
