//! Procedural textures that repeat: tiles, wood, hammer marks, painted bands. 8 bits a channel.

use image::ImageEncoder;

/// RGB bytes, row 0 on top.
pub struct Bitmap {
    size: u32,
    bytes: Vec<u8>,
}

impl Bitmap {
    /// `size` x `size`; `color` gets the texel's centre in [0,1)^2 (v down) and returns encoded channels in [0, 1].
    fn new(size: u32, color: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        let mut bytes = Vec::with_capacity(3 * (size * size) as usize);
        for y in 0..size {
            for x in 0..size {
                let place = |k: u32| (k as f64 + 0.5) / size as f64;
                bytes.extend(color(place(x), place(y)).map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8));
            }
        }
        Self { size, bytes }
    }

    /// Tangent-space normals of a repeating height field; heights and sides in the same unit.
    fn normals_of(size: u32, height: impl Fn(f64, f64) -> f64) -> Self {
        let step = 1.0 / size as f64;
        Self::new(size, |u, v| {
            let slope_u = (height(u + step, v) - height(u - step, v)) / (2.0 * step);
            // v runs down, the normal's y runs up.
            let slope_v = (height(u, v - step) - height(u, v + step)) / (2.0 * step);
            let length = (slope_u * slope_u + slope_v * slope_v + 1.0).sqrt();
            [-slope_u / length, -slope_v / length, 1.0 / length].map(|n| 0.5 + 0.5 * n)
        })
    }

    pub fn png(&self) -> Vec<u8> {
        use image::codecs::png::{CompressionType, FilterType, PngEncoder};
        let mut out = Vec::new();
        let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive);
        encoder
            .write_image(&self.bytes, self.size, self.size, image::ExtendedColorType::Rgb8)
            .expect("memory takes every picture");
        out
    }
}

/// Two light and two dark stone tiles with veins, and the grout between them.
pub fn tiles() -> Bitmap {
    Bitmap::new(512, |u, v| {
        let is_dark = (u < 0.5) != (v < 0.5);
        let (x, y) = (u + 0.06 * fractal(u, v, 3, 4), v + 0.06 * fractal(u, v, 3, 9));
        let vein = (1.0 - (2.0 * fractal(x, y, 4, if is_dark { 21 } else { 33 })).abs() * 3.0).max(0.0).powi(3);
        let cloud = fractal(u, v, 2, if is_dark { 5 } else { 7 });
        let stone = if is_dark {
            mix([0.20, 0.27, 0.31], [0.40, 0.47, 0.48], 0.35 * vein + 0.25 + 0.5 * cloud)
        } else {
            mix([0.86, 0.82, 0.75], [0.70, 0.63, 0.56], 0.4 * vein + 0.2 + 0.5 * cloud)
        };
        mix([0.46, 0.43, 0.40], stone, on_tile(u, v))
    })
}

/// Roughness in green, metallic (none) in blue: polished tiles, rough grout.
pub fn tile_roughness() -> Bitmap {
    Bitmap::new(256, |u, v| [0.0, 0.9 + (0.22 - 0.9) * on_tile(u, v), 0.0])
}

/// Rounded edges of the tiles.
pub fn tile_normals() -> Bitmap {
    Bitmap::normals_of(256, |u, v| 0.004 * on_tile(u, v))
}

/// 0 on the grout, 1 on a tile; four tiles in the unit square.
fn on_tile(u: f64, v: f64) -> f64 {
    let to_edge = |x: f64| {
        let place = (2.0 * x).rem_euclid(1.0);
        place.min(1.0 - place)
    };
    smooth_step(0.012, 0.03, to_edge(u).min(to_edge(v)))
}

/// Growth rings about a heart beside the board, with fibres.
pub fn wood() -> Bitmap {
    Bitmap::new(512, |u, v| {
        let (x, y) = (u - 0.18, 1.25 * (v + 0.32));
        let radius = (x * x + y * y).sqrt() + 0.035 * fractal(u, v, 2, 40) + 0.004 * fractal(u, v, 8, 41);
        let ring = (19.0 * radius).rem_euclid(1.0);
        // Late wood darkens slowly and ends sharply.
        let late = smooth_step(0.15, 0.88, ring) * (1.0 - smooth_step(0.9, 1.0, ring));
        let fibre = 0.12 * fractal(3.0 * u, 0.25 * v, 12, 42) + 0.2 * fractal(u, v, 2, 43);
        mix([0.72, 0.50, 0.31], [0.43, 0.24, 0.13], (0.75 * late + fibre).clamp(0.0, 1.0))
    })
}

/// Shallow dents of a hammer; repeats.
pub fn hammered() -> Bitmap {
    Bitmap::normals_of(256, |u, v| {
        const CELLS: i64 = 7;
        let (x, y) = (u * CELLS as f64, v * CELLS as f64);
        let mut nearest = f64::INFINITY;
        for j in -1..=1 {
            for i in -1..=1 {
                let (cx, cy) = (x.floor() as i64 + i, y.floor() as i64 + j);
                let wrapped = (cx.rem_euclid(CELLS), cy.rem_euclid(CELLS));
                let place = |salt| 0.5 + 0.8 * (hash(wrapped.0, wrapped.1, salt) - 0.5);
                let (dx, dy) = (cx as f64 + place(50) - x, cy as f64 + place(51) - y);
                nearest = nearest.min(dx * dx + dy * dy);
            }
        }
        0.022 * nearest.min(1.0)
    })
}

/// Painted bands for the vase: v runs along its profile from the foot.
pub fn bands() -> Bitmap {
    const GLAZE: [f64; 3] = [0.05, 0.36, 0.38];
    const CREAM: [f64; 3] = [0.90, 0.84, 0.70];
    const RUST: [f64; 3] = [0.66, 0.27, 0.12];
    Bitmap::new(256, |u, v| {
        let zigzag = 0.035 * (4.0 * ((8.0 * u).rem_euclid(1.0) - 0.5).abs() - 1.0);
        let inside = |from: f64, to: f64, x: f64| smooth_step(from, from + 0.006, x) * smooth_step(-to, 0.006 - to, -x);
        let mut color = GLAZE;
        for (from, to) in [(0.27, 0.283), (0.445, 0.458), (0.56, 0.585)] {
            color = mix(color, CREAM, inside(from, to, v));
        }
        color = mix(color, CREAM, inside(0.335, 0.385, v + zigzag));
        mix(color, RUST, inside(0.35, 0.37, v + zigzag) + inside(0.567, 0.578, v))
    })
}

fn mix(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    let share = share.clamp(0.0, 1.0);
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
}

fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Repeating value noise of four octaves, about -0.5 to 0.5; `cells` in the unit square at the first.
pub fn fractal(u: f64, v: f64, cells: i64, salt: u64) -> f64 {
    (0..4).map(|octave| value_noise(u, v, cells << octave, salt + 100 * octave) / (1 << octave) as f64).sum::<f64>()
        / 1.3
}

fn value_noise(u: f64, v: f64, cells: i64, salt: u64) -> f64 {
    let (x, y) = (u * cells as f64, v * cells as f64);
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let (s, t) = (smooth_step(0.0, 1.0, x - x.floor()), smooth_step(0.0, 1.0, y - y.floor()));
    let at = |di: i64, dj: i64| hash((i + di).rem_euclid(cells), (j + dj).rem_euclid(cells), salt) - 0.5;
    let row = |dj: i64| at(0, dj) + (at(1, dj) - at(0, dj)) * s;
    row(0) + (row(1) - row(0)) * t
}

/// A number in [0, 1) for a cell (the finaliser of SplitMix64, Steele et al. 2014).
fn hash(i: i64, j: i64, salt: u64) -> f64 {
    let mut h =
        (i as u64).wrapping_mul(0x9e3779b97f4a7c15) ^ (j as u64).wrapping_mul(0xc2b2ae3d27d4eb4f) ^ (salt << 17);
    h = (h ^ (h >> 30)).wrapping_mul(0xbf58476d1ce4e5b9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94d049bb133111eb);
    ((h ^ (h >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
