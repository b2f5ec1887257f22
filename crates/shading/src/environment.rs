//! Pictures of the surroundings on the GPU, blurred for rough mirrors.

use std::f32::consts::TAU;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::role::Role;
use meniscus_gpu::{Buffer, Gpu, HostField, HostStruct, host_fields};
use meniscus_scene::{Environment, Scene};

use crate::ShadingError;

/// Texels of a picture of the surroundings and of its blurred levels: red, green, blue, nothing.
#[derive(Clone, Copy, Debug)]
pub enum EnvironmentTexels {}

impl Role for EnvironmentTexels {
    type Element = [f32; 4];
    const NAME: &'static str = "EnvironmentTexels";
    const UNIT: &'static str = "linear radiance, Rec. 709";
    const EMPTY: [f32; 4] = [0.0; 4];
}

/// Sizes of the levels; WGSL: `EnvironmentSize` in `shaders/shading/environment.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct EnvironmentSize {
    /// Columns and rows of the picture; 0 if there is none.
    pub sharp: [u32; 2],
    /// Of each blurred level.
    pub blurred: [u32; 2],
}

impl HostStruct for EnvironmentSize {
    const WGSL_NAME: &'static str = "EnvironmentSize";
    const FIELDS: &'static [HostField] = host_fields!(EnvironmentSize { sharp, blurred });
}

impl EnvironmentSize {
    /// The sizes for a scene's picture.
    pub(crate) fn of(scene: &Scene) -> Self {
        match &scene.environment {
            Some(picture) => Self {
                sharp: picture.size().map(|side| side as u32),
                blurred: BLURRED.map(|side| side as u32),
            },
            None => Self::zeroed(),
        }
    }
}

/// Blurred levels, for equal steps of perceptual roughness up to 1.
pub(crate) const BLURRED_LEVELS: usize = 5;
const BLURRED: [usize; 2] = [64, 32];

/// The picture of the surroundings on the GPU; a single black texel where a scene has none.
#[derive(Debug)]
pub struct EnvironmentMap {
    texels: Buffer<EnvironmentTexels>,
}

impl EnvironmentMap {
    /// Blurs and uploads what `scene` has.
    ///
    /// # Errors
    /// [`ShadingError::Gpu`] when it exceeds the device's limits.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, ShadingError> {
        Ok(Self { texels: Buffer::from_slice(gpu, &Self::texels_of(scene))? })
    }

    /// The texels of all levels, one at least.
    pub fn texels_of(scene: &Scene) -> Vec<[f32; 4]> {
        let Some(picture) = &scene.environment else { return vec![[0.0; 4]] };
        let mut texels: Vec<[f32; 4]> = picture.radiance().iter().copied().map(pack).collect();
        // Small enough for some hundred samples of a lobe to miss nothing.
        let mut source = (**picture).clone();
        while source.size()[0] > 2 * BLURRED[0] {
            source = source.halved();
        }
        for level in 1..=BLURRED_LEVELS {
            let roughness = level as f32 / BLURRED_LEVELS as f32;
            let blurred = Environment::from_fn(BLURRED, |d| blurred(&source, d, roughness * roughness));
            texels.extend(blurred.radiance().iter().copied().map(pack));
        }
        texels
    }

    /// For a pass that reads it.
    pub fn texels(&self) -> &Buffer<EnvironmentTexels> {
        &self.texels
    }
}

fn pack([red, green, blue]: [f32; 3]) -> [f32; 4] {
    [red, green, blue, 0.0]
}

/// What a mirror of GGX width `alpha` shows in `direction`, seen along its normal: the first sum of the split-sum
/// approximation (Karis 2013), with Hammersley's points.
fn blurred(source: &Environment, normal: Vec3, alpha: f32) -> Vec3 {
    const SAMPLES: u32 = 192;
    let (across, along) = normal.any_orthonormal_pair();
    let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
    for i in 0..SAMPLES {
        let u = (i as f32 + 0.5) / SAMPLES as f32;
        let phi = TAU * (i.reverse_bits() as f32 / 2f32.powi(32));
        let cos = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let half_way = sin * phi.cos() * across + sin * phi.sin() * along + cos * normal;
        let light = 2.0 * cos * half_way - normal;
        let n_l = light.dot(normal);
        if n_l > 0.0 {
            sum += n_l * source.at(light.normalize());
            weight += n_l;
        }
    }
    sum / weight.max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_the_brightness_and_widens_with_roughness() {
        let white = Environment::from_fn([128, 64], |_| Vec3::ONE);
        assert!((blurred(&white, Vec3::X, 0.5) - 1.0).abs().max_element() < 1e-4);
        let half = Environment::from_fn([128, 64], |d| Vec3::splat(if d.z > 0.0 { 1.0 } else { 0.0 }));
        // Ten degrees below the edge: the rougher the mirror, the more it shows of the bright half.
        let below = Vec3::new(0.985, 0.0, -0.174);
        let seen: Vec<f32> = [0.04, 0.16, 0.36, 0.64, 1.0].map(|a| blurred(&half, below, a).x).to_vec();
        assert!(seen.is_sorted() && seen[0] < 0.1 && (0.3..0.5).contains(&seen[4]), "{seen:?}");
    }
}
