//! Where converted values go.

/// A destination that is only written, in pieces that different threads may write: RAM, or a mapped GPU buffer that must not be
/// read (`wgpu::WriteOnly` splits and copies just so).
pub trait Sink: Send + Sized {
    /// What is written.
    type Item: Copy + Default + Send;

    /// How many values fit.
    fn len(&self) -> usize;

    /// Whether none fits.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The first `mid` places, at most [`Self::len`], and the others.
    fn split_at(self, mid: usize) -> (Self, Self);

    /// Writes `values`, exactly as many as fit.
    fn copy_from(self, values: &[Self::Item]);

    /// Writes what `make` puts into the buffer it is given, which has one place for each that fits. Memory that may be read can
    /// be that buffer itself; `scratch` is for sinks that cannot.
    fn fill<E>(
        self,
        scratch: &mut Vec<Self::Item>,
        make: impl FnOnce(&mut [Self::Item]) -> Result<(), E>,
    ) -> Result<(), E> {
        scratch.clear();
        scratch.resize(self.len(), Self::Item::default());
        make(scratch)?;
        self.copy_from(scratch);
        Ok(())
    }
}

impl<T: Copy + Default + Send> Sink for &mut [T] {
    type Item = T;

    fn len(&self) -> usize {
        (**self).len()
    }

    fn split_at(self, mid: usize) -> (Self, Self) {
        self.split_at_mut(mid)
    }

    fn copy_from(self, values: &[T]) {
        self.copy_from_slice(values);
    }

    fn fill<E>(self, _: &mut Vec<T>, make: impl FnOnce(&mut [T]) -> Result<(), E>) -> Result<(), E> {
        make(self)
    }
}

/// `sink` in pieces of `size` places, the last one of what is left.
pub(crate) fn pieces<S: Sink>(sink: S, size: usize) -> Vec<S> {
    let mut rest = sink;
    let mut pieces = Vec::with_capacity(rest.len().div_ceil(size.max(1)));
    while rest.len() > size {
        let (piece, others) = rest.split_at(size);
        pieces.push(piece);
        rest = others;
    }
    if !rest.is_empty() {
        pieces.push(rest);
    }
    pieces
}
