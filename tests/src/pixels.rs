use std::path::Path;

use serde_json::Value;

/// An 8-bit image.
#[derive(Clone, PartialEq, Eq)]
pub struct Pixels {
    /// Width and height.
    pub size: [u32; 2],
    /// Red, green, blue, alpha, row by row from the top left; alpha is 255 where the file has none.
    pub rgba: Vec<[u8; 4]>,
}

impl Pixels {
    /// Reads a PNG file.
    ///
    /// # Panics
    /// When it is missing or not complete.
    pub fn read(path: &Path) -> Self {
        Self::try_read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    }

    /// [`Self::read`] for pictures that may be missing or damaged.
    ///
    /// # Errors
    /// In words.
    pub fn try_read(path: &Path) -> Result<Self, String> {
        let image = image::open(path).map_err(|e| e.to_string())?.into_rgba8();
        Ok(Self { size: [image.width(), image.height()], rgba: image.pixels().map(|p| p.0).collect() })
    }

    /// Writes red, green and blue as a PNG file; alpha is left out.
    ///
    /// # Errors
    /// In words.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let rgb = self.rgba.iter().flat_map(|p| p[..3].to_vec()).collect();
        let image = image::RgbImage::from_raw(self.size[0], self.size[1], rgb)
            .ok_or_else(|| format!("{} pixels are not {:?}", self.rgba.len(), self.size))?;
        let file = std::fs::File::create(path).map_err(|e| format!("{}: {e}", path.display()))?;
        // Committed pictures: small rather than quick.
        let encoder = image::codecs::png::PngEncoder::new_with_quality(
            file,
            image::codecs::png::CompressionType::Best,
            image::codecs::png::FilterType::Adaptive,
        );
        image.write_with_encoder(encoder).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// Mean absolute difference over all pixels and colours, in steps of 8 bits.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn mean_difference(&self, other: &Self) -> f64 {
        assert_eq!(self.size, other.size);
        let pairs = self.rgba.iter().zip(&other.rgba);
        let sum: u64 =
            pairs.flat_map(|(a, b)| a[..3].iter().zip(&b[..3]).map(|(a, b)| u64::from(a.abs_diff(*b)))).sum();
        sum as f64 / (3 * self.rgba.len()) as f64
    }

    /// Share of the pixels that are pure black, which nothing under a sky is: an image that was not drawn, or a NaN on its
    /// way to 8 bits.
    pub fn black_share(&self) -> f64 {
        self.rgba.iter().filter(|p| p[..3] == [0; 3]).count() as f64 / self.rgba.len() as f64
    }

    /// Number of different colours; few mean that nothing was drawn.
    pub fn colours(&self) -> usize {
        self.rgba.iter().collect::<std::collections::HashSet<_>>().len()
    }
}

/// The JSON file at `path`.
///
/// # Panics
/// When it is none.
pub fn read_json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
