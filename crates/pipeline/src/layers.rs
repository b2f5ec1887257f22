//! What of a picture is written beside its colours, for those who compose or measure it.

use std::str::FromStr;

use glam::Vec3;
use meniscus_compositor::develop::finite_radiance;
use meniscus_core::{Camera, Channel};
use meniscus_gpu::role::NO_SURFACE;
use meniscus_ssfr::twin::unpack_normal;

use crate::{PipelineError, PreparedFrame, Renderer, World};

/// A layer of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// `depth.Z`: distance along the view axis of what is seen first, water or objects, world units; [`Layer::FAR`] for the sky.
    Depth,
    /// `normal.X`, `.Y`, `.Z`: unit normal of the water in the axes of the file; 0 where there is none.
    Normal,
    /// `thickness.Z`: length of water along the view ray, world units.
    Thickness,
    /// `kept.Z`: share of the particles of the place that are drawn, 0 to 1; 0 where there is no water.
    Kept,
    /// `fluid.R`, `.G`, `.B`, `.A`: linear radiance where water is seen first, with alpha 1; else 0.
    Fluid,
    /// `scene.R`, `.G`, `.B`: linear radiance of the objects without the water.
    Scene,
}

impl Layer {
    /// All, by the names that users type.
    pub const NAMES: [(&str, Self); 6] = [
        ("depth", Self::Depth),
        ("normal", Self::Normal),
        ("thickness", Self::Thickness),
        ("kept", Self::Kept),
        ("fluid", Self::Fluid),
        ("scene", Self::Scene),
    ];
    /// Depth of the sky, as Blender has it.
    pub const FAR: f32 = 1e10;
}

impl FromStr for Layer {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let names = || Self::NAMES.map(|(name, _)| name).join(", ");
        let found = Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, layer)| *layer);
        found.ok_or_else(|| format!("there is no layer `{name}`; there are {}", names()))
    }
}

impl Renderer {
    /// The channels of `layers` of the picture that was just drawn of `frame`.
    ///
    /// # Errors
    /// The GPU's.
    ///
    /// # Panics
    /// Before the first frame.
    pub fn layers(
        &self,
        layers: &[Layer],
        frame: &PreparedFrame,
        world: &World,
        camera: &Camera,
    ) -> Result<Vec<Channel>, PipelineError> {
        let gpu = self.gpu();
        let images = self.images();
        let post = &self.settings().post;
        let water = images.surface.distance.read(gpu)?;
        let scene = images.scene_distance.read(gpu)?;
        // What lies behind the scene was cut off when splats were drawn; smoothing may move it there again.
        let is_water: Vec<bool> = water.iter().zip(&scene).map(|(w, s)| *w < NO_SURFACE && w < s).collect();
        let masked = |values: Vec<f32>| -> Vec<f32> {
            values
                .into_iter()
                .zip(&is_water)
                .map(|(value, is_water)| if *is_water { value } else { 0.0 })
                .collect()
        };
        let mut channels = Vec::new();
        let mut add = |name: &str, values: Vec<f32>| channels.push(Channel { name: name.to_owned(), values });
        for layer in layers {
            match layer {
                Layer::Depth => {
                    let first = water.iter().zip(&scene).map(|(w, s)| w.min(*s).min(Layer::FAR));
                    add("depth.Z", first.collect());
                }
                Layer::Normal => {
                    let to_world = camera.view_from_world().inverse();
                    let normals = images.surface.normal.read(gpu)?;
                    let normals: Vec<Vec3> =
                        normals.iter().map(|bits| to_world.transform_vector3(unpack_normal(*bits))).collect();
                    for (axis, name) in ["normal.X", "normal.Y", "normal.Z"].into_iter().enumerate() {
                        add(name, masked(normals.iter().map(|normal| normal[axis]).collect()));
                    }
                }
                Layer::Thickness => add("thickness.Z", masked(images.surface.thickness.read(gpu)?)),
                Layer::Kept => add("kept.Z", masked(self.kept_fractions(frame, world, camera)?)),
                Layer::Fluid => {
                    let radiance = finite_radiance(post, &images.radiance.read_floats(gpu)?);
                    for (c, name) in ["fluid.R", "fluid.G", "fluid.B"].into_iter().enumerate() {
                        add(name, masked(radiance.iter().map(|pixel| pixel[c]).collect()));
                    }
                    add("fluid.A", masked(vec![1.0; water.len()]));
                }
                Layer::Scene => {
                    let scene = finite_radiance(post, &images.scene_color.read_floats(gpu)?);
                    let color = |c: usize| scene.iter().map(|pixel| pixel[c]).collect();
                    for (c, name) in ["scene.R", "scene.G", "scene.B"].into_iter().enumerate() {
                        add(name, color(c));
                    }
                }
            }
        }
        Ok(channels)
    }
}
