use crate::Pixels;

/// Which pixels of a picture show water.
#[derive(Clone, PartialEq, Eq)]
pub struct Mask {
    size: [usize; 2],
    water: Vec<bool>,
}

impl Mask {
    /// From one flag per pixel, row by row from the top left.
    ///
    /// # Panics
    /// When their number is not that of the pixels.
    pub fn new(size: [u32; 2], water: Vec<bool>) -> Self {
        let size = size.map(|side| side as usize);
        assert_eq!(water.len(), size[0] * size[1]);
        Self { size, water }
    }

    /// From a picture that was drawn transparent and without a floor: alpha is the coverage by water.
    pub fn of_alpha(picture: &Pixels) -> Self {
        Self::new(picture.size, picture.rgba.iter().map(|p| p[3] >= 128).collect())
    }

    /// Whether both are of pictures of one size.
    pub fn has_size(&self, other: &Self) -> bool {
        self.size == other.size
    }

    /// Water in either. Both have the same size.
    pub fn union(&self, other: &Self) -> Self {
        let either = self.water.iter().zip(&other.water).map(|(a, b)| *a || *b).collect();
        Self { size: self.size, water: either }
    }

    /// Wider by `margin` pixels in every direction.
    pub fn dilated(&self, margin: usize) -> Self {
        let [width, height] = self.size;
        let near = |x: usize, y: usize| {
            let columns = x.saturating_sub(margin)..(x + margin + 1).min(width);
            (y.saturating_sub(margin)..(y + margin + 1).min(height))
                .any(|row| self.water[row * width..][columns.clone()].contains(&true))
        };
        Self { size: self.size, water: (0..self.water.len()).map(|i| near(i % width, i / width)).collect() }
    }

    /// The values, one per pixel, where water is.
    pub fn pick(&self, values: &[f32]) -> Vec<f32> {
        values.iter().zip(&self.water).filter(|(_, water)| **water).map(|(value, _)| *value).collect()
    }

    /// White where water is, else black.
    pub fn picture(&self) -> Pixels {
        let colour = |water: &bool| if *water { [255; 4] } else { [0, 0, 0, 255] };
        Pixels { size: self.size.map(|side| side as u32), rgba: self.water.iter().map(colour).collect() }
    }

    /// Number of pixels that show water.
    pub fn area(&self) -> usize {
        self.water.iter().filter(|w| **w).count()
    }

    /// Share of the picture that shows water.
    pub fn share(&self) -> f64 {
        self.area() as f64 / self.water.len() as f64
    }

    /// `[left, right, top, bottom]`: first and last column and row that show water, as parts of width and height from 0 to
    /// 1; `None` without water.
    pub fn bounds(&self) -> Option<[f64; 4]> {
        let [width, height] = self.size;
        let column = |x: &usize| (0..height).any(|y| self.water[y * width + *x]);
        let row = |y: &usize| self.water[y * width..(y + 1) * width].contains(&true);
        let across = |x: usize| x as f64 / width as f64;
        let down = |y: usize| y as f64 / height as f64;
        Some([
            across((0..width).find(column)?),
            across((0..width).rev().find(column)? + 1),
            down((0..height).find(row)?),
            down((0..height).rev().find(row)? + 1),
        ])
    }

    /// Mean row of the water from 0 (top) to 1 (bottom); NaN without water.
    pub fn mean_row(&self) -> f64 {
        let [width, height] = self.size;
        let sum: usize = self.water.iter().enumerate().filter(|(_, w)| **w).map(|(i, _)| i / width).sum();
        (sum as f64 / self.area() as f64 + 0.5) / height as f64
    }

    /// Pixels without water that water encloses: those that no way through pixels without water, over edges or corners,
    /// connects with the picture's border (a notch in a scalloped silhouette is none). As a share of the water's area.
    pub fn hole_share(&self) -> f64 {
        let [width, height] = self.size;
        let mut outside = vec![false; self.water.len()];
        let on_border = |i: &usize| {
            let (x, y) = (i % width, i / width);
            x == 0 || y == 0 || x == width - 1 || y == height - 1
        };
        let mut open: Vec<usize> = (0..self.water.len()).filter(on_border).collect();
        while let Some(i) = open.pop() {
            if self.water[i] || std::mem::replace(&mut outside[i], true) {
                continue;
            }
            let (x, y) = (i % width, i / width);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                open.extend((x.saturating_sub(1)..(x + 2).min(width)).map(|column| row * width + column));
            }
        }
        let holes = self.water.iter().zip(&outside).filter(|(water, outside)| !**water && !**outside).count();
        holes as f64 / self.area().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str]) -> Mask {
        let size = [rows[0].len() as u32, rows.len() as u32];
        Mask::new(size, rows.iter().flat_map(|row| row.chars().map(|c| c == '#')).collect())
    }

    #[test]
    fn only_enclosed_pixels_are_holes() {
        assert_eq!(mask(&[".....", ".###.", ".#.#.", ".###.", "....."]).hole_share(), 1.0 / 8.0);
        // Open to the right, and over a corner.
        assert_eq!(mask(&[".....", ".###.", ".#...", ".###.", "....."]).hole_share(), 0.0);
        assert_eq!(mask(&["....", ".##.", ".#.#", ".###"]).hole_share(), 0.0);
        assert_eq!(mask(&["...", "..."]).hole_share(), 0.0);
    }

    #[test]
    fn masks_grow_in_every_direction_and_join() {
        let dot = mask(&[".....", ".....", "..#..", ".....", "....."]);
        assert!(dot.dilated(1) == mask(&[".....", ".###.", ".###.", ".###.", "....."]));
        assert_eq!(dot.dilated(9).area(), 25);
        assert!(mask(&["#.."]).union(&mask(&["..#"])) == mask(&["#.#"]));
        assert_eq!(mask(&["#.#"]).pick(&[1.0, 2.0, 3.0]), [1.0, 3.0]);
    }

    #[test]
    fn bounds_share_and_mean_row() {
        let some = mask(&["....", "..#.", "..#.", "...."]);
        assert_eq!(some.bounds(), Some([0.5, 0.75, 0.25, 0.75]));
        assert_eq!(some.share(), 0.125);
        assert_eq!(some.mean_row(), 0.5);
        assert_eq!(mask(&["..."]).bounds(), None);
    }
}
