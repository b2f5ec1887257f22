//! How coarse the thickness may be for the errors that the user tolerates.

use crate::stand_ins::{Coarseness, StandIns};
use crate::{LodParams, Mode};

/// Error of the thickness that stand-ins may cause, relative to the thickness: estimates from few views; of lattices seen along
/// their rows it is larger (`tests/tests/chain/detail.rs` bounds both). By part, shell and buried, and [`Coarseness`]. The shell
/// is worse: what is left out of shape there lies at the edge of the water.
const RELATIVE_ERROR: [[f32; 3]; 2] = [[0.02, 0.06, 0.1], [0.002, 0.02, 0.06]];

/// Greatest change of colour for a relative change of thickness: `x exp(-x)` is at most 1/e.
const COLOR_PER_RELATIVE_ERROR: f32 = 0.367_879_45;

/// Stand-ins lie an edge of what they replace apart, and their sum ripples with that period. A ripple of any strength is
/// tolerated up to this many tolerated errors in pixels: four pixels by default, two of the samples of 2 x 2 pixels that the
/// thickness is made of and smoothed over.
const PERIOD_ERRORS: f32 = 8.0;

/// Distance of particles, in samples of the thickness, up to which stand-ins cost less than their particles: a large sphere covers
/// many samples, while a particle is shared out between four whatever its size. Measured on llvmpipe for samples of 2 x 2 pixels.
const WORTH_IT_SAMPLES: [f32; 3] = [1.5, 2.5, 4.0];

/// The stand-ins to take for a part of a chunk whose particles are `spacing_px` pixels apart, where a sample of the thickness is as
/// wide as `sample_px`; `None`: its particles.
pub(crate) fn stand_ins_for(
    of_part: &[StandIns; 3],
    is_buried: bool,
    spacing_px: f32,
    sample_px: f32,
    params: &LodParams,
) -> Option<StandIns> {
    if params.mode == Mode::Threshold && !(params.threshold > 0.0 && params.threshold < 1.0) {
        return None;
    }
    let is_tolerated = |coarseness: Coarseness| {
        let error = RELATIVE_ERROR[usize::from(is_buried)][coarseness as usize] * COLOR_PER_RELATIVE_ERROR;
        error <= params.error_color
            || coarseness.edge_spacings() * spacing_px <= PERIOD_ERRORS * params.error_px
    };
    Coarseness::ALL
        .into_iter()
        .rev()
        .filter(|&coarseness| {
            is_tolerated(coarseness) && spacing_px <= WORTH_IT_SAMPLES[coarseness as usize] * sample_px
        })
        .map(|coarseness| of_part[coarseness as usize])
        .find(|stand_ins| stand_ins.count > 0)
}
