//! From a threshold to keep probabilities.

use meniscus_gpu::role::KeptRange;

use crate::select::Candidate;
use crate::{LodParams, Policy};

/// Smallest keep probability other than none, in 1/65536: below it, the sixteen bits of the hash would bias the fade's
/// mean weight by more than 0.3 % (see the bound in the tests of [`crate::weight`]).
pub const MIN_KEEP: u32 = 16;

/// Importance of buried particles in that of others, and of shells that face away: they only show through cracks, but the
/// threshold is the fraction of all.
pub(crate) const BURIED: f64 = 0.1;

/// How importance becomes a keep probability; rises with the threshold for every importance.
pub(crate) enum Cut {
    /// Threshold 1, to the last particle.
    All,
    /// Threshold 0.
    None,
    /// `min(1, scale * importance)`.
    Scale(f64),
    /// `1 - cut / importance`, where positive.
    Level(f64),
}

impl Cut {
    pub(crate) fn solve(candidates: &[Candidate], params: &LodParams) -> Self {
        let threshold = f64::from(params.threshold);
        match params.policy {
            _ if params.threshold >= 1.0 => Self::All,
            _ if params.threshold <= 0.0 || candidates.is_empty() => Self::None,
            Policy::Default => Self::Scale(solve_scale(candidates, threshold)),
            Policy::Thesis => {
                let (sum, count) = candidates.iter().fold((0.0, 0.0), |(sum, count), c| {
                    let n = f64::from(c.chunk.count);
                    (sum + n * c.importance, count + n)
                });
                // l / (1 + l) >= 1 - t with l = r w / CLOD, solved for the random number r.
                Self::Level(sum / count * (1.0 - threshold) / threshold)
            }
        }
    }

    /// Whether nothing but what is spared is kept.
    pub(crate) fn keeps_none(&self) -> bool {
        matches!(self, Self::None)
    }

    fn probability(&self, importance: f64) -> f64 {
        match self {
            Self::All => 1.0,
            Self::None => 0.0,
            Self::Scale(scale) => (scale * importance).min(1.0),
            Self::Level(cut) => (1.0 - cut / importance).max(0.0),
        }
    }

    /// The keep probability in 1/65536; 0 keeps none.
    pub(crate) fn keep(&self, importance: f64, at_least: f64) -> u32 {
        Self::integer(self.probability(importance).max(at_least))
    }

    /// A probability in 1/65536; 0 only for none.
    pub(crate) fn integer(p: f64) -> u32 {
        if p == 0.0 { 0 } else { ((p * 65536.0).round() as u32).clamp(MIN_KEEP, KeptRange::KEEP_ALL) }
    }
}

/// The scale at which the expected number of kept particles is `threshold` times all, isolated ones counted with what is
/// spared of them, but the others still are kept for half the threshold.
fn solve_scale(candidates: &[Candidate], threshold: f64) -> f64 {
    let total: f64 = candidates.iter().map(|c| f64::from(c.chunk.count)).sum();
    let kept = |scale: f64| {
        let (kept, unspared) = candidates.iter().fold((0.0, 0.0), |(kept, unspared), c| {
            let [p, p_shell, p_buried] =
                [1.0, c.shell, BURIED].map(|factor| (scale * c.importance * factor).min(1.0));
            let [isolated, shell] = [c.chunk.isolated, c.chunk.shell].map(f64::from);
            let buried = f64::from(c.chunk.count) - isolated - shell;
            let of_all = isolated * p + shell * p_shell + buried * p_buried;
            (kept + of_all + isolated * (c.spared - p).max(0.0), unspared + of_all)
        });
        f64::min(kept, 2.0 * unspared)
    };
    let (least, most) = candidates
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(least, most), c| (least.min(c.importance), most.max(c.importance)));
    // At the low end no p is above half the threshold, at the high end every p is 1. Sixty halvings of the logarithm of
    // their ratio leave less than the distance of two neighbouring f32 thresholds, so that higher ones keep more.
    let (mut low, mut high) = (0.5 * threshold / most, 1.0 / (BURIED * least));
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if kept(middle) < threshold * total { low = middle } else { high = middle }
    }
    high
}
