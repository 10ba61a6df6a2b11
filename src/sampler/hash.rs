//! Integer hashes, the same words as shaders/core/random.glsl bit for bit (gate 2).

/// PCG output function RXS-M-XS over one LCG step (O'Neill 2014; as a hash: Jarzynski and Olano 2020). A bijection.
pub fn pcg(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Two rounds of multiply and shift, a bijection without bit bias (form and constants: Wellons' hash-prospector, "lowbias32").
pub fn mix32(v: u32) -> u32 {
    let v = (v ^ (v >> 16)).wrapping_mul(0x21f0_aaad);
    let v = (v ^ (v >> 15)).wrapping_mul(0xd35a_2d97);
    v ^ (v >> 15)
}

/// Four words to four (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", JCGT 9(3), pcg4d).
pub fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = v.map(|a| a.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        if round == 0 {
            [x, y, z, w] = [x, y, z, w].map(|a| a ^ (a >> 16));
        }
    }
    [x, y, z, w]
}

/// Adds a word to a hash; order matters. For a fixed `h` a bijection of `v`, and the other way round.
pub fn hash_combine(h: u32, v: u32) -> u32 {
    // The outer round is mix32: two rounds of pcg flip bit 10 in 41 % of cases only.
    mix32(h ^ pcg(v.wrapping_add(0x9e37_79b9)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_combine_is_injective_in_its_word() {
        let mut words: Vec<u32> = (0..1 << 16).map(|v| hash_combine(12345, v)).collect();
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), 1 << 16);
    }

    /// Flipping one input bit flips each output bit about half of the time.
    #[test]
    fn hashes_avalanche() {
        let count = 4096;
        for bit in 0..32 {
            let mut flips = [0u32; 32];
            for i in 0..count {
                let v = pcg(i);
                let change = hash_combine(v, 7) ^ hash_combine(v ^ (1 << bit), 7);
                flips.iter_mut().enumerate().for_each(|(k, f)| *f += (change >> k) & 1);
            }
            // 6 sigma of a binomial(4096, 1/2) is 192.
            assert!(flips.iter().all(|&f| f.abs_diff(count / 2) < 192), "bit {bit}: {flips:?}");
        }
    }
}
