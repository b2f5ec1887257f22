//! Our readers on a clock.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use meniscus_core::{Cancel, FrameRequest, FrameSource};
use meniscus_io::{Series, SeriesOptions};
use serde_json::{Value, json};

#[derive(Args)]
pub struct Options {
    /// The file.
    path: PathBuf,
    /// What is done with it.
    #[arg(long, value_enum, default_value_t = Tool::Meniscus)]
    tool: Tool,
    /// Read all attributes instead of none.
    #[arg(long)]
    all: bool,
    /// Worker threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// How often; every time is printed.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
}

#[derive(Clone, Copy, ValueEnum)]
enum Tool {
    /// Reads one frame as the pipeline does: finite positions in f32 relative to the origin.
    Meniscus,
    /// Opens the series as well: survey, spacing, up axis.
    Open,
    /// Copies the file's bytes from the page cache to memory: what no reader can be faster than.
    Copy,
}

/// Times of `repeat` runs after one that is not counted, in milliseconds.
pub fn run(options: &Options) -> Result<Value, Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(options.threads).build_global()?;
    let bytes = std::fs::metadata(&options.path)?.len();
    let open = || Series::open(&options.path, &SeriesOptions::default());
    let series = open()?;
    let names = series.frame_info(0, false)?.attributes.into_iter().map(|attribute| attribute.name);
    let request = FrameRequest { attributes: if options.all { names.collect() } else { Vec::new() } };
    let mut points = 0;
    let mut copy = vec![0_u8; if matches!(options.tool, Tool::Copy) { usize::try_from(bytes)? } else { 0 }];
    let (mut wall_ms, mut cpu_ms) = (Vec::new(), Vec::new());
    for run in 0..=options.repeat {
        let (wall, cpu) = (Instant::now(), process_cpu_ms());
        match options.tool {
            Tool::Meniscus => {
                let frame = series.read(0, &request, &Cancel::default())?;
                points = frame.sets.iter().map(|set| set.particles.positions.len()).sum();
            }
            Tool::Open => drop(std::hint::black_box(open()?)),
            Tool::Copy => {
                std::io::Read::read_exact(&mut std::fs::File::open(&options.path)?, &mut copy)?;
                std::hint::black_box(&copy);
            }
        }
        if run > 0 {
            wall_ms.push(wall.elapsed().as_secs_f64() * 1e3);
            cpu_ms.push(process_cpu_ms() - cpu);
        }
    }
    Ok(json!({ "bytes": bytes, "points": points, "wall_ms": wall_ms, "cpu_ms": cpu_ms }))
}

/// User + system milliseconds of this process so far.
fn process_cpu_ms() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 / 1e6
}
