//! A point of a surface as both worlds describe it, and the rules that turn it into a shading frame.
//!
//! The geometric normal follows the winding (front is counter-clockwise). An interpolated normal is turned to its side; a
//! normal map tilts it in the vertex's tangent frame; a surface that does not transmit is turned towards the viewer. Where
//! the viewer is on different sides of the two normals, the geometric one shades.

use glam::{DVec2, DVec3};

use crate::bsdf::mixture::Mixture;

/// What a world knows of a hit, before the viewer's side is considered.
#[derive(Clone, Debug)]
pub struct Surface {
    pub point: DVec3,
    /// Unit, on the front side.
    pub geometric_normal: DVec3,
    /// Unit, interpolated; the geometric one where the vertices have none.
    pub normal: DVec3,
    /// World-space tangent (any length, not yet orthogonal) and handedness of the bitangent.
    pub tangent: Option<(DVec3, f64)>,
    /// Normal in the tangent frame, scaled and not yet unit.
    pub normal_map: Option<DVec3>,
    pub params: Mixture,
    /// First set of texture coordinates.
    pub uv: DVec2,
    /// Numbers in the scene's lists of instances and materials.
    pub object: u32,
    pub material: u32,
    pub transmits: bool,
    /// Radiance towards the origin of the ray that hit.
    pub emission: DVec3,
    /// Light group of that.
    pub group: u32,
    /// For a surface that parts two media: the medium behind it, or Some(NONE). None where light goes through without a
    /// change of medium (thin walls) or not at all.
    pub boundary: Option<u32>,
}

/// Orthonormal; z is the shading normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub x: DVec3,
    pub y: DVec3,
    pub z: DVec3,
}

impl Frame {
    /// Duff et al. 2017, "Building an orthonormal basis, revisited", listing 3.
    pub fn around(z: DVec3) -> Self {
        let sign = 1f64.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: DVec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: DVec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// x along the part of `tangent` that is orthogonal to z; `around(z)` where there is none.
    pub fn along(z: DVec3, tangent: DVec3) -> Self {
        // What is left of a tangent that is nearly the normal is rounding: 1e-6 of its length leaves ten digits.
        let across = tangent - tangent.dot(z) * z;
        if across.length_squared() <= 1e-12 * tangent.length_squared() {
            return Self::around(z);
        }
        let x = across.normalize();
        Self { x, y: z.cross(x), z }
    }

    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    pub fn to_world(&self, v: DVec3) -> DVec3 {
        (v.x * self.x + v.y * self.y + v.z * self.z).normalize()
    }
}

/// Frame to shade in, seen from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Shading {
    pub frame: Frame,
    /// Towards the viewer unless the surface transmits; then the front side.
    pub geometric_normal: DVec3,
    /// The two normals disagreed about the viewer's side.
    pub disagrees: bool,
}

impl Surface {
    /// The bitangent of the front, handedness included, may oppose the y axis of the frame that `wo` is shaded in: directions of
    /// anisotropy follow it.
    pub fn orient(&mut self, wo: DVec3) {
        let is_back = !self.transmits && wo.dot(self.geometric_normal) < 0.0;
        if self.tangent.is_some_and(|t| t.1 < 0.0) != is_back {
            self.params.mirror();
        }
    }

    /// `wo`: world direction to the viewer.
    pub fn shading(&self, wo: DVec3) -> Shading {
        let mut ng = self.geometric_normal;
        let mut ns = if self.normal.dot(ng) < 0.0 { -self.normal } else { self.normal };
        if let (Some(map), Some((tangent, handedness))) = (self.normal_map, self.tangent) {
            let frame = Frame::along(ns, tangent);
            let bitangent = handedness * ns.cross(frame.x);
            ns = (map.x * frame.x + map.y * bitangent + map.z * ns).try_normalize().unwrap_or(ns);
        }
        if !self.transmits && wo.dot(ng) < 0.0 {
            (ng, ns) = (-ng, -ns);
        }
        let disagrees = (wo.dot(ns) < 0.0) != (wo.dot(ng) < 0.0);
        let z = if disagrees { ng } else { ns };
        let frame = self.tangent.map_or_else(|| Frame::around(z), |t| Frame::along(z, t.0));
        Shading { frame, geometric_normal: ng, disagrees }
    }
}

impl Shading {
    /// Shading and geometric normal see `wi` (world) on the same side; `local` is the same direction in the frame.
    pub fn sides_agree(&self, wi: DVec3, local: DVec3) -> bool {
        (wi.dot(self.geometric_normal) < 0.0) == (local.z < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        for z in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.3, -0.5, -0.8).normalize()] {
            for f in [Frame::around(z), Frame::along(z, DVec3::new(1.0, 2.0, 3.0)), Frame::along(z, z)] {
                assert!((f.x.cross(f.y) - f.z).length() < 1e-14, "{f:?}");
                assert!(f.x.dot(f.y).abs() < 1e-14 && f.x.is_normalized(), "{f:?}");
                let v = DVec3::new(0.1, 0.2, 0.3).normalize();
                assert!((f.to_world(f.to_local(v)) - v).length() < 1e-14);
            }
        }
    }
}
