//! The pixels of a picture as something to draw on.

use meniscus_core::Pixels;

/// A picture in display colours. Colours blend as they are coded, as text usually does.
pub struct Canvas<'a> {
    pixels: &'a mut Pixels,
    size: [usize; 2],
}

/// How much of each pixel of a rectangle is covered.
pub struct Mask {
    pub left: i64,
    pub top: i64,
    pub size: [usize; 2],
    /// Row by row, 0 to 1.
    pub coverage: Vec<f32>,
}

/// Darkness of the halo that makes white readable on white.
const HALO: f32 = 0.6;

impl Mask {
    /// Nothing covered in a rectangle of `size` pixels with this top left corner.
    pub fn new(left: i64, top: i64, size: [usize; 2]) -> Self {
        Self { left, top, size, coverage: vec![0.0; size[0] * size[1]] }
    }

    /// Covers a pixel, in coordinates of the rectangle, at least this much; nothing outside of it.
    pub fn cover(&mut self, x: i64, y: i64, coverage: f32) {
        let [width, height] = self.size;
        if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
            && x < width
            && y < height
        {
            let pixel = &mut self.coverage[y * width + x];
            *pixel = pixel.max(coverage.clamp(0.0, 1.0));
        }
    }

    /// The same, grown by `radius` pixels with a soft edge.
    fn grown(&self, radius: usize) -> Self {
        let by = radius as i64;
        let size = self.size.map(|side| side + 2 * radius);
        let mut grown = Self::new(self.left - by, self.top - by, size);
        for y in 0..self.size[1] {
            for x in 0..self.size[0] {
                let coverage = self.coverage[y * self.size[0] + x];
                if coverage == 0.0 {
                    continue;
                }
                for dy in -by..=by {
                    for dx in -by..=by {
                        let distance = ((dx * dx + dy * dy) as f32).sqrt();
                        let share = 1.0 - distance / (radius as f32 + 1.0);
                        grown.cover(x as i64 + by + dx, y as i64 + by + dy, coverage * share);
                    }
                }
            }
        }
        grown
    }
}

impl<'a> Canvas<'a> {
    /// A display image of `size` = `[width, height]`; `None` for linear pixels, which are data and no picture to write on.
    ///
    /// # Panics
    /// If there are not as many pixels as `size` says.
    pub fn new(pixels: &'a mut Pixels, size: [u32; 2]) -> Option<Self> {
        let size = size.map(|side| side as usize);
        assert_eq!(pixels.len(), size[0] * size[1], "pixels of a picture of {size:?}");
        (!matches!(pixels, Pixels::Linear(_))).then_some(Self { pixels, size })
    }

    /// `[width, height]` in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Paints what `mask` covers in white with a dark halo of `radius` pixels.
    pub fn write(&mut self, mask: &Mask, radius: usize) {
        self.fill(&mask.grown(radius), |_, _| [0.0; 3], HALO);
        self.fill(mask, |_, _| [1.0; 3], 1.0);
    }

    /// Paints what `mask` covers, in the colour (sRGB, 0 to 1) of each of its pixels.
    pub fn fill(&mut self, mask: &Mask, color: impl Fn(usize, usize) -> [f32; 3], opacity: f32) {
        for y in 0..mask.size[1] {
            for x in 0..mask.size[0] {
                let coverage = opacity * mask.coverage[y * mask.size[0] + x];
                if coverage > 0.0 {
                    self.blend(mask.left + x as i64, mask.top + y as i64, color(x, y), coverage);
                }
            }
        }
    }

    fn blend(&mut self, x: i64, y: i64, color: [f32; 3], coverage: f32) {
        let [width, height] = self.size;
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x >= width || y >= height {
            return;
        }
        let index = y * width + x;
        match self.pixels {
            Pixels::Display8(pixels) => {
                let old = pixels[index].to_le_bytes().map(|c| f32::from(c) / 255.0);
                let new = over(old, color, coverage).map(|c| (c * 255.0).round() as u8);
                pixels[index] = u32::from_le_bytes(new);
            }
            Pixels::Display16(pixels) => {
                let old = pixels[index].map(|c| f32::from(c) / 65535.0);
                pixels[index] = over(old, color, coverage).map(|c| (c * 65535.0).round() as u16);
            }
            Pixels::Linear(_) => {}
        }
    }
}

/// A colour over a pixel; alpha is not multiplied into colours.
fn over([r, g, b, alpha]: [f32; 4], color: [f32; 3], coverage: f32) -> [f32; 4] {
    let rest = alpha * (1.0 - coverage);
    let sum = coverage + rest;
    let mix = |old: f32, new: f32| if sum > 0.0 { (new * coverage + old * rest) / sum } else { old };
    [mix(r, color[0]), mix(g, color[1]), mix(b, color[2]), sum]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_cover_what_is_there_in_any_depth_and_stay_within_the_picture() {
        let mut mask = Mask::new(-1, -1, [3, 3]);
        mask.coverage.fill(0.5);
        let mut shallow = Pixels::Display8(vec![0xff00_0000, 0x0000_0000]);
        let mut deep = Pixels::Display16(vec![[0, 0, 0, 65535], [0; 4]]);
        for pixels in [&mut shallow, &mut deep] {
            Canvas::new(pixels, [2, 1]).unwrap().fill(&mask, |_, _| [1.0, 0.0, 0.0], 1.0);
        }
        // Half of it over black, and all that there is where nothing was.
        assert_eq!(shallow, Pixels::Display8(vec![0xff00_0080, 0x8000_00ff]));
        assert_eq!(deep, Pixels::Display16(vec![[32768, 0, 0, 65535], [65535, 0, 0, 32768]]));
        assert!(Canvas::new(&mut Pixels::Linear(vec![[0.0; 4]]), [1, 1]).is_none());
    }

    #[test]
    fn white_is_readable_on_white() {
        let mut pixels = Pixels::Display8(vec![0xffff_ffff; 81]);
        let mut mask = Mask::new(4, 4, [1, 1]);
        mask.cover(0, 0, 1.0);
        Canvas::new(&mut pixels, [9, 9]).unwrap().write(&mask, 2);
        let Pixels::Display8(pixels) = pixels else { unreachable!() };
        assert_eq!((pixels[40], pixels[0]), (0xffff_ffff, 0xffff_ffff));
        assert!(pixels[41] & 0xff < 180 && pixels[42] & 0xff < 230 && pixels[43] == 0xffff_ffff);
    }
}
