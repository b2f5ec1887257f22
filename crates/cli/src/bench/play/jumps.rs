//! Dragging the seek bar: how soon something is seen of a frame, and how soon all of it.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use meniscus_core::Cancel;
use meniscus_pipeline::PreparedFrame;
use meniscus_prefetch::{Plan, Prefetcher};
use serde::Serialize;

use super::super::spread::Spread;
use super::super::{Orbit, ms_since};
use crate::failure::Failure;
use crate::picture::Studio;

/// First impressions are of one in so many particles.
pub const COARSE_SHARE: u32 = 8;

/// What was seen after jumps, drawing included.
#[derive(Clone, Debug, Serialize)]
pub struct JumpReport {
    pub jumps: u32,
    /// Jumps to frames that were in memory.
    pub at_hand: u32,
    /// Jumps whose frames failed.
    pub failed: u32,
    /// Until the first impression is drawn, of the jumps that had one.
    pub first_impression_ms: Option<Spread>,
    /// Until the whole frame is drawn, of those that were not at hand.
    pub whole_ms: Option<Spread>,
}

/// Jumps to `jumps` places all over the series of `prefetcher`.
pub fn run(
    prefetcher: &Prefetcher<Arc<PreparedFrame>>,
    studio: &mut Studio,
    orbit: &mut Orbit,
    jumps: u32,
    cancel: &Cancel,
) -> Result<JumpReport, Failure> {
    // Multiples of the golden ratio leave no part of the series out and never come back to a place.
    const STRIDE: f64 = 0.618_033_988_749_895;
    let count = prefetcher.frame_count();
    let (mut coarse_ms, mut whole_ms) = (Vec::new(), Vec::new());
    let (mut at_hand, mut failed) = (0, 0);
    for jump in 1..=jumps {
        let index = ((f64::from(jump) * STRIDE).fract() * count as f64) as usize;
        let started = Instant::now();
        prefetcher.set_plan(Plan::Play { playhead: index, step: 0, looping: false });
        let mut waited = false;
        let whole = loop {
            if let Some(whole) = prefetcher.take_ready(index) {
                break whole;
            }
            waited = true;
            if let Some(coarse) = prefetcher.take_coarse(index) {
                orbit.draw(studio, &coarse, cancel)?;
                coarse_ms.push(ms_since(started));
            }
            if cancel.is_cancelled() {
                return Err(Failure::Interrupted);
            }
            thread::sleep(Duration::from_millis(1));
        };
        match whole {
            Ok(whole) => {
                orbit.draw(studio, &whole, cancel)?;
                if waited {
                    whole_ms.push(ms_since(started));
                } else {
                    at_hand += 1;
                }
                prefetcher.give_back(index, whole);
            }
            Err(_) => failed += 1,
        }
    }
    let (first_impression_ms, whole_ms) = (Spread::of(&coarse_ms), Spread::of(&whole_ms));
    Ok(JumpReport { jumps, at_hand, failed, first_impression_ms, whole_ms })
}
