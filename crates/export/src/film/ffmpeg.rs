//! Films by the program `ffmpeg`: any codec and container that it was built with, and pictures beyond 3840 x 2160.

use std::fs::File;
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};

use super::even::{even, padded};
use super::spool::Spool;
use super::{Film, FilmOptions, FinishedFilm, quantiser};
use crate::still::channels;
use crate::{ExportError, Format};

/// Encoders that take a constant rate factor, by the beginning of their names.
const TAKES_CRF: [&str; 5] = ["libx26", "libvpx", "libaom", "libsvtav1", "librav1e"];

/// A film on its way through a pipe.
pub(super) struct FfmpegFilm {
    /// Only its place is ours; ffmpeg writes it.
    spool: Spool,
    process: Process,
    path: PathBuf,
    size: [u32; 2],
    pictures: u64,
}

impl FfmpegFilm {
    pub fn open(
        path: &Path,
        format: Format,
        codec: Option<&str>,
        options: &FilmOptions,
    ) -> Result<Self, ExportError> {
        let spool = Spool::new(path)?;
        let arguments = arguments(format, codec, options);
        let process = Process::start(path, spool.place(), &arguments)?;
        Ok(Self { spool, process, path: path.to_owned(), size: options.size, pictures: 0 })
    }
}

impl Film for FfmpegFilm {
    fn push(&mut self, pixels: &[u32]) -> Result<(), ExportError> {
        let bytes = channels(&padded(pixels, self.size), false);
        let Some(input) = &mut self.process.input else { return Err(self.process.failure(&self.path)) };
        if input.write_all(&bytes).is_err() {
            // It has said why on its standard error.
            return Err(self.process.failure(&self.path));
        }
        self.pictures += 1;
        Ok(())
    }

    fn finish(mut self: Box<Self>, path: &Path) -> Result<FinishedFilm, ExportError> {
        drop(self.process.input.take());
        let status = self.process.child.wait();
        if !status.is_ok_and(|status| status.success()) || self.pictures == 0 {
            return Err(self.process.failure(&self.path));
        }
        let Self { spool, pictures, .. } = *self;
        spool.persist(path)?;
        Ok(FinishedFilm { path: path.to_owned(), pictures })
    }
}

/// A running ffmpeg. Ended when dropped.
struct Process {
    child: Child,
    input: Option<ChildStdin>,
    complaints: File,
}

impl Process {
    fn start(path: &Path, output: &Path, arguments: &[String]) -> Result<Self, ExportError> {
        let io = |source| ExportError::Io { path: path.to_owned(), source };
        // A file, not a pipe: nobody reads while pictures are written.
        let complaints = tempfile::tempfile().map_err(io)?;
        let mut child = Command::new("ffmpeg")
            .args(arguments)
            .arg(output)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(complaints.try_clone().map_err(io)?)
            .spawn()
            .map_err(|error| match error.kind() {
                std::io::ErrorKind::NotFound => ExportError::NoFfmpeg { path: path.to_owned() },
                _ => io(error),
            })?;
        let input = child.stdin.take();
        Ok(Self { child, input, complaints })
    }

    /// What it said last.
    fn failure(&mut self, path: &Path) -> ExportError {
        drop(self.input.take());
        let _ = self.child.wait();
        let mut bytes = Vec::new();
        let _ = self.complaints.rewind().and_then(|()| self.complaints.read_to_end(&mut bytes));
        let text = String::from_utf8_lossy(&bytes).trim().replace('\n', "; ");
        let said = if text.is_empty() { "it ended without a word".to_owned() } else { text };
        ExportError::Encode { path: path.to_owned(), message: format!("ffmpeg: {said}") }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// All but the name of the output.
fn arguments(format: Format, codec: Option<&str>, options: &FilmOptions) -> Vec<String> {
    let (container, usual) = match format {
        Format::Mkv => ("matroska", "libx264"),
        Format::Mov => ("mov", "libx264"),
        Format::Webm => ("webm", "libvpx-vp9"),
        Format::Avi => ("avi", "mjpeg"),
        _ => ("mp4", "libx264"),
    };
    let codec = codec.unwrap_or(usual);
    let [width, height] = even(options.size);
    let mut arguments = words("-hide_banner -loglevel error -nostdin -f rawvideo -pix_fmt rgb24");
    arguments.extend(words(&format!("-video_size {width}x{height} -framerate {} -i pipe:0", options.rate)));
    // The matrix is said twice: to the filter that converts, and to the file.
    arguments
        .extend(words("-vf scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int"));
    arguments.extend(words("-pix_fmt yuv420p -color_primaries bt709 -color_trc bt709 -colorspace bt709"));
    arguments.extend(words(&format!("-color_range tv -c:v {codec}")));
    let takes_crf = TAKES_CRF.iter().any(|beginning| codec.starts_with(beginning));
    arguments.extend(match options.bits_per_second {
        Some(bits) => words(&format!("-b:v {bits}")),
        None if takes_crf => words(&format!("-crf {} -b:v 0", quantiser(options.quality))),
        None => words(&format!("-q:v {}", scale(options.quality))),
    });
    if matches!(container, "mp4" | "mov") {
        arguments.extend(words("-movflags +faststart"));
    }
    arguments.extend(words(&format!("-f {container} -y")));
    arguments
}

fn words(text: &str) -> Vec<String> {
    text.split(' ').map(String::from).collect()
}

/// The scale of older codecs: 31 for the least quality, 1 for the best.
fn scale(quality: u8) -> u32 {
    (31.0 - f64::from(quality) * 0.3).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Encoder, FrameRate};

    fn line(format: Format, codec: Option<&str>, bits_per_second: Option<u32>) -> String {
        let options = FilmOptions {
            size: [641, 359],
            rate: FrameRate { numerator: 30000, denominator: 1001 },
            pictures: 3,
            quality: 75,
            bits_per_second,
            encoder: Encoder::Ffmpeg { codec: None },
        };
        arguments(format, codec, &options).join(" ")
    }

    #[test]
    fn the_command_line_says_size_rate_colours_and_quality() {
        let mp4 = line(Format::Mp4, None, None);
        for part in
            ["642x360", "30000/1001", "libx264", "-crf 20", "+faststart", "-colorspace bt709", "-f mp4"]
        {
            assert!(mp4.contains(part), "{part}: {mp4}");
        }
        let webm = line(Format::Webm, None, Some(5_000_000));
        assert!(
            webm.contains("libvpx-vp9") && webm.contains("-b:v 5000000") && !webm.contains("-crf"),
            "{webm}"
        );
        let mov = line(Format::Mov, Some("prores_ks"), None);
        assert!(mov.contains("prores_ks") && mov.contains("-q:v 9") && mov.contains("-f mov"), "{mov}");
    }
}
