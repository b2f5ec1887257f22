use glam::Vec3;
use meniscus_color::{ColorScale, Quantity};
use meniscus_core::{
    Aabb, Cancel, Choice, DEFAULT_RADIUS_PER_SPACING, FrameRequest, FrameSource, Look, RadiusChoice,
    SeriesSpace, SetFrame, Short, UNEVEN_RADIUS_PER_SPACING,
};
use meniscus_lod::FoamOptions;
use meniscus_scene::{Description, Scene};
use meniscus_shading::WaterScale;
use meniscus_ssfr::AnisotropyParams;

use crate::colors::{sample, uncolored, without_values};
use crate::measure::{Extent, column_depth, extent, outline};
use crate::{FoamSettings, PipelineError, Settings, foam};

/// What stays the same over a series: its space, the room it takes, the scene around it and how clear the water is.
#[derive(Clone, Debug)]
pub struct World {
    space: SeriesSpace,
    bounds: Aabb,
    outline: Vec<Vec3>,
    scene: Scene,
    scale: WaterScale,
    request: FrameRequest,
    color: Option<ColorScale>,
    color_choices: Vec<Choice>,
    foam: Option<(FoamOptions, Choice)>,
    water_particles: usize,
    form: Option<Choice>,
    strays: Option<Choice>,
}

impl World {
    /// The world of a series, from its first, middle and last readable frame, so that a still camera holds all of it.
    ///
    /// # Errors
    /// [`PipelineError::Frame`] when none of the three can be read; a scene setting out of range.
    pub fn of_series(
        source: &dyn FrameSource,
        space: SeriesSpace,
        settings: &Settings,
    ) -> Result<Self, PipelineError> {
        let (quantity, request) = (settings.color.quantity()?, request(settings)?);
        let last = source.frame_count().saturating_sub(1);
        let mut frames = vec![0, last / 2, last];
        frames.dedup();
        let mut error = None;
        let mut measured = Vec::new();
        for index in frames {
            match source.read(index, &request, &Cancel::default()) {
                Ok(frame) => measured.push(Measured::of(&frame, &space, quantity.as_ref(), &settings.foam)),
                Err(e) => {
                    error.get_or_insert(e);
                }
            }
        }
        if let (true, Some(error)) = (measured.is_empty(), error) {
            return Err(PipelineError::Frame(error));
        }
        Self::of_measured(&measured, space, settings)
    }

    /// The world of a single frame.
    ///
    /// # Errors
    /// As [`Self::of_series`].
    pub fn of_frame(
        frame: &SetFrame,
        space: SeriesSpace,
        settings: &Settings,
    ) -> Result<Self, PipelineError> {
        let quantity = settings.color.quantity()?;
        Self::of_measured(&[Measured::of(frame, &space, quantity.as_ref(), &settings.foam)], space, settings)
    }

    fn of_measured(
        measured: &[Measured],
        space: SeriesSpace,
        settings: &Settings,
    ) -> Result<Self, PipelineError> {
        let bounds = measured.iter().fold(Aabb::EMPTY, |all, m| all.union(m.bounds));
        let outline = measured.iter().flat_map(|m| m.outline.iter().copied()).collect();
        let mut columns: Vec<f32> = measured.iter().filter_map(|m| m.depth).collect();
        columns.sort_by(f32::total_cmp);
        let column = columns.get(columns.len() / 2).copied().unwrap_or(0.0);
        // A sheet or a tall pillar is looked through from the side.
        let sides = [1, 2].map(|turn| bounds.extent()[(space.up.index() + turn) % 3]);
        let depth = column.min(sides[0].min(sides[1]) + space.spacing as f32);
        let spacing = space.spacing as f32;
        let (description, file) = match &settings.scene.file {
            Some(path) => {
                let text = std::fs::read_to_string(path)
                    .map_err(|source| PipelineError::SceneFile { path: path.clone(), source })?;
                let file = path.display().to_string();
                (Description::from_toml(&text, &file)?, file)
            }
            None => (Description::default(), "the automatic scene".to_owned()),
        };
        let description = settings.scene.apply(description);
        let scene = description.resolve(bounds, space.origin, space.up, spacing, &file)?;
        // Nothing but thin films: their own thickness is the scale.
        let scale = WaterScale {
            depth_world: depth.max(spacing),
            spacing_world: spacing,
            metres_per_world: space.metres_per_unit as f32,
        };
        let values = measured.iter().flat_map(|m| m.values.iter().copied()).collect();
        let (color, color_choice) = settings.color.scale(values)?.unzip();
        let plain = measured.iter().flat_map(|m| m.plain.iter().cloned()).collect();
        let uncolored = color.as_ref().and_then(|scale| uncolored(&plain, &scale.quantity));
        let color_choices = color_choice.flatten().into_iter().chain(uncolored).collect();
        let request = request(settings)?;
        let walls = foam::walls(&measured.iter().map(|m| m.bounds).collect::<Vec<_>>(), spacing);
        let speeds = measured.iter().flat_map(|m| m.speeds.iter().copied()).collect();
        let foam = settings.foam.options(speeds, walls, &space, scale);
        let water_particles = measured.iter().map(|m| m.water_particles).max().unwrap_or(0);
        let form = form_choice(&settings.surface.anisotropy, water_particles);
        Ok(Self {
            space,
            bounds,
            outline,
            scene,
            scale,
            request,
            color,
            color_choices,
            foam,
            water_particles,
            form,
            strays: strays_choice(measured.iter().map(|m| &m.strays)),
        })
    }

    /// Origin, spacing, radius, up axis.
    pub fn space(&self) -> &SeriesSpace {
        &self.space
    }

    /// Box around the particles, stray ones left out, world.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Points that outline the particles of the first, middle and last frame, stray ones left out, world: what a camera
    /// has to hold.
    pub fn outline(&self) -> &[Vec3] {
        &self.outline
    }

    /// What surrounds the water.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Lengths of the water that automatic parameters of lighting models are scaled by.
    pub fn scale(&self) -> WaterScale {
        self.scale
    }

    /// What has to be read of a frame besides its positions.
    pub fn request(&self) -> &FrameRequest {
        &self.request
    }

    /// What the particles are coloured by, the same over the whole series.
    pub fn color(&self) -> Option<&ColorScale> {
        self.color.as_ref()
    }

    /// What foam of the water is found by, the same over the whole series; `None` where none is looked for.
    pub fn foam(&self) -> Option<&FoamOptions> {
        self.foam.as_ref().map(|(options, _)| options)
    }

    /// What automatic choices for the surface of the water go by.
    pub(crate) fn water(&self) -> Water {
        Water { particles: self.water_particles, unevenness: unevenness(&self.space) }
    }

    /// Nearest distance that is drawn: a thousandth of the data's diagonal.
    pub fn near_distance(&self) -> f32 {
        (self.bounds.extent().length() * 1e-3).max(f32::MIN_POSITIVE)
    }

    /// The automatic choices that were made here.
    pub fn choices(&self) -> Vec<Choice> {
        let absorption = Choice {
            what: "absorption".into(),
            value: format!("scaled to a water depth of {}", Short(f64::from(self.scale.depth_world))),
            reason: "the median column still transmits".into(),
            flag: "--param lighting.attenuation_scale=FACTOR".into(),
        };
        let foam = self.foam.as_ref().map(|(_, choice)| choice.clone());
        let colors = self.color_choices.iter().cloned();
        let own = self.strays.iter().chain(&self.form).chain(&self.scene.choices).cloned();
        std::iter::once(absorption).chain(own).chain(colors).chain(foam).collect()
    }
}

/// How many particles of water there are, and how they lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Water {
    /// Most of them in the first, middle and last frame.
    pub(crate) particles: usize,
    /// 0 to 1, as far as the radius was chosen larger than usual for it; in hundredths.
    pub(crate) unevenness: f64,
}

fn unevenness(space: &SeriesSpace) -> f64 {
    if space.radius_choice == RadiusChoice::User {
        return 0.0;
    }
    let more = space.radius / space.spacing - DEFAULT_RADIUS_PER_SPACING;
    let share = more / (UNEVEN_RADIUS_PER_SPACING - DEFAULT_RADIUS_PER_SPACING);
    (share.clamp(0.0, 1.0) * 100.0).round() / 100.0
}

/// What has to be read of a frame besides its positions.
fn request(settings: &Settings) -> Result<FrameRequest, PipelineError> {
    let mut request = settings.color.request()?;
    settings.foam.extend(&mut request);
    Ok(request)
}

/// What is said of the form of particles of water, if it is chosen automatically and there are any.
fn form_choice(anisotropy: &AnisotropyParams, particles: usize) -> Option<Choice> {
    let limit = anisotropy.most_ellipsoids();
    let (value, reason, other) = if anisotropy.resolved(particles).is_on() {
        ("ellipsoids", format!("of up to {limit} of them spheres would show as bumps"), "none")
    } else {
        ("spheres", format!("shapes of more than {limit} of them may take long to find"), "yu-turk")
    };
    (anisotropy.form.is_none() && particles > 0).then(|| Choice {
        what: "particles".into(),
        value: format!("drawn as {value}"),
        reason,
        flag: format!("--param anisotropy.form={other}"),
    })
}

/// Particles of a frame that are far from the others.
struct Strays {
    count: usize,
    of: usize,
    frame: usize,
}

/// What is said of strays: of the frame that has most of them, if any has.
fn strays_choice<'a>(strays: impl Iterator<Item = &'a Strays>) -> Option<Choice> {
    let most = strays.filter(|strays| strays.count > 0).max_by_key(|strays| strays.count)?;
    let Strays { count, of, frame } = most;
    Some(Choice {
        what: "strays".into(),
        value: format!("{count} of {of} particles of frame {frame}, not framed by the camera"),
        reason: "few, and a gap away from the others or below them".into(),
        flag: "--camera to see them, --box to leave them out".into(),
    })
}

struct Measured {
    bounds: Aabb,
    strays: Strays,
    outline: Vec<Vec3>,
    water_particles: usize,
    /// Median depth of water columns, `None` without water.
    depth: Option<f32>,
    /// What the sets are coloured by, of particles spread over the frame.
    values: Vec<f32>,
    /// Names of sets that have no such attribute.
    plain: Vec<String>,
    /// How fast some of the particles move relative to their mean; empty where foam does not ask for it.
    speeds: Vec<f32>,
}

impl Measured {
    fn of(frame: &SetFrame, space: &SeriesSpace, quantity: Option<&Quantity>, foam: &FoamSettings) -> Self {
        let drawn = || frame.sets.iter().filter(|set| set.look != Look::Hidden && !set.particles.is_empty());
        let extents: Vec<Extent> = drawn().map(|set| extent(&set.particles.positions, space.up)).collect();
        let bounds = extents.iter().fold(Aabb::EMPTY, |all, of_set| all.union(of_set.bounds));
        let strays = Strays {
            count: extents.iter().map(|of_set| of_set.strays).sum(),
            of: drawn().map(|set| set.particles.len()).sum(),
            frame: frame.index,
        };
        let outline = drawn().flat_map(|set| outline(&set.particles, bounds, space.radius as f32)).collect();
        let spacing = space.spacing as f32;
        let water = || drawn().filter(|set| set.look == Look::Water);
        let water_particles = water().map(|set| set.particles.len()).sum();
        let depth =
            water().map(|set| column_depth(&set.particles, bounds, space.up, spacing)).reduce(f32::max);
        let values = quantity.map(|quantity| sample(frame, quantity)).unwrap_or_default();
        let plain = quantity.map(|quantity| without_values(frame, quantity).map(str::to_owned).collect());
        let speeds = foam.velocity().map(|velocity| foam::sample(frame, velocity)).unwrap_or_default();
        Self {
            bounds,
            strays,
            outline,
            water_particles,
            depth,
            values,
            plain: plain.unwrap_or_default(),
            speeds,
        }
    }
}
