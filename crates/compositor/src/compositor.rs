use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use meniscus_gpu::role::{FourPixels, Lumas, Radiance, Scratch, TextureRole};
use meniscus_gpu::{
    Buffer, ComputePipeline, ComputePipelineDescriptor, Definition, Dispatch, Gpu, HostField, HostStruct,
    PicturePipeline, PicturePipelineDescriptor, Pixels, Recorder, Shader, Texture, covered, host_fields,
    shader,
};

use crate::bloom::{Bloom, BloomImages};
use crate::{CompositorError, CompositorParameters, Display, ToneCurve};

const TONE_MAP: Shader = shader!("compositor/tone_map");
const FXAA_EDGES: Shader = shader!("compositor/fxaa_edges");
const FXAA: Shader = shader!("compositor/fxaa");
const TONE_MAP_PASS: &str = "compositor.tone_map";
pub(crate) const INCLUDES: &[Shader] = &[
    shader!(include "compositor/light"),
    shader!(include "compositor/luma"),
    shader!(include "compositor/edges"),
];

/// The parameters as the GPU sees them; WGSL: `ToneMap` in `shaders/compositor/tone_map.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct ToneMapUniform {
    gain: [f32; 3],
    contrast: f32,
    size_px: [u32; 2],
    saturation: f32,
    pad: u32,
    white_balance: [f32; 3],
    bloom: f32,
}

impl HostStruct for ToneMapUniform {
    const WGSL_NAME: &'static str = "ToneMap";
    const FIELDS: &'static [HostField] =
        host_fields!(ToneMapUniform { gain, contrast, size_px, saturation, pad, white_balance, bloom });
}

/// WGSL: `Smoothing` in `shaders/compositor/edges.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct SmoothingUniform {
    size_px: [u32; 2],
    luma_scale: f32,
    luma_offset: f32,
    row_px: u32,
    pad: u32,
}

impl HostStruct for SmoothingUniform {
    const WGSL_NAME: &'static str = "Smoothing";
    const FIELDS: &'static [HostField] =
        host_fields!(SmoothingUniform { size_px, luma_scale, luma_offset, row_px, pad });
}

/// Turns radiance into the display image.
#[derive(Debug)]
pub struct Compositor {
    parameters: CompositorParameters,
    tone_map: PicturePipeline,
    anti_aliasing: Option<AntiAliasing>,
    bloom: Option<Bloom>,
    /// Made for the size of the last frame.
    images: Option<Images>,
}

/// The passes that smooth edges.
#[derive(Debug)]
struct AntiAliasing {
    /// Tone mapping that keeps brightness for the following passes.
    tone_map: PicturePipeline,
    edges: ComputePipeline,
    fxaa: ComputePipeline,
}

/// What lies between the passes.
#[derive(Debug)]
struct Images {
    size: [u32; 2],
    /// The picture before anti-aliasing.
    mapped: Texture<FourPixels>,
    smoothing: Option<SmoothingImages>,
    bloom: Option<BloomImages>,
}

#[derive(Debug)]
struct SmoothingImages {
    /// `shaders/compositor/luma.inc.wgsl`.
    lumas: Texture<Lumas>,
    /// `Edges` of `shaders/compositor/edges.inc.wgsl`.
    edges: Buffer<Scratch>,
}

impl SmoothingImages {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, CompositorError> {
        Ok(Self {
            lumas: Texture::new(gpu, Display::texels(size))?,
            edges: Buffer::new(gpu, 1 + size[0] as usize * size[1] as usize)?,
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
            })
        };
        Ok(Self {
            tone_map: tone_map(gpu, parameters, false)?,
            anti_aliasing: parameters.anti_aliasing.then(anti_aliasing).transpose()?,
            bloom: (parameters.bloom > 0.0).then(|| Bloom::new(gpu)).transpose()?,
            images: None,
            parameters: parameters.clone(),
        })
    }

    /// Exposes the following pictures by `stops`.
    pub fn set_exposure(&mut self, stops: f32) {
        self.parameters.exposure = Some(stops);
    }

    /// Makes room for pictures of `size` pixels; allocates only when the size changes.
    ///
    /// # Errors
    /// [`CompositorError::Gpu`] beyond the device's limits.
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<(), CompositorError> {
        if self.images.as_ref().is_none_or(|images| images.size != size) {
            // The old ones go first: two sets of images may not fit.
            self.images = None;
            let smoothing = self.anti_aliasing.is_some().then(|| SmoothingImages::new(gpu, size));
            let bloom = self.bloom.is_some().then(|| BloomImages::new(gpu, size));
            let (smoothing, bloom) = (smoothing.transpose()?, bloom.transpose()?);
            let mapped = Texture::new(gpu, Display::texels(size))?;
            self.images = Some(Images { size, mapped, smoothing, bloom });
        }
        Ok(())
    }

    /// Records `compositor.tone_map`, with bloom `compositor.bloom_down` and `compositor.bloom_up` before it, and with anti-aliasing
    /// `compositor.fxaa_edges` and `compositor.fxaa` after it.
    ///
    /// # Panics
    /// Without [`Self::resize`] to the picture's size.
    pub fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        radiance: &Texture<Radiance>,
        display: &Display,
    ) {
        let images = self.images_for(radiance);
        let (Some(passes), Some(smoothing)) = (&self.anti_aliasing, &images.smoothing) else {
            return self.record_as_drawn(gpu, recorder, radiance, display);
        };
        let SmoothingImages { lumas, edges } = smoothing;
        let size = images.size;
        self.record_tone_map(gpu, recorder, radiance, images, (&passes.tone_map, Some(lumas)), display);
        let smoothing = recorder.uniform(&smoothing_uniform(&self.parameters, display));
        recorder.clear(gpu, "compositor.fxaa_edges", edges, 1);
        let bindings = [("smoothing", smoothing.clone()), ("lumas", lumas.bind()), ("edges", edges.bind())];
        recorder.compute(
            gpu,
            "compositor.fxaa_edges",
            &passes.edges,
            &bindings,
            Dispatch::Pixels(Display::texels(size)),
        );
        let bindings = [
            ("smoothing", smoothing),
            ("source", images.mapped.bind()),
            ("lumas", lumas.bind()),
            ("edges", edges.bind()),
            ("smoothed", display.rows().bind()),
        ];
        // Each invocation walks on through the list, whose length the GPU knows.
        recorder.compute(gpu, "compositor.fxaa", &passes.fxaa, &bindings, covered::dispatch(size));
    }

    /// As [`Self::record`], of radiance whose edges are smooth already.
    ///
    /// # Panics
    /// Without [`Self::resize`] to the picture's size.
    pub fn record_as_drawn(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        radiance: &Texture<Radiance>,
        display: &Display,
    ) {
        let images = self.images_for(radiance);
        self.record_tone_map(gpu, recorder, radiance, images, (&self.tone_map, None), display);
    }

    fn record_tone_map(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder,
        radiance: &Texture<Radiance>,
        images: &Images,
        (pipeline, lumas): (&PicturePipeline, Option<&Texture<Lumas>>),
        display: &Display,
    ) {
        let tone = recorder.uniform(&tone_map_uniform(&self.parameters, images.size));
        let mut bindings = vec![("tone", tone), ("radiance", radiance.bind())];
        if let (Some(bloom), Some(levels)) = (&self.bloom, &images.bloom) {
            bloom.record(gpu, recorder, self.parameters.stops().exp2(), radiance, levels);
            bindings.push(("bloom", levels.finest().bind()));
        }
        let targets = [("mapped", images.mapped.view())];
        let targets: Vec<_> = targets.into_iter().chain(lumas.map(|lumas| ("lumas", lumas.view()))).collect();
        recorder.picture(gpu, TONE_MAP_PASS, pipeline, &bindings, &targets, None);
        recorder.copy_rows(gpu, TONE_MAP_PASS, &images.mapped, display.rows().buffer());
    }

    fn images_for(&self, radiance: &Texture<Radiance>) -> &Images {
        let images = self.images.as_ref().filter(|images| images.size == radiance.size());
        images.unwrap_or_else(|| panic!("no room for a picture of {:?} pixels", radiance.size()))
    }
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
) -> Result<PicturePipeline, CompositorError> {
    let curve = match parameters.tone_curve {
        ToneCurve::Neutral => Some("NEUTRAL"),
        ToneCurve::Filmic => Some("FILMIC"),
        ToneCurve::Clip => None,
    };
    let is_graded = parameters.contrast != 1.0 || parameters.saturation != 1.0;
    let graded = is_graded.then_some("GRADED");
    let transparent = parameters.transparent.then_some("TRANSPARENT");
    let bloom = (parameters.bloom > 0.0).then_some("BLOOM");
    let smoothed = is_smoothed.then_some("SMOOTHED");
    let definitions: Vec<Definition> = [curve, graded, transparent, bloom, smoothed]
        .into_iter()
        .flatten()
        .map(|name| Definition { name, value: 1 })
        .collect();
    let targets = [FourPixels::FORMAT, Lumas::FORMAT];
    Ok(gpu.picture_pipeline(&PicturePipelineDescriptor {
        shader: TONE_MAP,
        includes: INCLUDES,
        definitions: &definitions,
        targets: &targets[..1 + usize::from(is_smoothed)],
        pixels: Pixels::All,
    })?)
}

fn tone_map_uniform(parameters: &CompositorParameters, size: [u32; 2]) -> ToneMapUniform {
    let gain = Vec3::from(parameters.white_balance) * parameters.stops().exp2();
    ToneMapUniform {
        gain: gain.to_array(),
        contrast: parameters.contrast,
        size_px: size,
        saturation: parameters.saturation,
        pad: 0,
        white_balance: parameters.white_balance,
        bloom: parameters.bloom,
    }
}

fn smoothing_uniform(parameters: &CompositorParameters, display: &Display) -> SmoothingUniform {
    // The brightness that edges are looked for in is 0 to 1.5, of which alpha has a third.
    let (luma_scale, luma_offset) = if parameters.transparent { (1.5, 0.0) } else { (1.0, 0.5) };
    SmoothingUniform {
        size_px: display.size(),
        luma_scale,
        luma_offset,
        row_px: display.rows().size()[0],
        pad: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniforms_match_their_shaders() {
        ToneMapUniform::check_layout(&TONE_MAP, INCLUDES).unwrap();
        SmoothingUniform::check_layout(&FXAA, INCLUDES).unwrap();
    }
}
