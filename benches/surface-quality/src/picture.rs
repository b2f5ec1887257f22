//! Normals of several surfaces beside each other.

use std::error::Error;
use std::fs::File;
use std::path::Path;

use glam::Vec3;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{self, FilterType};
use image::{Rgb, RgbImage};

use crate::surface::Surface;

/// Of each picture, pixels.
const WIDTH: u32 = 480;
/// Between pictures, pixels.
const GAP: u32 = 4;
const QUALITY: u8 = 85;

/// Writes one row of pictures of `size` per entry of `rows`, made smaller, as a JPEG.
///
/// # Errors
/// The file's.
pub fn write(path: &Path, rows: &[Vec<Surface>], size: [u32; 2]) -> Result<(), Box<dyn Error>> {
    let height = WIDTH * size[1] / size[0];
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let [width, whole] =
        [(columns, WIDTH), (rows.len() as u32, height)].map(|(n, side)| n.max(1) * (side + GAP) - GAP);
    let mut sheet = RgbImage::from_pixel(width, whole, Rgb([255; 3]));
    for (row, surfaces) in (0_i64..).zip(rows) {
        for (column, surface) in (0_i64..).zip(surfaces) {
            let at = |x, y| color(surface.normal[(y * size[0] + x) as usize]);
            let picture = RgbImage::from_fn(size[0], size[1], at);
            let picture = imageops::resize(&picture, WIDTH, height, FilterType::Triangle);
            let [x, y] = [(column, WIDTH), (row, height)].map(|(n, side)| n * i64::from(side + GAP));
            imageops::replace(&mut sheet, &picture, x, y);
        }
    }
    sheet.write_with_encoder(JpegEncoder::new_with_quality(File::create(path)?, QUALITY))?;
    Ok(())
}

/// From -1..1 to 0..255; white where there is no surface.
fn color(normal: Vec3) -> Rgb<u8> {
    if normal == Vec3::ZERO {
        return Rgb([255; 3]);
    }
    Rgb((normal * 127.5 + 127.5).to_array().map(|c| c.round() as u8))
}
