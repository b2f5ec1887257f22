//! Foam, spray and bubbles.

use glam::Vec3;
use meniscus_core::{Aabb, Choice, FrameRequest, Look, SeriesSpace, SetFrame};
use meniscus_gpu::role::{FoamDrop, FoamDrops, FoamLayers, Radiance};
use meniscus_gpu::{Binding, Buffer, Gpu, GpuError, Image, Recorder, Texture};
use meniscus_lod::{ChunkedSet, FoamOptions, LodParams, Mode, foam};
use meniscus_shading::{FoamLook, FoamPass, LightingInputs, WaterScale};
use meniscus_ssfr::{FoamSplats, FoamUniform, SurfaceImages};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{PipelineError, SettingsError};

/// What [`FoamSettings::velocity`] says for no velocities.
const NONE: &str = "none";
/// Particles of a frame whose velocities are looked at, at least.
const SAMPLED: usize = 1 << 14;
/// Share of the sampled speeds that violent flow is not slower than: what few escaped particles do is no measure.
const VIOLENT: f32 = 0.98;
/// How close to a side of its box water touches it.
const WALL_SPACINGS: f32 = 1.0;
/// Gravity, m/s^2.
const GRAVITY: f32 = 9.81;

/// Where there is foam, and how much of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FoamSettings {
    /// Factor on the optical depth of foam, 0 to 10; 0: none is looked for.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub amount: f32,
    /// Attribute with the velocities that say where air is trapped, or none: only particles on their own are foam, as spray. Left
    /// out: the one that goes by such a name, if there is one.
    pub velocity: Option<String>,
    /// Speed that closing speeds are counted in, length per time in the file's units, > 0; left out: what water of the data's depth
    /// reaches when it falls, or the fastest of its particles relative to their mean, whichever is more.
    #[schemars(range(min = 1e-30, max = 1e30))]
    pub speed: Option<f32>,
    /// Mean speed at which neighbours close in on a particle, in `speed`, at which foam begins, and from which on all is foam; 0 to
    /// 10, the second larger.
    #[schemars(inner(range(min = 0.0, max = 10.0)))]
    pub closing: [f32; 2],
    /// Optical depth of foam where the surface is bent sharply, 0 to 10; 0: none.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub curvature: f32,
    /// Sine of the angle between normals 0.6 spacings apart at which that begins, 0.01 to 1; in full at twice as much.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub curvature_threshold: f32,
}

impl Default for FoamSettings {
    fn default() -> Self {
        Self {
            amount: 0.0,
            velocity: None,
            speed: None,
            closing: FoamOptions::CLOSING,
            curvature: 0.0,
            curvature_threshold: 0.25,
        }
    }
}

impl FoamSettings {
    /// Whether drops of foam are looked for.
    pub fn has_drops(&self) -> bool {
        self.amount > 0.0
    }

    /// Whether there is any foam.
    pub fn is_on(&self) -> bool {
        self.has_drops() || self.curvature > 0.0
    }

    /// Name of the velocities that are to be read.
    pub(crate) fn velocity(&self) -> Option<&str> {
        self.velocity.as_deref().filter(|name| *name != NONE && self.has_drops())
    }

    pub(crate) fn validate(&self) -> Result<(), SettingsError> {
        let check = |name: &str, value: f32, [min, max]: [f32; 2]| {
            if (min..=max).contains(&value) {
                return Ok(());
            }
            Err(SettingsError::Stage(format!("foam.{name} is {value}; it must be {min} to {max}")))
        };
        check("amount", self.amount, [0.0, 10.0])?;
        check("curvature", self.curvature, [0.0, 10.0])?;
        check("curvature_threshold", self.curvature_threshold, [0.01, 1.0])?;
        check("speed", self.speed.unwrap_or(1.0), [1e-30, 1e30])?;
        let [begin, all] = self.closing;
        check("closing", begin, [0.0, 10.0])?;
        check("closing", all, [0.0, 10.0])?;
        if begin >= all {
            let message = format!("foam.closing is [{begin}, {all}]; the second must be larger");
            return Err(SettingsError::Stage(message));
        }
        Ok(())
    }

    /// Adds what has to be read to `request`.
    pub(crate) fn extend(&self, request: &mut FrameRequest) {
        let velocity = self.velocity().filter(|name| request.attributes.iter().all(|other| other != name));
        request.attributes.extend(velocity.map(str::to_owned));
    }

    /// What foam is found by in a series with the given speeds ([`sample`]), and what was chosen; `None` where none is looked for.
    pub(crate) fn options(
        &self,
        mut speeds: Vec<f32>,
        walls: Aabb,
        space: &SeriesSpace,
        scale: WaterScale,
    ) -> Option<(FoamOptions, Choice)> {
        if !self.has_drops() {
            return None;
        }
        let velocity = self.velocity().filter(|_| !speeds.is_empty()).map(str::to_owned);
        let fall = (GRAVITY / space.metres_per_unit as f32 * scale.depth_world).sqrt();
        let rank = (speeds.len().max(1) - 1) as f32 * VIOLENT;
        speeds.sort_unstable_by(f32::total_cmp);
        let violent = speeds.get(rank as usize).copied().unwrap_or(0.0);
        let speed = self.speed.unwrap_or(fall.max(violent));
        let choice = match &velocity {
            Some(name) => Choice {
                what: "foam".into(),
                value: format!(
                    "where neighbours close in by `{name}` at {:.3e} and more",
                    speed * self.closing[0]
                ),
                reason: match self.speed {
                    Some(_) => "as asked".into(),
                    None if fall >= violent => {
                        "a tenth of what water of that depth reaches when it falls".into()
                    }
                    None => "a tenth of what the fastest particles reach".into(),
                },
                flag: "--param foam.speed=SPEED".into(),
            },
            None => Choice {
                what: "foam".into(),
                value: "spray only, particles with few neighbours".into(),
                reason: "no velocities".into(),
                flag: "--param foam.velocity=NAME".into(),
            },
        };
        Some((FoamOptions { velocity, speed, closing: self.closing, up: space.up, walls }, choice))
    }
}

/// Where walls hold the water back: the sides of its box that it reaches in more than one of the frames with these bounds. A front
/// that runs on reaches none twice. Of a single frame it is not known, and all sides are taken for walls.
pub(crate) fn walls(frames: &[Aabb], spacing_world: f32) -> Aabb {
    let bounds = frames.iter().fold(Aabb::EMPTY, |all, of_frame| all.union(*of_frame));
    let near = WALL_SPACINGS * spacing_world;
    let is_wall = |gap: &dyn Fn(&Aabb) -> f32| {
        frames.iter().filter(|of_frame| gap(of_frame) <= near).count() >= frames.len().min(2)
    };
    let mut walls = Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
    for axis in 0..3 {
        if is_wall(&|of_frame| of_frame.min[axis] - bounds.min[axis]) {
            walls.min[axis] = bounds.min[axis];
        }
        if is_wall(&|of_frame| bounds.max[axis] - of_frame.max[axis]) {
            walls.max[axis] = bounds.max[axis];
        }
    }
    walls
}

/// Speeds of some of a frame's water relative to its mean, which a tank on a moving ship has as well.
pub(crate) fn sample(frame: &SetFrame, velocity: &str) -> Vec<f32> {
    let water = frame.sets.iter().filter(|set| set.look == Look::Water);
    let attributes = water.flat_map(|set| &set.particles.attributes);
    let velocities: Vec<Vec3> = attributes
        .filter(|a| a.name == velocity && a.components == 3)
        .flat_map(|a| {
            let step = (a.values.len() / 3 / SAMPLED).max(1);
            a.values.chunks_exact(3).step_by(step).map(Vec3::from_slice)
        })
        .filter(|v| v.is_finite())
        .collect();
    let mean = velocities.iter().map(|v| v.as_dvec3()).sum::<glam::DVec3>() / velocities.len().max(1) as f64;
    velocities.iter().map(|v| (v.as_dvec3() - mean).length() as f32).collect()
}

/// The drops of a set on the GPU.
#[derive(Debug, Default)]
pub(crate) struct GpuFoam {
    /// None where the set has no foam.
    pages: Vec<Buffer<FoamDrops>>,
    serial: Option<u64>,
}

impl GpuFoam {
    /// Uploads the drops of `set` unless they are there already.
    pub(crate) fn upload(&mut self, gpu: &Gpu, set: &ChunkedSet) -> Result<(), GpuError> {
        if self.serial == Some(set.serial()) {
            return Ok(());
        }
        self.serial = None;
        let drops = set.foam.as_deref().unwrap_or_default();
        let pages: Vec<&[_]> = drops.chunks(gpu.page_elements::<FoamDrop>()).collect();
        self.pages.truncate(pages.len());
        for (page, drops) in pages.into_iter().enumerate() {
            match self.pages.get_mut(page) {
                Some(buffer) => buffer.write(gpu, drops)?,
                None => self.pages.push(Buffer::from_slice(gpu, drops)?),
            }
        }
        self.serial = Some(set.serial());
        Ok(())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.pages.is_empty()
    }

    /// The pages, and what of them is drawn at this level of detail.
    pub(crate) fn drawn(
        &self,
        spacing_world: f32,
        settings: &FoamSettings,
        lod: &LodParams,
    ) -> Vec<(&Buffer<FoamDrops>, FoamUniform)> {
        let share = if lod.mode == Mode::Threshold { lod.threshold } else { 1.0 };
        let all = self.pages.iter().map(Buffer::len).sum();
        let mut left = foam::prefix(all, share);
        let of_page = |page: &Buffer<FoamDrops>| {
            let count = page.len().min(left);
            left -= count;
            FoamUniform {
                spacing_world,
                widening: foam::widening(share),
                amount: settings.amount,
                count: count as u32,
            }
        };
        self.pages.iter().zip(self.pages.iter().map(of_page)).collect()
    }
}

/// Draws foam; made for one size of pictures.
#[derive(Debug)]
pub(crate) struct FoamStage {
    splats: FoamSplats,
    pass: FoamPass,
    layers: Image<FoamLayers>,
    bare_radiance: Texture<Radiance>,
}

impl FoamStage {
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, PipelineError> {
        Ok(Self {
            splats: FoamSplats::new(gpu),
            pass: FoamPass::new(gpu)?,
            layers: Image::new(gpu, size)?,
            bare_radiance: Texture::new(gpu, size)?,
        })
    }

    /// Where the picture without foam is to be.
    pub(crate) fn bare_radiance(&self) -> &Texture<Radiance> {
        &self.bare_radiance
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.layers.size()
    }

    /// Draws the drops of `pages` over [`Self::bare_radiance`], which was lit from `inputs` and the surface in `images`: `radiance`.
    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of two passes, each used once")]
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        camera: &Binding,
        pages: &[(&Buffer<FoamDrops>, FoamUniform)],
        images: &SurfaceImages,
        inputs: &LightingInputs<'_>,
        look: &FoamLook,
        radiance: &Texture<Radiance>,
    ) {
        self.splats.record(recorder, gpu, camera, pages, images, inputs.scene_distance, &self.layers);
        self.pass.record(gpu, recorder, inputs, &self.layers, look, &self.bare_radiance, radiance);
    }
}
