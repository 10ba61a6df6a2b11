//! The triangles, spheres and discs of a surface meter: a table of its own, from the shapes' world geometry, with an alias table by area.
//!
//! A mirrored instance turns its winding, as in `prepare::geometry`, so that side +1 is the front of every shape.

use std::f64::consts::PI;

use glam::DVec3;

use crate::light::alias::AliasTable;
use crate::prepare::records::{AliasRecord, HIT_DISC, HIT_SPHERE, HIT_TRIANGLE, SensorElementRecord};
use crate::scene::{Projection, Scene, Shape, SurfaceMeter};

/// Tables of a meter; empty for everything that has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Elements {
    pub records: Vec<SensorElementRecord>,
    pub alias: Vec<AliasRecord>,
}

/// One element in the world.
enum Element {
    Triangle([DVec3; 3]),
    Sphere {
        center: DVec3,
        radius: f64,
    },
    /// Two radii at a right angle; `x` cross `y` points to the front.
    Disc {
        center: DVec3,
        x: DVec3,
        y: DVec3,
    },
}

impl Element {
    fn area(&self) -> f64 {
        match self {
            Self::Triangle([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
            Self::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Self::Disc { x, y, .. } => PI * x.cross(*y).length(),
        }
    }
}

/// Area of the shapes together, m2, one side.
pub fn surface_area(scene: &Scene, shapes: &[usize]) -> f64 {
    let mut area = 0.0;
    visit(scene, shapes, |element| area += element.area());
    area
}

/// A point a little above the measured side: what surrounds it surrounds the meter. The origin where there is no area.
pub fn surface_anchor(scene: &Scene, meter: &SurfaceMeter) -> DVec3 {
    // A thousandth of the extent: outside the surface in f32, and inside what a meter may stand in.
    const LIFT: f64 = 1e-3;
    let mut anchor = None;
    visit(scene, &meter.shapes, |element| {
        let size = element.area().sqrt();
        if anchor.is_some() || !(size > 0.0 && size.is_finite()) {
            return;
        }
        let (point, front) = match element {
            Element::Triangle([a, b, c]) => ((a + b + c) / 3.0, (b - a).cross(c - a).normalize()),
            Element::Sphere { center, radius } => (center + radius * DVec3::Y, DVec3::Y),
            Element::Disc { center, x, y } => (center, x.cross(y).normalize()),
        };
        anchor = Some(point + front * if meter.is_back { -LIFT * size } else { LIFT * size });
    });
    anchor.unwrap_or(DVec3::ZERO)
}

/// The tables of the scene's camera; the error is a sentence.
pub fn elements(scene: &Scene) -> Result<Elements, String> {
    let (Projection::MeterSurface(meter) | Projection::MeterLeaving(meter)) = &scene.camera.projection else {
        return Ok(Elements::default());
    };
    let SurfaceMeter { shapes, is_back } = meter;
    let origin = scene.camera.to_world.translation;
    let (mut records, mut areas) = (Vec::new(), Vec::new());
    visit(scene, shapes, |element| {
        let area = element.area();
        // What has no area is never chosen; what is not finite has no place.
        if area > 0.0 && area.is_finite() {
            areas.push(area);
            records.push(record(&element, origin, *is_back));
        }
    });
    let Some(table) = AliasTable::new(&areas) else {
        return Err("the surface of the meter has no area; name a shape that has one".into());
    };
    let total: f64 = areas.iter().sum();
    for ((record, area), probability) in records.iter_mut().zip(&areas).zip(&table.pmf) {
        record.weight = (area / total / probability) as f32;
    }
    Ok(Elements { alias: table.records(), records })
}

fn record(element: &Element, origin: DVec3, is_back: bool) -> SensorElementRecord {
    let vec = |v: DVec3| v.as_vec3().to_array();
    let side = if is_back { -1.0 } else { 1.0 };
    match element {
        Element::Triangle(corners) => {
            let [a, b, c] = corners.map(|v| vec(v - origin));
            SensorElementRecord { a, kind: HIT_TRIANGLE, b, weight: 1.0, c, side }
        }
        Element::Sphere { center, radius } => {
            let b = [*radius as f32, 0.0, 0.0];
            SensorElementRecord { a: vec(*center - origin), kind: HIT_SPHERE, b, weight: 1.0, c: [0.0; 3], side }
        }
        Element::Disc { center, x, y } => {
            let a = vec(*center - origin);
            SensorElementRecord { a, kind: HIT_DISC, b: vec(*x), weight: 1.0, c: vec(*y), side }
        }
    }
}

fn visit(scene: &Scene, shapes: &[usize], mut take: impl FnMut(Element)) {
    for instance in shapes.iter().filter_map(|&i| scene.instances.get(i)) {
        let m = instance.to_world;
        let is_mirrored = m.matrix3.determinant() < 0.0;
        let mut triangle = |[a, b, c]: [DVec3; 3]| {
            let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
            take(Element::Triangle(corners.map(|p| m.transform_point3(p))));
        };
        match instance.shape {
            Shape::Mesh(mesh) => {
                let mesh = &scene.meshes[mesh];
                for t in &mesh.triangles {
                    triangle(t.map(|i| mesh.positions[i as usize].map(f64::from).into()));
                }
            }
            Shape::Rectangle => {
                let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
                let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                triangle([a, b, c]);
                triangle([a, c, d]);
            }
            Shape::Disc => {
                let (x, y) = (m.matrix3.x_axis, m.matrix3.y_axis);
                take(Element::Disc { center: m.translation, x, y: if is_mirrored { -y } else { y } });
            }
            Shape::Sphere => take(Element::Sphere { center: m.translation, radius: m.matrix3.x_axis.length() }),
        }
    }
}
