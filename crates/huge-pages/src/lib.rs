//! An allocator that asks for huge pages for large allocations.
//!
//! The arrays of a frame are tens of megabytes, written once and given back. On pages of 4 kB, taking them from the kernel
//! costs more than converting the numbers: reading a raw file with all attributes takes two and a half times as long. A
//! program opts in, because allocators belong to the whole process:
//!
//!     #[global_allocator]
//!     static ALLOCATOR: meniscus_huge_pages::HugePages = meniscus_huge_pages::HugePages;
//!
//! and by calling [`give_back`].

use std::alloc::{GlobalAlloc, Layout, System};

/// From this size on an allocation asks for huge pages, bytes: two of the common 2 MiB, so that at least one fits in whatever
/// its start.
pub const LARGE: usize = 4 << 20;

/// The system's allocator, which asks the kernel for huge pages from [`LARGE`] bytes on. On Linux, where transparent huge
/// pages are set to `madvise` or `always`; elsewhere it is the system's allocator.
pub struct HugePages;

// SAFETY: the system's allocator answers every call; what is done besides changes neither addresses nor contents.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those of the system's allocator.
        advised(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        advised(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        // SAFETY: as above.
        advised(unsafe { System.realloc(pointer, layout, new_size) }, new_size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Sees to it, for the rest of the process' life, that large blocks go back to the system when they are freed. glibc else
/// learns from the first freed frames to keep blocks of up to 32 MiB in its heaps, where they stay: a player then was measured to
/// hold a third more than its budget instead of a hundredth. Allocators other than glibc's do so by themselves.
pub fn give_back() {
    /// Blocks from here on are mapped on their own, bytes: far below the arrays of a frame, far above what is allocated often.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    const MAPPED: libc::c_int = 1 << 20;
    // SAFETY: `mallopt` takes plain numbers and may be called at any time; a parameter it does not know changes nothing.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, MAPPED)
    };
}

/// `pointer`, after asking for huge pages for the whole pages of the `size` bytes there.
fn advised(pointer: *mut u8, size: usize) -> *mut u8 {
    #[cfg(target_os = "linux")]
    if size >= LARGE && !pointer.is_null() {
        // The system's own pages may be larger than these; then it refuses, which costs nothing but the call.
        const PAGE: usize = 4096;
        let skipped = pointer.align_offset(PAGE);
        let whole = size.saturating_sub(skipped) & !(PAGE - 1);
        // SAFETY: the range lies within an allocation that was made just now, and the advice changes no contents. A refusal
        // (a kernel without huge pages) leaves everything as it was.
        unsafe { libc::madvise(pointer.wrapping_add(skipped).cast(), whole, libc::MADV_HUGEPAGE) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = size;
    pointer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[global_allocator]
    static ALLOCATOR: HugePages = HugePages;

    #[test]
    fn contents_survive_growing_and_shrinking() {
        let mut numbers: Vec<u64> = (0..LARGE as u64 / 16).collect();
        numbers.extend(LARGE as u64 / 16..LARGE as u64);
        numbers.truncate(LARGE / 4);
        numbers.shrink_to_fit();
        assert!(numbers.iter().copied().eq(0..LARGE as u64 / 4));
        assert!(vec![0u8; 3 * LARGE + 1].iter().all(|&byte| byte == 0));
    }

    /// The kernel marks the mappings that were asked for.
    #[cfg(target_os = "linux")]
    #[test]
    #[expect(clippy::print_stderr, reason = "a skipped test must not look like a passed one")]
    fn large_allocations_are_marked_and_small_ones_are_not() {
        let is_marked = |address: usize| {
            let maps = std::fs::read_to_string("/proc/self/smaps").unwrap();
            let mut inside = false;
            maps.lines().find_map(|line| {
                let range = line.split_once(' ').and_then(|(range, _)| range.split_once('-'));
                if let Some((Ok(begin), Ok(end))) =
                    range.map(|(a, b)| (usize::from_str_radix(a, 16), usize::from_str_radix(b, 16)))
                {
                    inside = (begin..end).contains(&address);
                }
                (inside && line.starts_with("VmFlags:"))
                    .then(|| line.split_whitespace().any(|flag| flag == "hg"))
            })
        };
        if !std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists() {
            eprintln!("SKIPPED: this kernel has no transparent huge pages");
            return;
        }
        let (large, small) = (vec![1u8; 4 * LARGE], vec![1u8; LARGE / 8]);
        assert_eq!(is_marked(large.as_ptr() as usize + 2 * LARGE), Some(true));
        assert_ne!(is_marked(small.as_ptr() as usize + LARGE / 16), Some(true));
    }
}
