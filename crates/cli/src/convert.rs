//! `meniscus convert`.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use meniscus_core::FrameSource;
use meniscus_export::{ExportError, OutputPattern};
use meniscus_io::Series;
use meniscus_io::writer::{Encoding, Format, write_pvd};

use crate::args::{ConvertArgs, ConvertEncoding};
use crate::failure::Failure;
use crate::input;
use crate::terminal::{Terminal, interrupt};

pub fn run(args: &ConvertArgs, terminal: &Terminal) -> Result<(), Failure> {
    let format = format(&args.output, args.encoding)?;
    let names = Names::parse(&args.output)?;
    let cancel = interrupt();
    let series = input::open(&args.input, true, &cancel)?;
    let frames = args.wanted.within(series.frame_count())?;
    if frames.len() > 1 && names.of(0) == names.of(1) {
        let (count, stem) = (frames.len(), args.output.file_stem().unwrap_or_default().to_string_lossy());
        return Err(Failure::Usage(format!(
            "{}: {count} frames cannot go into one file; give a pattern such as {stem}_%04d, or pick one with --frame N",
            args.output.display()
        )));
    }
    let collection = (frames.len() > 1).then(|| names.collection());
    let outputs = frames.iter().map(|&index| names.of(index)).chain(collection);
    refuse_inputs(&series, &args.input.input, outputs)?;
    let folder = args.output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)
        .map_err(|source| ExportError::Io { path: args.output.clone(), source })?;

    terminal.flaws(series.flaws());
    let bar = terminal.progress(frames.len() as u64, "frames");
    let times = series.times();
    let (mut written, mut failures, mut particles) = (Vec::new(), Vec::new(), 0_u64);
    for &index in frames.iter().take_while(|_| !cancel.is_cancelled()) {
        let path = names.of(index);
        match series.convert_frame(index, &path, format, &cancel) {
            Ok(count) => {
                particles += count as u64;
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                // Frames without a time are told apart by their number.
                written.push((times[index].unwrap_or(index as f64), name));
            }
            Err(_) if cancel.is_cancelled() => break,
            Err(error) if error.file() == Some(path.as_path()) => {
                return Err(ExportError::Encode { path, message: error.to_string() }.into());
            }
            Err(error) if frames.len() == 1 => return Err(error.into()),
            Err(error) => {
                bar.suspend(|| terminal.say(format_args!("note: frame {index} is missing: {error}")));
                failures.push(error.to_string());
            }
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let mut result = names.of(frames[0]);
    if frames.len() > 1 {
        result = names.collection();
        write_pvd(&result, &written)
            .map_err(|e| ExportError::Encode { path: result.clone(), message: e.to_string() })?;
    }
    if cancel.is_cancelled() {
        return Err(Failure::Interrupted);
    }
    if let Some(first) = failures.first() {
        let (failed, wanted, first) = (failures.len(), frames.len(), first.clone());
        return Err(Failure::FramesMissing { failed, wanted, first });
    }
    terminal.say(format_args!(
        "wrote {}: {particles} particles in {} frames",
        result.display(),
        written.len()
    ));
    Ok(())
}

/// What is written under this name.
fn format(output: &Path, encoding: ConvertEncoding) -> Result<Format, Failure> {
    let xml = match encoding {
        ConvertEncoding::Raw => Encoding::Raw,
        ConvertEncoding::Zlib => Encoding::Zlib,
        ConvertEncoding::Lz4 => Encoding::Lz4,
        ConvertEncoding::Lzma => Encoding::Lzma,
        ConvertEncoding::Base64 => Encoding::Base64,
        ConvertEncoding::Ascii => Encoding::Ascii,
    };
    let ending = output.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match (ending.as_str(), encoding) {
        ("vtu", _) => Ok(Format::Vtu(xml)),
        ("vtp", _) => Ok(Format::Vtp(xml)),
        ("vtk", ConvertEncoding::Raw) => Ok(Format::LegacyBinary),
        ("vtk", ConvertEncoding::Ascii) => Ok(Format::LegacyAscii),
        ("vtk", _) => Err(Failure::Usage(format!(
            "{}: legacy files are raw or ascii; choose one of these, or write .vtu",
            output.display()
        ))),
        _ => Err(Failure::Usage(format!(
            "{}: cannot write this kind of file; expected a name that ends in .vtu, .vtp or .vtk",
            output.display()
        ))),
    }
}

/// Names of the frames: those of a picture sequence, with another ending.
struct Names {
    pattern: OutputPattern,
    output: PathBuf,
}

impl Names {
    fn parse(output: &Path) -> Result<Self, Failure> {
        let pattern = OutputPattern::parse(&output.with_extension("png")).map_err(|error| match error {
            ExportError::BadPattern { found, .. } => {
                ExportError::BadPattern { path: output.to_owned(), found }
            }
            other => other,
        })?;
        Ok(Self { pattern, output: output.to_owned() })
    }

    fn of(&self, index: usize) -> PathBuf {
        self.pattern.path(index).with_extension(self.output.extension().unwrap_or_default())
    }

    /// The `.pvd` beside the frames: their name without the number.
    fn collection(&self) -> PathBuf {
        let stem = self.output.file_stem().and_then(OsStr::to_str).unwrap_or_default();
        let before = stem.split('%').next().unwrap_or_default().trim_end_matches(['_', '-', '.']);
        let name = if before.is_empty() { "series" } else { before };
        self.output.with_file_name(format!("{name}.pvd"))
    }
}

/// Converting in place would destroy what was not selected, and with numbered frames also those not read yet.
fn refuse_inputs(
    series: &Series,
    input: &Path,
    outputs: impl Iterator<Item = PathBuf>,
) -> Result<(), Failure> {
    let files = (0..series.frame_count()).flat_map(|index| series.files(index));
    let inputs: HashSet<PathBuf> =
        files.chain([input.to_owned()]).filter_map(|file| file.canonicalize().ok()).collect();
    for output in outputs {
        if output.canonicalize().is_ok_and(|output| inputs.contains(&output)) {
            return Err(Failure::Usage(format!(
                "{}: this is the input; give another name",
                output.display()
            )));
        }
    }
    Ok(())
}
