//! The ephemeris pack: Chebyshev blocks, bit-packed (`assets/astro/de440/SOURCE.md` has the format).

use super::State;
use crate::constants::SECONDS_PER_DAY;
use crate::error::{AstroError, Result};
use glam::DVec3;
use std::borrow::Cow;

/// More coefficients than this are refused: they live in an array on the stack.
const MAX_COUNT: usize = 40;

#[derive(Debug, Clone)]
struct Track {
    days: f64,
    count: usize,
    blocks: usize,
    /// Metres in a unit of the stored integers.
    quantum_m: f64,
    /// Byte at which its bits begin.
    offset: usize,
    block_bits: usize,
    /// Smallest value and number of bits: x, y, z by coefficient.
    fields: Vec<(i64, u32)>,
}

/// A parsed pack.
#[derive(Debug, Clone)]
pub(super) struct Pack {
    bytes: Cow<'static, [u8]>,
    start_jd: f64,
    end_jd: f64,
    tracks: Vec<Option<Track>>,
}

/// Reads little-endian numbers and never beyond the end.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let end = self.at + N;
        let slice = self.bytes.get(self.at..end).ok_or_else(|| broken("it ends too early"))?;
        self.at = end;
        slice.try_into().map_err(|_| broken("it ends too early"))
    }
    fn u32(&mut self) -> Result<usize> {
        self.take().map(|b| u32::from_le_bytes(b) as usize)
    }
    fn f64(&mut self) -> Result<f64> {
        self.take().map(f64::from_le_bytes)
    }
}

fn broken(reason: &str) -> AstroError {
    AstroError::Malformed { what: "ephemeris pack", text: "the given bytes".into(), reason: reason.to_owned() }
}

impl Pack {
    /// Checks everything that evaluation relies on.
    pub(super) fn parse(bytes: Cow<'static, [u8]>) -> Result<Self> {
        let mut r = Reader { bytes: &bytes, at: 0 };
        if &r.take::<8>()? != b"HIMMELEP" || r.u32()? != 1 {
            return Err(broken("it does not begin with HIMMELEP and version 1"));
        }
        let bodies = r.u32()?;
        let (start_jd, end_jd) = (r.f64()?, r.f64()?);
        if !(start_jd.is_finite() && end_jd.is_finite() && start_jd < end_jd) {
            return Err(broken("its span is empty"));
        }
        let mut tracks = Vec::new();
        for _ in 0..bodies.min(64) {
            let (ident, days, count, blocks) = (r.u32()?, r.u32()?, r.u32()?, r.u32()?);
            let quantum_m = r.f64()?;
            let offset = u64::from_le_bytes(r.take()?);
            if ident > 63 || days == 0 || !(2..=MAX_COUNT).contains(&count) || !quantum_m.is_finite() {
                return Err(broken("a body's header is out of range"));
            }
            let mut fields = Vec::with_capacity(3 * count);
            for _ in 0..3 * count {
                let low = i64::from_le_bytes(r.take()?);
                let [bits] = r.take::<1>()?;
                if bits > 56 || low.unsigned_abs() > 1 << 60 {
                    return Err(broken("a coefficient is wider than 56 bits"));
                }
                fields.push((low, u32::from(bits)));
            }
            let block_bits: usize = fields.iter().map(|f| f.1 as usize).sum();
            let end = u128::from(offset) + (block_bits as u128 * blocks as u128).div_ceil(8) + 8;
            if end > bytes.len() as u128 || blocks as f64 * (days as f64) < end_jd - start_jd {
                return Err(broken("a body's blocks do not cover its span"));
            }
            if tracks.len() <= ident {
                tracks.resize(ident + 1, None);
            }
            let track =
                Track { days: days as f64, count, blocks, quantum_m, offset: offset as usize, block_bits, fields };
            tracks[ident] = Some(track);
        }
        Ok(Self { bytes, start_jd, end_jd, tracks })
    }

    /// Whether a date lies within.
    pub(super) fn covers(&self, jd: f64) -> bool {
        jd >= self.start_jd && jd <= self.end_jd
    }

    /// A track's state at a date inside the span; `None` where the pack has no such body.
    pub(super) fn state(&self, ident: usize, jd: f64) -> Option<State> {
        let track = self.tracks.get(ident)?.as_ref()?;
        let since = jd - self.start_jd;
        let block = ((since / track.days) as usize).min(track.blocks - 1);
        let x = 2.0 * (since / track.days - block as f64) - 1.0;
        let mut bit = block * track.block_bits;
        let (mut position, mut rate) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let mut c = [0.0; MAX_COUNT];
            let fields = &track.fields[axis * track.count..(axis + 1) * track.count];
            for (slot, &(low, bits)) in c.iter_mut().zip(fields) {
                *slot = (low + self.bits(track.offset, bit, bits) as i64) as f64;
                bit += bits as usize;
            }
            (position[axis], rate[axis]) = chebyshev(&c[..track.count], x);
        }
        Some(State {
            position_m: DVec3::from_array(position) * track.quantum_m,
            velocity_m_s: DVec3::from_array(rate) * (track.quantum_m * 2.0 / (track.days * SECONDS_PER_DAY)),
        })
    }

    /// `bits` (at most 56) bits from a bit position after a byte offset; `parse` has checked that eight bytes follow.
    fn bits(&self, offset: usize, bit: usize, bits: u32) -> u64 {
        let at = offset + bit / 8;
        let word = self.bytes.get(at..at + 8).and_then(|b| b.try_into().ok()).map_or(0, u64::from_le_bytes);
        (word >> (bit % 8)) & ((1u64 << bits) - 1)
    }
}

/// Σ c_k T_k(x) and its derivative, by Clenshaw's recurrence for both.
fn chebyshev(c: &[f64], x: f64) -> (f64, f64) {
    let (mut b1, mut b2, mut d1, mut d2) = (0.0, 0.0, 0.0, 0.0);
    for &ck in c[1..].iter().rev() {
        let d0 = 2.0 * x * d1 - d2 + 2.0 * b1;
        (d2, d1) = (d1, d0);
        let b0 = 2.0 * x * b1 - b2 + ck;
        (b2, b1) = (b1, b0);
    }
    (c[0] + x * b1 - b2, b1 + x * d1 - d2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clenshaw_agrees_with_the_definition() {
        let (c, x) = ([0.5, -1.0, 0.25, 0.125], 0.3_f64);
        let t = [1.0, x, 2.0 * x * x - 1.0, 4.0 * x.powi(3) - 3.0 * x];
        let d = [0.0, 1.0, 4.0 * x, 12.0 * x * x - 3.0];
        let sum = |v: [f64; 4]| v.iter().zip(c).map(|(a, b)| a * b).sum::<f64>();
        let (value, rate) = chebyshev(&c, x);
        assert!((value - sum(t)).abs() < 1e-15 && (rate - sum(d)).abs() < 1e-14);
    }

    #[test]
    fn broken_packs_are_refused() {
        assert!(Pack::parse(Cow::Borrowed(b"")).is_err());
        assert!(Pack::parse(Cow::Borrowed(b"HIMMELEP\x01\0\0\0\x01\0\0\0")).is_err());
        assert!(Pack::parse(Cow::Owned(vec![0xff; 4096])).is_err());
    }
}
