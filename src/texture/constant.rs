//! The same RGBA everywhere (`type = "constant"`). GLSL: shaders/texture/constant.glsl.

use glam::DVec4;

pub fn eval(value: DVec4) -> DVec4 {
    value
}
