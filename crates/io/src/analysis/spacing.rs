//! The distance of neighbouring particles, from the particles alone.
//!
//! The number density at sampled places is summed with a smooth kernel, as SPH does; where the neighbourhood is symmetric, the
//! place lies inside the liquid and the spacing is `density^(-1/d)`. Surfaces, spray and walls therefore do not count. The places
//! are beside particles, out of reach of their kernels: at a particle itself the density is that of the others and of the one that is
//! sure to be there, which among random particles is an eighth too much. Only where liquid is too thin for that, particles are
//! looked at themselves. Deterministic.

use super::neighbours::Neighbourhood;
use super::subset::Subset;

/// Kernel support in spacings: about 113 neighbours in space, 28 in the plane; the sum over a lattice is then within 0.5 %.
const SUPPORT: f32 = 3.0;

/// A way of looking: cheap and strict first, then thorough for thin and torn liquid.
struct Effort {
    /// Particles at which the density is taken, or to either side of which.
    samples: usize,
    /// Whether it is taken beside them.
    beside: bool,
    /// Longest offset of the neighbours' weighted centre, in supports, at which a particle counts as inside the liquid.
    max_offset: f32,
}

const EFFORTS: [Effort; 2] = [
    Effort { samples: 320, beside: true, max_offset: 0.05 },
    Effort { samples: 4096, beside: false, max_offset: 0.06 },
];

/// Numbers whose multiples fill the unit interval evenly, and two of them the unit square.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;
const SQUARE_ROOT: f64 = 0.414_213_562_373_095;

/// Deviations of the number density of random particles, smoothed over [`SUPPORT`] spacings.
const RANDOM_2D: f64 = 0.350;
const RANDOM_3D: f64 = 0.211;

/// As [`Effort::max_offset`], where densities are compared: among random particles few neighbourhoods are as symmetric as the
/// spacing asks for, and those are denser or thinner than the others.
const MAX_OFFSET_COMPARED: f32 = 0.1;

/// Fewest samples inside the liquid that make an estimate certain.
const MIN_INSIDE: usize = 12;

/// An estimate of the spacing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Estimate {
    /// In the points' unit, > 0.
    pub spacing: f64,
    /// Why it should not be trusted.
    pub doubt: Option<String>,
    /// How unevenly the particles lie: the deviation of their number density, smoothed as above, between places that are near each
    /// other, as a share of what it is of random ones. A lattice has 0.05, and 0 is also said where it was not measured.
    pub unevenness: f64,
}

/// Estimates the spacing of `points`, all finite, at those of them that are in `at`; `flat_axis` has no extent.
pub(crate) fn estimate(points: &Subset<'_>, at: &Subset<'_>, flat_axis: Option<usize>) -> Estimate {
    let [cheap, thorough] = EFFORTS;
    match attempt(points, at, flat_axis, &cheap) {
        Some(estimate) if estimate.doubt.is_none() => estimate,
        _ => attempt(points, at, flat_axis, &thorough).unwrap_or_else(|| guess(points)),
    }
}

/// A length of the data's order, where no particle has neighbours: the extent shared out among the particles, as many along
/// each dimension of their box.
fn guess(points: &Subset<'_>) -> Estimate {
    let extents: [f64; 3] = std::array::from_fn(|axis| {
        let values = || points.iter().map(|p| f64::from(p[axis]));
        (values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)).max(0.0)
    });
    let extent = extents.iter().copied().fold(0.0, f64::max);
    if extent == 0.0 {
        let doubt = match points.len() {
            0 => "there are no particles".into(),
            1 => "there is one particle".into(),
            count => format!("all {count} particles are at the same place"),
        };
        return Estimate { spacing: 1.0, doubt: Some(doubt), unevenness: 0.0 };
    }
    let mut places: Vec<[u32; 3]> = points.iter().map(|p| p.map(f32::to_bits)).collect();
    places.sort_unstable();
    places.dedup();
    let dimensions = extents.iter().filter(|e| **e > 1e-6 * extent).count();
    let spacing = extent * (places.len() as f64).powf(-1.0 / dimensions as f64);
    let doubt = Some("the particles are too far apart to have neighbours".into());
    Estimate { spacing, doubt, unevenness: 0.0 }
}

/// `None` when the particles have no neighbours.
fn attempt(
    points: &Subset<'_>,
    at: &Subset<'_>,
    flat_axis: Option<usize>,
    effort: &Effort,
) -> Option<Estimate> {
    let dimensions = if flat_axis.is_some() { 2 } else { 3 };
    let samples: Vec<[f32; 3]> = sample(at, effort.samples).collect();
    let mut guess = occupied_spacing(points, flat_axis)?;
    for _ in 0..8 {
        let reach = 1.1 * SUPPORT * guess;
        let places = if effort.beside { both_sides(&samples, reach, flat_axis) } else { Vec::new() };
        let near = Neighbourhood::collect(points, &[&samples[..], &places].concat(), reach);
        let Some(dense) = dense_spacing(&near, &samples, reach, dimensions) else {
            guess *= 2.0;
            continue;
        };
        if SUPPORT * dense > reach {
            guess = 1.1 * dense;
            continue;
        }
        let places = if effort.beside { &places } else { &samples };
        // Among the fewer neighbours in the plane, few neighbourhoods are symmetric.
        let max_offset = effort.max_offset * if dimensions == 2 { 1.6 } else { 1.0 };
        let mut estimate = refine(&near, places, dense, reach, dimensions, max_offset);
        if effort.beside {
            let support = (SUPPORT * estimate.spacing as f32).min(reach);
            estimate.unevenness = unevenness(&near, places, support, dimensions);
        }
        return Some(estimate);
    }
    None
}

/// Two places for each of `samples`, `distance` from it and opposite each other, in directions that are evenly spread over the
/// sphere, or the circle around `flat_axis`.
fn both_sides(samples: &[[f32; 3]], distance: f32, flat_axis: Option<usize>) -> Vec<[f32; 3]> {
    let shift = |i: usize| -> [f32; 3] {
        let turn = std::f32::consts::TAU * (i as f64 * GOLDEN_RATIO).fract() as f32;
        let height =
            if flat_axis.is_some() { 0.0 } else { 2.0 * (i as f64 * SQUARE_ROOT).fract() as f32 - 1.0 };
        let flat = (1.0 - height * height).sqrt();
        let mut along = [flat * turn.cos(), flat * turn.sin(), height].map(|c| c * distance);
        along.rotate_right((flat_axis.unwrap_or(2) + 1) % 3);
        along
    };
    let place = |sample: &[f32; 3], shift: [f32; 3], sign: f32| -> [f32; 3] {
        std::array::from_fn(|axis| sample[axis] + sign * shift[axis])
    };
    let sides = |(i, sample)| [1.0, -1.0].map(|sign| place(sample, shift(i), sign));
    samples.iter().enumerate().flat_map(sides).collect()
}

/// [`Estimate::unevenness`] from `places` of which two and two are opposite each other, those inside the liquid.
fn unevenness(near: &Neighbourhood, places: &[[f32; 3]], support: f32, dimensions: usize) -> f64 {
    let inside = |place: [f32; 3]| {
        let found = density(near, place, support, dimensions, MAX_OFFSET_COMPARED);
        found.filter(|found| found.1).map(|found| found.0)
    };
    let mut differences: Vec<f32> = places
        .as_chunks::<2>()
        .0
        .iter()
        .filter_map(|&[a, b]| Some(dimensions as f32 * (inside(a)? / inside(b)?).ln().abs()))
        .collect();
    if differences.len() < MIN_INSIDE {
        return 0.0;
    }
    differences.sort_by(f32::total_cmp);
    // Half of the differences of two normal numbers are smaller than 0.954 deviations.
    let deviation = f64::from(differences[differences.len() / 2]) / 0.954;
    // The root of the integral of the squared kernel: Campbell's theorem, for a density of one per cubed or squared spacing.
    deviation / if dimensions == 2 { RANDOM_2D } else { RANDOM_3D }
}

/// About `count` of `points`, evenly spread over the list; a step prime to most row lengths avoids sampling a lattice along
/// one of its planes.
fn sample(points: &Subset<'_>, count: usize) -> impl Iterator<Item = [f32; 3]> {
    let count = count.min(points.len());
    // The golden ratio's multiples fill the unit interval evenly.
    (0..count).map(move |i| {
        let fraction =
            if count == points.len() { i as f64 / count as f64 } else { (i as f64 * GOLDEN_RATIO).fract() };
        points.get(((fraction * points.len() as f64) as usize).min(points.len() - 1))
    })
}

/// Upper estimate of the spacing: the volume of the occupied cells of a grid that is refined until few samples share a cell.
/// `None` without an extent.
fn occupied_spacing(points: &Subset<'_>, flat_axis: Option<usize>) -> Option<f32> {
    if points.len() < 2 {
        return None;
    }
    let samples: Vec<[f32; 3]> = sample(points, 1 << 15).collect();
    let mut extent = 0.0_f32;
    for axis in 0..3 {
        let mut values: Vec<f32> = samples.iter().map(|p| p[axis]).collect();
        values.sort_by(f32::total_cmp);
        // Without the outermost hundredth, so that a lost particle far away does not set the scale.
        let cut = values.len() / 100;
        extent = extent.max(values[values.len() - 1 - cut] - values[cut]);
    }
    if extent <= 0.0 {
        return None;
    }
    let dimensions = if flat_axis.is_some() { 2 } else { 3 };
    let mut cell = extent / 4.0;
    for _ in 0..24 {
        let cells: std::collections::HashSet<[i32; 3]> =
            samples.iter().map(|p| p.map(|c| (c / cell).floor() as i32)).collect();
        if samples.len() < 8 * cells.len() {
            let per_cell = points.len() as f32 / cells.len() as f32;
            return Some(cell / per_cell.powf(1.0 / dimensions as f32));
        }
        cell *= 0.5;
    }
    Some(cell)
}

/// Spacing in the denser parts, from the distance to the k-th neighbour: its lower quartile over the samples. `None` when
/// most samples have fewer neighbours within `reach`.
fn dense_spacing(near: &Neighbourhood, samples: &[[f32; 3]], reach: f32, dimensions: usize) -> Option<f32> {
    let (k, radius_in_spacings) = if dimensions == 2 { (8, 1.596) } else { (20, 1.684) };
    let mut spacings: Vec<f32> = samples
        .iter()
        .filter_map(|&sample| {
            let mut distances: Vec<f32> = near.offsets(sample, reach).map(length).collect();
            let k = k.min(distances.len().saturating_sub(1));
            if k < 3 {
                return None;
            }
            let (_, kth, _) = distances.select_nth_unstable_by(k, f32::total_cmp);
            let scale = (k as f32 / if dimensions == 2 { 8.0 } else { 20.0 }).powf(1.0 / dimensions as f32);
            Some(*kth / (radius_in_spacings * scale)).filter(|spacing| *spacing > 0.0)
        })
        .collect();
    if spacings.len() < samples.len().div_ceil(4) {
        return None;
    }
    spacings.sort_by(f32::total_cmp);
    Some(spacings[spacings.len() / 4])
}

fn refine(
    near: &Neighbourhood,
    samples: &[[f32; 3]],
    start: f32,
    reach: f32,
    dimensions: usize,
    max_offset: f32,
) -> Estimate {
    let mut spacing = start;
    let mut inside = 0;
    for _ in 0..3 {
        let support = (SUPPORT * spacing).min(reach);
        let found: Vec<(f32, bool)> = samples
            .iter()
            .filter_map(|&sample| density(near, sample, support, dimensions, max_offset))
            .collect();
        let mut trusted: Vec<f32> = found.iter().filter(|(_, inside)| *inside).map(|(s, _)| *s).collect();
        inside = trusted.len();
        let quantile = if inside >= MIN_INSIDE {
            0.5
        } else {
            // Hardly any inside: the densest neighbourhoods miss the least.
            trusted = found.iter().map(|(s, _)| *s).collect();
            0.03
        };
        if trusted.is_empty() {
            break;
        }
        trusted.sort_by(f32::total_cmp);
        spacing = trusted[((trusted.len() - 1) as f64 * quantile) as usize];
    }
    let doubt = (inside < MIN_INSIDE)
        .then(|| format!("only {inside} of {} sampled particles lie inside the liquid", samples.len()));
    Estimate { spacing: f64::from(spacing), doubt, unevenness: 0.0 }
}

/// Spacing from the kernel sum at `sample`, and whether its neighbourhood is symmetric; `None` without neighbours.
fn density(
    near: &Neighbourhood,
    sample: [f32; 3],
    support: f32,
    dimensions: usize,
    max_offset: f32,
) -> Option<(f32, bool)> {
    let (mut sum, mut centre, mut count) = (0.0_f32, [0.0_f32; 3], 0);
    for offset in near.offsets(sample, support) {
        let weight = wendland(length(offset) / support);
        sum += weight;
        count += 1;
        for axis in 0..3 {
            centre[axis] += weight * offset[axis];
        }
    }
    if count < 4 {
        return None;
    }
    // Wendland C2 kernel, normalised in the plane and in space (Dehnen & Aly 2012, table 1).
    let (normalised, power) = if dimensions == 2 {
        (sum * 7.0 / (std::f32::consts::PI * support.powi(2)), 0.5)
    } else {
        (sum * 21.0 / (2.0 * std::f32::consts::PI * support.powi(3)), 1.0 / 3.0)
    };
    let full = if dimensions == 2 { 20 } else { 70 };
    let symmetric = length(centre) / (sum * support) < max_offset && count >= full;
    Some((normalised.powf(-power), symmetric))
}

fn wendland(q: f32) -> f32 {
    let rest = (1.0 - q).max(0.0);
    rest.powi(4) * (1.0 + 4.0 * q)
}

fn length(v: [f32; 3]) -> f32 {
    v.iter().map(|c| c * c).sum::<f32>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(points: &[[f32; 3]], flat_axis: Option<usize>) -> Estimate {
        super::estimate(&Subset::all(points), &Subset::all(points), flat_axis)
    }

    /// Numbers in [0, 1), deterministic (Weyl sequence through a mixing step).
    fn noise(seed: &mut u64) -> f32 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 40) as f32 / (1 << 24) as f32
    }

    fn lattice(size: [usize; 3], spacing: f32, jitter: f32) -> Vec<[f32; 3]> {
        let mut seed = 7;
        let mut points = Vec::new();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    points.push([x, y, z].map(|c| (c as f32 + jitter * (noise(&mut seed) - 0.5)) * spacing));
                }
            }
        }
        points
    }

    fn assert_near(found: &Estimate, expected: f64, tolerance: f64, what: &str) {
        let error = (found.spacing / expected - 1.0).abs();
        assert!(error < tolerance, "{what}: {} instead of {expected}: {:.1} %", found.spacing, 100.0 * error);
    }

    #[test]
    fn lattices_of_any_scale() {
        for (spacing, jitter) in [(1.0, 0.0), (0.0036, 0.0), (250.0, 0.3), (0.045, 0.6)] {
            let found = estimate(&lattice([20, 16, 12], spacing, jitter), None);
            // 5 %: the promise of the specification.
            assert_near(&found, f64::from(spacing), 0.05, &format!("jitter {jitter}"));
            assert_eq!(found.doubt, None);
        }
    }

    #[test]
    fn spray_and_a_lost_particle_do_not_matter() {
        let mut points = lattice([20, 20, 10], 0.1, 0.2);
        let mut seed = 3;
        for _ in 0..2000 {
            points.push([noise(&mut seed) * 20.0, noise(&mut seed) * 20.0, 2.0 + noise(&mut seed) * 20.0]);
        }
        points.push([1e5, 0.0, 0.0]);
        assert_near(&estimate(&points, None), 0.1, 0.05, "with a third of spray");
    }

    #[test]
    fn a_hexagonal_packing_keeps_its_volume_per_particle() {
        // Face-centred cubic: four particles in a cube of edge a, hence spacing a / 4^(1/3).
        let mut points = Vec::new();
        for [x, y, z] in lattice([10, 10, 10], 1.0, 0.0) {
            for shift in [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]] {
                points.push([x + shift[0], y + shift[1], z + shift[2]]);
            }
        }
        assert_near(&estimate(&points, None), 0.25_f64.cbrt(), 0.05, "fcc");
    }

    #[test]
    fn flat_data_is_measured_in_its_plane() {
        let points: Vec<[f32; 3]> = lattice([60, 30, 1], 0.02, 0.0);
        assert_near(&estimate(&points, Some(2)), 0.02, 0.05, "flat");
    }

    #[test]
    fn without_neighbours_the_extent_is_shared_out() {
        // Extent over the d-th root of the number of particles, d the dimension of their box.
        for (points, flat_axis, expected) in [
            (vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], Some(2), 3_f64.powf(-0.5)),
            (vec![[0.0; 3], [2.0; 3]], None, 2.0 * 2_f64.powf(-1.0 / 3.0)),
            (vec![[0.0; 3], [7.0, 0.0, 0.0]], None, 3.5),
            (vec![[4e-3; 3]], None, 1.0),
            (vec![], None, 1.0),
        ] {
            let found = estimate(&points, flat_axis);
            assert_near(&found, expected, 1e-6, &format!("{points:?}"));
            assert!(found.doubt.is_some());
        }
    }

    #[test]
    fn a_pile_counts_once() {
        let pile = vec![[0.25; 3]; 1_000_000];
        let found = estimate(&pile, None);
        assert_eq!(found.spacing, 1.0);
        assert_eq!(found.doubt.as_deref(), Some("all 1000000 particles are at the same place"));
        let mut and_one = pile.clone();
        and_one.push([4.25, 0.25, 0.25]);
        assert_near(&estimate(&and_one, None), 2.0, 1e-6, "a pile and a particle");
        // The samples in the pile have no symmetric neighbourhood, those in the block have.
        let mut and_block = pile;
        and_block.extend(lattice([40, 40, 40], 0.1, 0.0));
        assert_near(&estimate(&and_block, None), 0.1, 0.05, "a pile in a block");
    }

    /// Random particles, as some FLIP codes seed them, in a box and in a square.
    #[test]
    fn random_particles_have_their_share_of_the_volume() {
        let mut seed = 5;
        let random: Vec<[f32; 3]> = (0..40_000).map(|_| [0; 3].map(|_| noise(&mut seed))).collect();
        let found = estimate(&random, None);
        assert_near(&found, 40_000_f64.powf(-1.0 / 3.0), 0.02, "random");
        // By definition; of some seventy pairs, a tenth is one deviation.
        assert!((found.unevenness - 1.0).abs() < 0.25, "{found:?}");
        let flat: Vec<[f32; 3]> = random[..4000].iter().map(|&[x, y, _]| [x, 0.5, y]).collect();
        let found = estimate(&flat, Some(1));
        assert_near(&found, 4000_f64.powf(-0.5), 0.05, "random and flat");
        assert!((found.unevenness - 1.0).abs() < 0.25, "{found:?}");
    }

    /// One particle anywhere in each cell of a lattice, and the lattice itself.
    #[test]
    fn order_is_even() {
        for (jitter, unevenness) in [(0.0, 0.0..0.1), (0.3, 0.0..0.2), (1.0, 0.2..0.5)] {
            let found = estimate(&lattice([30, 30, 30], 0.1, jitter), None);
            assert!(unevenness.contains(&found.unevenness), "{jitter}: {found:?}");
        }
    }

    #[test]
    fn few_particles_are_doubted() {
        assert!(estimate(&[], None).doubt.is_some());
        assert!(estimate(&[[1.0; 3]; 5], None).doubt.is_some(), "five times the same point");
        let cube = estimate(&lattice([2, 2, 2], 0.5, 0.0), None);
        assert!(cube.doubt.is_some() && cube.spacing > 0.2 && cube.spacing < 1.2, "{cube:?}");
    }
}
