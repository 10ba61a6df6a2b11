//! The sky of the tests: from `scene::Sky` and `scene::Image` by its own lookup and a plainer way of sampling.
//!
//! Nothing here reads records or shares code with `sky` and `sky_table`: a half-texel shift, a wrong turn or a wrong density
//! there must show as a difference. Rows and columns by cumulative sums, uniform in (u, v) inside a cell, density
//! p W H / (2 pi^2 sin(theta)). (The independent oracle has its own in reference/independent.)

use std::f64::consts::PI;

use glam::DVec3;

use crate::scene;

/// A sky decoded to f64, scale included.
#[derive(Clone, Debug)]
pub struct SceneSky {
    width: usize,
    height: usize,
    texels: Vec<DVec3>,
    rotation_rad: f64,
    /// Ascending to 1: `row_cdf[j]` is the probability of the rows up to and with j.
    row_cdf: Vec<f64>,
    /// The same within each row.
    column_cdf: Vec<f64>,
}

impl SceneSky {
    /// None when the image does not exist or is not as large as it says.
    pub fn new(sky: &scene::Sky, images: &[scene::Image]) -> Option<Self> {
        let (width, height, texels) = match sky.radiance {
            scene::SkyRadiance::Uniform(radiance) => (1, 1, vec![radiance]),
            scene::SkyRadiance::Image(index) => {
                let image = images.get(index)?;
                (image.width as usize, image.height as usize, decode(&image.pixels))
            }
        };
        if texels.is_empty() || texels.len() != width * height {
            return None;
        }
        let usable = |x: f64| if x.is_finite() && x > 0.0 { x } else { 0.0 };
        let clean = |t: &DVec3| usable(sky.scale) * DVec3::new(usable(t.x), usable(t.y), usable(t.z));
        let texels: Vec<DVec3> = texels.iter().map(clean).collect();
        let rotation_rad = if sky.rotation_rad.is_finite() { sky.rotation_rad } else { 0.0 };
        let (row_cdf, column_cdf) = cumulate(&texels, width, height);
        Some(Self { width, height, texels, rotation_rad, row_cdf, column_cdf })
    }

    /// True when no direction has light.
    pub fn is_black(&self) -> bool {
        self.texels.iter().all(|t| *t == DVec3::ZERO)
    }

    /// Radiance from direction `d`, W/(m2 sr).
    pub fn radiance(&self, d: DVec3) -> DVec3 {
        let (x, y) = self.place(d);
        let (w, h) = (self.width as f64, self.height as f64);
        // Four texels whose centres surround (x, y), each by the area of the opposite rectangle.
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let mut sum = DVec3::ZERO;
        for (cx, cy) in [(left, top), (left + 1.0, top), (left, top + 1.0), (left + 1.0, top + 1.0)] {
            let weight = (1.0 - (x - 0.5 - cx).abs()) * (1.0 - (y - 0.5 - cy).abs());
            let column = (cx - w * (cx / w).floor()) as usize % self.width;
            let row = cy.clamp(0.0, h - 1.0) as usize;
            sum += weight * self.texels[row * self.width + column];
        }
        sum
    }

    /// A direction and its density in 1/sr (0: no sample, at a pole or under a black sky).
    pub fn sample(&self, u: [f64; 2]) -> (DVec3, f64) {
        if self.is_black() {
            return (DVec3::Y, 0.0);
        }
        let (row, v) = invert(&self.row_cdf, u[0]);
        let line = &self.column_cdf[row * self.width..(row + 1) * self.width];
        let (column, s) = invert(line, u[1]);
        let theta = PI * (row as f64 + v) / self.height as f64;
        let azimuth = 2.0 * PI * ((column as f64 + s) / self.width as f64 - 0.5) - self.rotation_rad;
        let d = DVec3::new(theta.sin() * azimuth.sin(), theta.cos(), -theta.sin() * azimuth.cos());
        (d, self.cell_density(row, column, theta.sin()))
    }

    fn cell_density(&self, row: usize, column: usize, sin_theta: f64) -> f64 {
        let step = |cdf: &[f64], i: usize| cdf[i] - if i > 0 { cdf[i - 1] } else { 0.0 };
        let line = &self.column_cdf[row * self.width..(row + 1) * self.width];
        let probability = step(&self.row_cdf, row) * step(line, column);
        let area = 2.0 * PI * PI * sin_theta / (self.width * self.height) as f64;
        if area > 0.0 { probability / area } else { 0.0 }
    }

    /// Image coordinates in texels. The sky turned by +a about y is looked up at azimuth + a.
    fn place(&self, d: DVec3) -> (f64, f64) {
        let d = d.normalize();
        let turns = 0.5 + (d.x.atan2(-d.z) + self.rotation_rad) / (2.0 * PI);
        let v = if d.y.abs() < 0.9 { d.y.acos() } else { d.x.hypot(d.z).atan2(d.y) } / PI;
        ((turns - turns.floor()) * self.width as f64, v * self.height as f64)
    }
}

fn decode(pixels: &scene::Pixels) -> Vec<DVec3> {
    let linear = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        if c > 0.04045 { ((c + 0.055) / 1.055).powf(2.4) } else { c / 12.92 }
    };
    match pixels {
        scene::Pixels::RgbF32(data) => {
            data.chunks_exact(3).map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect()
        }
        scene::Pixels::Rgba16(_) => unreachable!("read_sky gives floats"),
        scene::Pixels::Rgba8(data) => {
            data.chunks_exact(4).map(|p| DVec3::new(linear(p[0]), linear(p[1]), linear(p[2]))).collect()
        }
    }
}

/// Cumulative sums of (brightest of the 3x3 texels that a cell's lookup blends) x sin(theta at the cell's middle).
fn cumulate(texels: &[DVec3], width: usize, height: usize) -> (Vec<f64>, Vec<f64>) {
    let mut row_cdf = Vec::with_capacity(height);
    let mut column_cdf = Vec::with_capacity(width * height);
    let mut total = 0.0;
    for j in 0..height {
        let sin_theta = (PI * (j as f64 + 0.5) / height as f64).sin();
        let mut sum = 0.0;
        for i in 0..width {
            let mut weight = 0.0f64;
            for row in [j.saturating_sub(1), j, (j + 1).min(height - 1)] {
                for column in [(i + width - 1) % width, i, (i + 1) % width] {
                    weight = weight.max(texels[row * width + column].element_sum());
                }
            }
            sum += weight * sin_theta;
            column_cdf.push(sum);
        }
        if sum > 0.0 {
            column_cdf[j * width..].iter_mut().for_each(|c| *c /= sum);
        }
        total += sum;
        row_cdf.push(total);
    }
    if total > 0.0 {
        row_cdf.iter_mut().for_each(|c| *c /= total);
    }
    (row_cdf, column_cdf)
}

/// First entry above `u`, and where in its step `u` lies.
fn invert(cdf: &[f64], u: f64) -> (usize, f64) {
    let i = cdf.partition_point(|&c| c <= u).min(cdf.len() - 1);
    let below = if i > 0 { cdf[i - 1] } else { 0.0 };
    let step = cdf[i] - below;
    (i, if step > 0.0 { ((u - below) / step).clamp(0.0, 1.0 - f64::EPSILON) } else { 0.5 })
}
