use meniscus_color::ColorScale;
use meniscus_core::Pixels;

use crate::canvas::{Canvas, Mask};
use crate::{ScaleBar, legend, text};

/// What is written over a picture; what is `None` is not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// A line of text at the top left.
    pub text: Option<String>,
    /// The time, under the text.
    pub time: Option<String>,
    /// What the colours mean, at the right.
    pub legend: Option<ColorScale>,
    /// A length, at the bottom left.
    pub scale: Option<ScaleBar>,
}

/// A line of text is this share of a picture's height, but not smaller than can be read.
const LINE: f32 = 1.0 / 32.0;
const LEAST_LINE_PX: f32 = 11.0;

impl Overlay {
    /// Draws on a display image of `size` = `[width, height]`; linear pixels stay as they are. What does not fit is cut off.
    ///
    /// # Panics
    /// If there are not as many pixels as `size` says.
    pub fn draw(&self, pixels: &mut Pixels, size: [u32; 2]) {
        let Some(mut canvas) = Canvas::new(pixels, size) else { return };
        let height = size[1] as f32;
        let line_px = (LINE * height).max(LEAST_LINE_PX);
        let halo_px = (line_px / 8.0).ceil() as usize;
        for (number, line) in self.text.iter().chain(&self.time).enumerate() {
            let at = [line_px, line_px * (0.8 + 1.25 * number as f32)];
            canvas.write(&text::line(line, line_px, at), halo_px);
        }
        if let Some(scale) = &self.legend {
            legend::draw(&mut canvas, scale, line_px, halo_px);
        }
        if let Some(bar) = &self.scale {
            let bottom = height - line_px;
            canvas.write(&ruler(bar.length_px, line_px, bottom), halo_px);
            let at = [line_px, bottom - 1.6 * line_px];
            canvas.write(&text::line(&bar.label, line_px, at), halo_px);
        }
    }
}

/// A horizontal line with a stop at either end, standing on `bottom`.
fn ruler(length_px: f32, line_px: f32, bottom: f32) -> Mask {
    let (stop, thick) = ((0.4 * line_px).round() as usize, (line_px / 10.0).round().max(1.0) as usize);
    let width = length_px.round() as usize;
    let mut mask = Mask::new(line_px as i64, bottom as i64 - stop as i64, [width.max(1), stop.max(thick)]);
    let [width, height] = mask.size;
    for y in 0..height {
        for x in 0..width {
            let is_line = y + thick >= height || x < thick || x + thick >= width;
            mask.cover(x as i64, y as i64, f32::from(u8::from(is_line)));
        }
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREY: u32 = 0xff80_8080;

    /// The box around what was drawn: first and last column, first and last row.
    fn drawn(overlay: &Overlay, size: [u32; 2]) -> Option<[usize; 4]> {
        let mut pixels = Pixels::Display8(vec![GREY; (size[0] * size[1]) as usize]);
        overlay.draw(&mut pixels, size);
        let Pixels::Display8(pixels) = pixels else { unreachable!() };
        let changed = || pixels.iter().enumerate().filter(|(_, p)| **p != GREY).map(|(i, _)| i);
        let (columns, rows) =
            (|| changed().map(|i| i % size[0] as usize), || changed().map(|i| i / size[0] as usize));
        Some([columns().min()?, columns().max()?, rows().min()?, rows().max()?])
    }

    #[test]
    fn everything_has_its_corner() {
        let size = [640, 480];
        assert_eq!(drawn(&Overlay::default(), size), None);
        let text = Overlay { text: Some("Dam break".into()), ..Default::default() };
        let [_, right, top, bottom] = drawn(&text, size).unwrap();
        assert!(right < 200 && top > 3 && bottom < 40);
        // The time takes the place of a text that is not there, and else comes under it.
        let time = Overlay { time: Some("t = 1".into()), ..Default::default() };
        assert!(drawn(&time, size).unwrap()[3] < 40);
        let both = Overlay { text: text.text.clone(), ..time };
        assert!(drawn(&both, size).unwrap()[3] > 40);
        let bar = ScaleBar { length_px: 100.0, label: "1 m".into() };
        let [left, right, top, bottom] =
            drawn(&Overlay { scale: Some(bar), ..Default::default() }, size).unwrap();
        // With the halo of two pixels.
        assert_eq!((right - left + 1, bottom < 470, top > 420), (104, true, true));
    }

    #[test]
    fn pictures_of_any_size_are_written_on() {
        let overlay = Overlay {
            text: Some("Ä long text with a \u{1F30A} that no font has".repeat(20)),
            time: Some("t = 1".into()),
            scale: Some(ScaleBar { length_px: 1e4, label: "far".into() }),
            legend: None,
        };
        for size in [[1, 1], [7, 300], [300, 7]] {
            let _ = drawn(&overlay, size);
        }
        // What does not fit ends at the edge.
        assert_eq!(drawn(&overlay, [300, 200]).unwrap()[1], 299);
    }
}
