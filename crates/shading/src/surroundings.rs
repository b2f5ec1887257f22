use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::{HostField, HostStruct, host_fields};
use meniscus_scene::{Material, Pattern, Scene, UpFrame};

use crate::EnvironmentSize;

/// An opaque surface as the GPU sees it; WGSL: `meniscus::material::Material`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MaterialUniform {
    /// Linear Rec. 709.
    pub color: [f32; 3],
    /// Perceptual roughness.
    pub roughness: f32,
    /// 0 = dielectric, 1 = metal.
    pub metallic: f32,
    /// Size of the pattern's largest element, world units, > 0.
    pub scale_world: f32,
    /// Half the width of the joints between elements, in elements, > 0.
    pub joint_half_width: f32,
    /// Tone of the joints; 1 = none are seen.
    pub joint_tone: f32,
    /// How much elements differ in tone.
    pub element_amplitude: f32,
    /// Noise cells per element.
    pub coarse_frequency: f32,
    /// Amplitude of that noise.
    pub coarse_amplitude: f32,
    /// Noise cells per element, second octave.
    pub fine_frequency: f32,
    /// Amplitude of that noise.
    pub fine_amplitude: f32,
    /// Pad.
    pub pad_a: f32,
    /// Pad.
    pub pad_b: f32,
    /// Pad to 16 bytes.
    pub pad_c: f32,
}

impl MaterialUniform {
    /// Rough, plain and grey.
    pub(crate) const GREY: Self = Self {
        color: [0.5; 3],
        roughness: 1.0,
        metallic: 0.0,
        scale_world: 1.0,
        joint_half_width: 0.01,
        joint_tone: 1.0,
        element_amplitude: 0.0,
        coarse_frequency: 1.0,
        coarse_amplitude: 0.0,
        fine_frequency: 1.0,
        fine_amplitude: 0.0,
        pad_a: 0.0,
        pad_b: 0.0,
        pad_c: 0.0,
    };

    /// Mean of the pattern's tone.
    fn mean_tone(&self) -> f32 {
        let joints = 1.0 - (1.0 - 2.0 * self.joint_half_width).powi(2);
        1.0 - joints * (1.0 - self.joint_tone)
    }
}

impl From<&Material> for MaterialUniform {
    fn from(material: &Material) -> Self {
        let surface = Self {
            color: material.color,
            roughness: material.roughness,
            metallic: material.metallic,
            scale_world: material.scale.max(f32::MIN_POSITIVE),
            ..Self::GREY
        };
        match material.pattern {
            Pattern::Plain => surface,
            Pattern::Tiles => Self {
                joint_half_width: 0.012,
                joint_tone: 0.7,
                element_amplitude: 0.05,
                coarse_frequency: 5.3,
                coarse_amplitude: 0.025,
                fine_frequency: 23.0,
                fine_amplitude: 0.015,
                ..surface
            },
            Pattern::Concrete => Self {
                joint_half_width: 0.006,
                joint_tone: 0.6,
                element_amplitude: 0.03,
                coarse_frequency: 2.7,
                coarse_amplitude: 0.09,
                fine_frequency: 61.0,
                fine_amplitude: 0.05,
                ..surface
            },
            Pattern::Soil => Self {
                coarse_frequency: 3.1,
                coarse_amplitude: 0.18,
                fine_frequency: 29.0,
                fine_amplitude: 0.16,
                ..surface
            },
        }
    }
}

/// Sun and sky as the GPU sees them; WGSL: `meniscus::sky::Sky`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SkyUniform {
    /// Unit, towards the sun, world.
    pub sun_direction: [f32; 3],
    /// Strength of the glow around the sun.
    pub glow: f32,
    /// On a surface that faces the sun.
    pub sun_irradiance: [f32; 3],
    /// Pad.
    pub pad_a: f32,
    /// Radiance straight up.
    pub zenith: [f32; 3],
    /// Pad.
    pub pad_b: f32,
    /// Radiance at the horizon.
    pub horizon: [f32; 3],
    /// Pad.
    pub pad_c: f32,
    /// Radiance from below the horizon, where there is no floor.
    pub ground: [f32; 3],
    /// Pad.
    pub pad_d: f32,
    /// Irradiance of a surface that faces up, without the sun.
    pub irradiance_up: [f32; 3],
    /// Pad.
    pub pad_e: f32,
    /// Irradiance of a surface that faces down.
    pub irradiance_down: [f32; 3],
    /// Pad.
    pub pad_f: f32,
    /// Unit, against gravity, world.
    pub up: [f32; 3],
    /// Pad.
    pub pad_g: f32,
}

/// Sky and floor as the GPU sees them; WGSL: `meniscus::surroundings::Surroundings`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Surroundings {
    /// Sun and sky.
    pub sky: SkyUniform,
    /// The floor's surface.
    pub floor: MaterialUniform,
    /// First ground direction of the floor's pattern.
    pub east: [f32; 3],
    /// Height of the floor along the up axis, world.
    pub floor_height_world: f32,
    /// Second ground direction.
    pub north: [f32; 3],
    /// 1 / distance over which haze takes over.
    pub haze_per_world: f32,
    /// Where patterns start, world.
    pub anchor: [f32; 3],
    /// 1 if there is a floor.
    pub has_floor: u32,
    /// Radiance of the lit floor, averaged over its pattern and all directions.
    pub floor_radiance: [f32; 3],
    /// Pad to 16 bytes.
    pub pad: f32,
    /// A picture in place of the sky.
    pub environment: EnvironmentSize,
}

impl Surroundings {
    /// Haze takes over at this many sizes of the data: beyond what is looked at, near enough to hide the horizon's edge.
    const HAZE_SIZES: f32 = 40.0;

    /// Diagonal of the data, world units.
    pub(crate) fn size_world(&self) -> f32 {
        1.0 / (Self::HAZE_SIZES * self.haze_per_world).max(f32::MIN_POSITIVE)
    }

    /// The uniform of `scene`.
    pub fn new(scene: &Scene) -> Self {
        let frame = UpFrame::new(scene.up);
        let floor = scene.floor.as_ref();
        let mut sky = SkyUniform {
            sun_direction: scene.sun.direction.to_array(),
            glow: scene.sky.glow,
            sun_irradiance: scene.sun.irradiance,
            zenith: scene.sky.zenith,
            horizon: scene.sky.horizon,
            ground: scene.sky.ground,
            up: frame.up.to_array(),
            ..Zeroable::zeroed()
        };
        let picture = scene.environment.as_deref();
        let up = picture.map_or_else(|| sky_irradiance(&sky, frame), |p| p.irradiance(Vec3::Z));
        let material = MaterialUniform::from(&floor.map(|f| f.material).unwrap_or_default());
        let sun = Vec3::from(sky.sun_irradiance) * scene.sun.direction.dot(frame.up).max(0.0);
        let floor_radiance =
            Vec3::from(material.color) * material.mean_tone() * (sun + up) * std::f32::consts::FRAC_1_PI;
        let ground =
            picture.map_or(sky.ground.into(), |p| p.irradiance(Vec3::NEG_Z) * std::f32::consts::FRAC_1_PI);
        let below = if floor.is_some() { floor_radiance } else { ground };
        sky.irradiance_up = up.to_array();
        sky.irradiance_down = (below * std::f32::consts::PI).to_array();
        Self {
            sky,
            floor: material,
            east: frame.east.to_array(),
            floor_height_world: floor.map_or(0.0, |f| f.height_world),
            north: frame.north.to_array(),
            haze_per_world: 1.0 / (Self::HAZE_SIZES * scene.size_world),
            anchor: scene.anchor.to_array(),
            has_floor: floor.is_some().into(),
            floor_radiance: floor_radiance.to_array(),
            pad: 0.0,
            environment: EnvironmentSize::of(scene),
        }
    }
}

/// Irradiance from the upper hemisphere: midpoint rule in azimuth and squared sine, which spreads the samples by cosine.
fn sky_irradiance(sky: &SkyUniform, frame: UpFrame) -> Vec3 {
    const RINGS: u32 = 16;
    const SECTORS: u32 = 32;
    let mut sum = Vec3::ZERO;
    for ring in 0..RINGS {
        let sine_squared = (ring as f32 + 0.5) / RINGS as f32;
        let elevation = (1.0 - sine_squared).sqrt().asin();
        for sector in 0..SECTORS {
            let azimuth = std::f32::consts::TAU * (sector as f32 + 0.5) / SECTORS as f32;
            sum += crate::twin::sky::sky_radiance(sky, frame.direction(azimuth, elevation));
        }
    }
    sum * std::f32::consts::PI / (RINGS * SECTORS) as f32
}

impl HostStruct for MaterialUniform {
    const WGSL_NAME: &'static str = "Material";
    const FIELDS: &'static [HostField] = host_fields!(MaterialUniform {
        color,
        roughness,
        metallic,
        scale_world,
        joint_half_width,
        joint_tone,
        element_amplitude,
        coarse_frequency,
        coarse_amplitude,
        fine_frequency,
        fine_amplitude,
        pad_a,
        pad_b,
        pad_c,
    });
}

impl HostStruct for SkyUniform {
    const WGSL_NAME: &'static str = "Sky";
    const FIELDS: &'static [HostField] = host_fields!(SkyUniform {
        sun_direction,
        glow,
        sun_irradiance,
        pad_a,
        zenith,
        pad_b,
        horizon,
        pad_c,
        ground,
        pad_d,
        irradiance_up,
        pad_e,
        irradiance_down,
        pad_f,
        up,
        pad_g,
    });
}

impl HostStruct for Surroundings {
    const WGSL_NAME: &'static str = "Surroundings";
    const FIELDS: &'static [HostField] = host_fields!(Surroundings {
        sky,
        floor,
        east,
        floor_height_world,
        north,
        haze_per_world,
        anchor,
        has_floor,
        floor_radiance,
        pad,
        environment,
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_core::{Aabb, UpAxis};

    #[test]
    fn a_white_sky_gives_the_irradiance_of_pi() {
        let mut scene = Scene::around(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, UpAxis::Y, 0.1);
        scene.sky = meniscus_scene::Sky { zenith: [1.0; 3], horizon: [1.0; 3], ground: [1.0; 3], glow: 0.0 };
        scene.floor = None;
        let s = Surroundings::new(&scene);
        for irradiance in [s.sky.irradiance_up, s.sky.irradiance_down] {
            // 1e-4: 512 additions in f32.
            assert!(
                irradiance.iter().all(|e| (e / std::f32::consts::PI - 1.0).abs() < 1e-4),
                "{irradiance:?}"
            );
        }
    }

    #[test]
    fn host_structs_match_their_shader() {
        let shader = crate::opaque_scene::BACKGROUND;
        MaterialUniform::check_layout(&shader, crate::INCLUDES).unwrap();
        SkyUniform::check_layout(&shader, crate::INCLUDES).unwrap();
        Surroundings::check_layout(&shader, crate::INCLUDES).unwrap();
    }
}
