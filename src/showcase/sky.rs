//! The evening sky: a gradient, a hazy sun with its glow, thin clouds, hills on the horizon. 512 x 256, .hdr.
//!
//! The sun is wide and dim (16 degrees across, 35 W/(m2 sr) in red) as behind haze: a path tracer finds the light it throws through
//! glass by chance only, and a sun of true size would need a thousand times the samples.

use glam::DVec3;
use image::codecs::hdr::HdrEncoder;

use super::pattern::fractal;

const SIZE: (usize, usize) = (512, 256);
/// From -z towards +x, and above the horizon.
const SUN_AZIMUTH_DEG: f64 = -68.0;
const SUN_ELEVATION_DEG: f64 = 23.0;
const SUN_RADIUS_DEG: f64 = 8.0;
const SUN_RADIANCE: [f64; 3] = [35.0, 25.0, 13.8];

/// The bytes of the .hdr file.
pub fn picture() -> Vec<u8> {
    let pixels: Vec<image::Rgb<f32>> = (0..SIZE.0 * SIZE.1)
        .map(|i| {
            let u = ((i % SIZE.0) as f64 + 0.5) / SIZE.0 as f64;
            let v = ((i / SIZE.0) as f64 + 0.5) / SIZE.1 as f64;
            image::Rgb(radiance(u, v).map(|x| x as f32))
        })
        .collect();
    let mut out = Vec::new();
    HdrEncoder::new(&mut out).encode(&pixels, SIZE.0, SIZE.1).expect("memory takes every picture");
    out
}

fn direction(azimuth_rad: f64, elevation_rad: f64) -> DVec3 {
    let flat = elevation_rad.cos();
    DVec3::new(flat * azimuth_rad.sin(), elevation_rad.sin(), -flat * azimuth_rad.cos())
}

/// Radiance at (u, v) of the lat-long image, W/(m2 sr).
fn radiance(u: f64, v: f64) -> [f64; 3] {
    let azimuth = (u - 0.5) * std::f64::consts::TAU;
    let elevation = (0.5 - v) * std::f64::consts::PI;
    let sun = direction(SUN_AZIMUTH_DEG.to_radians(), SUN_ELEVATION_DEG.to_radians());
    let to_sun = direction(azimuth, elevation).dot(sun).clamp(-1.0, 1.0).acos().to_degrees();
    let warmth = (0.5 + 0.5 * (to_sun.to_radians()).cos()).powi(2);

    // From the horizon's warm haze to the blue above, and the ground's reflection below.
    let height = elevation.sin();
    let horizon = mix([0.78, 0.62, 0.62], [1.55, 0.98, 0.58], warmth);
    let zenith = [0.16, 0.27, 0.52];
    let mut sky = mix(horizon, zenith, 1.0 - (-4.2 * height.max(0.0)).exp());
    let cloud = (fractal(u, 6.0 * v, 6, 60) + 0.5 - 0.42).max(0.0) * smooth(0.06, 0.3, height) * 1.6;
    sky = mix(sky, mix([0.80, 0.72, 0.76], [2.1, 1.45, 0.98], warmth), cloud.min(0.75));
    let glow = 3.2 * (-to_sun / 7.0).exp() + 0.55 * (-to_sun / 26.0).exp();
    let disc = smooth(SUN_RADIUS_DEG + 0.8, SUN_RADIUS_DEG - 0.8, to_sun);
    for (c, value) in sky.iter_mut().enumerate() {
        *value += glow * [1.0, 0.62, 0.30][c] + disc * SUN_RADIANCE[c];
    }

    // Two ranges of hills and the plain before them.
    let ridge = |scale: f64, base: f64, salt: u64| (base + scale * (fractal(u, 0.0, 9, salt) + 0.5)).to_radians();
    let texel = std::f64::consts::PI / SIZE.1 as f64;
    let behind = |ridge: f64| smooth(ridge + 0.6 * texel, ridge - 0.6 * texel, elevation);
    sky = mix(sky, mix(horizon, [0.34, 0.40, 0.52], 0.62), behind(ridge(6.5, 0.6, 70)));
    sky = mix(sky, mix(horizon, [0.20, 0.27, 0.30], 0.80), behind(ridge(4.0, -0.4, 80)));
    mix(sky, [0.30, 0.25, 0.21], smooth(0.0, -0.12, height))
}

fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
}

/// 0 at `from`, 1 at `to`, either way round.
fn smooth(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
