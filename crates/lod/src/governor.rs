//! Detail that follows the clock or the user's hand, for the viewer: pictures that depend on how fast the last ones were, or
//! on what was drawn before, are not for `render`.

use crate::{LodParams, Mode};

/// Holds a frame rate: scales the tolerated errors until a frame takes the time it may.
#[derive(Clone, Debug)]
pub struct RateGovernor {
    target_ms: f64,
    /// Factor on the tolerated errors, 1 to [`Self::COARSEST`].
    coarsening: f64,
}

impl RateGovernor {
    /// Errors are never tolerated beyond this many times what the user allows: 32 pixels for half a pixel.
    pub const COARSEST: f64 = 64.0;

    /// Frames this much faster than wanted leave the detail alone: without a band it would never rest.
    const BAND: f64 = 0.8;

    /// Largest change per frame, so that one slow frame (another program, a compiled shader) does not blur the picture.
    const STEP: f64 = 1.25;

    /// Holds `frames_per_second`, > 0.
    pub fn new(frames_per_second: f64) -> Self {
        Self { target_ms: 1e3 / frames_per_second.max(1e-3), coarsening: 1.0 }
    }

    /// Takes in how long the last frame took, in milliseconds; what is not a time is ignored.
    pub fn frame_took(&mut self, ms: f64) {
        if !(ms > 0.0 && ms.is_finite()) {
            return;
        }
        let load = ms / self.target_ms;
        if !(Self::BAND..=1.0).contains(&load) {
            // Towards the middle of the band.
            let factor = (load / Self::BAND.sqrt()).clamp(1.0 / Self::STEP, Self::STEP);
            self.coarsening = (self.coarsening * factor).clamp(1.0, Self::COARSEST);
        }
    }

    /// The parameters for the next frame: `base` with its errors scaled.
    pub fn params(&self, base: &LodParams) -> LodParams {
        coarsened(base, self.coarsening)
    }
}

/// `base` by its error bounds, each tolerated `factor` times.
fn coarsened(base: &LodParams, factor: f64) -> LodParams {
    LodParams {
        mode: Mode::ErrorBound,
        error_px: (f64::from(base.error_px) * factor) as f32,
        error_color: (f64::from(base.error_color) * factor).min(1.0) as f32,
        ..*base
    }
}

/// Adds detail while nothing moves: every following frame halves the errors, until all is drawn. Whatever changes drops it
/// back at once.
#[derive(Clone, Debug, Default)]
pub struct Refinement {
    still_frames: u32,
}

impl Refinement {
    /// Halvings before everything is drawn.
    pub const STEPS: u32 = 3;

    /// The parameters for the next frame, from those of a moving picture; `is_still`: it shows what the last one did, from
    /// the same place, with the same `moving` parameters.
    pub fn next(&mut self, is_still: bool, moving: &LodParams) -> LodParams {
        self.still_frames = if is_still { self.still_frames.saturating_add(1) } else { 0 };
        match self.still_frames {
            0 => *moving,
            n if n < Self::STEPS && moving.mode == Mode::ErrorBound => {
                coarsened(moving, 0.5f64.powi(n as i32))
            }
            // Equal steps to the full set.
            n if n < Self::STEPS => {
                let rest = (1.0 - moving.threshold) * n as f32 / Self::STEPS as f32;
                LodParams { threshold: moving.threshold + rest, ..*moving }
            }
            _ => LodParams { mode: Mode::Threshold, threshold: 1.0, ..*moving },
        }
    }

    /// Whether the last parameters draw everything: a viewer need not draw again until something changes.
    pub fn is_complete(&self) -> bool {
        self.still_frames >= Self::STEPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUND: LodParams = LodParams {
        mode: Mode::ErrorBound,
        threshold: 1.0,
        policy: crate::Policy::Default,
        error_px: 0.5,
        error_color: 0.004,
        far: None,
    };

    /// Frames of a machine that takes `fixed + work / coarsening` milliseconds.
    fn play(governor: &mut RateGovernor, fixed: f64, work: f64, frames: usize) -> Vec<f64> {
        (0..frames)
            .map(|_| {
                let coarsening = governor.params(&BOUND).error_px / BOUND.error_px;
                let ms = fixed + work / f64::from(coarsening);
                governor.frame_took(ms);
                ms
            })
            .collect()
    }

    #[test]
    fn a_rate_that_can_be_held_is_held_and_rests() {
        let mut governor = RateGovernor::new(50.0);
        let frames = play(&mut governor, 5.0, 100.0, 60);
        assert_eq!(frames[0], 105.0);
        let late = &frames[20..];
        assert!(late.iter().all(|&ms| (16.0..=20.0).contains(&ms)), "{late:?}");
        assert!(late.windows(2).all(|pair| pair[0] == pair[1]), "it must not swing: {late:?}");
        // Work gone, detail comes back to what the user allows, and no finer.
        play(&mut governor, 1.0, 1.0, 60);
        assert_eq!(governor.params(&BOUND), BOUND);
    }

    #[test]
    fn a_rate_that_cannot_be_held_ends_at_the_coarsest() {
        let mut governor = RateGovernor::new(1000.0);
        play(&mut governor, 5.0, 100.0, 100);
        let params = governor.params(&BOUND);
        assert_eq!(params.error_px, 32.0);
        // 0.004 * 64 in f64, rounded once.
        assert!((params.error_color - 0.256).abs() < 1e-6);
        for nonsense in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
            governor.frame_took(nonsense);
            assert_eq!(governor.params(&BOUND), params);
        }
    }

    #[test]
    fn one_slow_frame_changes_little() {
        let mut governor = RateGovernor::new(50.0);
        governor.frame_took(5000.0);
        assert_eq!(governor.params(&BOUND).error_px, 0.5 * 1.25);
    }

    #[test]
    fn a_still_picture_gets_all_detail_in_steps_and_a_moving_one_none() {
        for moving in [BOUND, LodParams { threshold: 0.4, ..LodParams::default() }] {
            let mut refinement = Refinement::default();
            assert_eq!(refinement.next(false, &moving), moving);
            let steps: Vec<LodParams> = (0..4).map(|_| refinement.next(true, &moving)).collect();
            assert!(steps[0].error_px < moving.error_px || steps[0].threshold > moving.threshold);
            assert!(steps[1].error_px < steps[0].error_px || steps[1].threshold > steps[0].threshold);
            assert!(steps[2].is_full() && steps[3].is_full() && refinement.is_complete());
            assert_eq!(refinement.next(false, &moving), moving);
            assert!(!refinement.is_complete());
        }
    }
}
