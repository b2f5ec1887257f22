use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::role::{DisplayImage, Radiance};
use meniscus_gpu::{
    ComputePipeline, ComputePipelineDescriptor, Dispatch, Gpu, HostField, HostStruct, Image, Recorder,
    Shader, host_fields, shader,
};

use crate::{CompositorError, CompositorParameters, ToneCurve};

const TONE_MAP: Shader = shader!("compositor/tone_map");
const FXAA: Shader = shader!("compositor/fxaa");

/// The parameters as the GPU sees them; WGSL: `ToneMap` in `shaders/compositor/tone_map.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct ToneMapUniform {
    gain: [f32; 3],
    contrast: f32,
    size_px: [u32; 2],
    saturation: f32,
    curve: u32,
    transparent: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

impl HostStruct for ToneMapUniform {
    const WGSL_NAME: &'static str = "ToneMap";
    const FIELDS: &'static [HostField] = host_fields!(ToneMapUniform {
        gain,
        contrast,
        size_px,
        saturation,
        curve,
        transparent,
        pad0,
        pad1,
        pad2,
    });
}

/// Turns radiance into the display image.
#[derive(Debug)]
pub struct Compositor {
    tone_map: ComputePipeline,
    fxaa: ComputePipeline,
    /// The picture before anti-aliasing; made for the size of the last frame.
    mapped: Option<Image<DisplayImage>>,
}

impl Compositor {
    /// Compiles the passes.
    ///
    /// # Errors
    /// [`CompositorError::Gpu`] when a shader does not compile.
    pub fn new(gpu: &Gpu) -> Result<Self, CompositorError> {
        Ok(Self {
            tone_map: gpu.compute_pipeline(&ComputePipelineDescriptor::new(TONE_MAP))?,
            fxaa: gpu.compute_pipeline(&ComputePipelineDescriptor::new(FXAA))?,
            mapped: None,
        })
    }

    /// Makes room for pictures of `size` pixels; allocates only when the size changes.
    ///
    /// # Errors
    /// [`CompositorError::Gpu`] beyond the device's limits.
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<(), CompositorError> {
        if self.mapped.as_ref().map(Image::size) != Some(size) {
            self.mapped = Some(Image::new(gpu, size)?);
        }
        Ok(())
    }

    /// Records `compositor.tone_map` and, with anti-aliasing, `compositor.fxaa`. Parameters outside of their ranges are the
    /// caller's to refuse ([`CompositorParameters::validate`]); here they only look odd. Without [`Self::resize`] to the
    /// picture's size there is no anti-aliasing.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        parameters: &CompositorParameters,
        radiance: &Image<Radiance>,
        display: &Image<DisplayImage>,
    ) {
        let size = radiance.size();
        let smoothed = parameters.anti_aliasing.then_some(self.mapped.as_ref()).flatten();
        let smoothed = smoothed.filter(|image| image.size() == size);
        let tone = recorder.uniform(&tone_map_uniform(parameters, size));
        let mapped = smoothed.unwrap_or(display);
        let bindings = [("tone", tone), ("radiance", radiance.bind()), ("mapped", mapped.bind())];
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let groups = Dispatch::Groups(pixels.div_ceil(64));
        recorder.compute(gpu, "compositor.tone_map", &self.tone_map, &bindings, groups);
        if let Some(mapped) = smoothed {
            let size_px = recorder.uniform(&[size[0], size[1], 0, 0]);
            let bindings = [("size_px", size_px), ("source", mapped.bind()), ("smoothed", display.bind())];
            recorder.compute(gpu, "compositor.fxaa", &self.fxaa, &bindings, Dispatch::Pixels(size));
        }
    }
}

fn tone_map_uniform(parameters: &CompositorParameters, size: [u32; 2]) -> ToneMapUniform {
    let gain = Vec3::from(parameters.white_balance) * parameters.exposure.exp2();
    ToneMapUniform {
        gain: gain.to_array(),
        contrast: parameters.contrast,
        size_px: size,
        saturation: parameters.saturation,
        curve: match parameters.tone_curve {
            ToneCurve::Neutral => 0,
            ToneCurve::Filmic => 1,
            ToneCurve::Clip => 2,
        },
        transparent: parameters.transparent.into(),
        pad0: 0,
        pad1: 0,
        pad2: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uniform_matches_its_shader() {
        ToneMapUniform::check_layout(&TONE_MAP, &[]).unwrap();
    }
}
