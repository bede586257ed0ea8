//! Asking for memory before it is read.

#![expect(
    unsafe_code,
    reason = "the instruction takes a pointer; without it rays of a tree of a million triangles wait for memory"
)]

/// Asks for the cache lines of `items[index]`; nothing happens where there is no such item.
#[inline(always)]
pub(super) fn prefetch<T>(items: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let item = items.as_ptr().wrapping_add(index).cast::<i8>();
        for line in (0..size_of::<T>()).step_by(64) {
            // SAFETY: a prefetch reads nothing a program can see, and faults at no address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(item.wrapping_add(line)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (items, index);
}
