//! Where pictures go: files of their own, or a film.

use std::path::{Path, PathBuf};

use meniscus_core::{Channel, Choice, PixelDepth, Pixels};
use meniscus_export::{
    Encoder, ExportError, Film, FilmOptions, Format, OutputPattern, Still, StillOptions, film_size, note_of,
    open_film, write_still,
};

use super::shots::Shots;
use crate::args::RenderArgs;
use crate::failure::Failure;

/// What the name of the output asks for.
pub enum Output {
    /// A picture per file.
    Stills(Stills),
    /// All in one file.
    Film(FilmOutput),
}

/// Numbered pictures, or one.
pub struct Stills {
    pattern: OutputPattern,
    depth: PixelDepth,
    options: StillOptions,
    /// Numbers of what is there, in order.
    written: Vec<usize>,
}

/// A film on its way.
pub struct FilmOutput {
    path: PathBuf,
    film: Option<Box<dyn Film>>,
    /// What is shown again where a frame is missing.
    last: Option<Vec<u32>>,
    /// Pictures that are missing before the first that is there.
    leading: usize,
    written: usize,
}

impl Output {
    /// Checks that `args` fit the kind of file that they name.
    pub fn parse(args: &RenderArgs, transparent: bool) -> Result<Self, Failure> {
        let path = &args.output;
        let format = Format::of(path)?;
        let depth = format.depth(args.bits, path)?;
        let unsuitable = |message: &str| {
            Err(Failure::Output(ExportError::Unsuitable { path: path.clone(), message: message.into() }))
        };
        if transparent && !format.has_alpha() {
            return unsuitable("this format has no transparent pixels; .png and .exr have");
        }
        if args.show.is_some() && depth != PixelDepth::Display8 {
            return unsuitable(
                "the pictures of --show have 8 bits per channel; write .png or .jpg without --bits",
            );
        }
        if depth == PixelDepth::Linear && (!args.overlay.is_empty() || args.text.is_some()) {
            return unsuitable(
                "linear radiance is not written on; leave out --overlay and --text, or write .png",
            );
        }
        if depth != PixelDepth::Linear && !args.layers.is_empty() {
            return unsuitable("only .exr has layers besides the picture");
        }
        if !args.layers.is_empty() && args.exposure.samples().max(args.supersample) > 1 {
            return unsuitable(
                "layers are those of a single picture; leave out --samples, --supersample and blur",
            );
        }
        if format.is_film() {
            if args.time.shard.is_some() {
                return unsuitable(
                    "a share of the pictures is no film; write out_%04d.png, then use `meniscus join`",
                );
            }
            if args.time.resume {
                return unsuitable(
                    "a film cannot be resumed; write out_%04d.png with --resume, then use `meniscus join`",
                );
            }
            return Ok(Self::Film(FilmOutput {
                path: path.clone(),
                film: None,
                last: None,
                leading: 0,
                written: 0,
            }));
        }
        if args.encoding.bitrate.is_some() || args.encoding.encoder()? != Encoder::BuiltIn {
            return unsuitable("--bitrate and --encoder are about films; this is a picture");
        }
        let options = StillOptions { quality: args.encoding.still_quality() };
        Ok(Self::Stills(Stills { pattern: OutputPattern::parse(path)?, depth, options, written: Vec::new() }))
    }

    /// Whether it is one file with all pictures.
    pub fn is_film(&self) -> bool {
        matches!(self, Self::Film(_))
    }

    /// What pixels it takes.
    pub fn depth(&self) -> PixelDepth {
        match self {
            Self::Stills(stills) => stills.depth,
            Self::Film(_) => PixelDepth::Display8,
        }
    }

    /// Begins a film, or checks that all pictures have names. What was chosen.
    pub fn open(&mut self, args: &RenderArgs, shots: &Shots) -> Result<Option<Choice>, Failure> {
        match self {
            Self::Stills(stills) => {
                stills.pattern.check(shots.shots.len())?;
                Ok(None)
            }
            Self::Film(film) => {
                let is_jpeg = Format::of(&film.path)? == Format::Avi;
                let options = FilmOptions {
                    size: args.picture.size.0,
                    rate: shots.rate,
                    pictures: shots.shots.len() as u64,
                    quality: args.encoding.film_quality(is_jpeg),
                    bits_per_second: args.encoding.bitrate.map(|rate| rate.0),
                    encoder: args.encoding.encoder()?,
                };
                film.film = Some(open_film(&film.path, &options)?);
                let [width, height] = film_size(Format::of(&film.path)?, &options);
                Ok((options.size != [width, height]).then(|| Choice {
                    what: "film".into(),
                    value: format!("{width}x{height}"),
                    reason: "it has even sides; the last column or row is there twice".into(),
                    flag: "--size".into(),
                }))
            }
        }
    }

    /// Whether picture `number` is there already, whole, with this note, and not older than `data`.
    pub fn has(&self, number: usize, size: [u32; 2], note: &str, data: &[PathBuf]) -> bool {
        let Self::Stills(stills) = self else { return false };
        let path = stills.pattern.path(number);
        let age = |path: &Path| path.metadata().and_then(|file| file.modified()).ok();
        let is_fresh = age(&path).is_some_and(|made| data.iter().all(|file| age(file) <= Some(made)));
        is_fresh && note_of(&path, size).as_deref() == Some(note)
    }

    /// Notes that picture `number` is there.
    pub fn skip(&mut self, number: usize) {
        if let Self::Stills(stills) = self {
            stills.written.push(number);
        }
    }

    /// Writes picture `number`.
    pub fn push(
        &mut self,
        number: usize,
        size: [u32; 2],
        (pixels, channels): (&Pixels, &[Channel]),
        with_alpha: bool,
        note: &str,
    ) -> Result<(), ExportError> {
        match self {
            Self::Stills(stills) => {
                let still = Still { size, pixels, with_alpha, channels, note };
                write_still(&stills.pattern.path(number), &still, stills.options)?;
                stills.written.push(number);
                Ok(())
            }
            Self::Film(film) => {
                let Pixels::Display8(pixels) = pixels else { return Ok(()) };
                for _ in 0..std::mem::take(&mut film.leading) {
                    film.append(pixels)?;
                }
                film.append(pixels)?;
                film.last = Some(pixels.clone());
                Ok(())
            }
        }
    }

    /// A picture that there will not be: a film shows its neighbour longer, so that the others stay at their time.
    pub fn miss(&mut self) -> Result<(), ExportError> {
        let Self::Film(film) = self else { return Ok(()) };
        match film.last.take() {
            Some(last) => {
                film.append(&last)?;
                film.last = Some(last);
            }
            None => film.leading += 1,
        }
        Ok(())
    }

    /// Completes the output; what was written, in words.
    pub fn finish(self) -> Result<String, ExportError> {
        match self {
            Self::Stills(stills) => Ok(stills.names()),
            Self::Film(FilmOutput { path, film, written, .. }) => {
                film.map_or(Ok(()), |film| film.finish(&path).map(drop))?;
                Ok(format!("{}: {written} pictures", path.display()))
            }
        }
    }

    /// Keeps what was written before something went wrong; what that is and what is missing, in words.
    pub fn keep(self, shots: &Shots) -> String {
        let wanted = shots.shots.len();
        match self {
            Self::Stills(stills) => {
                let is_missing = |number: &usize| !stills.written.contains(number);
                let missing: Vec<usize> =
                    shots.shots.iter().map(|shot| shot.moment.number).filter(is_missing).collect();
                let name = |number: &usize| stills.pattern.path(*number).display().to_string();
                let missing = match missing.as_slice() {
                    [] => return format!("all {wanted} pictures are there"),
                    [one] => name(one),
                    [first, .., last] => format!("{} to {}", name(first), name(last)),
                };
                let count = stills.written.len();
                let hint = if count > 0 { "; --resume goes on from there" } else { "" };
                format!("{count} of {wanted} pictures are there, missing: {missing}{hint}")
            }
            Self::Film(FilmOutput { path, film, written, .. }) => {
                keep_film(film.filter(|_| written > 0), &path, wanted)
            }
        }
    }
}

/// Completes a film that was to be `path`, under a name that says that it is a part of the `wanted` pictures; what there is, in
/// words. Without a picture there is nothing.
pub fn keep_film(film: Option<Box<dyn Film>>, path: &Path, wanted: usize) -> String {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let partial = path.with_extension(format!("partial.{ending}"));
    match film.map(|film| film.finish(&partial)) {
        Some(Ok(film)) => {
            format!("the first {} of {wanted} pictures are in {}", film.pictures, film.path.display())
        }
        _ => format!("nothing of {} is left", path.display()),
    }
}

impl Stills {
    /// The names of what was written.
    fn names(&self) -> String {
        let name = |number: Option<&usize>| number.map(|n| self.pattern.path(*n).display().to_string());
        let (first, last) = (name(self.written.first()), name(self.written.last()));
        match (first, last) {
            (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
            (Some(only), _) => only,
            _ => "nothing".into(),
        }
    }
}

impl FilmOutput {
    fn append(&mut self, pixels: &[u32]) -> Result<(), ExportError> {
        if let Some(film) = &mut self.film {
            film.push(pixels)?;
            self.written += 1;
        }
        Ok(())
    }
}
