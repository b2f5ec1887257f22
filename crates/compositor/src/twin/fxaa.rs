//! CPU twin of `shaders/compositor/fxaa_edges.wgsl` and `fxaa.wgsl`.

use glam::{IVec2, Vec4};

const MIN_CONTRAST: f32 = 0.035;
const RELATIVE_CONTRAST: f32 = 0.085;
const WEIGHTS: [f32; 2] = [0.8, 0.2];
const SEARCH: i32 = 10;

/// A picture and its brightness, row by row from the top left.
#[derive(Debug)]
pub struct Picture<'a> {
    /// Display colours and alpha, each in [0, 1].
    pub colors: &'a [[f32; 4]],
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Whether alpha is coverage.
    pub transparent: bool,
}

impl Picture<'_> {
    fn at(&self, pixel: IVec2) -> Vec4 {
        let size = IVec2::from_array(self.size.map(|side| side as i32));
        let p = pixel.clamp(IVec2::ZERO, size - 1);
        self.colors[(p.y * size.x + p.x) as usize].into()
    }

    /// Brightness in steps, 0 to 255, whole numbers: with the same ties as on the GPU.
    fn luma(&self, pixel: IVec2) -> f32 {
        let color = self.at(pixel);
        let luma = color.truncate().truncate().dot(WEIGHTS.into());
        (255.0 * if self.transparent { (luma + 0.5 * color.w) / 1.5 } else { luma }).round()
    }

    /// Whether the brightness, 0 to 1.5 with that of alpha, changes by `contrast` steps up to `brightest` as it does at edges.
    fn is_edge(&self, contrast: f32, brightest: f32) -> bool {
        let (scale, offset) = if self.transparent { (1.5 / 255.0, 0.0) } else { (1.0 / 255.0, 0.5) };
        scale * contrast >= MIN_CONTRAST.max(RELATIVE_CONTRAST * (scale * brightest + offset))
    }

    fn edge_end(&self, pixel: IVec2, along: IVec2, across: IVec2, mean: f32, gradient: f32) -> (f32, f32) {
        let mut difference = 0.0;
        for i in 1..=SEARCH {
            let p = pixel + i * along;
            difference = 0.5 * (self.luma(p) + self.luma(p + across)) - mean;
            if difference.abs() >= gradient {
                return (i as f32, difference);
            }
        }
        (SEARCH as f32, difference)
    }

    /// The pixel after anti-aliasing (Lottes 2009, FXAA): mixed with the neighbour across the edge by the share of the pixel that
    /// the true edge would cut off.
    pub fn smoothed(&self, [x, y]: [u32; 2]) -> [f32; 4] {
        let pixel = IVec2::new(x as i32, y as i32);
        let luma = |x, y| self.luma(pixel + IVec2::new(x, y));
        let [n, s, w, e, m] = [luma(0, -1), luma(0, 1), luma(-1, 0), luma(1, 0), luma(0, 0)];
        let brightest = m.max(n).max(s).max(w).max(e);
        let contrast = brightest - m.min(n).min(s).min(w).min(e);
        if !self.is_edge(contrast, brightest) {
            return self.at(pixel).to_array();
        }
        let [nw, ne, sw, se] = [luma(-1, -1), luma(1, -1), luma(-1, 1), luma(1, 1)];
        let horizontal =
            (nw - 2.0 * w + sw).abs() + 2.0 * (n - 2.0 * m + s).abs() + (ne - 2.0 * e + se).abs();
        let vertical = (nw - 2.0 * n + ne).abs() + 2.0 * (w - 2.0 * m + e).abs() + (sw - 2.0 * s + se).abs();
        let is_horizontal = horizontal >= vertical;
        let (before, after, axis) = if is_horizontal { (n, s, IVec2::Y) } else { (w, e, IVec2::X) };
        let is_before = (before - m).abs() >= (after - m).abs();
        let (opposite, across) = if is_before { (before, -axis) } else { (after, axis) };
        let along = IVec2::new(axis.y, axis.x);
        let mean = 0.5 * (m + opposite);
        let gradient = 0.25 * (opposite - m).abs();
        let forward = self.edge_end(pixel, along, across, mean, gradient);
        let backward = self.edge_end(pixel, -along, across, mean, gradient);
        let nearest = if forward.0 < backward.0 { forward } else { backward };
        let cut = if (nearest.1 < 0.0) != (m < mean) {
            (0.5 - nearest.0 / (forward.0 + backward.0)).max(0.0)
        } else {
            0.0
        };
        let around = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
        let t = ((around - m).abs() / contrast).clamp(0.0, 1.0);
        let stands_out = t * t * (3.0 - 2.0 * t);
        let blend = cut.max(0.5 * stands_out * stands_out);
        self.at(pixel).lerp(self.at(pixel + across), blend).to_array()
    }
}
