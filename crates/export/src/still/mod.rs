//! Single pictures.

mod exr;
mod jpeg;
mod png;
mod read;

use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use meniscus_core::{Channel, Pixels};

use crate::beside::beside;
use crate::{ExportError, Format};

pub use read::{note_of, read_still};

/// Quality of JPEG pictures, 1 to 100, unless something else is asked for: no blocks to be seen, a sixth of a PNG.
pub const DEFAULT_JPEG_QUALITY: u8 = 92;

/// The name under which [`Still::note`] lies in a file.
const NOTE_KEY: &str = "meniscus";

/// A picture to be written.
#[derive(Clone, Copy, Debug)]
pub struct Still<'a> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// As many as `size` says.
    pub pixels: &'a Pixels,
    /// Whether alpha is written; else it is left out.
    pub with_alpha: bool,
    /// Numbers beside the colours, as many per channel as pixels; for OpenEXR only.
    pub channels: &'a [Channel],
    /// Latin text that comes along in the file: how the picture was made. May be empty.
    pub note: &'a str,
}

/// How pictures are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StillOptions {
    /// Of JPEG, 1 to 100.
    pub quality: u8,
}

impl Default for StillOptions {
    fn default() -> Self {
        Self { quality: DEFAULT_JPEG_QUALITY }
    }
}

/// Writes a picture in the format that the name of `path` ends in: display images as PNG (8 or 16 bits, as the pixels are) or
/// JPEG, linear ones as OpenEXR. Missing folders are made.
///
/// # Errors
/// [`ExportError`]: a format that cannot hold these pixels, or the system's; nothing is left under `path` then, and an older
/// file stays as it was.
///
/// # Panics
/// If there are not as many pixels as `size` says.
pub fn write_still(path: &Path, still: &Still<'_>, options: StillOptions) -> Result<(), ExportError> {
    let expected = still.size[0] as usize * still.size[1] as usize;
    assert_eq!(still.pixels.len(), expected, "pixels of a {:?} image", still.size);
    let io = |source| ExportError::Io { path: path.to_owned(), source };
    let mut beside = beside(path).map_err(io)?;
    let mut file = BufWriter::new(beside.as_file_mut());
    let encoded = match (Format::of(path)?, still.pixels) {
        (Format::Png, Pixels::Display8(_) | Pixels::Display16(_)) => png::encode(&mut file, still),
        (Format::Jpeg, Pixels::Display8(pixels)) => jpeg::encode(&mut file, still, pixels, options.quality),
        (Format::Exr, Pixels::Linear(pixels)) => exr::encode(&mut file, still, pixels),
        (format, pixels) => {
            let message = format!("{} pixels do not go into {format:?}", pixels.depth().as_str());
            return Err(ExportError::Unsuitable { path: path.to_owned(), message });
        }
    };
    encoded.map_err(|error| error.about(path))?;
    file.flush().map_err(io)?;
    drop(file);
    beside.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// A display image as a JPEG file, for the film at `path`.
pub(crate) fn compress_jpeg(
    path: &Path,
    size: [u32; 2],
    pixels: &[u32],
    quality: u8,
) -> Result<Vec<u8>, ExportError> {
    jpeg::compress(size, pixels, quality).map_err(|error| error.about(path))
}

/// What an encoder writes to.
trait Sink: Write + Seek {}

impl<W: Write + Seek> Sink for W {}

/// Why a picture could not be encoded.
enum EncodeError {
    /// The system refused.
    Io(std::io::Error),
    /// The encoder did, in its words.
    Encoder(String),
}

impl EncodeError {
    fn about(self, path: &Path) -> ExportError {
        match self {
            Self::Io(source) => ExportError::Io { path: path.to_owned(), source },
            Self::Encoder(message) => ExportError::Encode { path: path.to_owned(), message },
        }
    }
}

impl From<std::io::Error> for EncodeError {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

/// Red, green, blue and, with alpha, a fourth byte of each pixel of a display image.
pub(crate) fn channels(pixels: &[u32], with_alpha: bool) -> Vec<u8> {
    let channels = if with_alpha { 4 } else { 3 };
    pixels.iter().flat_map(|p| p.to_le_bytes().into_iter().take(channels)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of 3 x 2 pixels whose channels all differ.
    fn display() -> Pixels {
        Pixels::Display8(vec![0xff00_0001, 0xff00_0200, 0x8003_0000, 0x00ff_ffff, 0xff12_3456, 0xff00_0000])
    }

    fn still(pixels: &Pixels, with_alpha: bool) -> Still<'_> {
        Still { size: [3, 2], pixels, with_alpha, channels: &[], note: "a note" }
    }

    #[test]
    fn pixels_survive_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/out.png");
        let Pixels::Display8(expected) = display() else { unreachable!() };
        write_still(&path, &still(&display(), true), StillOptions::default()).unwrap();
        let read = image::open(&path).unwrap().into_rgba8();
        let back: Vec<u32> = read.pixels().map(|p| u32::from_le_bytes(p.0)).collect();
        assert_eq!(back, expected);
        write_still(&path, &still(&display(), false), StillOptions::default()).unwrap();
        assert_eq!(image::open(&path).unwrap().color().channel_count(), 3);
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn sixteen_bits_survive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        let values: Vec<[u16; 4]> = (0..6).map(|i| [i * 257 + 1, i, 65535 - i, 40_000]).collect();
        let pixels = Pixels::Display16(values.clone());
        write_still(&path, &still(&pixels, true), StillOptions::default()).unwrap();
        let read = image::open(&path).unwrap();
        assert_eq!(read.color(), image::ColorType::Rgba16);
        assert_eq!(read.into_rgba16().pixels().map(|p| p.0).collect::<Vec<_>>(), values);
        write_still(&path, &still(&pixels, false), StillOptions::default()).unwrap();
        assert_eq!(image::open(&path).unwrap().color(), image::ColorType::Rgb16);
    }

    #[test]
    fn radiance_above_one_survives_in_half_floats() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.exr");
        let values: Vec<[f32; 4]> = (0..6).map(|i| [0.1 * i as f32, 40.0 * i as f32, 1e-3, 0.25]).collect();
        let pixels = Pixels::Linear(values.clone());
        write_still(&path, &still(&pixels, true), StillOptions::default()).unwrap();
        let read = image::open(&path).unwrap().into_rgba32f();
        for (read, [r, g, b, a]) in read.pixels().zip(&values) {
            // Colours are multiplied by alpha in this format.
            for (read, expected) in read.0.iter().zip([r * a, g * a, b * a, *a]) {
                // A half float has eleven bits.
                assert!((read - expected).abs() <= expected / 2048.0, "{read} {expected}");
            }
        }
        write_still(&path, &still(&pixels, false), StillOptions::default()).unwrap();
        assert_eq!(image::open(&path).unwrap().color().channel_count(), 3);
    }

    #[test]
    fn jpeg_is_close_to_what_it_was_given_and_better_with_more_quality() {
        let folder = tempfile::tempdir().unwrap();
        let size = [32, 16];
        let pixels: Vec<u32> = (0..512).map(|i| 0xff00_0000 | (i / 32 * 9) << 8 | (i % 32 * 7)).collect();
        let pixels = Pixels::Display8(pixels);
        let error = |quality| {
            let path = folder.path().join("out.jpeg");
            let still = Still { size, pixels: &pixels, with_alpha: false, channels: &[], note: "" };
            write_still(&path, &still, StillOptions { quality }).unwrap();
            let read = image::open(&path).unwrap().into_rgb8();
            let Pixels::Display8(expected) = &pixels else { unreachable!() };
            let pairs = read.as_raw().iter().zip(channels(expected, false));
            pairs.map(|(a, b)| u64::from(a.abs_diff(b))).sum::<u64>()
        };
        // Two steps of 255 per channel.
        assert!(error(92) < 2 * 512 * 3, "{}", error(92));
        assert!(error(92) < error(30));
    }

    #[test]
    fn notes_are_found_again_in_every_format() {
        let folder = tempfile::tempdir().unwrap();
        let linear = Pixels::Linear(vec![[0.5; 4]; 6]);
        for (name, pixels) in [("a.png", &display()), ("a.jpg", &display()), ("a.exr", &linear)] {
            let path = folder.path().join(name);
            write_still(&path, &still(pixels, false), StillOptions::default()).unwrap();
            assert_eq!(note_of(&path, [3, 2]), Some("a note".to_owned()), "{name}");
            assert_eq!(note_of(&path, [3, 3]), None, "{name}: of another size");
            let bytes = std::fs::read(&path).unwrap();
            std::fs::write(&path, &bytes[..bytes.len() - bytes.len() / 4]).unwrap();
            assert_eq!(note_of(&path, [3, 2]), None, "{name}: cut off");
        }
        assert_eq!(note_of(&folder.path().join("none.png"), [3, 2]), None);
    }

    #[test]
    fn what_does_not_go_into_a_format_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let linear = Pixels::Linear(vec![[0.5; 4]; 6]);
        for (name, pixels) in [("a.exr", &display()), ("a.jpg", &linear), ("a.mp4", &display())] {
            let error =
                write_still(&folder.path().join(name), &still(pixels, false), StillOptions::default());
            assert!(matches!(error, Err(ExportError::Unsuitable { .. })), "{error:?}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    /// Whoever reads the old picture meanwhile, or is left with it after a power cut, has all of it: the new one takes over
    /// its name, not its bytes. A second name for the old file shows which of the two happened.
    #[test]
    fn an_older_picture_is_replaced_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let [path, second_name] = ["out.png", "old.png"].map(|name| folder.path().join(name));
        let write = |width: u32| {
            let pixels = Pixels::Display8(vec![0xff00_0001; width as usize]);
            let still =
                Still { size: [width, 1], pixels: &pixels, with_alpha: false, channels: &[], note: "" };
            write_still(&path, &still, StillOptions::default()).unwrap();
        };
        write(1);
        std::fs::hard_link(&path, &second_name).unwrap();
        write(2);
        let width = |path: &Path| image::open(path).unwrap().width();
        assert_eq!((width(&path), width(&second_name)), (2, 1));
    }

    #[test]
    fn an_unwritable_place_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "x").unwrap();
        let error = write_still(&file.join("out.png"), &still(&display(), false), StillOptions::default());
        assert!(error.unwrap_err().to_string().contains("out.png"));
    }
}
