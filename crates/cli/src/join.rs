//! `meniscus join`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use meniscus_export::{ExportError, FilmOptions, Format, OutputPattern, open_film, read_still};

use crate::args::JoinArgs;
use crate::failure::Failure;
use crate::render::keep_film;
use crate::terminal::{Terminal, interrupt};

/// More missing numbers than this are not listed one by one.
const LISTED: usize = 8;

pub fn run(args: &JoinArgs, terminal: &Terminal) -> Result<(), Failure> {
    let format = Format::of(&args.output)?;
    let pictures = pictures(&args.inputs)?;
    let cancel = interrupt();
    let Some(first) = pictures.values().next() else {
        return Err(Failure::Usage("there are no numbered pictures (.png, .jpg) among the inputs".into()));
    };
    let (size, _) = read_still(first)?;
    let options = FilmOptions {
        size,
        rate: args.encoding.rate(),
        pictures: pictures.len() as u64,
        quality: args.encoding.film_quality(format == Format::Avi),
        bits_per_second: args.encoding.bitrate.map(|rate| rate.0),
        encoder: args.encoding.encoder()?,
    };
    let mut film = open_film(&args.output, &options)?;
    let bar = terminal.progress(pictures.len() as u64, "pictures");
    for (written, path) in pictures.values().enumerate() {
        if cancel.is_cancelled() {
            bar.finish_and_clear();
            let kept = keep_film(Some(film).filter(|_| written > 0), &args.output, pictures.len());
            return Err(Failure::InterruptedOutput { kept });
        }
        let (found, pixels) = read_still(path)?;
        if found != size {
            let message = format!(
                "it is {}x{}, the first picture, {}, is {}x{}; a film has one size",
                found[0],
                found[1],
                first.display(),
                size[0],
                size[1]
            );
            return Err(ExportError::Unreadable { path: path.clone(), message }.into());
        }
        film.push(&pixels)?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let film = film.finish(&args.output)?;
    terminal.say(format_args!("wrote {}: {} pictures", film.path.display(), film.pictures));
    Ok(())
}

/// All pictures by their numbers, which have no gap.
fn pictures(inputs: &[PathBuf]) -> Result<BTreeMap<usize, PathBuf>, Failure> {
    let mut pictures: BTreeMap<usize, PathBuf> = BTreeMap::new();
    for input in inputs {
        let found = if input.is_file() {
            let number = number(input).ok_or_else(|| {
                Failure::Usage(format!(
                    "{}: there is no number before the ending of its name",
                    input.display()
                ))
            })?;
            vec![(number, input.clone())]
        } else if input.is_dir() {
            list(input)?.into_iter().filter_map(|path| Some((number(&path)?, path))).collect()
        } else {
            let pattern = OutputPattern::parse(input)?;
            let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let files = list(pattern.folder())?;
            files.into_iter().filter_map(|path| Some((pattern.number_of(&name(&path))?, path))).collect()
        };
        if found.is_empty() {
            return Err(Failure::Usage(format!("{}: there are no numbered pictures", input.display())));
        }
        for (number, path) in found {
            if let Some(other) = pictures.get(&number).filter(|other| **other != path) {
                return Err(Failure::Usage(format!(
                    "{} and {}: two pictures with the number {number}; give one of them",
                    other.display(),
                    path.display()
                )));
            }
            pictures.insert(number, path);
        }
    }
    let missing = missing(&pictures);
    if missing.is_empty() {
        return Ok(pictures);
    }
    let listed: Vec<String> = missing.iter().take(LISTED).map(ToString::to_string).collect();
    let more = if missing.len() > LISTED { ", ..." } else { "" };
    Err(Failure::Usage(format!(
        "{} of the pictures are missing: {}{more}; draw them (`render --resume` leaves out those that are there)",
        missing.len(),
        listed.join(", ")
    )))
}

/// Numbers between the first and the last that no picture has.
fn missing(pictures: &BTreeMap<usize, PathBuf>) -> Vec<usize> {
    let numbers: Vec<usize> = pictures.keys().copied().collect();
    numbers.windows(2).flat_map(|pair| pair[0] + 1..pair[1]).take(1000).collect()
}

/// What lies in `folder`.
fn list(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unreadable = |error: std::io::Error| {
        let message = error.to_string();
        Failure::Output(ExportError::Unreadable { path: folder.to_owned(), message })
    };
    let entries = std::fs::read_dir(folder).map_err(unreadable)?;
    entries.map(|entry| entry.map(|entry| entry.path()).map_err(unreadable)).collect()
}

/// The number at the end of the name of a picture.
fn number(path: &Path) -> Option<usize> {
    let is_picture = matches!(Format::of(path), Ok(Format::Png | Format::Jpeg));
    let stem = path.file_stem().filter(|_| is_picture)?.to_str()?;
    let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    stem[stem.len() - digits..].parse().ok().filter(|_| !stem.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_at_the_end_of_names() {
        assert_eq!(number(Path::new("a/out_0012.png")), Some(12));
        assert_eq!(number(Path::new("7.jpg")), Some(7));
        for other in ["out.png", "out_3.txt", ".meniscus-3.png", "out_3_b.png", "99999999999999999999999.png"]
        {
            assert_eq!(number(Path::new(other)), None, "{other}");
        }
    }

    #[test]
    fn gaps_are_found() {
        let pictures = [3, 4, 7, 9].map(|number| (number, PathBuf::new())).into_iter().collect();
        assert_eq!(missing(&pictures), [5, 6, 8]);
        assert_eq!(missing(&BTreeMap::new()), [0; 0]);
    }
}
