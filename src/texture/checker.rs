//! Checkerboard (`type = "checker"`): `scale` squares a unit of u and of v, `a` where floor(u s) + floor(v s) is even.
//! GLSL: shaders/texture/checker.glsl.

use glam::{DVec2, DVec4};

/// NaN and infinity give `a`.
pub fn eval(a: DVec4, b: DVec4, scale: DVec2, uv: DVec2) -> DVec4 {
    let square = (uv * scale).floor();
    let is_odd = square.x.rem_euclid(2.0) + square.y.rem_euclid(2.0) == 1.0;
    if is_odd { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_alternate_through_zero() {
        let at = |u, v| eval(DVec4::ZERO, DVec4::ONE, DVec2::new(2.0, 4.0), DVec2::new(u, v)).x;
        assert_eq!(
            [at(0.1, 0.1), at(0.6, 0.1), at(-0.1, 0.1), at(-0.1, -0.1), at(0.1, 0.3)],
            [0.0, 1.0, 1.0, 0.0, 1.0]
        );
        assert_eq!([at(f64::NAN, 0.3), at(f64::INFINITY, 0.0)], [0.0, 0.0]);
    }
}
