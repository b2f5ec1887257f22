use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::{HostField, HostStruct, host_fields};
use meniscus_scene::{Material, Pattern, Scene, UpFrame};

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
    /// `PATTERN_*` in WGSL.
    pub pattern: u32,
    /// Size of the pattern's largest element, world units, > 0.
    pub scale_world: f32,
    /// Pad to 16 bytes.
    pub pad: f32,
}

impl From<&Material> for MaterialUniform {
    fn from(material: &Material) -> Self {
        let pattern = match material.pattern {
            Pattern::Plain => 0,
            Pattern::Tiles => 1,
            Pattern::Concrete => 2,
            Pattern::Soil => 3,
        };
        Self {
            color: material.color,
            roughness: material.roughness,
            metallic: material.metallic,
            pattern,
            scale_world: material.scale.max(f32::MIN_POSITIVE),
            pad: 0.0,
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
}

impl Surroundings {
    /// Haze takes over at this many sizes of the data: beyond what is looked at, near enough to hide the horizon's edge.
    const HAZE_SIZES: f32 = 40.0;

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
        let up = sky_irradiance(&sky, frame);
        let down = match floor {
            Some(floor) => {
                let sun = Vec3::from(sky.sun_irradiance) * scene.sun.direction.dot(frame.up).max(0.0);
                Vec3::from(floor.material.color) * (sun + up)
            }
            None => Vec3::from(sky.ground) * std::f32::consts::PI,
        };
        sky.irradiance_up = up.to_array();
        sky.irradiance_down = down.to_array();
        Self {
            sky,
            floor: (&floor.map(|f| f.material).unwrap_or_default()).into(),
            east: frame.east.to_array(),
            floor_height_world: floor.map_or(0.0, |f| f.height_world),
            north: frame.north.to_array(),
            haze_per_world: 1.0 / (Self::HAZE_SIZES * scene.size_world),
            anchor: scene.anchor.to_array(),
            has_floor: floor.is_some().into(),
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
    const FIELDS: &'static [HostField] =
        host_fields!(MaterialUniform { color, roughness, metallic, pattern, scale_world, pad });
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
        let shader = crate::opaque::SHADER;
        MaterialUniform::check_layout(&shader, crate::INCLUDES).unwrap();
        SkyUniform::check_layout(&shader, crate::INCLUDES).unwrap();
        Surroundings::check_layout(&shader, crate::INCLUDES).unwrap();
    }
}
