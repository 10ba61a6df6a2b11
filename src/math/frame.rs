//! Orthonormal frames: shading space has z = normal. GLSL: shaders/core/frame.glsl.

use glam::DVec3;

/// Right-handed: t x b = n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub t: DVec3,
    pub b: DVec3,
    pub n: DVec3,
}

impl Frame {
    /// About the unit `n`, without a singularity: Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1).
    /// The sign of a zero n.z counts, as it does in GLSL.
    pub fn from_normal(n: DVec3) -> Self {
        let s = 1f64.copysign(n.z);
        let a = -1.0 / (s + n.z);
        let b = n.x * n.y * a;
        Self { t: DVec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x), b: DVec3::new(b, s + n.y * n.y * a, -n.y), n }
    }

    /// About the unit `n`, x axis along the part of `tangent` perpendicular to it (Gram-Schmidt). Where the tangent is 0, not
    /// finite or along `n` (sine below 1e-4), the frame of the normal alone.
    pub fn from_tangent(n: DVec3, tangent: DVec3) -> Self {
        let largest = tangent.abs().max_element();
        // The limit is GLSL's: sums and squares of f32 stay finite below it.
        if !(tangent.is_finite() && largest > 0.0 && largest < 1e38) {
            return Self::from_normal(n);
        }
        let v = tangent / largest;
        let t = v - n * n.dot(v);
        let t = t - n * n.dot(t);
        if t.length_squared() <= 1e-8 * v.length_squared() {
            return Self::from_normal(n);
        }
        let t = t.normalize();
        Self { t, b: n.cross(t), n }
    }

    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.t), v.dot(self.b), v.dot(self.n))
    }

    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.t * v.x + self.b * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp;

    fn assert_orthonormal(f: &Frame) {
        let lengths = [f.t.length(), f.b.length(), f.n.length()];
        let dots = [f.t.dot(f.b), f.b.dot(f.n), f.n.dot(f.t)];
        assert!(lengths.iter().all(|l| (l - 1.0).abs() < 1e-12), "{f:?}");
        assert!(dots.iter().all(|d| d.abs() < 1e-12), "{f:?}");
        assert!((f.t.cross(f.b) - f.n).length() < 1e-12, "{f:?}");
    }

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        let grid = (0..32).flat_map(|i| (0..32).map(move |j| [f64::from(i) / 31.0, f64::from(j) / 31.0]));
        let poles = [DVec3::Z, -DVec3::Z, DVec3::new(0.0, 1e-9, -1.0).normalize(), DVec3::X, -DVec3::Y];
        for n in grid.map(warp::uniform_sphere).chain(poles) {
            assert_orthonormal(&Frame::from_normal(n));
            for tangent in [DVec3::X, DVec3::new(3.0, -2.0, 0.1), n * 2.0, DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
                assert_orthonormal(&Frame::from_tangent(n, tangent));
            }
        }
    }

    #[test]
    fn local_and_world_are_inverse() {
        let f = Frame::from_tangent(DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
        let v = DVec3::new(-0.3, 0.7, 0.2);
        assert!((f.to_world(f.to_local(v)) - v).length() < 1e-14);
        assert!((f.to_world(DVec3::Z) - f.n).length() < 1e-14);
        assert!(f.to_local(DVec3::new(1.0, 2.0, 3.0)).x > 0.0);
    }
}
