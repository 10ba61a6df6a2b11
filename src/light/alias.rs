//! Choosing one of n entries in constant time: the alias table of Walker, built as in Vose 1991 ("A linear algorithm for
//! generating random numbers with a given distribution"), with thresholds that are integers over 2^32.
//!
//! The draw is two random words: entry `mulhi(index_word, n)`, kept when `fraction_word < threshold`, else its alias. A full
//! entry is its own alias, so it needs no case. Building is f64 and rounds; what the finished table really does is then counted
//! in integers, and that is the pmf: no estimator divides by a probability that the table does not have.
//! Kernels: shaders/light/choose.glsl. Tests: below.

use crate::prepare::records::AliasRecord;

/// One half of an `AliasRecord`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    /// Kept when the fraction word is below.
    pub threshold: u32,
    pub alias: u32,
}

/// A finished table over `entries.len()` choices.
#[derive(Clone, Debug, PartialEq)]
pub struct AliasTable {
    pub entries: Vec<Entry>,
    /// Exact probability of each choice, correctly rounded to f64.
    pub pmf: Vec<f64>,
}

impl AliasTable {
    /// Table proportional to `weights`. NaN and negative weights count as 0, +infinity as the largest finite weight (or 1).
    /// A positive weight always keeps a positive probability, at least 2^-32/n; weight 0 is never chosen.
    /// None when no weight is positive, or there are more than 2^31 of them.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let largest = weights.iter().copied().filter(|w| w.is_finite()).fold(0.0, f64::max);
        let has_infinite = weights.contains(&f64::INFINITY);
        let largest = if largest > 0.0 { largest } else { 1.0 };
        // Divided by the largest before summing, so that the sum stays finite.
        let clean = |w: f64| if w == f64::INFINITY { 1.0 } else { (w / largest).max(0.0) };
        let sum: f64 = weights.iter().map(|&w| clean(w)).sum();
        let is_any = has_infinite || weights.iter().any(|&w| w > 0.0);
        if !is_any || weights.len() > 1 << 31 {
            return None;
        }
        let per_entry = weights.len() as f64 / sum;
        let mut scaled: Vec<f64> = weights.iter().map(|&w| clean(w) * per_entry).collect();
        let entries = vose(weights, &mut scaled);
        drop(scaled);
        let pmf = exact_pmf(&entries);
        Some(Self { entries, pmf })
    }

    pub fn choose(&self, index_word: u32, fraction_word: u32) -> u32 {
        choose(self.entries.len() as u32, |i| self.entries[i as usize], index_word, fraction_word)
    }

    /// Two entries a row, as the kernels read it; the spare half of an odd table is never reached.
    pub fn records(&self) -> Vec<AliasRecord> {
        self.entries
            .chunks(2)
            .map(|pair| {
                let second = pair.get(1).copied().unwrap_or_default();
                AliasRecord {
                    threshold0: pair[0].threshold,
                    alias0: pair[0].alias,
                    threshold1: second.threshold,
                    alias1: second.alias,
                }
            })
            .collect()
    }
}

/// The draw over any store of entries.
pub fn choose(count: u32, entry: impl Fn(u32) -> Entry, index_word: u32, fraction_word: u32) -> u32 {
    let index = ((u64::from(index_word) * u64::from(count)) >> 32) as u32;
    let e = entry(index);
    if fraction_word < e.threshold { index } else { e.alias }
}

/// The draw from the uploaded records.
pub fn choose_record(records: &[AliasRecord], count: u32, index_word: u32, fraction_word: u32) -> u32 {
    let entry = |i: u32| {
        let row = records[(i / 2) as usize];
        match i % 2 {
            0 => Entry { threshold: row.threshold0, alias: row.alias0 },
            _ => Entry { threshold: row.threshold1, alias: row.alias1 },
        }
    };
    choose(count, entry, index_word, fraction_word)
}

/// Fills every entry to one n-th of the mass from at most two choices. `scaled` has mean 1 and is used up.
fn vose(weights: &[f64], scaled: &mut [f64]) -> Vec<Entry> {
    let is_positive = |i: u32| weights[i as usize] > 0.0;
    let count = weights.len() as u32;
    let heaviest = (0..count).max_by(|&a, &b| scaled[a as usize].total_cmp(&scaled[b as usize])).unwrap_or(0);
    let (mut small, mut large): (Vec<u32>, Vec<u32>) = (0..count).partition(|&i| scaled[i as usize] < 1.0);
    let mut entries = vec![Entry::default(); weights.len()];
    while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
        small.pop();
        let mass = scaled[s as usize];
        entries[s as usize] = quantise(s, mass, is_positive(s), l);
        scaled[l as usize] -= 1.0 - mass;
        if scaled[l as usize] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    // What is left is full up to rounding; a weight of 0 left over must not become possible by it.
    for &i in small.iter().chain(&large) {
        entries[i as usize] = if is_positive(i) {
            Entry { threshold: u32::MAX, alias: i }
        } else {
            Entry { threshold: 0, alias: heaviest }
        };
    }
    entries
}

fn quantise(index: u32, mass: f64, is_positive: bool, alias: u32) -> Entry {
    let threshold = (mass * 4294967296.0).round().max(if is_positive { 1.0 } else { 0.0 });
    if threshold >= 4294967296.0 {
        Entry { threshold: u32::MAX, alias: index }
    } else {
        Entry { threshold: threshold as u32, alias }
    }
}

/// Counts, over all 2^64 pairs of words, how many give each choice.
fn exact_pmf(entries: &[Entry]) -> Vec<f64> {
    const WORDS: u64 = 1 << 32;
    let count = entries.len() as u64;
    // Words whose mulhi with `count` is below i: ceil(i 2^32 / count).
    let first_word = |i: u64| (i * WORDS).div_ceil(count);
    // One choice may have all 2^64 pairs, which wraps to 0; no other choice that can occur has a count of 0.
    let mut pairs = vec![0u64; entries.len()];
    let mut is_possible = vec![false; entries.len()];
    for (i, e) in entries.iter().enumerate() {
        let words = first_word(i as u64 + 1) - first_word(i as u64);
        let kept = if e.alias as usize == i { WORDS } else { u64::from(e.threshold) };
        for (choice, fractions) in [(i, kept), (e.alias as usize, WORDS - kept)] {
            if fractions > 0 {
                pairs[choice] = pairs[choice].wrapping_add(words.wrapping_mul(fractions));
                is_possible[choice] = true;
            }
        }
    }
    let probability = |(&n, &possible): (&u64, &bool)| if possible && n == 0 { 1.0 } else { n as f64 * 2f64.powi(-64) };
    pairs.iter().zip(&is_possible).map(probability).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pmf_by_counting(t: &AliasTable) -> Vec<f64> {
        // Stratified words: 2^10 indices x 2^10 fractions, one representative each.
        let mut seen = vec![0.0; t.entries.len()];
        for i in 0..1024u32 {
            for f in 0..1024u32 {
                seen[t.choose((i << 22) | 0x1f_ffff, (f << 22) | 0x1f_ffff) as usize] += 1.0 / 1048576.0;
            }
        }
        seen
    }

    #[test]
    fn the_pmf_is_that_of_the_draw() {
        for weights in [
            vec![1.0, 2.0, 3.0, 4.0],
            vec![5.0],
            vec![1.0; 7],
            vec![0.0, 1.0, 0.0],
            vec![1.0, 1e-3, 1e3, 0.5, 0.0, 2.0],
        ] {
            let t = AliasTable::new(&weights).unwrap();
            let sum: f64 = weights.iter().sum();
            assert!((t.pmf.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{weights:?}");
            for (i, seen) in pmf_by_counting(&t).into_iter().enumerate() {
                assert!((t.pmf[i] - weights[i] / sum).abs() < 1e-9, "{weights:?} {i} {}", t.pmf[i]);
                assert!((seen - t.pmf[i]).abs() < 4e-3, "{weights:?} entry {i}: drawn {seen}, pmf {}", t.pmf[i]);
                assert_eq!(weights[i] == 0.0, t.pmf[i] == 0.0);
            }
        }
    }

    #[test]
    fn extreme_ratios_keep_every_positive_weight() {
        for ratio in [1e-12, 1e-300, 5e-324] {
            let t = AliasTable::new(&[1.0, ratio, 0.0]).unwrap();
            assert!(t.pmf[1] > 0.0 && t.pmf[1] < 2e-10 && t.pmf[2] == 0.0 && t.pmf[0] > 0.999999);
        }
        let t = AliasTable::new(&[f64::MAX, f64::MAX, 1.0]).unwrap();
        assert!((t.pmf[0] - 0.5).abs() < 1e-9);
    }

    #[test]
    fn weights_that_are_no_weights_are_defined() {
        assert!(AliasTable::new(&[]).is_none());
        assert!(AliasTable::new(&[0.0, -1.0, f64::NAN]).is_none());
        let t = AliasTable::new(&[f64::NAN, 1.0, -3.0, f64::NEG_INFINITY]).unwrap();
        assert_eq!(t.pmf, [0.0, 1.0, 0.0, 0.0]);
        let t = AliasTable::new(&[f64::INFINITY, 0.0, 4.0]).unwrap();
        assert!((t.pmf[0] - 0.5).abs() < 1e-9 && (t.pmf[2] - 0.5).abs() < 1e-9);
        let t = AliasTable::new(&[f64::INFINITY]).unwrap();
        assert_eq!(t.pmf, [1.0]);
    }

    #[test]
    fn a_million_entries_with_one_hot_add_up() {
        let mut weights = vec![1.0; 1_000_003];
        weights[777] = 1e9;
        let t = AliasTable::new(&weights).unwrap();
        // A million additions of nearly the same number beside 1: up to half an ulp each.
        assert!((t.pmf.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert!((t.pmf[777] - 1e9 / (1e9 + 1_000_002.0)).abs() < 1e-8);
        assert!(t.pmf.iter().all(|&p| p > 0.0));
    }

    #[test]
    fn records_draw_the_same() {
        let t = AliasTable::new(&[3.0, 1.0, 0.2, 7.0, 0.0]).unwrap();
        let records = t.records();
        for k in 0..10_000u32 {
            let (a, b) = (k.wrapping_mul(0x9e37_79b9), k.wrapping_mul(0x85eb_ca6b) ^ 0x1234_5678);
            assert_eq!(t.choose(a, b), choose_record(&records, 5, a, b));
        }
        assert!(t.choose(u32::MAX, u32::MAX) < 5);
    }
}
