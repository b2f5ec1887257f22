use std::path::{Path, PathBuf};

use crate::{ExportError, Format};

/// Where frames go: one file, or a numbered sequence with `%d` or `%0Nd` in the file name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputPattern {
    folder: PathBuf,
    /// File name before and after the number; `None`: one file, whose name is `before`.
    before: String,
    number: Option<Number>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Number {
    digits: usize,
    after: String,
}

impl OutputPattern {
    /// Reads a path such as `out.png` or `frames/out_%04d.png`.
    ///
    /// # Errors
    /// [`ExportError::UnknownFormat`] for endings that name no format, [`ExportError::BadPattern`] for `%` in another form.
    pub fn parse(path: &Path) -> Result<Self, ExportError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Format::of(path)?;
        let mut before = String::new();
        let mut number: Option<Number> = None;
        let mut rest = name.as_str();
        while let Some(at) = rest.find('%') {
            let text = number.as_mut().map_or(&mut before, |n| &mut n.after);
            text.push_str(&rest[..at]);
            let tail = &rest[at + 1..];
            if let Some(after) = tail.strip_prefix('%') {
                text.push('%');
                rest = after;
                continue;
            }
            let end = tail.find(|c: char| !c.is_ascii_digit()).unwrap_or(tail.len());
            let digits = match (&tail[..end], tail[end..].starts_with('d')) {
                ("", true) => Some(1),
                (width, true) if width.len() == 2 && width.starts_with('0') => {
                    width[1..].parse().ok().filter(|&d| d > 0)
                }
                _ => None,
            };
            match digits {
                Some(digits) if number.is_none() => number = Some(Number { digits, after: String::new() }),
                _ => {
                    let shown = tail.chars().take(end + 1).collect::<String>();
                    return Err(ExportError::BadPattern {
                        path: path.to_owned(),
                        found: format!("%{shown}"),
                    });
                }
            }
            rest = &tail[end + 1..];
        }
        number.as_mut().map_or(&mut before, |n| &mut n.after).push_str(rest);
        Ok(Self { folder: path.parent().unwrap_or(Path::new("")).to_owned(), before, number })
    }

    /// Checks that `frames` frames fit: more than one needs a number.
    ///
    /// # Errors
    /// [`ExportError::NeedsPattern`] with a name that would do.
    pub fn check(&self, frames: usize) -> Result<(), ExportError> {
        if self.number.is_some() || frames <= 1 {
            return Ok(());
        }
        let path = self.path(0);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        let suggestion = path.with_file_name(format!("{stem}_%04d.{ending}"));
        Err(ExportError::NeedsPattern { path, frames, suggestion })
    }

    /// Whether the names are numbered.
    pub fn is_numbered(&self) -> bool {
        self.number.is_some()
    }

    /// The number in `name`, where it is a name of this pattern.
    pub fn number_of(&self, name: &str) -> Option<usize> {
        let Number { digits, after } = self.number.as_ref()?;
        let middle = name.strip_prefix(&self.before)?.strip_suffix(after)?;
        let padded = middle.len() == *digits || (middle.len() > *digits && !middle.starts_with('0'));
        let is_number = padded && middle.bytes().all(|c| c.is_ascii_digit());
        is_number.then(|| middle.parse().ok()).flatten()
    }

    /// The folder of all the files.
    pub fn folder(&self) -> &Path {
        if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder }
    }

    /// The file of frame `index` of the series.
    pub fn path(&self, index: usize) -> PathBuf {
        let name = match &self.number {
            None => self.before.clone(),
            Some(Number { digits, after }) => format!("{}{index:0digits$}{after}", self.before),
        };
        self.folder.join(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(path: &str) -> Result<OutputPattern, ExportError> {
        OutputPattern::parse(Path::new(path))
    }

    #[test]
    fn numbers_go_where_the_pattern_says() {
        assert_eq!(parse("a/out_%04d.png").unwrap().path(7), Path::new("a/out_0007.png"));
        assert_eq!(parse("%d.PNG").unwrap().path(12345), Path::new("12345.PNG"));
        assert_eq!(parse("100%%_%02d_b.png").unwrap().path(3), Path::new("100%_03_b.png"));
        assert_eq!(parse("out.png").unwrap().path(3), Path::new("out.png"));
    }

    #[test]
    fn what_is_not_understood_is_refused() {
        for bad in ["%s.png", "%4d.png", "%04x.png", "%d_%d.png", "%00d.png", "x%.png"] {
            assert!(matches!(parse(bad), Err(ExportError::BadPattern { .. })), "{bad}");
        }
        for bad in ["out", "out.gif", "png"] {
            assert!(matches!(parse(bad), Err(ExportError::UnknownFormat { .. })), "{bad}");
        }
    }

    #[test]
    fn what_is_suggested_is_understood() {
        let message = parse("p/dam.png").unwrap().check(3).unwrap_err().to_string();
        assert!(message.contains("a pattern such as p/dam_%04d.png, a film such as p/dam.mp4,"), "{message}");
    }

    #[test]
    fn numbers_are_found_again() {
        let pattern = parse("a/out_%04d.png").unwrap();
        for index in [0, 7, 9999, 12345] {
            let name = pattern.path(index).file_name().unwrap().to_string_lossy().into_owned();
            assert_eq!(pattern.number_of(&name), Some(index));
        }
        for other in
            ["out_7.png", "out_00007.png", "out_+007.png", "out_0007.jpg", "xout_0007.png", "out_.png"]
        {
            assert_eq!(pattern.number_of(other), None, "{other}");
        }
        assert_eq!(parse("out.png").unwrap().number_of("out.png"), None);
    }

    #[test]
    fn several_frames_need_a_number_and_the_message_shows_one() {
        let error = parse("a/out.png").unwrap().check(20).unwrap_err().to_string();
        assert!(error.contains("a/out_%04d.png"), "{error}");
        assert!(parse("a/out.png").unwrap().check(1).is_ok());
        assert!(parse("a/out%d.png").unwrap().check(20).is_ok());
    }
}
