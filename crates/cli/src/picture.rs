//! From picture flags to a renderer, a world and a camera.

use std::path::Path;

use glam::DVec3;
use meniscus_core::{Camera, Cancel, Choice, Flaws, FrameSource, Projection};
use meniscus_export::ExportError;
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_io::Series;
use meniscus_pipeline::{LodMode, LodParams, Meter, Registry, Renderer, Settings, World};
use meniscus_scene::{NamedView, above_ground, automatic_camera};

use crate::args::{Global, PictureArgs};
use crate::failure::Failure;
use crate::terminal::{Terminal, print};
use crate::values::{ColorRange, Detail, FoamAmount, Parameter};

/// Everything a picture needs besides its particles.
pub struct Studio {
    pub renderer: Renderer,
    pub world: World,
    pub camera: Camera,
    pub size: [u32; 2],
    /// The level of detail that was asked for.
    pub lod: LodParams,
    pub choices: Vec<Choice>,
    pub flaws: Flaws,
}

/// The settings that the flags ask for; prints them and gives `None` for `--param list`.
pub fn settings(args: &PictureArgs, registry: &Registry) -> Result<Option<Settings>, Failure> {
    let mut settings = Settings::default();
    let usage = |e: meniscus_pipeline::SettingsError| Failure::Usage(e.to_string());
    match args.lod {
        Detail::Threshold(threshold) => settings.lod.threshold = threshold,
        // Of a rate, these are the errors that are tolerated while it is held.
        Detail::Auto | Detail::Rate(_) => settings.lod.mode = LodMode::ErrorBound,
    }
    settings.scene.file.clone_from(&args.scene);
    settings.scene.environment.clone_from(&args.environment);
    settings.scene.sun = args.sun.map(|sun| sun.0);
    if let Some(name) = &args.filter {
        settings.choose_filter(registry, name).map_err(usage)?;
    }
    if let Some(name) = &args.lighting {
        settings.choose_lighting(registry, name).map_err(usage)?;
    }
    let color = &mut settings.color;
    color.by.clone_from(&args.color_by);
    if let Some(map) = &args.color_map {
        color.map.clone_from(map);
    }
    if let Some(ColorRange([min, max])) = args.color_range {
        (color.min, color.max) = (min, max);
    }
    color.log = args.color_log;
    if let Some(exposure) = args.exposure {
        settings.post.exposure = exposure.0;
    }
    if let Some(FoamAmount(amount)) = args.foam {
        settings.foam.amount = amount;
    }
    let mut list = false;
    for parameter in &args.params {
        match parameter {
            Parameter::List => list = true,
            Parameter::Set { key, value } => settings.set(key, value).map_err(usage)?,
        }
    }
    settings.validate(registry).map_err(usage)?;
    if list {
        settings.describe(registry).iter().for_each(|(key, value)| print(format_args!("{key}={value}")));
        return Ok(None);
    }
    Ok(Some(settings))
}

impl Studio {
    /// Opens the adapter, builds the renderer, and places scene and camera for the series.
    pub fn open(
        series: &Series,
        args: &PictureArgs,
        mut settings: Settings,
        global: &Global,
        registry: Registry,
        terminal: &Terminal,
    ) -> Result<Self, Failure> {
        let choice = AdapterChoice { adapter: global.adapter.clone(), require_gpu: global.require_gpu };
        let gpu = Gpu::new(&choice)?;
        let mut choices = series.choices().to_vec();
        choices.push(Choice {
            what: "adapter".into(),
            value: gpu.summary().name.clone(),
            reason: if global.adapter.is_some() { "as asked".into() } else { "the best there is".into() },
            flag: "--adapter NAME".into(),
        });
        let mut flaws = series.flaws().clone();
        gpu.flaw().cloned().into_iter().for_each(|flaw| flaws.add(flaw));
        settings.suit(gpu.summary());

        if settings.foam.velocity.is_none() {
            settings.foam.velocity = series.velocity().map(ToOwned::to_owned);
        }
        let world = World::of_series(series, *series.space(), &settings)?;
        // Pure water absorbs by its unit, not by the depth of the data.
        let is_pure = settings.lighting.parameters.get("pure_water") == Some(&serde_json::Value::Bool(true));
        choices.extend(world.choices().into_iter().filter(|choice| !is_pure || choice.what != "absorption"));
        choices.extend(args.params.iter().filter_map(vtk_name));
        if !sets_exposure(args) {
            choices.extend(settings.expose_for_liquid(&registry));
        }
        let (camera, camera_choice) = camera(args, &world, series.frame_count() > 1)?;
        choices.extend(camera_choice);
        terminal.choices(&choices);
        terminal.flaws(&flaws);
        let lod = settings.lod;
        let renderer = Renderer::new(gpu, registry, settings)?;
        Ok(Self { renderer, world, camera, size: args.size.0, lod, choices, flaws })
    }

    /// Fixes the exposure for all pictures where it is to be metered: on these frames of `source`, each from its camera. Those that
    /// cannot be read do not count.
    pub fn meter(
        &mut self,
        source: &dyn FrameSource,
        frames: &[(usize, Camera)],
        cancel: &Cancel,
        terminal: &Terminal,
    ) -> Result<(), Failure> {
        if self.renderer.settings().post.exposure.is_some() {
            return Ok(());
        }
        let preparer = self.renderer.preparer(&self.world);
        let mut meter = Meter::default();
        for (index, camera) in frames {
            if let Ok(frame) = source.read(*index, self.world.request(), cancel) {
                self.renderer.meter(&mut meter, &preparer.prepare(frame), &self.world, camera, self.size)?;
            }
        }
        match self.renderer.expose_by(&meter) {
            Ok(choice) => {
                terminal.choices(std::slice::from_ref(&choice));
                self.choices.push(choice);
            }
            Err(flaw) => {
                let flaws: Flaws = [flaw].into_iter().collect();
                terminal.flaws(&flaws);
                self.flaws.merge(&flaws);
            }
        }
        Ok(())
    }
}

/// Whether the exposure was said.
fn sets_exposure(args: &PictureArgs) -> bool {
    let is_it =
        |parameter: &Parameter| matches!(parameter, Parameter::Set { key, .. } if key == "post.exposure");
    args.exposure.is_some() || args.params.iter().any(is_it)
}

/// What a parameter in VTK's words was taken for.
fn vtk_name(parameter: &Parameter) -> Option<Choice> {
    let Parameter::Set { key, value } = parameter else { return None };
    let ours = Settings::key_of_vtk(key)?;
    Some(Choice {
        what: format!("`{key}`"),
        value: format!("{ours}={value}"),
        reason: "VTK's name of it".into(),
        flag: format!("--param {ours}=VALUE"),
    })
}

fn camera(args: &PictureArgs, world: &World, several: bool) -> Result<(Camera, Option<Choice>), Failure> {
    let space = world.space();
    let (mut camera, choice) = match (&args.camera, &args.view) {
        (Some(value), _) => {
            if value.eye == value.target {
                let at = value.eye;
                return Err(Failure::Usage(format!(
                    "--camera: eye and target are the same point {at}; move one of them"
                )));
            }
            let to_world = |point: DVec3| (point - space.origin).as_vec3();
            let camera = Camera {
                eye: to_world(value.eye),
                target: to_world(value.target),
                up: value.up.as_vec3(),
                projection: Projection::Perspective { fovy_rad: (value.fovy_deg.to_radians()) as f32 },
                near: world.near_distance(),
            };
            (camera, None)
        }
        (None, Some(name)) => {
            let view: NamedView =
                name.parse().map_err(|e: meniscus_scene::SceneError| Failure::Usage(e.to_string()))?;
            (view.camera(world.outline(), space.up, args.size.0), None)
        }
        (None, None) => {
            let camera = if world.scene().has_terrain {
                // From higher up: mountains stand around the water.
                NamedView::Iso.camera(world.outline(), space.up, args.size.0)
            } else {
                automatic_camera(world.outline(), space.up, args.size.0)
            };
            let file = |v: glam::Vec3| v.as_dvec3() + space.origin;
            let (eye, target) = (file(camera.eye), file(camera.target));
            let fovy = match camera.projection {
                Projection::Perspective { fovy_rad } => fovy_rad.to_degrees(),
                Projection::Orthographic { .. } => 0.0,
            };
            // A millionth of the way to the target, whatever the unit; for data near 1 and larger at least six decimals. Of no way, all there are.
            let decimals = 6 + (-eye.distance(target).log10()).ceil().clamp(0.0, 300.0) as usize;
            let comma = |v: DVec3| format!("{:.decimals$},{:.decimals$},{:.decimals$}", v.x, v.y, v.z);
            let up = camera.up.as_dvec3();
            let choice = Choice {
                what: "camera".into(),
                value: format!("\"{}/{}/{}/{fovy:.1}\"", comma(eye), comma(target), comma(up)),
                reason: if several { "fits first, middle and last frame" } else { "fits the particles" }
                    .into(),
                flag: "--camera or --view".into(),
            };
            (camera, Some(choice))
        }
    };
    if let Some(height) = args.ortho {
        camera.projection = Projection::Orthographic { height_world: height as f32 };
    }
    if let Some(near) = args.near {
        camera.near = near as f32;
    }
    camera.validate()?;
    if args.camera.is_none() {
        camera = above_ground(camera, space.up);
    }
    Ok((camera, choice))
}

/// Makes the folder of the file that `flag` names, so that a path that cannot be written is noticed before any work is done.
pub fn prepare_path(flag: &str, path: &Path) -> Result<(), Failure> {
    if path.is_dir() || path.file_name().is_none() {
        return Err(Failure::Usage(format!("{flag} {}: this is a folder; give a file name", path.display())));
    }
    match path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        Some(folder) => std::fs::create_dir_all(folder)
            .map_err(|source| ExportError::Io { path: path.to_owned(), source }.into()),
        None => Ok(()),
    }
}
