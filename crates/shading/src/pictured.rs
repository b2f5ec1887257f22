use std::sync::OnceLock;

use meniscus_gpu::{Definition, Gpu, GpuError};

use crate::Surroundings;

/// A pass that looks at the surroundings, in variants that are made when they are first needed: with a picture in place of the
/// sky, with shadows or another kind of the pass's own. Software drivers run through both sides of a choice in a shader.
#[derive(Debug)]
pub(crate) struct Pictured<P> {
    plain: P,
    /// Neither, which is never made, pictured, of the pass's own kind, both.
    variants: [OnceLock<Option<P>>; 4],
}

const PICTURED: Definition = Definition { name: "PICTURED", value: 1 };
const SHADOWED: Definition = Definition { name: "SHADOWED", value: 1 };

impl<P> Pictured<P> {
    /// `compile` makes the pass with these definitions.
    pub(crate) fn new(compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>) -> Result<Self, GpuError> {
        Ok(Self { plain: compile(&[])?, variants: Default::default() })
    }

    /// The pass as it is with the sky and without shadows.
    pub(crate) fn plain(&self) -> &P {
        &self.plain
    }

    /// As [`Self::choose`], with the shadows that objects throw if `is_shadowed`.
    pub(crate) fn choose_shadowed(
        &self,
        gpu: &Gpu,
        surroundings: &Surroundings,
        is_shadowed: bool,
        compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>,
    ) -> &P {
        self.choose(gpu, surroundings, is_shadowed.then_some(SHADOWED), compile)
    }

    /// The pass for these surroundings, of a kind of its own with `kind`, which is the same in every call that has one. What keeps
    /// it from compiling comes out of [`Gpu::wait`].
    pub(crate) fn choose(
        &self,
        gpu: &Gpu,
        surroundings: &Surroundings,
        kind: Option<Definition>,
        compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>,
    ) -> &P {
        let is_pictured = surroundings.environment.sharp[0] != 0;
        let mut definitions = Vec::new();
        definitions.extend(is_pictured.then_some(PICTURED));
        definitions.extend(kind);
        if definitions.is_empty() {
            return &self.plain;
        }
        let make = || compile(&definitions).inspect_err(|error| gpu.report(error)).ok();
        let variant = &self.variants[usize::from(is_pictured) + 2 * usize::from(kind.is_some())];
        variant.get_or_init(make).as_ref().unwrap_or(&self.plain)
    }
}
