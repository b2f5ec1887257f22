use std::cmp::Ordering;
use std::path::Path;

/// Lower-case extension; `series` for `.vtu.series` and the like, `bgeo` for `.bgeo.gz`.
pub(super) fn extension(path: &Path) -> String {
    let of = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let last = of(path).unwrap_or_default();
    if last == "gz" { path.file_stem().and_then(|stem| of(stem.as_ref())).unwrap_or_default() } else { last }
}

/// Order in which people count: runs of digits by value, the rest by letters.
pub(super) fn natural(a: &str, b: &str) -> Ordering {
    let (mut a_rest, mut b_rest) = (a.as_bytes(), b.as_bytes());
    while let (Some(&x), Some(&y)) = (a_rest.first(), b_rest.first()) {
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let (x, a_tail) = digits(a_rest);
            let (y, b_tail) = digits(b_rest);
            let order = x.len().cmp(&y.len()).then_with(|| x.cmp(y));
            if order.is_ne() {
                return order;
            }
            (a_rest, b_rest) = (a_tail, b_tail);
        } else if x != y {
            return x.cmp(&y);
        } else {
            (a_rest, b_rest) = (&a_rest[1..], &b_rest[1..]);
        }
    }
    // Equal but for leading zeros: any fixed order will do.
    a_rest.len().cmp(&b_rest.len()).then_with(|| a.cmp(b))
}

/// The leading digits without leading zeros, and what follows.
fn digits(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|b| !b.is_ascii_digit()).unwrap_or(text.len());
    let zeros = text[..end].iter().take_while(|&&b| b == b'0').count();
    (&text[zeros..end], &text[end..])
}

/// A file name with its last number taken out: what the files of a series share. Only the number before the extension counts.
pub(crate) fn stem(name: &str) -> String {
    last_number(name)
        .map_or_else(|| name.to_owned(), |(start, end)| format!("{}#{}", &name[..start], &name[end..]))
}

/// [`stem`] and the number; `None` without one.
pub(crate) fn numbered(name: &str) -> Option<(String, u64)> {
    let (start, end) = last_number(name)?;
    Some((stem(name), name[start..end].parse().ok()?))
}

/// Where the last number before the extension of `name` starts and ends.
fn last_number(name: &str) -> Option<(usize, usize)> {
    let body = &name[..name.rfind('.').unwrap_or(name.len())];
    let end = body.rfind(|c: char| c.is_ascii_digit())? + 1;
    let before = body[..end].rfind(|c: char| !c.is_ascii_digit());
    let start = before.map_or(0, |i| i + body[i..].chars().next().map_or(1, char::len_utf8));
    Some((start, end))
}

/// A file name pattern with one `%d` or `%0Nd`; `%i` and `%u` are the same.
pub(super) struct NumberPattern {
    prefix: String,
    suffix: String,
    width: usize,
}

impl NumberPattern {
    /// `None` when the name of `path` is no such pattern.
    pub fn parse(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let (prefix, rest) = name.split_once('%')?;
        let (width, suffix) = rest.split_once(['d', 'i', 'u'])?;
        if !width.chars().all(|c| c.is_ascii_digit()) || suffix.contains('%') {
            return None;
        }
        Some(Self { prefix: prefix.into(), suffix: suffix.into(), width: width.parse().unwrap_or(0) })
    }

    /// The number in `name`, if it fits the pattern.
    pub fn number_of(&self, name: &str) -> Option<u64> {
        let digits = name.strip_prefix(self.prefix.as_str())?.strip_suffix(self.suffix.as_str())?;
        let fits =
            !digits.is_empty() && digits.len() >= self.width && digits.bytes().all(|b| b.is_ascii_digit());
        digits.parse().ok().filter(|_| fits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_sorted_by_value() {
        let mut names = ["f_10.vtu", "f_9.vtu", "f_010.vtu", "f_1.vtu", "f.vtu", "e_99.vtu", "f_1_2.vtu"];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["e_99.vtu", "f.vtu", "f_1.vtu", "f_1_2.vtu", "f_9.vtu", "f_010.vtu", "f_10.vtu"]);
    }

    #[test]
    fn stems_leave_out_the_last_number() {
        for (name, expected) in [
            ("fluid_0003.vtu", "fluid_#.vtu"),
            ("T2_P00T0003.vtp", "T2_P00T#.vtp"),
            ("ρ12.vtk", "ρ#.vtk"),
            ("plain.vtk", "plain.vtk"),
            ("7.vtk", "#.vtk"),
        ] {
            assert_eq!(stem(name), expected);
        }
    }

    #[test]
    fn printf_patterns() {
        let pattern = |text: &str| NumberPattern::parse(Path::new(text));
        let padded = pattern("a/frame_%04d.vtu").expect("a pattern");
        assert_eq!(padded.number_of("frame_0012.vtu"), Some(12));
        assert_eq!(padded.number_of("frame_12.vtu"), None);
        assert_eq!(padded.number_of("frame_00x2.vtu"), None);
        for text in ["f%d.vtk", "f%i.vtk", "f%u.vtk"] {
            assert_eq!(pattern(text).and_then(|p| p.number_of("f7.vtk")), Some(7), "{text}");
        }
        for text in ["100%.vtu", "f_%s.vtu", "f_%d_%d.vtu", "f.vtu"] {
            assert!(pattern(text).is_none(), "{text}");
        }
    }
}
