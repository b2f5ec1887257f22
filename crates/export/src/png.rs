use std::io::{BufWriter, Write};
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::ExportError;
use crate::text::beside;

/// Writes a display image (sRGB, red in the lowest byte, row by row from the top left) as an 8-bit PNG; without
/// `with_alpha` the fourth channel is left out. Missing folders are made.
///
/// # Errors
/// [`ExportError::Io`] or [`ExportError::Encode`]; nothing is left under `path` then, and an older file stays as it was.
///
/// # Panics
/// If `pixels` is not `width * height` long.
pub fn write_png(path: &Path, size: [u32; 2], pixels: &[u32], with_alpha: bool) -> Result<(), ExportError> {
    assert_eq!(pixels.len(), size[0] as usize * size[1] as usize, "pixels of a {size:?} image");
    let io = |source| ExportError::Io { path: path.to_owned(), source };
    let mut beside = beside(path).map_err(io)?;

    let channels = if with_alpha { 4 } else { 3 };
    let bytes: Vec<u8> = pixels.iter().flat_map(|p| p.to_le_bytes().into_iter().take(channels)).collect();
    let color = if with_alpha { ExtendedColorType::Rgba8 } else { ExtendedColorType::Rgb8 };
    let mut file = BufWriter::new(beside.as_file_mut());
    PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive)
        .write_image(&bytes, size[0], size[1], color)
        .map_err(|e| match e {
            image::ImageError::IoError(source) => io(source),
            other => ExportError::Encode { path: path.to_owned(), message: other.to_string() },
        })?;
    file.flush().map_err(io)?;
    drop(file);
    beside.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_survive_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/out.png");
        let pixels = [0xff00_0001, 0xff00_0200, 0x8003_0000, 0x00ff_ffff, 0xff12_3456, 0xff00_0000];
        write_png(&path, [3, 2], &pixels, true).unwrap();
        let read = image::open(&path).unwrap().into_rgba8();
        let back: Vec<u32> = read.pixels().map(|p| u32::from_le_bytes(p.0)).collect();
        assert_eq!(back, pixels);
        write_png(&path, [3, 2], &pixels, false).unwrap();
        assert_eq!(image::open(&path).unwrap().color().channel_count(), 3);
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    /// Whoever reads the old picture meanwhile, or is left with it after a power cut, has all of it: the new one takes over
    /// its name, not its bytes. A second name for the old file shows which of the two happened.
    #[test]
    fn an_older_picture_is_replaced_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let [path, second_name] = ["out.png", "old.png"].map(|name| folder.path().join(name));
        write_png(&path, [1, 1], &[0xff00_0001], false).unwrap();
        std::fs::hard_link(&path, &second_name).unwrap();
        write_png(&path, [2, 1], &[0xff00_0002; 2], false).unwrap();
        let width = |path: &Path| image::open(path).unwrap().width();
        assert_eq!((width(&path), width(&second_name)), (2, 1));
    }

    #[test]
    fn an_unwritable_place_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "x").unwrap();
        let error = write_png(&file.join("out.png"), [1, 1], &[0], false).unwrap_err();
        assert!(error.to_string().contains("out.png"), "{error}");
    }
}
