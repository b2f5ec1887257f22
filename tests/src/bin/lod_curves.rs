//! What level of detail costs and what it changes: cost of a frame and error of the picture over the threshold and over the
//! tolerated error, as rows of a table for `benches/RESULTS.md`, with pictures; `strip.jpg` has the middle of the water in full detail, at
//! `--lod 0.1`, at `--lod 0.3` and at the default error bound.
//!
//!     cargo run --release -p meniscus-tests --bin lod-curves -- dam-break --out target/curves
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program; printing is its job")]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bench_views::View;
use clap::Parser;
use glam::Quat;
use meniscus_core::{Camera, Cancel, FrameRequest, FrameSource};
use meniscus_gpu::role::NO_SURFACE;
use meniscus_gpu::{AdapterChoice, Gpu, process_cpu_ms};
use meniscus_pipeline::{LodMode, LodParams, PreparedFrame, Registry, Renderer, Settings, World};
use meniscus_tests::golden::{flip_map, ssim_map};
use meniscus_tests::{Mask, Pixels};

/// Cost and error of a frame over the level of detail
#[derive(Parser)]
struct Arguments {
    /// One of `benches/views`, e.g. dam-break
    #[arg(value_parser = view)]
    view: View,

    /// Particles instead of the view's
    #[arg(long)]
    particles: Option<u64>,

    /// Picture size instead of the view's
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,

    /// Pictures per row; the table has their median
    #[arg(long, default_value_t = 5)]
    pictures: usize,

    /// Folder for pictures; made if missing
    #[arg(long)]
    out: PathBuf,
}

fn view(name: &str) -> Result<View, String> {
    let names = || View::all().map(|view| view.name).join(", ");
    View::all()
        .into_iter()
        .find(|view| view.name == name)
        .ok_or_else(|| format!("expected one of {}", names()))
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides: Option<Vec<u32>> = text.split('x').map(|side| side.parse().ok()).collect();
    sides.and_then(|sides| sides.try_into().ok()).ok_or_else(|| "expected WIDTHxHEIGHT".into())
}

/// Everything a row needs.
struct Bench {
    renderer: Renderer,
    world: World,
    frame: PreparedFrame,
    camera: Camera,
    size: [u32; 2],
}

/// A picture and what it was made from.
struct Shot {
    picture: Pixels,
    thickness: Vec<f32>,
    mask: Mask,
    kept: f64,
    stand_ins: u64,
}

impl Bench {
    fn open(view: &View) -> Result<Self, Box<dyn Error>> {
        let source = view.source();
        let settings = Settings::default();
        let frame = source.read(view.frame, &FrameRequest::default(), &Cancel::default())?;
        let world = World::of_frame(&frame, source.space(), &settings)?;
        let gpu = Gpu::new(&AdapterChoice::default())?;
        println!("{}", gpu.summary().name);
        let renderer = Renderer::new(gpu, Registry::builtin(), settings)?;
        let frame = renderer.preparer(&world).prepare(frame);
        Ok(Self { renderer, world, frame, camera: view.camera(), size: view.size })
    }

    fn shoot(&mut self, params: LodParams) -> Result<Shot, Box<dyn Error>> {
        self.renderer.set_lod(params)?;
        let picture = self.renderer.render(&self.frame, &self.world, &self.camera, self.size)?;
        let images = self.renderer.surface_images();
        let gpu = self.renderer.gpu();
        let distance = images.distance.read(gpu)?;
        let counts = self.renderer.counts();
        Ok(Shot {
            picture: Pixels {
                size: self.size,
                rgba: picture.pixels.iter().map(|p| p.to_le_bytes()).collect(),
            },
            thickness: images.thickness.read(gpu)?,
            mask: Mask::new(self.size, distance.iter().map(|d| *d < NO_SURFACE).collect()),
            kept: counts.kept as f64 / counts.input as f64,
            stand_ins: counts.stand_ins,
        })
    }

    /// Median CPU milliseconds of a frame whose camera has moved, choosing what is drawn included.
    fn cost(&mut self, pictures: usize) -> Result<f64, Box<dyn Error>> {
        let mut times = Vec::new();
        for step in 0..=pictures {
            let mut camera = self.camera;
            let turn = Quat::from_rotation_z(1e-4 * (step + 1) as f32);
            camera.eye = camera.target + turn * (camera.eye - camera.target);
            let before = process_cpu_ms();
            self.renderer.draw_and_wait(&self.frame, &self.world, &camera, self.size)?;
            times.push(process_cpu_ms() - before);
        }
        // The first compiles what the setting needs.
        times.remove(0);
        times.sort_by(f64::total_cmp);
        Ok(times[times.len() / 2])
    }
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len().max(1) as f64
}

/// Rows of the table whose pictures lie side by side in `strip.jpg`, after full detail.
const IN_STRIP: [&str; 3] = ["--lod 0.1", "--lod 0.3", "0.5 px, 1/255"];

/// Where the crops of a strip begin: around the middle of the water.
fn crop(mask: &Mask, size: [u32; 2]) -> [u32; 2] {
    let [left, right, top, bottom] = mask.bounds().unwrap_or([0.0, 1.0, 0.0, 1.0]);
    let middle = [left + right, top + bottom].map(|sum| sum / 2.0);
    [0, 1].map(|axis| {
        let first = (middle[axis] * f64::from(size[axis])) as u32;
        first.saturating_sub(CROP[axis] / 2).min(size[axis].saturating_sub(CROP[axis]))
    })
}

/// Size of a picture's part in a strip.
const CROP: [u32; 2] = [320, 240];

/// The same part of several pictures, side by side.
fn write_strip(path: &Path, pictures: &[Pixels], [left, top]: [u32; 2]) -> Result<(), Box<dyn Error>> {
    let strip = image::RgbImage::from_fn(CROP[0] * pictures.len() as u32, CROP[1], |x, y| {
        let picture = &pictures[(x / CROP[0]) as usize];
        let [x, y] = [left + x % CROP[0], top + y].map(|at| at as usize);
        let rgba = picture.rgba.get(y * picture.size[0] as usize + x).copied().unwrap_or_default();
        image::Rgb([rgba[0], rgba[1], rgba[2]])
    });
    let file = std::fs::File::create(path)?;
    strip.write_with_encoder(image::codecs::jpeg::JpegEncoder::new_with_quality(file, 85))?;
    Ok(())
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(&arguments.out)?;
    let view = View {
        particles: arguments.particles.unwrap_or(arguments.view.particles),
        size: arguments.size.unwrap_or(arguments.view.size),
        ..arguments.view.clone()
    };
    let mut bench = Bench::open(&view)?;
    let full = bench.shoot(LodParams::default())?;
    full.picture.write(&arguments.out.join("full.png"))?;
    // The first pictures are slow: buffers grow, and memory is touched for the first time.
    bench.cost(arguments.pictures)?;
    let full_ms = bench.cost(arguments.pictures)?;
    let [width, height] = view.size;
    println!(
        "{}: {} particles, {width}x{height}, {:.0} % covered\n\n| | CPU-ms a frame | of full | kept | stand-ins | FLIP | SSIM | thickness |",
        view.name,
        view.particles,
        100.0 * full.mask.share()
    );
    println!("|---|---|---|---|---|---|---|---|");
    println!("| full detail | {full_ms:.0} | 1.00 | {:.2} | 0 | - | - | - |", full.kept);
    let mut in_strip = vec![full.picture.clone()];
    let thresholds = [0.05, 0.1, 0.2, 0.3, 0.6, 0.9];
    let bounds = [(0.25, 0.5), (0.5, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, 16.0), (8.0, 64.0)];
    let by_threshold = thresholds
        .map(|threshold| (format!("--lod {threshold}"), LodParams { threshold, ..Default::default() }));
    let by_error = bounds.map(|(error_px, steps)| {
        let params = LodParams {
            mode: LodMode::ErrorBound,
            error_px,
            error_color: steps / 255.0,
            ..Default::default()
        };
        (format!("{error_px} px, {steps}/255"), params)
    });
    for (name, params) in by_threshold.into_iter().chain(by_error) {
        let shot = bench.shoot(params)?;
        let ms = bench.cost(arguments.pictures)?;
        let file: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '.').collect();
        shot.picture.write(&arguments.out.join(format!("{file}.png")))?;
        let mask = full.mask.union(&shot.mask);
        let flip = mean(&mask.pick(&flip_map(&full.picture, &shot.picture)));
        let ssim = mean(&mask.pick(&ssim_map(&full.picture, &shot.picture)));
        let bias = mean(&mask.pick(&shot.thickness)) / mean(&mask.pick(&full.thickness)) - 1.0;
        println!(
            "| {name} | {ms:.0} | {:.2} | {:.2} | {} | {flip:.4} | {ssim:.4} | {:+.2} % |",
            ms / full_ms,
            shot.kept,
            shot.stand_ins,
            100.0 * bias
        );
        if IN_STRIP.contains(&name.as_str()) {
            in_strip.push(shot.picture);
        }
    }
    write_strip(&arguments.out.join("strip.jpg"), &in_strip, crop(&full.mask, view.size))
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lod-curves: {error}");
            ExitCode::FAILURE
        }
    }
}
