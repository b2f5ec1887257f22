//! What the colours mean.

use meniscus_color::ColorScale;

use crate::canvas::{Canvas, Mask};
use crate::number::written;
use crate::text;

/// Most ticks.
const TICKS: usize = 6;

/// Draws the legend of `scale` at the right edge, in lines of `line_px` pixels: the name above a bar with ticks. The pointed ends
/// are the colours of all that lies beyond.
pub fn draw(canvas: &mut Canvas<'_>, scale: &ColorScale, line_px: f32, halo_px: usize) {
    let [width, height] = canvas.size().map(|side| side as f32);
    let ticks = scale.ticks(TICKS);
    let step = match ticks.as_slice() {
        // Of a logarithmic scale, the smallest tick has the most digits.
        [first, ..] if scale.log => *first,
        [first, second, ..] => second - first,
        _ => ticks[0].abs(),
    };
    let labels: Vec<String> = ticks.iter().map(|tick| written(*tick, step)).collect();
    let label_width = labels.iter().map(|label| text::width(label, line_px)).fold(0.0, f32::max);
    let bar_width = 0.7 * line_px;
    let bar_height = (0.5 * height).min(14.0 * line_px).round();
    let left = (width - line_px - label_width - 0.5 * line_px - bar_width).floor();
    let top = (0.5 * (height - bar_height)).round();

    let name = scale.quantity.to_string();
    let name_left = (width - line_px - text::width(&name, line_px)).min(left).max(0.0);
    let above = top - bar_width - 1.5 * line_px;
    canvas.write(&text::line(&name, line_px, [name_left, above]), halo_px);

    let (mask, first_row) = bar(left, top, bar_width, bar_height);
    let color = |_: usize, y: usize| {
        let place = 1.0 - (y as f32 - first_row + 0.5) / bar_height;
        scale.map.srgb(f64::from(place)).to_array()
    };
    canvas.write(&mask, halo_px);
    canvas.fill(&mask, color, 1.0);
    for (tick, label) in ticks.iter().zip(&labels) {
        let place = scale.position(*tick).unwrap_or(0.0) as f32;
        let y = top + (1.0 - place) * bar_height;
        let mut mark =
            Mask::new((left + bar_width) as i64, y.round() as i64 - 1, [(0.3 * line_px) as usize + 1, 2]);
        mark.coverage.fill(1.0);
        canvas.write(&mark, halo_px);
        let at = [left + bar_width + 0.5 * line_px, y - 0.5 * line_px];
        canvas.write(&text::line(label, line_px, at), halo_px);
    }
}

/// The bar with a triangle at either end, and the row of the mask in which the bar itself begins.
fn bar(left: f32, top: f32, width: f32, height: f32) -> (Mask, f32) {
    let point = width.ceil();
    let size = [width.ceil() as usize, (height + 2.0 * point) as usize];
    let mut mask = Mask::new(left as i64, (top - point) as i64, size);
    for y in 0..size[1] {
        let beyond = (point - y as f32 - 0.5).max(y as f32 + 0.5 - point - height).max(0.0);
        let half = 0.5 * width * (1.0 - beyond / point);
        for x in 0..size[0] {
            let inside = half - (x as f32 + 0.5 - 0.5 * width).abs() + 0.5;
            mask.cover(x as i64, y as i64, inside);
        }
    }
    (mask, point)
}

#[cfg(test)]
mod tests {
    use meniscus_color::ColorMap;
    use meniscus_core::Pixels;

    use super::*;

    /// The colours of the bar are those of the values that the ticks name, in their places.
    #[test]
    fn the_bar_has_the_colours_of_its_ticks() {
        let size = [640, 480];
        let scale = ColorScale::new("v".parse().unwrap(), ColorMap::Viridis, [0.0, 10.0], false).unwrap();
        let mut pixels = Pixels::Display8(vec![0xff80_8080; 640 * 480]);
        draw(&mut Canvas::new(&mut pixels, size).unwrap(), &scale, 16.0, 2);
        let Pixels::Display8(pixels) = pixels else { unreachable!() };
        // The middle column of the bar: where the purple start of the map is.
        let dark = |x: usize| pixels[355 * 640 + x].to_le_bytes();
        let column = (0..640)
            .find(|&x| {
                let [r, g, b, _] = dark(x);
                b > 80 && g < 20 && r > 60
            })
            .expect("the bar")
            + 5;
        let color = |y: usize| pixels[y * 640 + column].to_le_bytes();
        let height = 224.0_f32;
        for value in [0.5, 2.0, 5.0, 9.5] {
            let y = 240.0 + height * (0.5 - value / 10.0);
            let expected = scale.map.srgb(f64::from(value) / 10.0).to_array();
            for (found, expected) in color(y as usize).iter().zip(expected) {
                // Two rows, of 224 for 10.
                assert!(
                    (f32::from(*found) / 255.0 - expected).abs() < 0.03,
                    "{value}: {:?}",
                    color(y as usize)
                );
            }
        }
        // Nothing in the left half.
        assert!((0..480).all(|y| (0..320).all(|x| pixels[y * 640 + x] == 0xff80_8080)));
    }

    #[test]
    fn any_picture_and_any_scale_will_do() {
        for (min, max, log) in
            [(0.0, 0.0, false), (-1e300, 1e300, false), (1e-30, 1e30, true), (999.0, 999.001, false)]
        {
            let scale =
                ColorScale::new("pressure".parse().unwrap(), ColorMap::Turbo, [min, max], log).unwrap();
            for size in [[1, 1], [3, 200], [200, 3], [300, 200]] {
                let mut pixels = Pixels::Display8(vec![0; (size[0] * size[1]) as usize]);
                draw(&mut Canvas::new(&mut pixels, size).unwrap(), &scale, 12.0, 1);
            }
        }
    }
}
