//! How groups of particles move: not at all, as rigid bodies, or as a fluid.

use meniscus_core::Cancel;

use super::groups::Groups;
use super::names;
use crate::Error;
use crate::frame_data::FrameData;
use crate::scalar::ToF32;

/// A share of the fastest group's motion below which a group stands still.
const STILL: f64 = 1e-3;

/// A share of a group's motion by which its particles draw apart: below the first it is rigid, which leaves room for coordinates
/// of six digits, and above the second it deforms. What is between may be either, such as a calm river.
const RIGID: f64 = 1e-3;
/// See [`RIGID`].
const DEFORMS: f64 = 0.05;

/// Pairs of particles of a group whose distance is looked at.
const PAIRS: u64 = 1 << 12;

/// Particles below which every group looks rigid.
const FEW: u64 = 16;

/// The position of the same particle at another time.
pub(crate) type Later<'a> = &'a dyn Fn(usize) -> [f32; 3];

/// How each group moves.
pub(super) struct Motion {
    /// Root mean square of its displacements, else of its velocities.
    root_means: Vec<f64>,
    /// By how much the distances of its particles change, as a share of that.
    stretches: Vec<f64>,
    /// Whether they are of displacements.
    pub is_seen: bool,
}

impl Motion {
    /// By displacements to `later`, else by the velocities of the file; `None` when nothing moves or nothing tells.
    pub fn find(
        frame: &FrameData,
        positions: &[[f32; 3]],
        later: Option<Later>,
        groups: &Groups,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Error> {
        if let Some(later) = later {
            let motion_of = |i: usize| minus(later(i), positions[i]);
            let mut sums = Sums::of(groups);
            (0..positions.len()).for_each(|i| sums.add(i, motion_of(i)));
            if let Some(root_means) = sums.root_means() {
                let stretch = |a: usize, b: usize| {
                    let far = minus(positions[b], positions[a]);
                    length(plus(far, minus(motion_of(b), motion_of(a)))) - length(far)
                };
                let pairs = pairs(positions.len(), groups);
                let root_mean = |of: &Vec<[usize; 2]>| {
                    let mut sum = Mean::default();
                    of.iter().for_each(|&[a, b]| sum.add(stretch(a, b)));
                    sum.root()
                };
                let stretches = pairs.iter().map(root_mean).collect();
                return Ok(Some(Self::new(root_means, stretches, true)));
            }
        }
        let Some(velocity) = names::find(frame, names::VELOCITY, 3) else { return Ok(None) };
        let velocities = frame.attribute_array(velocity)?;
        let mut sums = Sums::of(groups);
        for block in frame.blocks() {
            let values = velocities.values(&block, &ToF32, cancel)?;
            values.as_chunks::<3>().0.iter().zip(block.first..).for_each(|(v, i)| sums.add(i, *v));
        }
        let Some(root_means) = sums.root_means() else { return Ok(None) };
        let mut stretches = Vec::new();
        for of in pairs(positions.len(), groups) {
            // Both ends rise from pair to pair.
            let ends = [0, 1].map(|end| of.iter().map(|pair| pair[end]).collect::<Vec<_>>());
            let a = frame.values_at(velocity, &ends[0], &ToF32, cancel)?;
            let b = frame.values_at(velocity, &ends[1], &ToF32, cancel)?;
            let mut sum = Mean::default();
            for ((a, b), [i, j]) in a.as_chunks::<3>().0.iter().zip(b.as_chunks::<3>().0).zip(of) {
                let far = minus(positions[j], positions[i]);
                sum.add(dot(far, minus(*b, *a)) / length(far));
            }
            stretches.push(sum.root());
        }
        Ok(Some(Self::new(root_means, stretches, false)))
    }

    /// `stretches` in the unit of `root_means`.
    fn new(root_means: Vec<f64>, stretches: Vec<f64>, is_seen: bool) -> Self {
        let stretches = stretches.iter().zip(&root_means).map(|(stretch, mean)| stretch / mean).collect();
        Self { root_means, stretches, is_seen }
    }

    /// Which groups stand still while others move.
    pub fn still(&self) -> Vec<bool> {
        let fastest = self.root_means.iter().copied().fold(0.0, f64::max);
        self.root_means.iter().map(|&mean| mean < STILL * fastest).collect()
    }

    /// Which groups move as one rigid body, of any shape and in any way, while others deform.
    pub fn rigid(&self, sizes: &[u64]) -> Vec<bool> {
        let moves: Vec<bool> = self.still().iter().map(|still| !still).collect();
        let others_deform = (0..sizes.len()).any(|group| moves[group] && self.stretches[group] > DEFORMS);
        let is_rigid = |group: usize| {
            others_deform && moves[group] && sizes[group] >= FEW && self.stretches[group] < RIGID
        };
        (0..sizes.len()).map(is_rigid).collect()
    }
}

/// Pairs of particles of each group. Half a list apart is far apart in most files, and any distance will do.
fn pairs(points: usize, groups: &Groups) -> Vec<Vec<[usize; 2]>> {
    let mut ends = vec![[Vec::new(), Vec::new()]; groups.len()];
    let mut seen = vec![0; groups.len()];
    for i in 0..points {
        let Some(group) = groups.of(i) else { continue };
        let half = groups.sizes[group] / 2;
        let (end, place) = if seen[group] < half { (0, seen[group]) } else { (1, seen[group] - half) };
        if place.is_multiple_of(half / PAIRS + 1) {
            ends[group][end].push(i);
        }
        seen[group] += 1;
    }
    ends.into_iter().map(|[a, b]| a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()).collect()
}

/// Sums of the squared lengths of each group's motions, and how many there are.
struct Sums<'a> {
    groups: &'a Groups,
    sums: Vec<Mean>,
}

impl<'a> Sums<'a> {
    fn of(groups: &'a Groups) -> Self {
        Self { groups, sums: vec![Mean::default(); groups.len()] }
    }

    fn add(&mut self, i: usize, motion: [f32; 3]) {
        if let Some(group) = self.groups.of(i) {
            self.sums[group].add(length(motion));
        }
    }

    /// `None` when nothing moves.
    fn root_means(&self) -> Option<Vec<f64>> {
        let means: Vec<f64> = self.sums.iter().map(Mean::root).collect();
        means.iter().any(|&mean| mean > 0.0).then_some(means)
    }
}

/// A sum of squares, and of how many.
#[derive(Clone, Default)]
struct Mean(f64, f64);

impl Mean {
    /// What is not finite says nothing.
    fn add(&mut self, value: f64) {
        if value.is_finite() {
            self.0 += value * value;
            self.1 += 1.0;
        }
    }

    fn root(&self) -> f64 {
        f64::sqrt(self.0 / self.1.max(1.0))
    }
}

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn plus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f64 {
    a.iter().zip(b).map(|(&a, b)| f64::from(a) * f64::from(b)).sum()
}

fn length(a: [f32; 3]) -> f64 {
    dot(a, a).sqrt()
}
