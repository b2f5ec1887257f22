//! H.264 in its usual form shares a colour between two by two pixels and has no odd sides.

use std::borrow::Cow;

/// The next even size.
pub(super) fn even(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.next_multiple_of(2))
}

/// `pixels` of `size` with the last column and row repeated where a side is odd.
pub(super) fn padded(pixels: &[u32], size: [u32; 2]) -> Cow<'_, [u32]> {
    let [width, height] = even(size).map(|side| side as usize);
    let [old_width, old_height] = size.map(|side| side as usize);
    if [width, height] == [old_width, old_height] {
        return Cow::Borrowed(pixels);
    }
    let at = |i: usize| pixels[(i / width).min(old_height - 1) * old_width + (i % width).min(old_width - 1)];
    Cow::Owned((0..width * height).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_sides_repeat_their_last_pixels() {
        assert_eq!(*padded(&[1, 2, 3, 4, 5, 6], [3, 2]), [1, 2, 3, 3, 4, 5, 6, 6]);
        assert_eq!(*padded(&[1, 2, 3], [1, 3]), [1, 1, 2, 2, 3, 3, 3, 3]);
        assert!(matches!(padded(&[1, 2, 3, 4], [2, 2]), Cow::Borrowed(_)));
    }
}
