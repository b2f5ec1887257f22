use std::path::Path;

use meniscus_core::PixelDepth;

use crate::ExportError;

/// A kind of file, by the ending of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 or 16 bits per channel, without loss.
    Png,
    /// 8 bits, smaller, with loss.
    Jpeg,
    /// Linear radiance in half floats, before exposure and tone mapping.
    Exr,
    /// H.264 film.
    Mp4,
    /// Motion JPEG film, every picture on its own.
    Avi,
    /// Films in containers that only ffmpeg writes.
    Mkv,
    /// See [`Self::Mkv`].
    Mov,
    /// See [`Self::Mkv`].
    Webm,
}

/// Endings in lower case.
const ENDINGS: [(&str, Format); 9] = [
    ("png", Format::Png),
    ("jpg", Format::Jpeg),
    ("jpeg", Format::Jpeg),
    ("exr", Format::Exr),
    ("mp4", Format::Mp4),
    ("avi", Format::Avi),
    ("mkv", Format::Mkv),
    ("mov", Format::Mov),
    ("webm", Format::Webm),
];

impl Format {
    /// The format that the name of `path` ends in, in any case.
    ///
    /// # Errors
    /// [`ExportError::UnknownFormat`] for all other endings.
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let known = ENDINGS.iter().find(|(name, _)| ending.as_deref() == Some(name));
        known.map(|(_, format)| *format).ok_or_else(|| {
            let found = ending.map_or_else(|| "no ending".to_owned(), |e| format!(".{e}"));
            ExportError::UnknownFormat { path: path.to_owned(), found }
        })
    }

    /// All endings in words.
    pub(crate) fn endings() -> String {
        let names: Vec<String> = ENDINGS.iter().map(|(name, _)| format!(".{name}")).collect();
        let (last, others) = names.split_last().expect("there are formats");
        format!("{} or {last}", others.join(", "))
    }

    /// Whether it holds many pictures that follow each other in time.
    pub fn is_film(self) -> bool {
        matches!(self, Self::Mp4 | Self::Avi | Self::Mkv | Self::Mov | Self::Webm)
    }

    /// Whether pixels may be transparent.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::Png | Self::Exr)
    }

    /// What its pixels are, where `bits` per channel are asked for.
    ///
    /// # Errors
    /// [`ExportError::Unsuitable`] about `path` when the format has not so many.
    pub fn depth(self, bits: Option<u8>, path: &Path) -> Result<PixelDepth, ExportError> {
        match (self, bits) {
            (Self::Exr, None | Some(16)) => Ok(PixelDepth::Linear),
            (Self::Png, Some(16)) => Ok(PixelDepth::Display16),
            (Self::Exr, Some(_)) => Err(ExportError::Unsuitable {
                path: path.to_owned(),
                message: "this format has 16 bits per channel, half floats; leave out --bits".into(),
            }),
            (_, None | Some(8)) => Ok(PixelDepth::Display8),
            (_, Some(bits)) => Err(ExportError::Unsuitable {
                path: path.to_owned(),
                message: format!("this format has 8 bits per channel, not {bits}; 16 go into .png and .exr"),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_count_in_any_case_and_unknown_ones_are_listed() {
        assert_eq!(Format::of(Path::new("a/b.JPG")).unwrap(), Format::Jpeg);
        assert_eq!(Format::of(Path::new("film.of.water.mp4")).unwrap(), Format::Mp4);
        for bad in ["out", "out.gif", "png", ".mp4"] {
            let error = Format::of(Path::new(bad)).unwrap_err().to_string();
            assert!(error.contains(".png, .jpg") && error.contains("or .webm"), "{error}");
        }
    }

    #[test]
    fn bits_that_a_format_lacks_are_refused() {
        let depth = |name: &str, bits| Format::of(Path::new(name)).unwrap().depth(bits, Path::new(name));
        assert_eq!(depth("a.png", None).unwrap(), PixelDepth::Display8);
        assert_eq!(depth("a.png", Some(16)).unwrap(), PixelDepth::Display16);
        assert_eq!(depth("a.exr", None).unwrap(), PixelDepth::Linear);
        for (name, bits) in [("a.jpg", 16), ("a.mp4", 16), ("a.exr", 8)] {
            assert!(depth(name, Some(bits)).unwrap_err().to_string().contains(name));
        }
    }
}
