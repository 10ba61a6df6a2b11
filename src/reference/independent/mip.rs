//! Levels of detail and footprints of the independent mode: its own pyramids over the stored pixels, in f64 and unrounded.
//!
//! The definition is that of src/texture/mip.rs: each texel of a level is the mean, in linear light, of what it covers of the level
//! above; weighed by alpha where alpha says what is there. Here a level is made axis by axis.

use glam::DVec2;

use super::value::{bilinear, texel, wrapped};
use super::{Independent, Point};
use crate::reference::tree::{Hit, Ray, Shape};
use crate::scene::{Alpha, Filter, Minify, Scene, Texture, TextureFilter, Value, Wrap};

/// One level, row by row, each texel linear RGBA.
#[derive(Clone, Debug)]
pub(super) struct Level {
    width: u32,
    height: u32,
    texels: Vec<[f64; 4]>,
}

/// The levels of one texture of the scene, from 0 on; empty where it is read at a point.
pub(super) type Pyramid = Vec<Level>;

/// By texture of the scene.
pub(super) fn pyramids(scene: &Scene) -> Vec<Pyramid> {
    let is_presence = |number: usize| {
        // A material that no shape has says nothing of a texture.
        scene.instances.iter().any(|i| match &scene.materials[i.material].alpha {
            Alpha::Mask { value, .. } | Alpha::Blend { value } => reads(value, number),
            Alpha::Opaque => false,
        })
    };
    let of = |(number, texture): (usize, &Texture)| match texture {
        Texture::Image { image, minify: Minify { levels: Some(_), .. }, encoding, .. }
            if scene.texture_filter == TextureFilter::Mipmap =>
        {
            let image = &scene.images[*image];
            let at = |i: u32| texel(image, *encoding, i % image.width, i / image.width);
            let first = Level {
                width: image.width,
                height: image.height,
                texels: (0..image.width * image.height).map(at).collect(),
            };
            pyramid(first, is_presence(number))
        }
        _ => Pyramid::new(),
    };
    scene.textures.iter().enumerate().map(of).collect()
}

fn reads(value: &Value, number: usize) -> bool {
    match value {
        Value::Texture { texture, .. } => *texture == number,
        Value::Multiply(a, b) => reads(a, number) || reads(b, number),
        Value::Channel(a, _) | Value::Share(a) | Value::Rest(a) => reads(a, number),
        Value::Constant(_) | Value::Curve(_) | Value::VertexColor => false,
    }
}

/// Colours are carried multiplied with what they are weighed by, beside the plain ones for where nothing is there.
fn pyramid(first: Level, by_alpha: bool) -> Pyramid {
    let mut levels = vec![first];
    loop {
        let above = &levels[levels.len() - 1];
        if above.width == 1 && above.height == 1 {
            return levels;
        }
        let (width, height) = ((above.width / 2).max(1), (above.height / 2).max(1));
        let carried: Vec<[f64; 7]> =
            above.texels.iter().map(|&[r, g, b, a]| [r * a, g * a, b * a, a, r, g, b]).collect();
        let narrow = shrink(&carried, above.width, above.height, width);
        // Columns as rows, and back.
        let turned = shrink(&transpose(&narrow, width, above.height), above.height, width, height);
        let texels = transpose(&turned, height, width)
            .into_iter()
            .map(|[pr, pg, pb, a, r, g, b]| match by_alpha && a > 0.0 {
                true => [pr / a, pg / a, pb / a, a],
                false => [r, g, b, a],
            })
            .collect();
        levels.push(Level { width, height, texels });
    }
}

/// Each row of `width` values becomes `count` means of equal parts: what it covers of each value is its share.
fn shrink(values: &[[f64; 7]], width: u32, height: u32, count: u32) -> Vec<[f64; 7]> {
    let mut result = Vec::with_capacity((count * height) as usize);
    let part = f64::from(width) / f64::from(count);
    for row in values.chunks_exact(width as usize) {
        for i in 0..count {
            let (from, to) = (f64::from(i) * part, f64::from(i + 1) * part);
            let mut sum = [0.0; 7];
            for (k, value) in row.iter().enumerate().take(to.ceil() as usize).skip(from as usize) {
                let covered = (to.min(k as f64 + 1.0) - from.max(k as f64)).max(0.0);
                (0..7).for_each(|c| sum[c] += covered * value[c] / part);
            }
            result.push(sum);
        }
    }
    result
}

fn transpose(values: &[[f64; 7]], width: u32, height: u32) -> Vec<[f64; 7]> {
    (0..width).flat_map(|x| (0..height).map(move |y| values[(y * width + x) as usize])).collect()
}

impl Independent<'_> {
    /// Areas that the ray's cone covers at the hit, in the units of both texture coordinates.
    pub(super) fn areas(&self, ray: &Ray, hit: &Hit, point: &Point) -> [f64; 2] {
        let primitive = self.primitives.get(hit.primitive);
        let Shape::Triangle(v) = primitive.shape else { return [0.0; 2] };
        let diameter = ray.cone.x + hit.t * ray.cone.y;
        let on_surface = diameter.powi(2) / ray.direction.dot(point.geometric_normal).abs().max(1e-6);
        // Twice the area of the triangle, by its sides (Heron).
        let [a, b, c] = [v[0].distance(v[1]), v[1].distance(v[2]), v[2].distance(v[0])];
        let s = 0.5 * (a + b + c);
        let world = 2.0 * (s * (s - a) * (s - b) * (s - c)).max(0.0).sqrt();
        let corner = |k: usize| {
            let mut weights = [0.0; 2];
            if k > 0 {
                weights[k - 1] = 1.0;
            }
            self.point(hit.primitive, weights, v[k]).uvs
        };
        let [p, q, r] = [corner(0), corner(1), corner(2)];
        [0, 1].map(|set| on_surface / world * (q[set] - p[set]).perp_dot(r[set] - p[set]).abs())
    }

    /// RGBA of an image texture over a footprint of `area` in the unit square of `uv`.
    pub(super) fn footprint(&self, number: usize, uv: DVec2, area: f64) -> [f64; 4] {
        let Texture::Image { image, wrap, filter, minify, encoding } = &self.scene.textures[number] else {
            return [0.0; 4];
        };
        let image = &self.scene.images[*image];
        let is_mipmapped = self.scene.texture_filter == TextureFilter::Mipmap;
        let count = area * f64::from(image.width) * f64::from(image.height);
        let pyramid = &self.pyramids[number];
        if !is_mipmapped || count.is_nan() || count <= 1.0 {
            return at_point(image.width, image.height, *wrap, *filter, uv, |x, y| texel(image, *encoding, x, y));
        }
        if pyramid.is_empty() {
            return at_point(image.width, image.height, *wrap, minify.filter, uv, |x, y| texel(image, *encoding, x, y));
        }
        let last = pyramid.len() - 1;
        let level = (count.ln() / 4f64.ln()).min(last as f64);
        let read = |k: usize| {
            let l = &pyramid[k.min(last)];
            at_point(l.width, l.height, *wrap, minify.filter, uv, |x, y| l.texels[(y * l.width + x) as usize])
        };
        if minify.levels == Some(Filter::Nearest) {
            return read(level.round() as usize);
        }
        let (below, above) = (read(level as usize), read(level as usize + 1));
        let share = level.fract();
        [0, 1, 2, 3].map(|c| (1.0 - share) * below[c] + share * above[c])
    }
}

fn at_point(
    width: u32,
    height: u32,
    wrap: [Wrap; 2],
    filter: Filter,
    uv: DVec2,
    read: impl Fn(u32, u32) -> [f64; 4],
) -> [f64; 4] {
    let (x, y) = (uv.x * f64::from(width), uv.y * f64::from(height));
    let fetch = |i: f64, j: f64| read(wrapped(wrap[0], i, width), wrapped(wrap[1], j, height));
    match filter {
        Filter::Nearest => fetch(x.floor(), y.floor()),
        Filter::Linear => bilinear(x, y, fetch),
    }
}
