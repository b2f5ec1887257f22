//! What level of detail costs and what it changes: cost of a frame and error of the picture over the threshold and over the
//! tolerated error, as rows of a table for `benches/RESULTS.md`, with pictures.
//!
//!     cargo run --release -p meniscus-tests --bin lod-curves -- dam/dam_break_0001.vtu \
//!         --camera 4.2,-2.2,1.9/1.4,0.5,0.15/20 --size 1280x720 --out target/curves
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program; printing is its job")]

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use glam::{Quat, Vec3};
use meniscus_core::{Camera, Cancel, FrameRequest, FrameSource, Projection};
use meniscus_gpu::role::NO_SURFACE;
use meniscus_gpu::{AdapterChoice, Gpu, process_cpu_ms};
use meniscus_io::{Series, SeriesOptions};
use meniscus_pipeline::{LodMode, LodParams, PreparedFrame, Registry, Renderer, Settings, World};
use meniscus_tests::golden::{flip_map, ssim_map};
use meniscus_tests::{Mask, Pixels};

/// Cost and error of a frame over the level of detail.
#[derive(Parser)]
struct Arguments {
    /// A file or a series, of which the first frame is drawn
    input: PathBuf,

    /// Eye, point looked at (the file's coordinates) and vertical field of view in degrees; z is up
    #[arg(long, value_name = "ex,ey,ez/tx,ty,tz/fovy", allow_hyphen_values = true, value_parser = view)]
    camera: ([f64; 3], [f64; 3], f64),

    /// Picture size
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    size: [u32; 2],

    /// Pictures per row; the table has their median
    #[arg(long, default_value_t = 5)]
    pictures: usize,

    /// Folder for pictures; made if missing
    #[arg(long)]
    out: PathBuf,
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let found: Vec<f64> = text.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
    found.try_into().ok()
}

fn view(text: &str) -> Result<([f64; 3], [f64; 3], f64), String> {
    let parts: Vec<&str> = text.split('/').collect();
    let [eye, target, fovy] = parts[..] else { return Err("expected eye/target/fovy".into()) };
    let wrong = || "expected ex,ey,ez/tx,ty,tz/fovy".to_owned();
    let [fovy] = numbers(fovy).ok_or_else(wrong)?;
    Ok((numbers(eye).ok_or_else(wrong)?, numbers(target).ok_or_else(wrong)?, fovy))
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
    fn open(arguments: &Arguments) -> Result<Self, Box<dyn Error>> {
        let series = Series::open(&arguments.input, &SeriesOptions::default())?;
        let settings = Settings::default();
        let world = World::of_series(&series, *series.space(), &settings)?;
        let gpu = Gpu::new(&AdapterChoice::default())?;
        println!("{}", gpu.summary().name);
        let renderer = Renderer::new(gpu, Registry::builtin(), settings)?;
        let frame = series.read(0, &FrameRequest::default(), &Cancel::default())?;
        let frame = renderer.preparer(&world).prepare(frame);
        let (eye, target, fovy_deg) = arguments.camera;
        let to_world = |p: [f64; 3]| (glam::DVec3::from(p) - world.space().origin).as_vec3();
        let camera = Camera {
            eye: to_world(eye),
            target: to_world(target),
            up: Vec3::Z,
            projection: Projection::Perspective { fovy_rad: fovy_deg.to_radians() as f32 },
            near: world.near_distance(),
        };
        Ok(Self { renderer, world, frame, camera, size: arguments.size })
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

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(&arguments.out)?;
    let mut bench = Bench::open(arguments)?;
    let full = bench.shoot(LodParams::default())?;
    full.picture.write(&arguments.out.join("full.png"))?;
    let full_ms = bench.cost(arguments.pictures)?;
    let [width, height] = arguments.size;
    println!(
        "{width}x{height}, {:.0} % covered\n\n| | CPU-ms a frame | of full | kept | stand-ins | FLIP | SSIM | thickness |",
        100.0 * full.mask.share()
    );
    println!("|---|---|---|---|---|---|---|---|");
    println!("| full detail | {full_ms:.0} | 1.00 | {:.2} | 0 | - | - | - |", full.kept);
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
    }
    Ok(())
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
