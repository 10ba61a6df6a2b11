//! Radiance HDR: header and pixels of four bytes, mantissas of 8 bits under a shared exponent (Ward 1991, "Real pixels").
//!
//! A mantissa is rounded to the nearest, so that a picture is as bright as it was: cutting off, as Ward's own routine does for a
//! reader that adds half a step, darkens what other readers see by 0.2 % and more. Rows are not run-length encoded, which the
//! format allows: a normalised pixel is never taken for a run's mark.

use std::io::Write;

/// Header of a picture with row 0 on top.
pub fn header(width: u32, height: u32) -> String {
    format!("#?RADIANCE\nSOFTWARE=steradian\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n")
}

/// Writes pixels in order.
pub fn write_pixels(out: &mut impl Write, pixels: &[[f32; 3]]) -> std::io::Result<()> {
    let bytes: Vec<u8> = pixels.iter().flat_map(|&p| rgbe(p)).collect();
    out.write_all(&bytes)
}

/// Negative values and NaN become 0; what lies beyond 2^127 becomes the largest pixel, what lies below 2^-128 becomes 0.
pub fn rgbe(color: [f32; 3]) -> [u8; 4] {
    let color = color.map(|v| if v > 0.0 { f64::from(v).min(255.0 / 256.0 * 127f64.exp2()) } else { 0.0 });
    let largest = color[0].max(color[1]).max(color[2]);
    if largest < (-128f64).exp2() {
        return [0; 4];
    }
    // The exponent e for which the largest is in [2^(e-1), 2^e), from the bits: a logarithm may be off by one at powers of two.
    let mut exponent = ((largest.to_bits() >> 52) as i32) - 1022;
    if (largest * f64::from(8 - exponent).exp2()).round() >= 256.0 {
        exponent += 1;
    }
    let step = f64::from(8 - exponent).exp2();
    let [r, g, b] = color.map(|v| (v * step).round() as u8);
    [r, g, b, (exponent + 128).clamp(1, 255) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decoded here, from the format's definition: m 2^(e - 136).
    #[test]
    fn pixels_come_back_to_half_a_step_without_bias() {
        let (mut bias, mut count) = (0.0, 0.0);
        for i in 0..40_000u32 {
            let scale = (f64::from(i % 200) - 100.0).exp2();
            let value = |k: u32| scale * f64::from(i.wrapping_mul(k) % 10_007) / 10_007.0;
            let color = [value(7919), value(104_729), value(1_299_709)].map(|v| v as f32);
            let [r, g, b, e] = rgbe(color);
            let step = (f64::from(e) - 136.0).exp2();
            for (m, v) in [r, g, b].into_iter().zip(color) {
                let back = f64::from(m) * step;
                assert!((back - f64::from(v)).abs() <= 0.5 * step, "{color:?}: {back}");
                bias += (back - f64::from(v)) / step;
                count += 1.0;
            }
            assert!(color == [0.0; 3] || r.max(g).max(b) >= 128, "{color:?} is normalised: {r} {g} {b}");
        }
        // Uniform in +-1/2: 6 standard errors.
        assert!((bias / count).abs() < 6.0 * (1f64 / 12.0).sqrt() / f64::sqrt(count), "{}", bias / count);
    }

    #[test]
    fn extremes_are_pixels() {
        assert_eq!(rgbe([1.0, 0.5, 0.25]), [128, 64, 32, 129]);
        assert_eq!(rgbe([0.999_999, 0.0, 0.0]), [128, 0, 0, 129], "rounds up into the next exponent");
        assert_eq!(rgbe([f32::NAN, -1.0, 0.0]), [0; 4]);
        assert_eq!(rgbe([f32::INFINITY, 1.0, 0.0]), [255, 0, 0, 255]);
        assert_eq!(rgbe([f32::MAX, 0.0, 0.0]), [255, 0, 0, 255]);
        assert_eq!(rgbe([1e-45, 0.0, 0.0]), [0; 4]);
    }
}
