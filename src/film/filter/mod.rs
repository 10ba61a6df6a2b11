//! Pixel filters by importance sampling: a sample's place on the film is the pixel's centre plus an offset whose density is the
//! filter, so that every sample weighs 1 and the mean is the filtered image without bias (Ernst, Stamminger and Greiner 2006,
//! "Filter importance sampling"). Filters are separable, never negative, and 0 beyond their radius; a place may lie outside its pixel.
//!
//! A filter is one file here with its density and the mass of its tail in f64, and one line in `filter_list!`. The device needs no
//! text of its own for it: it reads the inverse distribution from a table (`rows`), which a box of one pixel does not need either.
//! GLSL twin: shaders/film/filter.glsl (gate 3: `conform::film`); images: gate 7 (`conform::film`). Keys: docs/scene.md, [film].

pub mod blackman_harris;
pub mod boxed;
pub mod gaussian;

/// A filter over t = offset / radius in [-1, 1]; an even function.
pub struct Shape {
    pub doc: &'static str,
    /// Radius in pixels when none is given.
    pub radius: f64,
    /// Integrates to 1 over [-1, 1].
    pub density: fn(f64) -> f64,
    /// Integral of the density from t to 1, for t in [0, 1].
    pub tail: fn(f64) -> f64,
}

macro_rules! filter_list {
    ($($stem:ident $variant:ident $keyword:literal),* $(,)?) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
        pub enum FilterKind { $(#[value(name = $keyword)] #[serde(rename = $keyword)] $variant),* }

        impl FilterKind {
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];
            pub fn keyword(self) -> &'static str {
                match self { $(Self::$variant => $keyword),* }
            }
            pub fn shape(self) -> &'static Shape {
                match self { $(Self::$variant => &$stem::SHAPE),* }
            }
        }
    };
}

filter_list! {
    boxed Box "box",
    gaussian Gaussian "gaussian",
    blackman_harris BlackmanHarris "blackman-harris",
}

/// Largest radius, pixels: beyond it a picture is blurred, and that is not a filter's work.
pub const MAX_RADIUS: f64 = 32.0;

/// A filter and its radius in pixels.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PixelFilter {
    pub kind: FilterKind,
    pub radius: f64,
}

impl PixelFilter {
    /// The pixel's own square.
    pub const BOX: Self = Self { kind: FilterKind::Box, radius: 0.5 };

    /// `radius` in pixels, else the kind's own. The error says what is wrong with the radius.
    pub fn new(kind: FilterKind, radius: Option<f64>) -> Result<Self, String> {
        let radius = radius.unwrap_or(kind.shape().radius);
        if radius > 0.0 && radius <= MAX_RADIUS {
            return Ok(Self { kind, radius });
        }
        Err(format!("must be above 0 and at most {MAX_RADIUS} pixels"))
    }

    /// Density of one coordinate of the offset, 1/pixel.
    pub fn density(&self, offset: f64) -> f64 {
        let t = offset / self.radius;
        if t.abs() <= 1.0 { (self.kind.shape().density)(t) / self.radius } else { 0.0 }
    }

    /// Probability that an offset is below `offset`, pixels.
    pub fn distribution(&self, offset: f64) -> f64 {
        let tail = (self.kind.shape().tail)((offset / self.radius).abs().min(1.0));
        if offset < 0.0 { tail } else { 1.0 - tail }
    }

    /// Offset from the pixel's centre, in pixels, below which the share `u` of all offsets lies; u in [0, 1].
    pub fn offset(&self, u: f64) -> f64 {
        let magnitude = self.radius * inverse_tail(self.kind.shape(), u.min(1.0 - u));
        if u < 0.5 { -magnitude } else { magnitude }
    }

    /// Cells of the inverse distribution for the device; empty for the box of one pixel, which is u - 0.5.
    pub fn rows(&self) -> Vec<[u32; 4]> {
        if *self == Self::BOX { Vec::new() } else { self.cells() }
    }

    /// The same for any filter: a kernel with everything in it reads the box from a table too.
    pub fn cells(&self) -> Vec<[u32; 4]> {
        (0..CELL_COUNT).map(|cell| self.cell(cell)).collect()
    }

    /// The offset's size over a cell of tail masses [w0, w0 + h): a cubic in the place t within the cell that has the true values
    /// and slopes at both ends (dx/dw = -1/density). Powers of t upwards.
    fn cell(&self, cell: u32) -> [u32; 4] {
        let shape = self.kind.shape();
        let start = |cell: u32| f64::from(f32::from_bits((FIRST_CELL + cell) << CELL_SHIFT));
        let (w0, w1) = (start(cell), start(cell + 1));
        let [x0, x1] = [w0, w1].map(|w| inverse_tail(shape, w));
        let [d0, d1] = [x0, x1].map(|x| -(w1 - w0) / (shape.density)(x));
        let rise = x1 - x0;
        let cubic = [x0, d0, 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise];
        cubic.map(|c| ((self.radius * c) as f32).to_bits())
    }
}

/// Place t in [0, 1] whose tail holds `mass` in [0, 0.5]: Newton's method, kept inside a bracket.
fn inverse_tail(shape: &Shape, mass: f64) -> f64 {
    let (mut low, mut high, mut t) = (0.0f64, 1.0f64, 0.5f64);
    for _ in 0..100 {
        let excess = (shape.tail)(t) - mass;
        if excess > 0.0 {
            low = t
        } else {
            high = t
        }
        let next = t + excess / (shape.density)(t);
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - t).abs() <= 1e-15 || high - low <= 1e-15 {
            return next;
        }
        t = next;
    }
    t
}

/// Cells are the f32 numbers w in [2^-25, 0.5) that share their exponent and 4 bits of mantissa: 16 cells an octave, so that a cubic
/// is right to 1e-6 of w however thin the tail. Below 2^-25 no 24-bit number leads but 0, which the first cell takes.
pub const CELL_SHIFT: u32 = 19;
/// Bits of 2^-25, shifted.
pub const FIRST_CELL: u32 = (102 << 23) >> CELL_SHIFT;
pub const CELL_COUNT: u32 = ((126 << 23) >> CELL_SHIFT) - FIRST_CELL;

/// The device's reading of `rows` in f64: offset for u in [0, 1). Replay calls it.
pub fn offset_from_rows(rows: &[[u32; 4]], u: f64) -> f64 {
    if rows.is_empty() {
        return u - 0.5;
    }
    let w = u.min(1.0 - u).clamp((-25f64).exp2(), 0.5 - (-25f64).exp2()) as f32;
    let bits = w.to_bits();
    let cubic = rows[((bits >> CELL_SHIFT) - FIRST_CELL) as usize].map(|c| f64::from(f32::from_bits(c)));
    let t = f64::from(bits & ((1 << CELL_SHIFT) - 1)) / f64::from(1u32 << CELL_SHIFT);
    let magnitude = cubic.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if u < 0.5 { -magnitude } else { magnitude }
}

/// Constants for GLSL.
pub fn glsl() -> String {
    format!("const uint FILTER_CELL_SHIFT = {CELL_SHIFT}u;\nconst uint FILTER_FIRST_CELL = {FIRST_CELL}u;\n")
}

#[cfg(test)]
mod tests;
