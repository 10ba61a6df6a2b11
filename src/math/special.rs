//! Small f64 functions that std lacks; the twins of shaders/core/exp.glsl that are not std's own.

use glam::DVec3;

/// Y of linear Rec.709 (ITU-R BT.709, item 3.2).
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// a b - c d to about one rounding (Kahan; Jeannerod, Louvet and Muller 2013, algorithm 1).
pub fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let w = c * d;
    let e = c.mul_add(-d, w);
    a.mul_add(b, -w) + e
}

/// sRGB's electro-optical transfer function (IEC 61966-2-1), from code value in [0,1] to linear.
pub fn srgb_decode(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Its inverse, from linear to code value.
pub fn srgb_encode(v: f64) -> f64 {
    if v <= 0.04045 / 12.92 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_of_products_survives_cancellation() {
        // (1+e)(1-e) - 1*1 = -e^2, which is lost when the product is rounded.
        let e = 2f64.powi(-30);
        assert_eq!(difference_of_products(1.0 + e, 1.0 - e, 1.0, 1.0), -e * e);
    }

    #[test]
    fn srgb_goes_there_and_back() {
        for i in 0..=255 {
            let v = f64::from(i) / 255.0;
            assert!((srgb_encode(srgb_decode(v)) - v).abs() < 1e-12, "{i}");
        }
        // IEC 61966-2-1: code 188 is nearly half the light.
        assert!((srgb_decode(188.0 / 255.0) - 0.502_886_458).abs() < 1e-9);
    }
}
