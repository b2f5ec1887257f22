//! The list of pixels that show fluid; WGSL: `meniscus::covered` in `shaders/common/covered.inc.wgsl`.

use crate::Dispatch;

/// The list for a picture of `size` pixels of which those show fluid whose index `shows` is true for, as words of a
/// [`Scratch`](crate::role::Scratch) buffer.
pub fn list(size: [u32; 2], shows: impl Fn(usize) -> bool) -> Vec<u32> {
    let pixels = (0..size[0] * size[1]).filter(|&i| shows(i as usize));
    let mut words = vec![0];
    words.extend(pixels.map(|i| (i % size[0]) | (i / size[0]) << 16));
    words[0] = words.len() as u32 - 1;
    // A binding has room for at least one pixel.
    words.push(0);
    words
}

/// Dispatch of a pass over the list, in groups of 64.
pub fn dispatch(size: [u32; 2]) -> Dispatch {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    Dispatch::Shares(pixels.div_ceil(64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_its_length_and_all_that_shows() {
        assert_eq!(list([3, 2], |i| i > 3), [2, 1 | 1 << 16, 2 | 1 << 16, 0]);
        assert_eq!(list([3, 2], |_| false), [0, 0]);
        assert_eq!(dispatch([8, 8]), Dispatch::Shares(1));
    }
}
