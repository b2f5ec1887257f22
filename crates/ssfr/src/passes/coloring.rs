use bytemuck::{Pod, Zeroable};
use meniscus_gpu::role::{AttributeValues, ColorTable, Scratch, SurfaceColor};
use meniscus_gpu::{
    Binding, Buffer, ComputePipeline, Definition, Dispatch, Gpu, GpuError, HostField, HostStruct, Image,
    Recorder, Texture, shader,
};

use super::pages::{List, PageDrawing, each_page};
use super::{pipeline, pipeline_with};
use crate::splats::Common;
use crate::{SplatSet, SsfrParams, SurfaceImages};

/// Value of a particle that has none.
pub const NO_VALUE: f32 = f32::MAX;

/// From values to places on a colour scale: `(value - offset) * factor`, of the natural logarithm of the value where `is_log`;
/// WGSL: `ColorScale` in `shaders/ssfr/coloring.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ScaleUniform {
    /// Where the scale begins.
    pub offset: f32,
    /// One over its length.
    pub factor: f32,
    /// 1 or 0.
    pub is_log: u32,
}

impl HostStruct for ScaleUniform {
    const WGSL_NAME: &'static str = "ColorScale";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(ScaleUniform { offset, factor, is_log });
}

/// A set that was drawn into the surface, and the values of its particles.
#[derive(Clone, Copy, Debug)]
pub struct ColoredSet<'a> {
    /// The set.
    pub set: SplatSet<'a>,
    /// One buffer for each of its pages, in the order of their particles; [`NO_VALUE`] for none.
    pub values: &'a [Buffer<AttributeValues>],
}

/// Colours the surface by an attribute of the particles that it is made of.
#[derive(Debug)]
pub struct Coloring {
    splat: ComputePipeline,
    strips: ComputePipeline,
    resolve: ComputePipeline,
    table: Buffer<ColorTable>,
    /// Two numbers per pixel: weights and weighted places.
    sums: Image<Scratch>,
}

impl Coloring {
    /// For pictures of `size` = `[width, height]` pixels and a scale with the linear colours `table`, from its start to its end.
    ///
    /// # Errors
    /// [`GpuError`]: the shader does not compile, or beyond the device's limits.
    ///
    /// # Panics
    /// Without any colour.
    pub fn new(gpu: &Gpu, size: [u32; 2], table: &[[f32; 4]]) -> Result<Self, GpuError> {
        assert!(!table.is_empty(), "a colour scale without colours");
        Ok(Self {
            splat: pipeline(gpu, shader!("ssfr/coloring")),
            strips: pipeline_with(gpu, shader!("ssfr/coloring"), &[Definition { name: "STRIPS", value: 1 }]),
            resolve: pipeline(gpu, shader!("ssfr/coloring_resolve")),
            table: Buffer::from_slice(gpu, table)?,
            sums: Image::new(gpu, [2 * size[0], size[1]])?,
        })
    }

    /// Writes the colour of every pixel: the mean place of the particles near the visible surface, weighted by how near they are, on
    /// the scale. `images` hold the surface of `sets`, before or after smoothing.
    ///
    /// # Panics
    /// If the sizes differ, or a set has not as many values as pages.
    #[expect(clippy::too_many_arguments, reason = "inputs and outputs of two passes, each used once")]
    pub fn record(
        &self,
        recorder: &mut Recorder,
        gpu: &Gpu,
        camera: &Binding,
        sets: &[ColoredSet<'_>],
        scale: &ScaleUniform,
        images: &SurfaceImages,
        colors: &Texture<SurfaceColor>,
    ) {
        let [width, height] = images.size();
        assert_eq!(
            (self.sums.size(), colors.size()),
            ([2 * width, height], [width, height]),
            "size of colours"
        );
        let pixels = width as usize * height as usize;
        recorder.clear(gpu, "ssfr.coloring", self.sums.buffer(), 2 * pixels);
        let scale = recorder.uniform(scale);
        for ColoredSet { set, values } in sets {
            assert_eq!(set.pages.len(), values.len(), "pages with values");
            let common = Common::of(std::slice::from_ref(set), &SsfrParams::default());
            for list in [List::Front, List::Visible] {
                each_page(recorder, std::slice::from_ref(set), &common, list, |recorder, page| {
                    let bindings = vec![
                        ("camera", camera.clone()),
                        ("splats", page.splats),
                        ("scale", scale.clone()),
                        ("page", page.particles),
                        ("values", values[page.index].bind()),
                        ("front", images.front.bind()),
                        ("sums", self.sums.bind()),
                    ];
                    let drawing =
                        PageDrawing { whole: &self.splat, strips: &self.strips, list: &images.strips };
                    drawing.record(
                        recorder,
                        gpu,
                        "ssfr.coloring",
                        bindings,
                        None,
                        (page.ranges, page.groups),
                    );
                });
            }
        }
        let bindings = [("sums", self.sums.bind()), ("table", self.table.bind()), ("colors", colors.bind())];
        recorder.compute(
            gpu,
            "ssfr.coloring_resolve",
            &self.resolve,
            &bindings,
            Dispatch::Pixels(images.size()),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::INCLUDES;

    #[test]
    fn the_scale_has_the_layout_of_its_shader() {
        ScaleUniform::check_layout(&shader!("ssfr/coloring"), INCLUDES).unwrap();
    }
}
