//! Streams of random numbers that do not depend on threads: one for each question and batch.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// One stream.
pub(super) struct Random(Xoshiro256PlusPlus);

impl Random {
    /// The stream of a seed, a question and a batch; streams are unrelated (SplitMix64 spreads the seed).
    pub fn new(seed: u64, question: u64, batch: u64) -> Self {
        let mut spread = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mixed = spread.next_u64() ^ question.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut spread = Xoshiro256PlusPlus::seed_from_u64(mixed);
        let mixed = spread.next_u64() ^ batch.wrapping_mul(0xd134_2543_de82_ef95);
        Self(Xoshiro256PlusPlus::seed_from_u64(mixed))
    }

    /// Even in 0..1, never 1.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}
