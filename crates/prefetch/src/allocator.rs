/// Blocks from here on are mapped on their own, bytes: far below the arrays of a frame worth prefetching, far above what is
/// allocated often.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LARGE: libc::c_int = 1 << 20;

/// Sees to it that the memory of a frame goes back to the system when the frame is dropped. glibc else learns from the first freed
/// frames to keep blocks of up to 32 MiB in its heaps, where they stay: measured are a third more than the budget instead of
/// a hundredth.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn give_frames_back() {
    // SAFETY: `mallopt` takes plain numbers and may be called at any time; a parameter it does not know changes nothing.
    unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, LARGE) };
}

/// Other allocators give large blocks back by themselves.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(crate) fn give_frames_back() {}
