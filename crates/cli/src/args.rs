//! The command line as clap sees it. Flags that several commands share are structs that those commands flatten in.

mod film;

use std::path::PathBuf;

use clap::builder::ArgPredicate;
use clap::{Args, Parser, Subcommand, ValueEnum};
use meniscus_core::UpAxis;
use meniscus_io::{IoMode, Region};

use meniscus_pipeline::{Layer, LodView};

pub use film::{EncodingArgs, ExposureArgs, JoinArgs, TimeArgs};

use crate::failure::Failure;
use crate::values::{
    ByteCount, CameraValue, CaseName, ColorRange, Detail, ExposureValue, FoamAmount, FrameRange, ImageSize,
    MediumSpeed, MemorySize, Parameter, SunValue, Unit,
};

/// Exit codes, printed under every `--help`.
const EXIT_CODES: &str = "Exit codes: 0 done; 1 drawing or the GPU failed; 2 the command line is wrong; 3 the input cannot \
     be read; 4 no usable adapter; 5 the output cannot be written; 130 interrupted.";

/// Photo-realistic water from the particle files of fluid simulations.
#[derive(Debug, Parser)]
#[command(name = "meniscus", version, after_help = EXIT_CODES, propagate_version = true, disable_help_subcommand = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Option<Command>,

    /// Flags of every command.
    #[command(flatten)]
    pub global: Global,
}

/// Flags that every command takes.
#[derive(Clone, Debug, Args)]
pub struct Global {
    /// Print errors only.
    #[arg(short, long, global = true)]
    pub quiet: bool,

    /// Say more: -v what is done, -vv everything.
    #[arg(short, long, global = true, action = clap::ArgAction::Count, conflicts_with = "quiet")]
    pub verbose: u8,

    /// Worker threads for reading and preparing [default: one per core].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,

    /// Adapter that draws: its number in --list-adapters or part of its name [default: the best GPU, else software].
    #[arg(long, global = true, value_name = "NAME")]
    pub adapter: Option<String>,

    /// Fail rather than draw with a software adapter.
    #[arg(long, global = true)]
    pub require_gpu: bool,

    /// List the adapters and leave.
    #[arg(long)]
    pub list_adapters: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
#[expect(clippy::large_enum_variant, reason = "there is one in a process")]
pub enum Command {
    /// Say what is in a file or series.
    #[command(
        after_help = "Examples:\n  meniscus info fluid.pvd\n  meniscus info frames/ --frame 10 --stats\n  \
        meniscus info 'out_*.vtu' --json"
    )]
    Info(InfoArgs),
    /// Draw one picture, a numbered sequence or a film.
    #[command(after_help = "Examples:\n  meniscus render fluid.vtu -o water.png\n  \
        meniscus render fluid.pvd -o 'out_%04d.png'\n  meniscus render fluid.pvd -o still.png --frame 12 --size 1920x1080\n  \
        meniscus render dam.pvd -o 'dam_%04d.png' --where 'type == 0'\n  \
        meniscus render dam.pvd -o dam.png --frame 5 --set \"water=type == 0\" --set \"walls=type == 1:hidden\"\n  \
        meniscus render fluid.vtu -o side.png --camera \"0.5,0.3,1/0,0.1,0/0,1,0/35\"\n  \
        meniscus render fluid.pvd -o 'out_%04d.png' --trace trace.json\n  \
        meniscus render fluid.vtu -o milk.png --param lighting.attenuation_scale=20")]
    Render(RenderArgs),
    /// Measure the steady state: a camera that orbits half a degree every frame.
    #[command(
        after_help = "Examples:\n  meniscus bench fluid.vtu --size 1280x720 --frames 20\n  \
        meniscus bench fluid.vtu --json > full.json\n  meniscus bench fluid.vtu --lod 0.3 --json > lod.json\n  \
        meniscus bench fluid.vtu --trace trace.json\n  \
        meniscus bench fluid.pvd --play\n  meniscus bench fluid.pvd --play --rounds 3 --medium 80 --memory 2GB\n  \
        meniscus bench --compare full.json lod.json",
        mut_arg("input", |input| input
            .required(false)
            .required_unless_present("compare")
            .default_value_if("compare", ArgPredicate::IsPresent, "-"))
    )]
    Bench(BenchArgs),
    /// Write particles in another format, all attributes in their own types, with what the selection takes.
    #[command(after_help = "Examples:\n  meniscus convert fluid.vtu -o fluid.vtk\n  \
        meniscus convert fluid.pvd -o 'small/water_%04d.vtu' --every 10 --encoding zlib\n  \
        meniscus convert dam.pvd -o water.vtp --frame 5 --where 'type == 0'")]
    Convert(ConvertArgs),
    /// Make a particle series to try things on: analytic motion for size and regression, not a simulation.
    #[command(after_help = "Examples:\n  meniscus make dam-break -o dam --particles 100000 --frames 24\n  \
        meniscus make fjord-tsunami -o fjord --format vtk-binary")]
    Make(MakeArgs),
    /// Put numbered pictures together to a film, e.g. those of several machines.
    #[command(after_help = "Examples:\n  meniscus join 'out_%04d.png' -o film.mp4\n  \
        meniscus join machine1 machine2 machine3 -o film.mp4 --fps 30")]
    Join(JoinArgs),
}

/// What to read and how; shared by all commands that read.
#[derive(Clone, Debug, Args)]
pub struct InputArgs {
    /// A .vtk, .vtu, .vtp, .bgeo, .ply, .csv or .xyz file, a .pvd or .series, a directory, a quoted glob, or a pattern like frame_%04d.vtu.
    pub input: PathBuf,

    /// Distance between neighbouring particles, in the file's unit [default: from mass and density, else estimated].
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub spacing: Option<f64>,

    /// Radius drawn, in the file's unit; does not change the mean thickness [default: 0.625 spacing; up to 1 where particles lie at random].
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub radius: Option<f64>,

    /// Attribute that says how large each particle is (radius, diameter, volume, mass, smoothing length), or none: all are alike
    /// [default: one that varies, if that is sure].
    #[arg(long, value_name = "NAME|none")]
    pub radius_by: Option<String>,

    /// A named particle set and how it is drawn (water, solid, spheres, hidden); PATTERN is an expression as in --where.
    #[arg(long = "set", value_name = "NAME=PATTERN[:LOOK]")]
    pub sets: Vec<String>,

    /// Which particles are water, e.g. 'type == 0 and z < 2'.
    #[arg(long = "where", value_name = "EXPR")]
    pub where_expr: Option<String>,

    /// Take every n-th particle: by id where the file has one, so that the same ones are taken in every frame.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub every: Option<u32>,

    /// Take the particles inside this box, in the file's coordinates; a limit left empty does not limit.
    #[arg(long = "box", value_name = "xmin,xmax,ymin,ymax,zmin,zmax", allow_hyphen_values = true)]
    pub region: Option<Region>,

    /// Time between frames [default: what the files state].
    #[arg(long = "dt", value_name = "SECONDS", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub time_step: Option<f64>,

    /// How files come into memory; auto maps local files at rest, and reads those on a network or just written.
    #[arg(long = "io", value_name = "auto|map|read", default_value = "auto")]
    pub io_mode: IoMode,

    /// Keep points that the file marks as ghosts: copies that a neighbouring process owns.
    #[arg(long)]
    pub keep_ghosts: bool,

    /// Axis that points up.
    #[arg(long, value_enum, default_value_t = UpArg::Auto)]
    pub up: UpArg,

    /// Unit of the file's coordinates: m, cm, mm, or metres per unit.
    #[arg(long, value_name = "m|cm|mm|FACTOR")]
    pub unit: Option<Unit>,
}

/// `--up`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpArg {
    /// Guess from the data.
    Auto,
    /// x points up.
    X,
    /// y points up.
    Y,
    /// z points up.
    Z,
}

impl UpArg {
    /// The axis, `None` to guess.
    pub fn axis(self) -> Option<UpAxis> {
        match self {
            Self::Auto => None,
            Self::X => Some(UpAxis::X),
            Self::Y => Some(UpAxis::Y),
            Self::Z => Some(UpAxis::Z),
        }
    }
}

/// `meniscus info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// What to read.
    #[command(flatten)]
    pub input: InputArgs,

    /// Frame to look into.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_name = "N")]
    pub frame: usize,

    /// Read every attribute and give its smallest and largest value per component.
    #[arg(long)]
    pub stats: bool,

    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Everything that decides what a picture looks like; shared by `render` and `bench`.
#[derive(Clone, Debug, Args)]
pub struct PictureArgs {
    /// Width and height in pixels.
    #[arg(long, default_value = "1280x720", value_name = "WxH")]
    pub size: ImageSize,

    /// Level of detail: the fraction of the particles that are drawn (1 is full detail), or auto for as few as cannot be told
    /// from all (--param lod.error_px, lod.error_color); for `bench` also a rate to hold, like 30fps.
    #[arg(long, default_value_t = Detail::Threshold(1.0), allow_negative_numbers = true, value_name = "0..1|auto|FPSfps")]
    pub lod: Detail,

    /// Distance from the eye before which nothing is drawn, in the file's unit [default: a thousandth of the data's diagonal].
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub near: Option<f64>,

    /// Eye, target, up vector and vertical field of view in degrees, in the file's coordinates.
    #[arg(
        long,
        value_name = "ex,ey,ez/tx,ty,tz/ux,uy,uz/fovy",
        conflicts_with = "view",
        allow_hyphen_values = true
    )]
    pub camera: Option<CameraValue>,

    /// A named view instead of the automatic one.
    #[arg(long, value_name = "front|back|left|right|top|iso")]
    pub view: Option<String>,

    /// Parallel projection with this height of the picture in the file's unit.
    #[arg(long, value_name = "HEIGHT", allow_negative_numbers = true, value_parser = crate::values::positive)]
    pub ortho: Option<f64>,

    /// Surface filter: see --param for its parameters.
    #[arg(long, value_name = "NAME")]
    pub filter: Option<String>,

    /// Lighting model.
    #[arg(long, value_name = "NAME")]
    pub lighting: Option<String>,

    /// Colour the water and all other sets by this attribute: of a vector the magnitude, or a component as in velocity:x. The range
    /// is that of the whole series; sets without the attribute keep their colour.
    #[arg(long, value_name = "NAME[:COMPONENT]")]
    pub color_by: Option<String>,

    /// Colour map: viridis, inferno, plasma, magma, cividis, turbo, cool-to-warm or grayscale.
    #[arg(long, value_name = "NAME", requires = "color_by")]
    pub color_map: Option<String>,

    /// Values at the start and the end of the colours; one left empty is found in the series.
    #[arg(long, value_name = "MIN,MAX", requires = "color_by", allow_hyphen_values = true)]
    pub color_range: Option<ColorRange>,

    /// Logarithmic colours.
    #[arg(long, requires = "color_by")]
    pub color_log: bool,

    /// Foam, spray and bubbles: how much of them, 1 is the usual amount; --param foam.* for where they are [default: off].
    #[arg(long, value_name = "AMOUNT|off")]
    pub foam: Option<FoamAmount>,

    /// Scene file: terrain, floor, walls, boxes, sun and sky [default: a tiled floor under a clear sky].
    #[arg(long, value_name = "FILE.toml")]
    pub scene: Option<PathBuf>,

    /// Picture of the surroundings, .hdr or .exr: equirectangular, or cube faces in a cross or a strip; replaces sun and sky.
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,

    /// Where the sun stands, in degrees: clockwise from north seen from above, and above the horizon; makes a physical sky.
    #[arg(long, value_name = "AZIMUTH,ELEVATION", allow_hyphen_values = true)]
    pub sun: Option<SunValue>,

    /// Exposure in stops, each one more doubles the light, or auto: metered on the first, middle and last picture, then the same
    /// for all [default: 0, less for white liquids].
    #[arg(long, value_name = "EV|auto", allow_hyphen_values = true)]
    pub exposure: Option<ExposureValue>,

    /// Set a parameter, e.g. post.exposure=1.5; `--param list` prints them all with their values.
    #[arg(long = "param", value_name = "KEY=VALUE")]
    pub params: Vec<Parameter>,
}

/// Frames of the series, for commands that go through them.
#[derive(Clone, Debug, Args)]
pub struct WantedFrames {
    /// The one frame to take [default: all].
    #[arg(long, value_name = "N", allow_negative_numbers = true, conflicts_with = "frames")]
    pub frame: Option<usize>,

    /// Frames to take, the last one included; either end may be left out.
    #[arg(long, value_name = "A..B")]
    pub frames: Option<FrameRange>,
}

impl WantedFrames {
    /// Their indices in a series of `count` frames.
    pub fn within(&self, count: usize) -> Result<Vec<usize>, Failure> {
        match (self.frame, self.frames) {
            (Some(frame), _) if frame >= count => Err(Failure::Usage(format!(
                "--frame {frame}: the series has frames 0 to {}",
                count.max(1) - 1
            ))),
            (Some(frame), _) => Ok(vec![frame]),
            (None, Some(range)) => Ok(range.within(count).map_err(Failure::Usage)?.collect()),
            (None, None) => Ok((0..count).collect()),
        }
    }
}

/// What `--overlay` writes over pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OverlayItem {
    /// The time of the simulation.
    Time,
    /// What the colours of --color-by mean.
    Legend,
    /// A length; under perspective that of things at the centre of the view.
    Scale,
    /// The --text.
    Text,
}

/// `meniscus render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// What to read.
    #[command(flatten)]
    pub input: InputArgs,

    /// Picture to write (.png, .jpg, or .exr with linear radiance), a pattern like out_%04d.png for a sequence, or a film (.mp4,
    /// .avi; more with --encoder ffmpeg).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Which frames.
    #[command(flatten)]
    pub wanted: WantedFrames,

    /// How the picture is made.
    #[command(flatten)]
    pub picture: PictureArgs,

    /// Move the camera: a file of [[key]]s with `at` (seconds of film), `eye`, `target`, `up` and `fovy_deg`.
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["camera", "view", "ortho"])]
    pub camera_path: Option<PathBuf>,

    /// Draw N times as wide and high and take the mean: smoother edges, N x N times the work.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub supersample: u32,

    /// Leave the background transparent (.png, .exr); --param post.transparent=true.
    #[arg(long)]
    pub transparent: bool,

    /// Write over the pictures, several with commas: the time, a legend of --color-by, a scale bar, the --text.
    #[arg(long, value_enum, value_name = "WHAT", value_delimiter = ',')]
    pub overlay: Vec<OverlayItem>,

    /// Text at the top of the pictures.
    #[arg(long, value_name = "TEXT")]
    pub text: Option<String>,

    /// What else an .exr holds, several with commas: depth, normal, thickness, kept (share of the particles drawn), fluid, scene.
    #[arg(long, value_name = "LAYER", value_delimiter = ',')]
    pub layers: Vec<Layer>,

    /// Bits per channel, 8 or 16 [default: 8 for .png, 16 for .exr].
    #[arg(long, value_name = "8|16", value_parser = crate::values::bits)]
    pub bits: Option<u8>,

    /// Which moments are shown.
    #[command(flatten)]
    pub time: TimeArgs,

    /// How pictures and films are encoded.
    #[command(flatten)]
    pub encoding: EncodingArgs,

    /// What every picture is the mean of.
    #[command(flatten)]
    pub exposure: ExposureArgs,

    /// Memory for frames read ahead: a share of what is free, or bytes, like 500MB [default: half of what is free].
    #[arg(long, value_name = "SHARE|BYTES")]
    pub memory: Option<MemorySize>,

    /// Show what level of detail decided instead: lod-kept, lod-chunks, lod-levels on the water, or lod-culled, a map of what
    /// was drawn (green), tested (blue) and left out (red: outside, violet: too near, grey: too far).
    #[arg(long, value_name = "VIEW", conflicts_with_all = ["samples", "motion_blur", "aperture"])]
    pub show: Option<LodView>,

    /// Write a JSON report: adapter, milliseconds per stage, work done, automatic choices, flaws.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,

    /// Write what ran when - reading ahead, waiting, drawing, encoding - as a trace that ui.perfetto.dev opens.
    #[arg(long, value_name = "FILE.json")]
    pub trace: Option<PathBuf>,
}

/// `meniscus bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// What to read.
    #[command(flatten)]
    pub input: InputArgs,

    /// Frame of the series that is drawn.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, value_name = "N")]
    pub frame: usize,

    /// How the picture is made.
    #[command(flatten)]
    pub picture: PictureArgs,

    /// Pictures to measure.
    #[arg(long, default_value_t = 20, value_name = "K", conflicts_with = "play",
        value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,

    /// Playing the series.
    #[command(flatten)]
    pub play: PlayArgs,

    /// Pictures drawn before measuring; a few more while they still get faster, none for 0.
    #[arg(long, default_value_t = 3, value_name = "K", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub warmup: u32,

    /// Write what ran when - pictures, their passes, what they counted - as a trace that ui.perfetto.dev opens.
    #[arg(long, value_name = "FILE.json", conflicts_with = "compare")]
    pub trace: Option<PathBuf>,

    /// Draw nothing; print the ratios B / A of two runs, from `bench --json` or `render --report`.
    #[arg(long, num_args = 2, value_names = ["A.json", "B.json"], conflicts_with = "input")]
    pub compare: Vec<PathBuf>,

    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// What `bench --play` plays, and from what.
#[derive(Clone, Debug, Args)]
pub struct PlayArgs {
    /// Play the series as a viewer would, reading ahead, from --frame on, and measure that: stalls, rates, processor time and
    /// memory; before that every frame is read and drawn without reading ahead. Ctrl-C ends playing early.
    #[arg(long, conflicts_with = "compare")]
    pub play: bool,

    /// Pictures per second at most [default: as many as can be drawn].
    #[arg(long, value_name = "RATE", requires = "play", value_parser = crate::values::positive)]
    pub fps: Option<f64>,

    /// Frames from one picture to the next: -1 plays backwards, 4 shows every fourth.
    #[arg(long, value_name = "N", requires = "play", default_value_t = 1, allow_negative_numbers = true,
        value_parser = step)]
    pub step: isize,

    /// How many times the series is played, from the end on to the start.
    #[arg(long, value_name = "K", requires = "play", default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub rounds: u32,

    /// Memory for frames read ahead or kept for the next round: a share of what is free, or bytes, like 500MB [default: half
    /// of what is free].
    #[arg(long, value_name = "SHARE|BYTES", requires = "play")]
    pub memory: Option<MemorySize>,

    /// Memory of the GPU for particles that are drawn, uploaded ahead or kept for the next round [default: 1GB; with a software
    /// adapter, which draws from the memory that is read into, only what is drawn].
    #[arg(long, value_name = "BYTES", requires = "play")]
    pub gpu_memory: Option<ByteCount>,

    /// Read as if from a medium of this many MB per second, or one that takes so many times as long for a frame as drawing it
    /// does, like 0.9x.
    #[arg(long, value_name = "MB/S|FACTORx", requires = "play")]
    pub medium: Option<MediumSpeed>,

    /// Jump to so many places all over the series instead, as somebody does who drags the seek bar, and measure how soon
    /// something and all of each frame is seen.
    #[arg(long, value_name = "K", requires = "play", conflicts_with_all = ["rounds", "fps", "step", "follow"],
        value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub jumps: Option<u32>,

    /// Drop the files from the system's cache before they are played (Linux).
    #[arg(long, requires = "play")]
    pub cold: bool,

    /// Play frames, too, that are added to the series meanwhile.
    #[arg(long, requires = "play")]
    pub follow: bool,
}

fn step(text: &str) -> Result<isize, String> {
    text.parse()
        .ok()
        .filter(|step| *step != 0)
        .ok_or_else(|| "expected a whole number other than 0".to_owned())
}

/// `meniscus convert`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// What to read.
    #[command(flatten)]
    pub input: InputArgs,

    /// File to write (.vtu, .vtp, .vtk), or a pattern like out_%04d.vtu for a series, which gets a .pvd beside it.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Which frames.
    #[command(flatten)]
    pub wanted: WantedFrames,

    /// How numbers are stored.
    #[arg(long, value_enum, default_value_t = ConvertEncoding::Raw)]
    pub encoding: ConvertEncoding,
}

/// `--encoding` of `convert`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ConvertEncoding {
    /// As in memory: the fastest to read.
    Raw,
    /// Blocks compressed as VTK does it; .vtu and .vtp.
    Zlib,
    /// Blocks compressed faster, but less; .vtu and .vtp.
    Lz4,
    /// Blocks compressed as small as can be, slowly; .vtu and .vtp.
    Lzma,
    /// Text that holds the bytes; .vtu and .vtp.
    Base64,
    /// Text that people can read.
    Ascii,
}

/// `meniscus make`.
#[derive(Debug, Args)]
pub struct MakeArgs {
    /// Which case; the fjord comes with its land, a scene file for `render --scene`.
    #[arg(value_name = "sphere-entry|dam-break|fjord-tsunami")]
    pub case: CaseName,

    /// Folder for the files; made if missing.
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Number of particles [default: that of the published case].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=200_000_000))]
    pub particles: Option<u64>,

    /// Number of frames.
    #[arg(long, default_value_t = 1, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,

    /// Seed of the jitter and the spray.
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    pub seed: u64,

    /// File format.
    #[arg(long, value_enum, default_value_t = MakeFormat::VtuRaw)]
    pub format: MakeFormat,
}

/// `--format` of `make`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MakeFormat {
    /// .vtu, appended raw, uncompressed.
    VtuRaw,
    /// .vtu, appended raw, zlib.
    VtuZlib,
    /// Legacy .vtk 5.1, binary.
    VtkBinary,
}
