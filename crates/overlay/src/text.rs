//! Lines of text as masks.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, PxScale, ScaleFont};

use crate::canvas::Mask;

static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT).expect("the font that comes along is one")
});

/// Width of a line of text in pixels.
pub fn width(text: &str, height_px: f32) -> f32 {
    let font = FONT.as_scaled(PxScale::from(height_px));
    let mut before = None;
    text.chars()
        .map(|c| {
            let glyph = font.glyph_id(c);
            let kern = before.replace(glyph).map_or(0.0, |before| font.kern(before, glyph));
            kern + font.h_advance(glyph)
        })
        .sum()
}

/// A line of text with its top left corner at `(left, top)`.
pub fn line(text: &str, height_px: f32, [left, top]: [f32; 2]) -> Mask {
    let scale = PxScale::from(height_px);
    let font = FONT.as_scaled(scale);
    let (whole_left, whole_top) = (left.floor(), top.floor());
    let size = [width(text, height_px).ceil() as usize + 2, height_px.ceil() as usize + 2];
    let mut mask = Mask::new(whole_left as i64, whole_top as i64, size);
    let (mut x, y) = (left - whole_left, top - whole_top + font.ascent());
    let mut before = None;
    for c in text.chars() {
        let id = font.glyph_id(c);
        x += before.replace(id).map_or(0.0, |before| font.kern(before, id));
        let glyph = id.with_scale_and_position(scale, ab_glyph::point(x, y));
        x += font.h_advance(id);
        let Some(outline) = FONT.outline_glyph(glyph) else { continue };
        let corner = outline.px_bounds().min;
        outline.draw(|dx, dy, coverage| {
            mask.cover(corner.x as i64 + i64::from(dx), corner.y as i64 + i64::from(dy), coverage);
        });
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_as_wide_as_they_say_and_digits_all_alike() {
        let mask = line("t = 0.25 s", 20.0, [3.5, 7.0]);
        assert_eq!((mask.left, mask.top), (3, 7));
        let columns = |from: usize| (0..mask.size[1]).any(|y| mask.coverage[y * mask.size[0] + from] > 0.3);
        let last = (0..mask.size[0]).rev().find(|&x| columns(x)).expect("something is written");
        let end = 0.5 + width("t = 0.25 s", 20.0);
        assert!((last as f32) < end && last as f32 > end - 4.0, "{last}, {end}");
        // Times do not jump about while they count.
        let one = width("1111", 30.0);
        assert!(["0000", "4444", "8888"].iter().all(|text| (width(text, 30.0) - one).abs() < 0.1));
        assert!(line("", 20.0, [0.0; 2]).coverage.iter().all(|c| *c == 0.0));
    }
}
