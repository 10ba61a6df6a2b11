//! Double-double sums: an unevaluated pair of f64 with about 106 bits.
//!
//! TwoSum (Knuth 1969; Moller 1965) and the accurate addition and product of Hida, Li and Bailey 2001, "Algorithms for
//! Quad-Double Precision Floating Point Arithmetic". Sums of f32 blocks of one sign lose nothing until 2^50 of them.

/// `high + low`, with |low| <= ulp(high)/2.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Dd {
    pub high: f64,
    pub low: f64,
}

impl Dd {
    pub fn new(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }
    /// Rounded to f64.
    pub fn value(self) -> f64 {
        self.high + self.low
    }
    /// Adds an f64.
    pub fn add(&mut self, value: f64) {
        let (sum, error) = two_sum(self.high, value);
        (self.high, self.low) = quick_two_sum(sum, error + self.low);
    }
    pub fn plus(self, other: Self) -> Self {
        let (high, high_error) = two_sum(self.high, other.high);
        let (low, low_error) = two_sum(self.low, other.low);
        let (high, error) = quick_two_sum(high, high_error + low);
        let (high, low) = quick_two_sum(high, error + low_error);
        Self { high, low }
    }
    pub fn minus(self, other: Self) -> Self {
        self.plus(Self { high: -other.high, low: -other.low })
    }
    pub fn times(self, other: Self) -> Self {
        let product = self.high * other.high;
        let error = self.high.mul_add(other.high, -product) + (self.high * other.low + self.low * other.high);
        let (high, low) = quick_two_sum(product, error);
        Self { high, low }
    }
    /// Divided by an f64.
    pub fn over(self, divisor: f64) -> Self {
        let quotient = self.high / divisor;
        let remainder = self.minus(Self::new(quotient).times(Self::new(divisor)));
        let (high, low) = quick_two_sum(quotient, remainder.value() / divisor);
        Self { high, low }
    }
}

/// a + b and its rounding error, exactly.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_rounded = sum - a;
    (sum, (a - (sum - b_rounded)) + (b - b_rounded))
}

/// The same for |a| >= |b|.
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_do_not_depend_on_grouping() {
        let values: Vec<f64> = (0..10_000).map(|i| ((i * 7919 % 1013) as f32 * 1.1e-3 + 1e-7) as f64).collect();
        let mut whole = Dd::default();
        values.iter().for_each(|&v| whole.add(v));
        for size in [1, 3, 17, 1000] {
            let mut grouped = Dd::default();
            for chunk in values.chunks(size) {
                let mut part = Dd::default();
                chunk.iter().for_each(|&v| part.add(v));
                grouped = grouped.plus(part);
            }
            assert_eq!(grouped.value(), whole.value(), "groups of {size}");
        }
    }

    #[test]
    fn keeps_what_f64_loses() {
        let mut sum = Dd::new(1e16);
        (0..1000).for_each(|_| sum.add(0.001));
        sum.add(-1e16);
        assert!((sum.value() - 1.0).abs() < 1e-12, "{sum:?}");
        let third = Dd::new(1.0).over(3.0);
        let residue = third.times(Dd::new(3.0)).minus(Dd::new(1.0)).value();
        assert!(residue.abs() < 1e-31, "{residue:e}");
    }
}
