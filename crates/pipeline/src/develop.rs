use meniscus_compositor::develop::{
    display_16, finite_radiance, reduce_display_8, reduce_display_16, reduce_linear,
};
use meniscus_core::{PixelDepth, Pixels};

use crate::{PipelineError, Renderer};

impl Renderer {
    /// The picture that was just drawn, as it is written: `display` are its pixels, `supersampling` times as wide and high as
    /// `size`. With 16 bits, and of linear pixels, edges are as they were drawn: anti-aliasing works on 8 bits.
    ///
    /// # Errors
    /// The GPU's.
    ///
    /// # Panics
    /// Before the first frame, or if `display` is of another size.
    pub fn develop(
        &self,
        display: Vec<u32>,
        depth: PixelDepth,
        size: [u32; 2],
        supersampling: u32,
    ) -> Result<Pixels, PipelineError> {
        let radiance = || self.images().radiance.read_floats(self.gpu());
        let post = &self.settings().post;
        let is_reduced = supersampling > 1;
        Ok(match depth {
            PixelDepth::Display8 if is_reduced => {
                Pixels::Display8(reduce_display_8(&display, size, supersampling))
            }
            PixelDepth::Display8 => Pixels::Display8(display),
            PixelDepth::Display16 => {
                let pixels = display_16(post, &radiance()?, self.images().radiance.size());
                Pixels::Display16(if is_reduced {
                    reduce_display_16(&pixels, size, supersampling)
                } else {
                    pixels
                })
            }
            PixelDepth::Linear => {
                let pixels = finite_radiance(post, &radiance()?);
                Pixels::Linear(if is_reduced { reduce_linear(&pixels, size, supersampling) } else { pixels })
            }
        })
    }
}
