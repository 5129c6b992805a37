//! The samples so far as bytes: a head, sums for each pixel, a checksum.

use crate::error::{Error, Result};

/// First line of every file of samples. The number changes when what follows does.
const MAGIC: &[u8] = b"himmel reference samples 1\n";

/// What a pixel sums up: X, Y, Z, and the square of Y of each pass.
pub(super) type Sums = [f64; 4];

/// What the bytes belong to.
pub(super) struct Head {
    /// Hash of everything that decides the samples.
    pub fingerprint: u64,
    /// Passes that are summed up.
    pub passes: u64,
}

/// FNV-1a, 64 bits [fnv2012]: tells files apart, not forgers.
pub(super) fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

pub(super) fn write(head: &Head, sums: &[Sums]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(MAGIC.len() + 8 * (4 + 4 * sums.len()));
    bytes.extend_from_slice(MAGIC);
    for word in [head.fingerprint, head.passes, sums.len() as u64] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    for value in sums.iter().flatten() {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    let checksum = hash(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    bytes
}

/// The passes and sums in `bytes` if they belong to `fingerprint` and hold `count` pixels.
pub(super) fn read(bytes: &[u8], fingerprint: u64, count: usize) -> Result<(u64, Vec<Sums>)> {
    let error = |why: &str| Err(Error::Samples(why.into()));
    let Some(body) = bytes.strip_prefix(MAGIC) else {
        return error("it holds no samples of this version of himmel");
    };
    let broken = "it is cut off or damaged";
    if body.len() < 32 || body.len() % 8 != 0 {
        return error(broken);
    }
    let mut words = body.chunks_exact(8).map(|word| word.try_into().map_or(0, u64::from_le_bytes));
    let (found, passes, pixels) = (words.next(), words.next(), words.next());
    if pixels != Some(((body.len() - 32) / 32) as u64) || body.len() % 32 != 0 {
        return error(broken);
    }
    let values: Vec<u64> = words.collect();
    let (Some((checksum, values)), Some(passes)) = (values.split_last(), passes) else { return error(broken) };
    if *checksum != hash(&bytes[..bytes.len() - 8]) {
        return error(broken);
    }
    if found != Some(fingerprint) || pixels != Some(count as u64) {
        return error("it belongs to another scene, camera, size, time or seed");
    }
    let sums: Vec<Sums> = values.chunks_exact(4).map(|four| [0, 1, 2, 3].map(|i| f64::from_bits(four[i]))).collect();
    Ok((passes, sums))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_round_trip_and_nothing_else_is_read() {
        let sums = vec![[1.0, -2.5, f64::MIN_POSITIVE, 4.0], [0.1, 0.2, 0.3, 0.4]];
        let bytes = write(&Head { fingerprint: 7, passes: 3 }, &sums);
        assert_eq!(read(&bytes, 7, 2).unwrap(), (3, sums));
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end], 7, 2).is_err(), "{end}");
        }
        for at in 0..bytes.len() {
            let mut other = bytes.clone();
            other[at] ^= 4;
            assert!(read(&other, 7, 2).is_err(), "{at}");
        }
        for (fingerprint, count) in [(8, 2), (7, 3)] {
            let error = read(&bytes, fingerprint, count).unwrap_err().to_string();
            assert!(error.contains("another scene"), "{error}");
        }
        assert!(read(b"", 7, 2).is_err() && read(b"\x89PNG", 7, 2).is_err());
    }

    /// The published test vectors of FNV-1a.
    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(hash(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(hash(b"foobar"), 0x8594_4171_f739_67e8);
    }
}
