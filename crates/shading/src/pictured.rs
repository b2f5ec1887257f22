use std::sync::OnceLock;

use meniscus_gpu::{Definition, Gpu, GpuError};

use crate::Surroundings;

/// A pass that looks at the surroundings: as it is with the sky, and another one, made when it is first needed, for a picture
/// in place of the sky.
#[derive(Debug)]
pub(crate) struct Pictured<P> {
    sky: P,
    picture: OnceLock<Option<P>>,
}

/// Compiles the variant for a picture.
const PICTURED: Definition = Definition { name: "PICTURED", value: 1 };

impl<P> Pictured<P> {
    /// `compile` makes the pass with these definitions.
    pub(crate) fn new(compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>) -> Result<Self, GpuError> {
        Ok(Self { sky: compile(&[])?, picture: OnceLock::new() })
    }

    /// The pass for these surroundings. What keeps it from compiling comes out of [`Gpu::wait`].
    pub(crate) fn choose(
        &self,
        gpu: &Gpu,
        surroundings: &Surroundings,
        compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>,
    ) -> &P {
        if surroundings.environment.sharp[0] == 0 {
            return &self.sky;
        }
        let make = || compile(&[PICTURED]).inspect_err(|error| gpu.report(error)).ok();
        self.picture.get_or_init(make).as_ref().unwrap_or(&self.sky)
    }
}
