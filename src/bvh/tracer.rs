//! Rays in, hits out, on a device: the kernel that gate 5 and `benches/rays` run, with the traversal that renders use.
//!
//! Leaves out shading and everything else of a scene. One kernel a question, compiled for the kinds that are there.

use std::time::Duration;

use crate::gpu::{Buffer, Device, GpuError, Pipeline, Table, TableBody};
use crate::gpu_record;
use crate::prepare::records::{DiscRecord, InstanceRecord, SphereRecord, TriangleRecord};
use crate::shader::cache::Cache;
use crate::shader::compile::{CompileError, Source, compile};
use crate::shader::record::GpuRecord;

use super::traverse::{Geometry, Hit};

/// Invocations of a workgroup; 8 to 256 measured alike on lavapipe.
const WORKGROUP: u32 = 64;

gpu_record! {
    /// A ray and what its question needs besides.
    pub struct RayRecord {
        o: [f32; 3],
        t_max: f32,
        d: [f32; 3],
        /// `Question::Any`: the primitive that is not tested. `ClosestFrom`: `primitive_after`.
        primitive: u32,
        /// `ClosestFrom` only.
        t_after: f32,
        reserved: [u32; 3],
    }
}

gpu_record! {
    /// The words of a `Hit`; `Any` sets `kind` to 1 or 0, `Spawn` puts the new origin into t, b1, b2.
    pub struct HitRecord {
        t: f32,
        b1: f32,
        b2: f32,
        kind: u32,
        slot: u32,
        primitive: u32,
        instance: u32,
        reserved: u32,
    }
}

impl HitRecord {
    pub fn hit(&self) -> Hit {
        let HitRecord { t, b1, b2, kind, slot, primitive, instance, .. } = *self;
        Hit { t, b1, b2, kind, slot, primitive, instance }
    }
}

/// What is asked of each ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    Closest,
    ClosestFrom,
    Any,
    /// Where a ray leaving the closest hit, mirrored about the surface, begins. `kind` and `primitive` are of the hit.
    Spawn,
}

impl Question {
    fn main(self) -> &'static str {
        match self {
            Question::Closest => "    Hit h = trace_closest(ray);\n",
            Question::ClosestFrom => "    Hit h = trace_closest_from(ray, r.t_after, r.primitive);\n",
            Question::Any => {
                "    Hit h = hit_at(0.0, 0.0, 0.0, trace_any(ray, r.primitive) ? 1u : 0u, NO_HIT, NO_HIT);\n"
            }
            Question::Spawn => {
                "    Hit h = trace_closest(ray);\n    vec3 p = vec3(0.0), ng = vec3(0.0), error = vec3(0.0);\n\
                 #if HAS_TRIANGLES\n    if (h.kind == 0u) {\n        \
                 TriangleRecord f = TriangleRecord_load_triangles(h.slot);\n        \
                 p = triangle_point(f.v0, f.v1, f.v2, h.b1, h.b2, error);\n        \
                 ng = triangle_normal(f.v0, f.v1, f.v2);\n#if HAS_INSTANCES\n        \
                 InstanceRecord placed = InstanceRecord_load_instances(h.instance);\n        \
                 p = instance_point(placed, p, error);\n        \
                 ng = instance_normal(placed, ng);\n#endif\n    }\n#endif\n\
                 #if HAS_SPHERES\n    if (h.kind == 1u) {\n        \
                 SphereRecord f = SphereRecord_load_spheres(h.slot);\n        \
                 ng = sphere_normal(ray.o + h.t * ray.d, f.center);\n        \
                 p = sphere_point(ng, f.center, f.radius, error);\n    }\n#endif\n\
                 #if HAS_DISCS\n    if (h.kind == 2u) {\n        \
                 DiscRecord f = DiscRecord_load_discs(h.slot);\n        \
                 ng = f.normal;\n        \
                 p = disc_point(ray.o + h.t * ray.d, f.center, f.normal, f.radius, error);\n    }\n#endif\n    \
                 vec3 o = spawn_origin(p, error, ng, reflect(ray.d, ng));\n    \
                 h.t = o.x;\n    h.b1 = o.y;\n    h.b2 = o.z;\n"
            }
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Compile(#[from] CompileError),
}

/// A tree and its primitives on a device.
pub struct Tracer {
    device: Device,
    tables: Vec<Table>,
    bodies: Vec<(&'static str, TableBody)>,
    stack_size: u32,
    has_triangles: bool,
    has_spheres: bool,
    has_discs: bool,
    has_instances: bool,
}

/// A kernel with its rays uploaded.
pub struct Batch<'a> {
    tracer: &'a Tracer,
    pipeline: Pipeline,
    rays: Table,
    hits: Buffer,
    count: usize,
}

impl Tracer {
    pub fn new(device: &Device, g: &Geometry) -> Result<Tracer, TraceError> {
        let mut tracer = Tracer {
            device: device.clone(),
            tables: Vec::new(),
            bodies: Vec::new(),
            stack_size: g.bvh.stack_size(),
            has_triangles: !g.triangles.is_empty(),
            has_spheres: !g.spheres.is_empty(),
            has_discs: !g.discs.is_empty(),
            has_instances: !g.instances.is_empty(),
        };
        tracer.add("bvh", &g.bvh.nodes)?;
        if tracer.has_triangles {
            tracer.add("triangles", g.triangles)?;
        }
        if tracer.has_spheres {
            tracer.add("spheres", g.spheres)?;
        }
        if tracer.has_discs {
            tracer.add("discs", g.discs)?;
        }
        if tracer.has_instances {
            tracer.add("instances", g.instances)?;
        }
        Ok(tracer)
    }

    fn add<T: bytemuck::Pod>(&mut self, name: &'static str, records: &[T]) -> Result<(), GpuError> {
        let body = TableBody::choose(self.device.info(), name, size_of_val(records) / 16)?;
        self.tables.push(self.device.table(name, records, body)?);
        self.bodies.push((name, body));
        Ok(())
    }

    fn source(&self, question: Question, ray_body: TableBody) -> Result<Source, CompileError> {
        let mut tables = ray_body.glsl("rays", 1) + &RayRecord::glsl_struct() + &RayRecord::glsl_loader("rays");
        for (binding, (name, body)) in self.bodies.iter().enumerate() {
            tables += &body.glsl(name, binding as u32 + 2);
            match *name {
                "triangles" => tables += &(TriangleRecord::glsl_struct() + &TriangleRecord::glsl_loader(name)),
                "spheres" => tables += &(SphereRecord::glsl_struct() + &SphereRecord::glsl_loader(name)),
                "discs" => tables += &(DiscRecord::glsl_struct() + &DiscRecord::glsl_loader(name)),
                "instances" => tables += &(InstanceRecord::glsl_struct() + &InstanceRecord::glsl_loader(name)),
                _ => {}
            }
        }
        tables += &format!("const uint BVH_STACK = {}u;\n", self.stack_size);
        let head = format!(
            "layout(local_size_x = {WORKGROUP}) in;\n\
             layout(set = 0, binding = 0, std430) buffer HITS_block {{ uvec4 rows[]; }} HITS;\n\
             layout(push_constant) uniform Push {{ uint ray_count; }} push;\n"
        );
        let main = format!(
            "void main() {{\n    uint i = gl_GlobalInvocationID.x;\n    if (i < push.ray_count) {{\n    \
             RayRecord r = RayRecord_load_rays(i);\n    Ray ray = Ray(r.o, r.d, r.t_max);\n{}    \
             HITS.rows[2u * i] = uvec4(floatBitsToUint(vec3(h.t, h.b1, h.b2)), h.kind);\n    \
             uint instance = 0u;\n#if HAS_INSTANCES\n    instance = h.instance;\n#endif\n    \
             HITS.rows[2u * i + 1u] = uvec4(h.slot, h.primitive, instance, 0u);\n    }}\n}}\n",
            question.main()
        );
        let mut source = Source::new(&format!("trace {question:?}"))
            .define("HAS_TRIANGLES", self.has_triangles)
            .define("HAS_SPHERES", self.has_spheres)
            .define("HAS_DISCS", self.has_discs)
            .define("HAS_INSTANCES", self.has_instances)
            .part("tracer.head", head)
            .file("core/math.glsl")?
            .part("tracer.tables", tables)
            .file("bvh/node.glsl")?;
        if self.has_triangles {
            source = source.file("bvh/triangle.glsl")?;
        }
        if self.has_spheres {
            source = source.file("bvh/sphere.glsl")?;
        }
        if self.has_discs {
            source = source.file("bvh/disc.glsl")?;
        }
        if self.has_instances {
            source = source.file("bvh/instance.glsl")?;
        }
        source = source.file("bvh/space.glsl")?;
        source = match question {
            Question::Any => source.file("bvh/any.glsl")?,
            Question::Spawn => {
                source = source.file("bvh/closest.glsl")?.file("bvh/spawn.glsl")?;
                if self.has_instances { source.file("bvh/placed.glsl")? } else { source }
            }
            Question::Closest | Question::ClosestFrom => source.file("bvh/closest.glsl")?,
        };
        Ok(source.part("tracer.main", main))
    }

    /// Compiles the kernel for `question` and uploads the rays.
    pub fn batch(&self, question: Question, rays: &[RayRecord]) -> Result<Batch<'_>, TraceError> {
        let body = TableBody::choose(self.device.info(), "rays", rays.len() * RayRecord::ROWS)?;
        let spirv = compile(&self.source(question, body)?, &Cache::user())?;
        Ok(Batch {
            tracer: self,
            pipeline: self.device.pipeline(&spirv, &[])?,
            rays: self.device.table("rays", rays, body)?,
            hits: self.device.buffer("HITS", (rays.len() * size_of::<HitRecord>()).max(32) as u64)?,
            count: rays.len(),
        })
    }

    /// The answer for each ray, in order.
    pub fn trace(&self, question: Question, rays: &[RayRecord]) -> Result<Vec<HitRecord>, TraceError> {
        let mut hits = Vec::with_capacity(rays.len());
        // Within the limits of every table body and workgroup count.
        for part in rays.chunks(1 << 20) {
            let batch = self.batch(question, part)?;
            batch.run()?;
            hits.extend(batch.hits()?);
        }
        Ok(hits)
    }
}

impl Batch<'_> {
    /// Traces all rays once; wall-clock time of submit and wait.
    pub fn run(&self) -> Result<Duration, GpuError> {
        let mut bindings: Vec<_> = self.tracer.tables.iter().map(Table::binding).collect();
        bindings.extend([self.rays.binding(), self.hits.binding()]);
        let count = self.count as u32;
        let groups = [count.div_ceil(WORKGROUP), 1, 1];
        self.tracer.device.dispatch(&self.pipeline, &bindings, &count.to_ne_bytes(), groups)
    }

    pub fn hits(&self) -> Result<Vec<HitRecord>, GpuError> {
        self.hits.read(0..self.count)
    }
}
