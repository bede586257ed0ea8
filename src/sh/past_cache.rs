//! Writing tables that no cache holds.

#![expect(
    unsafe_code,
    reason = "the instruction takes a pointer; without it each line of a large table is read before it is written"
)]

/// Floats of a cache line.
const LINE: usize = 16;

/// Copies `from` to `to`, which is as long, past the caches where the machine can. [`finish`] makes it seen by others.
#[inline(always)]
pub(super) fn copy(to: &mut [f32], from: &[f32]) {
    let before = to.as_ptr().align_offset(LINE * size_of::<f32>());
    let before = before.min(to.len());
    let (head, to) = to.split_at_mut(before);
    let (from_head, from) = from.split_at(before);
    head.copy_from_slice(from_head);
    let (lines, tail) = to.as_chunks_mut::<LINE>();
    let (from_lines, from_tail) = from.as_chunks::<LINE>();
    for (line, from) in lines.iter_mut().zip(from_lines) {
        stream(line, from);
    }
    tail.copy_from_slice(from_tail);
}

/// Writes a line that begins where a cache line does.
#[inline(always)]
fn stream(line: &mut [f32; LINE], from: &[f32; LINE]) {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx"))]
    {
        use std::arch::x86_64::{_mm256_loadu_ps, _mm256_stream_ps};
        let (halves, _) = line.as_chunks_mut::<8>();
        let (from, _) = from.as_chunks::<8>();
        for (half, from) in halves.iter_mut().zip(from) {
            debug_assert_eq!(half.as_ptr().align_offset(32), 0);
            // SAFETY: eight floats are read and eight written, each in an array of eight; `copy` has aligned the line, and so
            // both its halves, to 32 bytes.
            unsafe { _mm256_stream_ps(half.as_mut_ptr(), _mm256_loadu_ps(from.as_ptr())) };
        }
    }
    #[cfg(not(all(target_arch = "x86_64", target_feature = "avx")))]
    {
        *line = *from;
    }
}

/// Ends a run of copies: other threads see what was written before what this thread writes next.
#[inline(always)]
pub(super) fn finish() {
    #[cfg(all(target_arch = "x86_64", target_feature = "avx"))]
    // SAFETY: the instruction is part of SSE, and so of every x86-64; it touches no memory.
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}
