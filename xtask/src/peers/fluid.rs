//! VTK's fluid mapper against `meniscus bench`.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{
    samples::{Samples, median, ratio, spread},
    tool::{Tools, json},
};
use crate::{
    error::{Error, Result},
    process,
};

/// What `bench-peers make` says.
#[derive(Debug, Clone, Deserialize, Serialize)]
pub struct Files {
    pub view: String,
    pub why: String,
    pub particles: u64,
    pub size: [u32; 2],
    pub camera: String,
    pub spacing: f64,
    pub radius: f64,
    pub raw: PathBuf,
    pub zlib: PathBuf,
    pub legacy: PathBuf,
}

/// One way of drawing a view.
#[derive(Debug, Serialize)]
pub struct Variant {
    pub name: &'static str,
    /// `None` where the tool is not there.
    pub samples: Option<Samples>,
    pub picture: PathBuf,
}

/// A view at one radius.
#[derive(Debug, Serialize)]
pub struct Comparison {
    pub files: Files,
    /// Drawn radius in spacings.
    pub radius_spacings: f64,
    pub radius: f64,
    /// The peer's, then ours.
    pub theirs: Vec<Variant>,
    pub ours: Vec<Variant>,
}

/// What `meniscus bench --json` says of whole frames.
#[derive(Deserialize)]
struct Bench {
    frame: BenchFrame,
}

#[derive(Deserialize)]
struct BenchFrame {
    wall_ms: BenchSpread,
    cpu_ms: BenchSpread,
}

#[derive(Deserialize)]
struct BenchSpread {
    median: f64,
}

const THEIRS: [(&str, &str); 2] = [("VTK, tuned", "tuned"), ("VTK, as it comes", "default")];

/// The bare rows have what VTK draws and nothing else: water over a sky, no floor, no shadow, no anti-aliasing. Those with VTK's
/// lighting have its composite, over our floor unless bare.
const OURS: [(&str, &[&str]); 7] = [
    ("meniscus", &[]),
    (
        "meniscus, bare",
        &["--scene", "bare.toml", "--param", "lighting.shadow=0", "--param", "post.anti_aliasing=false"],
    ),
    ("meniscus, --lod 0.3", &["--lod", "0.3"]),
    ("meniscus, vtk lighting", &["--lighting", "vtk"]),
    ("meniscus, vtk lighting, --lod 0.3", &["--lighting", "vtk", "--lod", "0.3"]),
    (
        "meniscus, vtk lighting, bare",
        &["--lighting", "vtk", "--scene", "bare.toml", "--param", "post.anti_aliasing=false"],
    ),
    (
        "meniscus, vtk lighting, bare, --lod 0.3",
        &["--lighting", "vtk", "--scene", "bare.toml", "--param", "post.anti_aliasing=false", "--lod", "0.3"],
    ),
];

const BARE_SCENE: &str = "[floor]\nvisible = false\n";

/// The published comparison draws particles of 0.9 spacings.
const PUBLISHED_SPACINGS: f64 = 0.9;

/// Draws `view` with all tools in turn.
pub fn compare(
    tools: &Tools,
    folder: &Path,
    view: &str,
    divide: u64,
    rounds: u32,
) -> Result<Vec<Comparison>> {
    let folder = folder.join(if divide > 1 { format!("{view}-quick") } else { view.to_owned() });
    let mut make = tools.ours("bench-peers");
    let files: Files = json(make.args(["make", view]).arg(&folder).args(["--divide", &divide.to_string()]))?;
    let scene = folder.join("bare.toml");
    std::fs::write(&scene, BARE_SCENE).map_err(|source| Error::File { path: scene, source })?;
    let radii = [files.radius / files.spacing, PUBLISHED_SPACINGS];
    radii.map(|spacings| at_radius(tools, &folder, &files, spacings, rounds)).into_iter().collect()
}

fn at_radius(tools: &Tools, folder: &Path, files: &Files, spacings: f64, rounds: u32) -> Result<Comparison> {
    let radius = spacings * files.spacing;
    let picture = |name: &str| folder.join(format!("{}-{spacings:.3}.png", name.replace([',', ' '], "")));
    let variant = |name| Variant { name, samples: None, picture: picture(name) };
    let mut comparison = Comparison {
        files: files.clone(),
        radius_spacings: spacings,
        radius,
        theirs: THEIRS.map(|(name, _)| variant(name)).into(),
        ours: OURS.map(|(name, _)| variant(name)).into(),
    };
    let size = format!("{}x{}", files.size[0], files.size[1]);
    let view =
        ["--radius", &radius.to_string(), "--camera", &files.camera, "--size", &size].map(String::from);
    // Time per frame differs by an order of magnitude; so do the frames that a median needs minutes for.
    let (their_frames, our_frames) = if files.particles > 4_000_000 { ("1", "3") } else { ("3", "8") };
    for round in 0..rounds {
        for ((_, look), variant) in THEIRS.iter().zip(&mut comparison.theirs) {
            let Some(mut vtk) = tools.script("vtk_fluid.py") else { continue };
            // VTK absorbs over a length of one; a quarter of the cube of all water is about what one looks through.
            let depth = 0.25 * files.spacing * (files.particles as f64).cbrt();
            let scale = (1.0 / depth).to_string();
            vtk.arg(&files.raw).arg(&variant.picture).args(&view);
            vtk.args(["--look", look, "--attenuation-scale", &scale, "--frames", their_frames]);
            let frames: Samples = json(&mut vtk)?;
            if let Some((wall_ms, cpu_ms)) = median(&frames.wall_ms).zip(median(&frames.cpu_ms)) {
                variant.samples.get_or_insert_default().add(wall_ms, cpu_ms);
            }
        }
        for ((_, flags), variant) in OURS.iter().zip(&mut comparison.ours) {
            let with_view = |command: &str| {
                let mut meniscus = tools.ours("meniscus");
                meniscus.current_dir(folder).arg(command).arg(&files.raw).args(&view).args(*flags);
                meniscus.arg("--quiet");
                meniscus
            };
            let mut bench = with_view("bench");
            bench.args(["--json", "--frames", our_frames]);
            let BenchFrame { wall_ms, cpu_ms } = json::<Bench>(&mut bench)?.frame;
            variant.samples.get_or_insert_default().add(wall_ms.median, cpu_ms.median);
            if round == 0 {
                let mut render = with_view("render");
                process::run(render.arg("--output").arg(&variant.picture))?;
            }
        }
    }
    Ok(comparison)
}

/// Ready for `benches/RESULTS.md`.
pub fn markdown(views: &[Vec<Comparison>]) -> String {
    let mut text = String::new();
    for comparison in views.iter().flatten() {
        let Files { view, particles, size, .. } = &comparison.files;
        text += &format!(
            "**{view}**: {particles} particles, {}x{}, radius {:.3} spacings\n\n",
            size[0], size[1], comparison.radius_spacings,
        );
        text += "| | CPU-ms a frame | wall ms | tuned VTK over this, CPU | wall |\n|---|---|---|---|---|\n";
        let reference = comparison.theirs[0].samples.clone().unwrap_or_default();
        for variant in comparison.theirs.iter().chain(&comparison.ours) {
            let Some(samples) = &variant.samples else { continue };
            let times = |r: Option<f64>| r.map_or_else(|| "-".to_owned(), |r| format!("{r:.1}"));
            text += &format!(
                "| {} | {} | {} | {} | {} |\n",
                variant.name,
                spread(&samples.cpu_ms),
                spread(&samples.wall_ms),
                times(ratio(&reference.cpu_ms, &samples.cpu_ms)),
                times(ratio(&reference.wall_ms, &samples.wall_ms)),
            );
        }
        text.push('\n');
    }
    text
}
