use crate::{ChunkedSet, LodError, LodParams, Selection, Viewpoint, select};

/// What a selection depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Inputs {
    set: u64,
    viewpoint: Viewpoint,
    params: LodParams,
}

/// Keeps the selection of a set and makes it anew only when something it depends on has changed (\[T\] 3.5.2).
#[derive(Debug, Default)]
pub struct Selector {
    inputs: Option<Inputs>,
    selection: Selection,
}

impl Selector {
    /// Brings the selection up to date, arguments as for [`select()`]; `true` where it was made anew and has to go to the
    /// GPU.
    ///
    /// # Errors
    /// As [`select()`]; the selection then is the last good one.
    pub fn update(
        &mut self,
        set: &ChunkedSet,
        viewpoint: &Viewpoint,
        params: &LodParams,
    ) -> Result<bool, LodError> {
        let inputs = Inputs { set: set.serial(), viewpoint: *viewpoint, params: *params };
        if self.inputs == Some(inputs) {
            return Ok(false);
        }
        self.selection = select(set, viewpoint, params)?;
        self.inputs = Some(inputs);
        Ok(true)
    }

    /// The selection that the last successful [`Self::update`] left; empty before the first.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }
}
