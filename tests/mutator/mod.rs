//! Damage to files, the same for the same seed: bits, slices, whole numbers, words of text formats, deep nesting.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Whole numbers on which lengths, counts and offsets break.
const INTEGERS: [u64; 14] = [
    0,
    1,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fff0,
    0xffff_ffff,
    0x1_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    u64::MAX,
];

/// What stands where a number was.
const WORDS: [&str; 24] = [
    "0",
    "-0",
    "-1",
    "1",
    "0.5",
    "1e999",
    "-1e999",
    "1e308",
    "1e-308",
    "5e-324",
    "1e30",
    "1e-30",
    "NaN",
    "inf",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "9007199254740993",
    "0x10",
    "null",
    "[]",
    "{}",
    "\"x\"",
];

/// A source of damage.
pub struct Mutator(Pcg64);

impl Mutator {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// Damages bytes in one to four ways; `other` is another file to copy from.
    pub fn damage(&mut self, bytes: &mut Vec<u8>, other: &[u8]) {
        for _ in 0..self.below(4) + 1 {
            self.damage_once(bytes, other);
        }
    }

    fn below(&mut self, end: usize) -> usize {
        self.0.random_range(0..end.max(1))
    }

    /// A slice of at most `longest` bytes; most are short.
    fn slice(&mut self, length: usize, longest: usize) -> std::ops::Range<usize> {
        let start = self.below(length);
        let longest = if self.below(3) == 0 { longest } else { 16 };
        start..(start + 1 + self.below(longest)).min(length)
    }

    fn damage_once(&mut self, bytes: &mut Vec<u8>, other: &[u8]) {
        if bytes.is_empty() {
            return bytes.extend(other);
        }
        let at = self.below(bytes.len());
        match self.below(11) {
            0 => bytes[at] ^= 1 << self.below(8),
            1 => bytes[at] = self.0.random(),
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(self.slice(bytes.len(), 256))),
            4 => {
                let copy = bytes[self.slice(bytes.len(), 256)].to_vec();
                bytes.splice(at..at, copy);
            }
            5 => {
                let copy = other.get(self.slice(other.len(), 256)).unwrap_or_default().to_vec();
                bytes.splice(at..at, copy);
            }
            6 => self.overwrite(bytes, at),
            7 | 8 => self.replace_number(bytes, at),
            9 => {
                let count = 1 + self.below(40);
                let bytes_of_noise: Vec<u8> = (0..count).map(|_| self.0.random()).collect();
                bytes.splice(at..at, bytes_of_noise);
            }
            _ => {
                let (open, count) = ([b'[', b'{', b'"', b'('][self.below(4)], [4, 140, 3000][self.below(3)]);
                bytes.splice(at..at, vec![open; count]);
            }
        }
    }

    /// Puts a whole number where one may be: aligned more often than not.
    fn overwrite(&mut self, bytes: &mut [u8], at: usize) {
        let width = [1, 2, 4, 8][self.below(4)];
        let at = if self.below(4) == 0 { at } else { at / width * width };
        let integer = INTEGERS[self.below(INTEGERS.len())].to_le_bytes();
        bytes.iter_mut().skip(at).zip(&integer[..width]).for_each(|(byte, new)| *byte = *new);
    }

    /// Replaces the first number after `at` that stands where text formats have values.
    fn replace_number(&mut self, bytes: &mut Vec<u8>, at: usize) {
        let word = WORDS[self.below(WORDS.len())];
        let is_number = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
        let starts = |w: &[u8]| !is_number(&w[0]) && !w[0].is_ascii_alphabetic() && is_number(&w[1]);
        if let Some(start) = bytes[at..].windows(2).position(starts).map(|k| at + k + 1) {
            let end = bytes[start..].iter().position(|b| !is_number(b)).map_or(bytes.len(), |k| start + k);
            bytes.splice(start..end, word.bytes());
        }
    }
}
