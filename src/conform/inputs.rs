//! Inputs of the probes: reproducible numbers over a domain, mixed with its edges.

use crate::sampler::hash::pcg4d;

/// Edge values are drawn this often, one time in EDGE_SHARE, so that pairs of edges meet in a million inputs too.
const EDGE_SHARE: u32 = 16;

/// Counter-based generator of one input row.
pub struct Inputs {
    key: [u32; 2],
    index: u32,
    draw: u32,
}

impl Inputs {
    /// The numbers of input `index` of the row called `name`.
    pub fn new(name: &str, index: u32) -> Self {
        let key = name.bytes().fold([0x811c_9dc5u32, 7], |[a, b], c| {
            [(a ^ u32::from(c)).wrapping_mul(16_777_619), b.wrapping_mul(31).wrapping_add(u32::from(c))]
        });
        Self { key, index, draw: 0 }
    }

    /// Any word.
    pub fn word(&mut self) -> u32 {
        self.draw += 1;
        pcg4d([self.key[0], self.key[1], self.index, self.draw])[0]
    }

    /// Any word, often one with few bits set or unset.
    pub fn word_or_edge(&mut self) -> u32 {
        let word = self.word();
        match self.word() % 8 {
            0 => [0, 1, u32::MAX, u32::MAX - 1, 1 << 31, (1 << 31) - 1][word as usize % 6],
            1 => 1 << (word % 32),
            2 => word >> (word % 32),
            _ => word,
        }
    }

    pub fn below(&mut self, count: u32) -> u32 {
        ((u64::from(self.word()) * u64::from(count)) >> 32) as u32
    }

    /// True one time in `n`.
    pub fn once_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    pub fn pick(&mut self, list: &[f32]) -> f32 {
        list[self.below(list.len() as u32) as usize]
    }

    fn fraction(&mut self) -> f64 {
        f64::from(self.word()) / 4_294_967_296.0
    }

    /// Evenly in [a, b], and often exactly a, b or 0 where it is between.
    pub fn range(&mut self, a: f32, b: f32) -> f32 {
        if self.once_in(EDGE_SHARE) {
            let zero = if a <= 0.0 && b >= 0.0 { 0.0 } else { a };
            return self.pick(&[a, b, zero]);
        }
        let t = self.fraction();
        ((f64::from(a) * (1.0 - t) + f64::from(b) * t) as f32).clamp(a, b)
    }

    /// Evenly in the logarithm between positive a and b.
    pub fn log(&mut self, a: f64, b: f64) -> f32 {
        let t = if self.once_in(EDGE_SHARE) { f64::from(self.below(2)) } else { self.fraction() };
        (a * (b / a).powf(t)) as f32
    }

    /// As `log`, of either sign.
    pub fn signed_log(&mut self, a: f64, b: f64) -> f32 {
        let x = self.log(a, b);
        if self.once_in(2) { -x } else { x }
    }

    /// What a sampler gives: a multiple of 2^-24 in [0, 1), often 0, the last one, or next to 0, 1/2 and 1.
    pub fn unit(&mut self) -> f32 {
        let steps = 1 << 24;
        let k = if self.once_in(EDGE_SHARE) {
            [0, 1, steps - 1, steps / 2, steps / 2 - 1, steps / 2 + 1, steps / 4, steps - 2][self.below(8) as usize]
        } else if self.once_in(EDGE_SHARE) {
            steps >> self.below(24).max(1)
        } else {
            self.below(steps)
        };
        k as f32 / steps as f32
    }

    /// Any finite float of ordinary size, log-distributed, or a special one: 0, -0, denormal, largest, infinities, NaN.
    pub fn any_float(&mut self) -> f32 {
        if self.once_in(4) {
            return self.pick(&[
                0.0,
                -0.0,
                1.0,
                -1.0,
                f32::MIN_POSITIVE,
                f32::MAX,
                f32::MIN,
                f32::INFINITY,
                f32::NEG_INFINITY,
                f32::NAN,
                1.0 - f32::EPSILON / 2.0,
                1.0 + f32::EPSILON,
                0.5,
                2.0,
            ]);
        }
        self.signed_log(1e-37, 3e38)
    }

    /// Unit vector rounded to f32: everywhere, near the axes and the equator, and the axes themselves.
    pub fn direction(&mut self) -> [f32; 3] {
        let kind = self.below(EDGE_SHARE);
        let axis = self.below(3) as usize;
        let sign = if self.once_in(2) { -1.0 } else { 1.0 };
        let mut v = [0.0f64; 3];
        if kind == 0 {
            v[axis] = sign;
        } else {
            let z = 2.0 * self.fraction() - 1.0;
            let (sin, cos) = (std::f64::consts::TAU * self.fraction()).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            v = [r * cos, r * sin, z];
            if kind == 1 {
                // Close to an axis.
                let tilt = f64::from(self.log(1e-9, 0.1));
                v = v.map(|c| c * tilt);
                v[axis] = sign;
            } else if kind == 2 {
                // Close to a coordinate plane.
                v[axis] = f64::from(self.signed_log(1e-12, 1e-2));
            }
        }
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| (c / length) as f32)
    }

    /// A direction with z > 0, down to grazing.
    pub fn upper_direction(&mut self) -> [f32; 3] {
        let mut v = self.direction();
        v[2] = v[2].abs();
        if v[2] == 0.0 {
            v[2] = 1e-6;
        }
        v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_repeat_and_stay_in_their_domain() {
        let draw = |i: u32| {
            let mut r = Inputs::new("row", i);
            (r.unit(), r.range(-2.0, 3.0), r.log(1e-3, 1e3), r.direction())
        };
        for i in 0..20_000 {
            let (u, x, l, d) = draw(i);
            assert_eq!(draw(i), (u, x, l, d));
            assert!((0.0..1.0).contains(&u) && (-2.0..=3.0).contains(&x) && (0.99e-3..=1.01e3).contains(&l));
            let length = d.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>();
            assert!((length - 1.0).abs() < 3e-7, "{d:?}");
        }
        let edges = (0..20_000).filter(|&i| draw(i).0 == 0.0).count();
        assert!(edges > 50, "{edges}");
    }
}
