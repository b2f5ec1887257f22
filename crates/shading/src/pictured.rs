use std::sync::OnceLock;

use meniscus_gpu::{Definition, Gpu, GpuError};

use crate::Surroundings;

/// A pass that looks at the surroundings, in variants that are made when they are first needed: with a picture in place of the
/// sky, and of kinds of the pass's own, like with shadows. Software drivers run through both sides of a choice in a shader.
#[derive(Debug)]
pub(crate) struct Pictured<P> {
    plain: P,
    /// By whether there is a picture (1), the first kind (2), the second (4) and so on; the first of all is never made.
    variants: [OnceLock<Option<P>>; 2 << MOST_KINDS],
}

/// Most kinds that a pass has of its own.
const MOST_KINDS: usize = 4;

const PICTURED: Definition = Definition { name: "PICTURED", value: 1 };
pub(crate) const SHADOWED: Definition = Definition { name: "SHADOWED", value: 1 };

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
        self.choose(gpu, surroundings, &[is_shadowed.then_some(SHADOWED)], compile)
    }

    /// The pass for these surroundings, of up to four kinds of its own, each of which is the same in every call that has one. What keeps
    /// it from compiling comes out of [`Gpu::wait`].
    pub(crate) fn choose(
        &self,
        gpu: &Gpu,
        surroundings: &Surroundings,
        kinds: &[Option<Definition>],
        compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>,
    ) -> &P {
        let is_pictured = surroundings.environment.sharp[0] != 0;
        self.variant(gpu, is_pictured.then_some(PICTURED), kinds, compile)
    }

    /// As [`Self::choose`] for a pass that does not look at the surroundings.
    pub(crate) fn choose_unpictured(
        &self,
        gpu: &Gpu,
        kinds: &[Option<Definition>],
        compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>,
    ) -> &P {
        self.variant(gpu, None, kinds, compile)
    }

    fn variant(
        &self,
        gpu: &Gpu,
        pictured: Option<Definition>,
        kinds: &[Option<Definition>],
        compile: impl FnOnce(&[Definition]) -> Result<P, GpuError>,
    ) -> &P {
        let kinds = || std::iter::once(pictured).chain(kinds.iter().copied());
        let place = kinds().enumerate().map(|(i, kind)| usize::from(kind.is_some()) << i).sum::<usize>();
        if place == 0 {
            return &self.plain;
        }
        let definitions: Vec<Definition> = kinds().flatten().collect();
        let make = || compile(&definitions).inspect_err(|error| gpu.report(error)).ok();
        self.variants[place].get_or_init(make).as_ref().unwrap_or(&self.plain)
    }
}
