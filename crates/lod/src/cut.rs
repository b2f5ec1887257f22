//! From a threshold to keep probabilities.

use meniscus_gpu::role::KeptRange;
use rayon::prelude::*;

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
    let groups: Vec<Group> = candidates.iter().map(Group::new).collect();
    let target = threshold * groups.iter().map(Group::all).sum::<f64>();
    let (least, most) = candidates
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(least, most), c| (least.min(c.importance), most.max(c.importance)));
    // At the low end no p is above half the threshold, at the high end every p is 1.
    let (mut low, mut high) = (0.5 * threshold / most, 1.0 / (BURIED * least));
    let (mut kept_low, mut kept_high) = (kept(&groups, low), kept(&groups, high));
    // What is kept rises in straight pieces: where the chord meets the target is right once both ends are on one piece. Halving
    // in between gets them there. What is left of the bracket is less than the distance of two neighbouring f32 thresholds
    // (6e-8), so that higher ones keep more.
    for turn in 0..MOST_TURNS {
        if high <= low * (1.0 + SETTLED) {
            break;
        }
        let share = (target - kept_low) / (kept_high - kept_low);
        let middle = match turn % 3 {
            2 => (low * high).sqrt(),
            // To either side of the meeting point, so that both ends close in on it.
            side => {
                let aside = if side == 0 { 1.0 - 0.25 * SETTLED } else { 1.0 + 0.25 * SETTLED };
                (low + share * (high - low)) * aside
            }
        };
        if middle <= low || middle >= high || middle.is_nan() {
            continue;
        }
        let there = kept(&groups, middle);
        if there < target { (low, kept_low) = (middle, there) } else { (high, kept_high) = (middle, there) }
    }
    high
}

/// Relative width at which the bracket of a scale is left.
const SETTLED: f64 = 1e-11;
/// Turns after which it is in any case: every third halves the logarithm of what is left of at most 120 decades.
const MOST_TURNS: u32 = 180;

/// Groups that are added up by themselves. Not by how many threads there are, which would change the last bits of the sum.
const GROUPS_AT_ONCE: usize = 4096;

/// What a chunk adds to the number of kept particles.
struct Group {
    /// Importance and number of its isolated particles, shell and buried ones.
    parts: [(f64, f64); 3],
    spared: f64,
}

impl Group {
    fn new(candidate: &Candidate) -> Self {
        let [isolated, shell, count] =
            [candidate.chunk.isolated, candidate.chunk.shell, candidate.chunk.count].map(f64::from);
        let w = candidate.importance;
        let parts = [(w, isolated), (w * candidate.shell, shell), (w * BURIED, count - isolated - shell)];
        Self { parts, spared: candidate.spared }
    }

    fn all(&self) -> f64 {
        self.parts.iter().map(|(_, count)| count).sum()
    }
}

/// How many particles are kept at `scale`: those spared counted, but at most twice as many as without them.
fn kept(groups: &[Group], scale: f64) -> f64 {
    let of_some = |groups: &[Group]| {
        groups.iter().fold((0.0, 0.0), |(kept, unspared), group| {
            let of_all: f64 = group.parts.iter().map(|(w, count)| count * (scale * w).min(1.0)).sum();
            let (w, isolated) = group.parts[0];
            let spared = isolated * (group.spared - (scale * w).min(1.0)).max(0.0);
            (kept + of_all + spared, unspared + of_all)
        })
    };
    let sums: Vec<(f64, f64)> = groups.par_chunks(GROUPS_AT_ONCE).map(of_some).collect();
    let (kept, unspared) = sums.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    f64::min(kept, 2.0 * unspared)
}
