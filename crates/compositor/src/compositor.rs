use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::role::{DisplayImage, Radiance, Scratch};
use meniscus_gpu::{
    Buffer, ComputePipeline, ComputePipelineDescriptor, Definition, Dispatch, Gpu, HostField, HostStruct,
    Image, Recorder, Shader, host_fields, shader,
};

use crate::{CompositorError, CompositorParameters, ToneCurve};

const TONE_MAP: Shader = shader!("compositor/tone_map");
const FXAA_EDGES: Shader = shader!("compositor/fxaa_edges");
const FXAA: Shader = shader!("compositor/fxaa");
const INCLUDES: &[Shader] = &[shader!(include "compositor/luma"), shader!(include "compositor/edges")];

/// The parameters as the GPU sees them; WGSL: `ToneMap` in `shaders/compositor/tone_map.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct ToneMapUniform {
    gain: [f32; 3],
    contrast: f32,
    size_px: [u32; 2],
    saturation: f32,
    transparent: u32,
}

impl HostStruct for ToneMapUniform {
    const WGSL_NAME: &'static str = "ToneMap";
    const FIELDS: &'static [HostField] =
        host_fields!(ToneMapUniform { gain, contrast, size_px, saturation, transparent });
}

/// WGSL: `Smoothing` in `shaders/compositor/edges.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct SmoothingUniform {
    size_px: [u32; 2],
    luma_scale: f32,
    luma_offset: f32,
}

impl HostStruct for SmoothingUniform {
    const WGSL_NAME: &'static str = "Smoothing";
    const FIELDS: &'static [HostField] = host_fields!(SmoothingUniform { size_px, luma_scale, luma_offset });
}

/// Turns radiance into the display image.
#[derive(Debug)]
pub struct Compositor {
    parameters: CompositorParameters,
    tone_map: ComputePipeline,
    anti_aliasing: Option<AntiAliasing>,
}

/// The passes that smooth edges, and what lies between them.
#[derive(Debug)]
struct AntiAliasing {
    /// Tone mapping that keeps brightness for the following passes.
    tone_map: ComputePipeline,
    edges: ComputePipeline,
    fxaa: ComputePipeline,
    /// Made for the size of the last frame.
    images: Option<SmoothingImages>,
}

#[derive(Debug)]
struct SmoothingImages {
    /// The picture before anti-aliasing.
    mapped: Image<DisplayImage>,
    /// `shaders/compositor/luma.inc.wgsl`.
    lumas: Buffer<Scratch>,
    /// `Edges` of `shaders/compositor/edges.inc.wgsl`.
    edges: Buffer<Scratch>,
}

impl SmoothingImages {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, CompositorError> {
        let [width, height] = size.map(|side| side as usize);
        Ok(Self {
            mapped: Image::new(gpu, size)?,
            lumas: Buffer::new(gpu, width.div_ceil(4) * height)?,
            edges: Buffer::new(gpu, 1 + width * height)?,
        })
    }
}

impl Compositor {
    /// Compiles the passes that `parameters` ask for.
    ///
    /// # Errors
    /// A parameter out of its range ([`CompositorParameters::validate`]); [`CompositorError::Gpu`] when a shader does not
    /// compile.
    pub fn new(gpu: &Gpu, parameters: &CompositorParameters) -> Result<Self, CompositorError> {
        parameters.validate()?;
        let anti_aliasing = || {
            Ok::<_, CompositorError>(AntiAliasing {
                tone_map: tone_map(gpu, parameters, true)?,
                edges: pipeline(gpu, FXAA_EDGES, &[])?,
                fxaa: pipeline(gpu, FXAA, &[])?,
                images: None,
            })
        };
        Ok(Self {
            tone_map: tone_map(gpu, parameters, false)?,
            anti_aliasing: parameters.anti_aliasing.then(anti_aliasing).transpose()?,
            parameters: parameters.clone(),
        })
    }

    /// Makes room for pictures of `size` pixels; allocates only when the size changes.
    ///
    /// # Errors
    /// [`CompositorError::Gpu`] beyond the device's limits.
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<(), CompositorError> {
        if let Some(AntiAliasing { images, .. }) = &mut self.anti_aliasing
            && images.as_ref().map(|images| images.mapped.size()) != Some(size)
        {
            // The old ones go first: two sets of images may not fit.
            *images = None;
            *images = Some(SmoothingImages::new(gpu, size)?);
        }
        Ok(())
    }

    /// Records `compositor.tone_map` and, with anti-aliasing, `compositor.fxaa_edges` and `compositor.fxaa`. Without
    /// [`Self::resize`] to the picture's size there is no anti-aliasing.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        radiance: &Image<Radiance>,
        display: &Image<DisplayImage>,
    ) {
        let size = radiance.size();
        let fitting = |images: &&SmoothingImages| images.mapped.size() == size;
        let smoothed =
            self.anti_aliasing.as_ref().and_then(|aa| Some((aa, aa.images.as_ref().filter(fitting)?)));
        match smoothed {
            Some((passes, images)) => self.record_smoothed(gpu, recorder, radiance, display, passes, images),
            None => self.record_as_drawn(gpu, recorder, radiance, display),
        }
    }

    /// Records `compositor.tone_map` of radiance whose edges are smooth already.
    pub fn record_as_drawn(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        radiance: &Image<Radiance>,
        display: &Image<DisplayImage>,
    ) {
        let tone = recorder.uniform(&tone_map_uniform(&self.parameters, radiance.size()));
        let bindings = [("tone", tone), ("radiance", radiance.bind()), ("mapped", display.bind())];
        let groups = words(radiance.size());
        recorder.compute(gpu, "compositor.tone_map", &self.tone_map, &bindings, groups);
    }

    fn record_smoothed(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        radiance: &Image<Radiance>,
        display: &Image<DisplayImage>,
        passes: &AntiAliasing,
        SmoothingImages { mapped, lumas, edges }: &SmoothingImages,
    ) {
        let size = radiance.size();
        let tone = recorder.uniform(&tone_map_uniform(&self.parameters, size));
        let smoothing = recorder.uniform(&smoothing_uniform(&self.parameters, size));
        let bindings = [
            ("tone", tone),
            ("radiance", radiance.bind()),
            ("mapped", mapped.bind()),
            ("display", display.bind()),
            ("lumas", lumas.bind()),
        ];
        recorder.compute(gpu, "compositor.tone_map", &passes.tone_map, &bindings, words(size));
        recorder.clear(gpu, "compositor.fxaa_edges", edges, 1);
        let bindings = [("smoothing", smoothing.clone()), ("lumas", lumas.bind()), ("edges", edges.bind())];
        recorder.compute(gpu, "compositor.fxaa_edges", &passes.edges, &bindings, words(size));
        let bindings = [
            ("smoothing", smoothing),
            ("source", mapped.bind()),
            ("lumas", lumas.bind()),
            ("edges", edges.bind()),
            ("smoothed", display.bind()),
        ];
        // Each invocation walks on through the list, whose length the GPU knows.
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let groups = Dispatch::Groups(pixels.div_ceil(64).min(1024));
        recorder.compute(gpu, "compositor.fxaa", &passes.fxaa, &bindings, groups);
    }
}

/// One invocation per word of four pixels of a row.
fn words([width, height]: [u32; 2]) -> Dispatch {
    Dispatch::Pixels([width.div_ceil(4), height])
}

fn pipeline(
    gpu: &Gpu,
    shader: Shader,
    definitions: &[Definition],
) -> Result<ComputePipeline, CompositorError> {
    let descriptor = ComputePipelineDescriptor {
        includes: INCLUDES,
        definitions,
        ..ComputePipelineDescriptor::new(shader)
    };
    Ok(gpu.compute_pipeline(&descriptor)?)
}

fn tone_map(
    gpu: &Gpu,
    parameters: &CompositorParameters,
    is_smoothed: bool,
) -> Result<ComputePipeline, CompositorError> {
    let curve = match parameters.tone_curve {
        ToneCurve::Neutral => Some("NEUTRAL"),
        ToneCurve::Filmic => Some("FILMIC"),
        ToneCurve::Clip => None,
    };
    let contrast = (parameters.contrast != 1.0).then_some("CONTRAST");
    let smoothed = is_smoothed.then_some("SMOOTHED");
    let definitions: Vec<Definition> =
        [curve, contrast, smoothed].into_iter().flatten().map(|name| Definition { name, value: 1 }).collect();
    pipeline(gpu, TONE_MAP, &definitions)
}

fn tone_map_uniform(parameters: &CompositorParameters, size: [u32; 2]) -> ToneMapUniform {
    let gain = Vec3::from(parameters.white_balance) * parameters.exposure.exp2();
    ToneMapUniform {
        gain: gain.to_array(),
        contrast: parameters.contrast,
        size_px: size,
        saturation: parameters.saturation,
        transparent: parameters.transparent.into(),
    }
}

fn smoothing_uniform(parameters: &CompositorParameters, size: [u32; 2]) -> SmoothingUniform {
    // The brightness that edges are looked for in is 0 to 1.5, of which alpha has a third.
    let (luma_scale, luma_offset) = if parameters.transparent { (1.5, 0.0) } else { (1.0, 0.5) };
    SmoothingUniform { size_px: size, luma_scale, luma_offset }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniforms_match_their_shaders() {
        ToneMapUniform::check_layout(&TONE_MAP, &[]).unwrap();
        SmoothingUniform::check_layout(&FXAA, INCLUDES).unwrap();
    }
}
