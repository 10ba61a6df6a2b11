//! The checksum of a part file: FNV-1a with 128 bits over words of 64 bits, then the length. Each step is a bijection of the state,
//! so that any one wrong word is found for certain; it is no protection against someone who means to deceive.

use std::io::{self, Read, Write};

use crate::shader::cache::{FNV_OFFSET, FNV_PRIME};

#[derive(Clone)]
struct Checksum {
    hash: u128,
    word: [u8; 8],
    filled: usize,
    length: u64,
}

impl Checksum {
    fn new() -> Self {
        Self { hash: FNV_OFFSET, word: [0; 8], filled: 0, length: 0 }
    }

    fn add(&mut self, mut bytes: &[u8]) {
        self.length += bytes.len() as u64;
        // Complete the word that was begun.
        if self.filled > 0 {
            let count = bytes.len().min(8 - self.filled);
            self.word[self.filled..self.filled + count].copy_from_slice(&bytes[..count]);
            self.filled += count;
            bytes = &bytes[count..];
            if self.filled < 8 {
                return;
            }
            self.step(self.word);
            self.filled = 0;
        }
        let words = bytes.chunks_exact(8);
        let rest = words.remainder();
        words.for_each(|w| self.step(std::array::from_fn(|i| w[i])));
        self.word[..rest.len()].copy_from_slice(rest);
        self.filled = rest.len();
    }

    fn step(&mut self, word: [u8; 8]) {
        self.hash = (self.hash ^ u128::from(u64::from_le_bytes(word))).wrapping_mul(FNV_PRIME);
    }

    fn value(mut self) -> u128 {
        self.word[self.filled..].fill(0);
        self.step(self.word);
        self.step(self.length.to_le_bytes());
        self.hash
    }
}

/// Passes on what is written, and sums it.
pub struct Seal<W> {
    out: W,
    checksum: Checksum,
}

impl<W: Write> Seal<W> {
    pub fn new(out: W) -> Self {
        Self { out, checksum: Checksum::new() }
    }

    pub fn finish(self) -> (u128, W) {
        (self.checksum.value(), self.out)
    }
}

impl<W: Write> Write for Seal<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.checksum.add(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// The first `length` bytes are followed by their checksum.
pub fn holds(input: &mut impl Read, length: u64) -> io::Result<bool> {
    let mut checksum = Checksum::new();
    let mut left = length;
    let mut buffer = vec![0u8; 1 << 18];
    while left > 0 {
        let count = (buffer.len() as u64).min(left) as usize;
        input.read_exact(&mut buffer[..count])?;
        checksum.add(&buffer[..count]);
        left -= count as u64;
    }
    let mut stored = [0u8; 16];
    input.read_exact(&mut stored)?;
    Ok(u128::from_le_bytes(stored) == checksum.value())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_do_not_matter_and_every_bit_does() {
        let bytes: Vec<u8> = (0..83u32).map(|i| (i * 37 % 251) as u8).collect();
        let of = |pieces: &[usize]| {
            let mut sum = Checksum::new();
            let mut rest = &bytes[..];
            for &piece in pieces.iter().cycle() {
                let (now, later) = rest.split_at(piece.min(rest.len()));
                sum.add(now);
                rest = later;
                if rest.is_empty() {
                    break;
                }
            }
            sum.value()
        };
        let whole = of(&[83]);
        for pieces in [&[1][..], &[3, 8, 0, 5], &[7, 9], &[16, 1]] {
            assert_eq!(of(pieces), whole, "{pieces:?}");
        }
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let mut sum = Checksum::new();
            sum.add(&flipped);
            assert_ne!(sum.value(), whole, "bit {bit}");
        }
        let mut longer = Checksum::new();
        longer.add(&[bytes.as_slice(), &[0]].concat());
        assert_ne!(longer.value(), whole, "a zero more");
    }
}
