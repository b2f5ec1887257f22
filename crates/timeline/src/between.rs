//! Particles between two frames, matched by id.

use glam::Vec3;
use meniscus_core::{Attribute, Flaw, Flaws, ParticleFrame, ParticleSet, SetFrame, hermite_weights};
use rayon::prelude::*;

/// Particles that are looked at to find out whether velocities fit.
const LOOKED_AT: usize = 4096;
/// Velocities fit a particle when they carry it at least this near to where it is next, as a share of its way ...
const FITS_WAY: f32 = 0.5;
/// ... and in spacings, for what hardly moves.
const FITS_SPACINGS: f32 = 0.1;
/// A particle jumps, through a periodic border say, when it misses where velocities carry it by more than so many of the longer of
/// its two ways ...
const JUMPS_WAYS: f32 = 2.0;
/// ... and so many spacings: particles do not come nearer to each other than about one.
const JUMPS_SPACINGS: f32 = 4.0;
/// From this share on, particles that come and go are worth a word.
const MANY: f64 = 0.01;

/// How far on the way, and how particles move there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<'a> {
    /// How much of the time between the frames has passed, 0..=1.
    pub share: f64,
    /// The time between the frames, in the unit of time of the velocities.
    pub step: f64,
    /// Name of the attribute that holds the velocities, three numbers a particle.
    pub velocity: Option<&'a str>,
    /// Physical distance of neighbouring particles, world.
    pub spacing_world: f32,
}

/// The particles of `before` on their way to `after`: cubic Hermite curves where there are velocities that fit, else straight
/// lines. What is in one frame only, or jumps, moves on by its own velocity and comes or goes halfway. Sets without ids are those
/// of the nearer frame. Attributes change evenly from frame to frame; where they differ in kind there are none.
///
/// Index, time and files are those of the nearer frame; what reading took is left open.
pub fn between(before: &SetFrame, after: &SetFrame, motion: &Motion<'_>) -> SetFrame {
    let mut flaws = before.flaws.clone();
    flaws.merge(&after.flaws);
    let sets = std::iter::zip(&before.sets, &after.sets);
    let sets = sets.map(|(before, after)| set_between(before, after, motion, &mut flaws)).collect();
    let nearer = if motion.share < 0.5 { before } else { after };
    SetFrame {
        index: nearer.index,
        time: nearer.time,
        files: nearer.files.clone(),
        origin: nearer.origin,
        sets,
        flaws,
        read: None,
    }
}

fn set_between(
    before: &ParticleSet,
    after: &ParticleSet,
    motion: &Motion<'_>,
    flaws: &mut Flaws,
) -> ParticleSet {
    let nearer = if motion.share < 0.5 { before } else { after };
    let (from, to) = (&before.particles, &after.particles);
    let have_ids = |frame: &ParticleFrame| !frame.is_empty() && frame.ids.len() == frame.len();
    let particles = if have_ids(from) && have_ids(to) {
        let pairs = Pairs::by_id(&from.ids, &to.ids);
        moved(Ends::new(from, to, &pairs, motion, flaws), &pairs, motion, flaws)
    } else {
        nearer.particles.clone()
    };
    ParticleSet { name: nearer.name.clone(), look: nearer.look, particles }
}

/// Who is who in two frames, by index.
struct Pairs {
    both: Vec<(u32, u32)>,
    only_from: Vec<u32>,
    only_to: Vec<u32>,
}

impl Pairs {
    /// Ids that are there several times are matched in the order of the frames.
    fn by_id(from: &[u64], to: &[u64]) -> Self {
        if from == to {
            let both = (0..from.len() as u32).map(|i| (i, i)).collect();
            return Self { both, only_from: Vec::new(), only_to: Vec::new() };
        }
        let by_id = |ids: &[u64]| {
            let mut order: Vec<u32> = (0..ids.len() as u32).collect();
            order.par_sort_unstable_by_key(|&i| (ids[i as usize], i));
            order
        };
        let (from_order, to_order) = rayon::join(|| by_id(from), || by_id(to));
        let mut pairs = Self { both: Vec::new(), only_from: Vec::new(), only_to: Vec::new() };
        let (mut a, mut b) = (from_order.iter().peekable(), to_order.iter().peekable());
        loop {
            match (a.peek(), b.peek()) {
                (Some(&&i), Some(&&j)) => match from[i as usize].cmp(&to[j as usize]) {
                    std::cmp::Ordering::Less => pairs.only_from.extend(a.next()),
                    std::cmp::Ordering::Greater => pairs.only_to.extend(b.next()),
                    std::cmp::Ordering::Equal => {
                        pairs.both.push((i, j));
                        a.next();
                        b.next();
                    }
                },
                (Some(_), None) => pairs.only_from.extend(a.next()),
                (None, Some(_)) => pairs.only_to.extend(b.next()),
                (None, None) => return pairs,
            }
        }
    }
}

/// Both ends of all ways.
struct Ends<'a> {
    from: &'a ParticleFrame,
    to: &'a ParticleFrame,
    /// Velocities at both ends, where there are some that fit.
    velocities: Option<[&'a [[f32; 3]]; 2]>,
    step: f32,
    spacing_world: f32,
}

impl<'a> Ends<'a> {
    fn new(
        from: &'a ParticleFrame,
        to: &'a ParticleFrame,
        pairs: &Pairs,
        motion: &Motion<'a>,
        flaws: &mut Flaws,
    ) -> Self {
        let velocities = |frame: &'a ParticleFrame| {
            let attribute = frame.attributes.iter().find(|a| Some(a.name.as_str()) == motion.velocity)?;
            let values = attribute.values.as_chunks::<3>().0;
            (attribute.components == 3 && values.len() == frame.len()).then_some(values)
        };
        let velocities = velocities(from).zip(velocities(to)).map(|(a, b)| [a, b]);
        let mut ends =
            Self { from, to, velocities, step: motion.step as f32, spacing_world: motion.spacing_world };
        if ends.velocities.is_some() && !ends.velocities_fit(&pairs.both) {
            ends.velocities = None;
            flaws.add(Flaw::VelocitiesUnused);
        }
        ends
    }

    /// Whether velocities carry most particles to where they are next.
    fn velocities_fit(&self, both: &[(u32, u32)]) -> bool {
        let sample = both.iter().step_by((both.len() / LOOKED_AT).max(1));
        let (mut fit, mut looked_at) = (0, 0);
        for &pair in sample {
            let way = self.way(pair);
            let misses = self.misses(pair, way);
            looked_at += 1;
            // NaN fits nothing.
            if misses <= FITS_WAY * way.length() + FITS_SPACINGS * self.spacing_world {
                fit += 1;
            }
        }
        2 * fit >= looked_at
    }

    fn way(&self, (i, j): (u32, u32)) -> Vec3 {
        Vec3::from(self.to.positions[j as usize]) - Vec3::from(self.from.positions[i as usize])
    }

    /// The ways that the velocities at both ends would take.
    fn slopes(&self, (i, j): (u32, u32)) -> Option<[Vec3; 2]> {
        let [from, to] = self.velocities?;
        Some([Vec3::from(from[i as usize]) * self.step, Vec3::from(to[j as usize]) * self.step])
    }

    /// How far a particle is from where its velocities carry it.
    fn misses(&self, pair: (u32, u32), way: Vec3) -> f32 {
        self.slopes(pair).map_or(0.0, |[a, b]| (way - 0.5 * (a + b)).length())
    }

    fn jumps(&self, pair: (u32, u32)) -> bool {
        let Some([a, b]) = self.slopes(pair) else { return false };
        let misses = self.misses(pair, self.way(pair));
        let longer = a.length().max(b.length());
        // NaN is no way to follow.
        misses.is_nan() || misses > JUMPS_WAYS * longer + JUMPS_SPACINGS * self.spacing_world
    }

    /// Where a pair is at `share` of its way.
    fn along(&self, pair: (u32, u32), share: f64) -> [f32; 3] {
        let start = Vec3::from(self.from.positions[pair.0 as usize]);
        let way = self.way(pair);
        let moved = match self.slopes(pair) {
            // The weights of both ends add up to 1: from the start on, no digits of large coordinates are lost.
            Some([a, b]) => {
                let [_, first, end, second] = hermite_weights(share).map(|weight| weight as f32);
                way * end + a * first + b * second
            }
            None => way * share as f32,
        };
        (start + moved).to_array()
    }

    /// Where particle `i` of the first frame is once it has gone on for `share` by itself.
    fn onwards(&self, i: u32, share: f64) -> [f32; 3] {
        let velocity = self.velocities.map_or(Vec3::ZERO, |[from, _]| finite(from[i as usize]));
        (Vec3::from(self.from.positions[i as usize]) + velocity * self.step * share as f32).to_array()
    }

    /// Where particle `j` of the second frame came from, `share` before it.
    fn backwards(&self, j: u32, share: f64) -> [f32; 3] {
        let velocity = self.velocities.map_or(Vec3::ZERO, |[_, to]| finite(to[j as usize]));
        (Vec3::from(self.to.positions[j as usize]) - velocity * self.step * share as f32).to_array()
    }
}

fn finite(velocity: [f32; 3]) -> Vec3 {
    let velocity = Vec3::from(velocity);
    if velocity.is_finite() { velocity } else { Vec3::ZERO }
}

fn moved(ends: Ends<'_>, pairs: &Pairs, motion: &Motion<'_>, flaws: &mut Flaws) -> ParticleFrame {
    let share = motion.share;
    let is_early = share < 0.5;
    let place = |&(i, j): &(u32, u32)| {
        if !ends.jumps((i, j)) {
            (ends.along((i, j), share), false)
        } else if is_early {
            (ends.onwards(i, share), true)
        } else {
            (ends.backwards(j, 1.0 - share), true)
        }
    };
    let (mut positions, jumps): (Vec<[f32; 3]>, Vec<bool>) = pairs.both.par_iter().map(place).unzip();
    let mut ids: Vec<u64> = pairs.both.par_iter().map(|(i, _)| ends.from.ids[*i as usize]).collect();
    if is_early {
        positions.extend(pairs.only_from.iter().map(|&i| ends.onwards(i, share)));
        ids.extend(pairs.only_from.iter().map(|&i| ends.from.ids[i as usize]));
    } else {
        positions.extend(pairs.only_to.iter().map(|&j| ends.backwards(j, 1.0 - share)));
        ids.extend(pairs.only_to.iter().map(|&j| ends.to.ids[j as usize]));
    }
    let attributes = attributes_between(ends.from, ends.to, pairs, share);
    let sizes = sizes_between(ends.from, ends.to, pairs, share);
    let unmatched =
        pairs.only_from.len() + pairs.only_to.len() + jumps.iter().filter(|jumps| **jumps).count();
    if unmatched as f64 > MANY * positions.len() as f64 {
        flaws.add(Flaw::ParticlesComeAndGo);
    }
    ParticleFrame { positions, ids, attributes, sizes }
}

/// The attributes that both frames have, of the particles in the order of [`moved`].
fn attributes_between(from: &ParticleFrame, to: &ParticleFrame, pairs: &Pairs, share: f64) -> Vec<Attribute> {
    let blend = |from: &Attribute| {
        let is_same = |to: &&Attribute| to.name == from.name && to.components == from.components;
        let to = to.attributes.iter().find(is_same)?;
        let components = from.components;
        let of = |attribute: &Attribute, particle: u32, c: usize| {
            attribute.values[particle as usize * components + c]
        };
        let values = blended(pairs, share, components, |i, c| of(from, i, c), |j, c| of(to, j, c));
        Some(Attribute { name: from.name.clone(), components, values })
    };
    from.attributes.iter().filter_map(blend).collect()
}

/// The sizes of the particles in the order of [`moved`]; empty where neither frame has any.
fn sizes_between(from: &ParticleFrame, to: &ParticleFrame, pairs: &Pairs, share: f64) -> Vec<f32> {
    if from.sizes.is_empty() && to.sizes.is_empty() {
        return Vec::new();
    }
    blended(pairs, share, 1, |i, _| from.size(i as usize), |j, _| to.size(j as usize))
}

/// `components` numbers of each particle in the order of [`moved`], from those of a particle in either frame.
fn blended(
    pairs: &Pairs,
    share: f64,
    components: usize,
    from: impl Fn(u32, usize) -> f32 + Sync,
    to: impl Fn(u32, usize) -> f32 + Sync,
) -> Vec<f32> {
    let (from, to) = (&from, &to);
    let (share, is_early) = (share as f32, share < 0.5);
    let both = pairs
        .both
        .par_iter()
        .flat_map_iter(|&(i, j)| (0..components).map(move |c| from(i, c) * (1.0 - share) + to(j, c) * share));
    let mut values: Vec<f32> = both.collect();
    if is_early {
        values.extend(pairs.only_from.iter().flat_map(|&i| (0..components).map(move |c| from(i, c))));
    } else {
        values.extend(pairs.only_to.iter().flat_map(|&j| (0..components).map(move |c| to(j, c))));
    }
    values
}

#[cfg(test)]
mod tests {
    use meniscus_core::Look;

    use super::*;

    type Path = fn(u64, f64) -> [f64; 3];

    /// Particles `ids` at `time`, each on `path`, with the velocities of the path times `factor`.
    fn frame(ids: &[u64], time: f64, path: Path, factor: Option<f64>) -> SetFrame {
        let at = |id: u64, time: f64| path(id, time).map(|c| c as f32);
        let slope = |id: u64, factor: f64| {
            let (a, b) = (path(id, time - 1e-4), path(id, time + 1e-4));
            [0, 1, 2].map(|i| (factor * (b[i] - a[i]) / 2e-4) as f32)
        };
        let attributes = factor.map(|factor| Attribute {
            name: "v".into(),
            components: 3,
            values: ids.iter().flat_map(|&id| slope(id, factor)).collect(),
        });
        let particles = ParticleFrame {
            positions: ids.iter().map(|&id| at(id, time)).collect(),
            ids: ids.to_vec(),
            attributes: attributes.into_iter().collect(),
            ..Default::default()
        };
        let water = ParticleSet { name: "water".into(), look: Look::Water, particles };
        SetFrame { sets: vec![water], ..Default::default() }
    }

    fn motion(share: f64, step: f64) -> Motion<'static> {
        Motion { share, step, velocity: Some("v"), spacing_world: 0.1 }
    }

    /// The position of `id`.
    fn find(frame: &SetFrame, id: u64) -> Option<Vec3> {
        let particles = &frame.sets[0].particles;
        let index = particles.ids.iter().position(|other| *other == id)?;
        Some(particles.positions[index].into())
    }

    /// Ballistic, with a cubic sideways, different for every particle.
    fn flight(id: u64, t: f64) -> [f64; 3] {
        let id = id as f64;
        [id + t * t * t, 2.0 * t - 4.9 * t * t, 0.5 * id * t]
    }

    #[test]
    fn with_velocities_cubic_ways_are_exact_in_any_order_of_the_file() {
        let before = frame(&[5, 1, 9], 0.5, flight, Some(1.0));
        let after = frame(&[9, 5, 1], 0.75, flight, Some(1.0));
        for share in [0.0, 0.2, 0.5, 0.8] {
            let middle = between(&before, &after, &motion(share, 0.25));
            assert!(middle.flaws.is_empty(), "{:?}", middle.flaws);
            for id in [1, 5, 9] {
                let expected = Vec3::from(flight(id, 0.5 + share * 0.25).map(|c| c as f32));
                // 1e-4: f32 velocities by differences over 2e-4.
                assert!(find(&middle, id).unwrap().distance(expected) < 1e-4, "{id} at {share}");
            }
        }
    }

    #[test]
    fn without_velocities_ways_are_straight() {
        let before = frame(&[1, 2], 0.0, flight, None);
        let after = frame(&[1, 2], 1.0, flight, None);
        let middle = between(&before, &after, &motion(0.25, 1.0));
        let (a, b) = (flight(2, 0.0), flight(2, 1.0));
        let expected = Vec3::from([0, 1, 2].map(|i| (0.75 * a[i] + 0.25 * b[i]) as f32));
        assert!(find(&middle, 2).unwrap().distance(expected) < 1e-6);
        assert!(middle.flaws.is_empty());
    }

    #[test]
    fn velocities_in_another_unit_of_time_are_found_out() {
        // Times in milliseconds, velocities per second.
        let before = frame(&[1, 2, 3], 0.5, flight, Some(1000.0));
        let after = frame(&[1, 2, 3], 0.75, flight, Some(1000.0));
        let middle = between(&before, &after, &motion(0.5, 0.25));
        assert_eq!(middle.flaws.iter().collect::<Vec<_>>(), [&Flaw::VelocitiesUnused]);
        let (a, b) = (flight(3, 0.5), flight(3, 0.75));
        let expected = Vec3::from([0, 1, 2].map(|i| (0.5 * (a[i] + b[i])) as f32));
        assert!(find(&middle, 3).unwrap().distance(expected) < 1e-5);
    }

    #[test]
    fn what_is_in_one_frame_only_moves_on_and_comes_or_goes_halfway() {
        let before = frame(&[1, 2, 3], 0.5, flight, Some(1.0));
        let after = frame(&[1, 3, 4], 0.75, flight, Some(1.0));
        let early = between(&before, &after, &motion(0.25, 0.25));
        let late = between(&before, &after, &motion(0.75, 0.25));
        let ids = |frame: &SetFrame| {
            let mut ids = frame.sets[0].particles.ids.clone();
            ids.sort_unstable();
            ids
        };
        assert_eq!((ids(&early), ids(&late)), (vec![1, 2, 3], vec![1, 3, 4]));
        for (frame, id, time) in [(&early, 2, 0.5625), (&late, 4, 0.6875)] {
            let expected = Vec3::from(flight(id, time).map(|c| c as f32));
            // Half the acceleration, 5, times the square of a sixteenth.
            assert!(find(frame, id).unwrap().distance(expected) < 0.03, "{id}");
        }
        assert!(early.flaws.iter().any(|flaw| *flaw == Flaw::ParticlesComeAndGo));
    }

    #[test]
    fn who_leaves_through_a_periodic_border_does_not_fly_through_the_domain() {
        fn flow(id: u64, t: f64) -> [f64; 3] {
            [(id as f64 + 10.0 * t).rem_euclid(100.0), 0.0, 0.0]
        }
        let ids: Vec<u64> = (0..100).collect();
        let mut before = frame(&ids, 0.0, flow, Some(1.0));
        let mut after = frame(&ids, 0.5, flow, Some(1.0));
        for frame in [&mut before, &mut after] {
            // Differences over the border itself are no velocities.
            frame.sets[0].particles.attributes[0].values.chunks_mut(3).for_each(|v| v[0] = 10.0);
        }
        for share in [0.3, 0.7] {
            let middle = between(&before, &after, &motion(share, 0.5));
            for id in [10, 97] {
                let expected = (id as f64 + 5.0 * share) as f32;
                let x = find(&middle, id).unwrap().x;
                assert!((x - expected).abs() < 1e-3 || (x - expected + 100.0).abs() < 1e-3, "{id}: {x}");
            }
        }
    }

    #[test]
    fn sizes_go_with_their_particles() {
        let mut before = frame(&[1, 2, 3], 0.0, flight, None);
        let mut after = frame(&[4, 3, 1], 1.0, flight, None);
        let sizes = |share| between(&before, &after, &motion(share, 1.0)).sets[0].particles.sizes.clone();
        assert!(sizes(0.25).is_empty());
        before.sets[0].particles.sizes = vec![1.0, 2.0, 3.0];
        after.sets[0].particles.sizes = vec![0.5, 3.0, 2.0];
        let of = |share| {
            let middle = between(&before, &after, &motion(share, 1.0)).sets.remove(0).particles;
            let mut of: Vec<(u64, f32)> = middle.ids.into_iter().zip(middle.sizes).collect();
            of.sort_by_key(|(id, _)| *id);
            of
        };
        assert_eq!(of(0.25), [(1, 1.25), (2, 2.0), (3, 3.0)]);
        assert_eq!(of(0.75), [(1, 1.75), (3, 3.0), (4, 0.5)]);
    }

    #[test]
    fn sets_without_ids_are_those_of_the_nearer_frame() {
        let mut before = frame(&[1, 2], 0.0, flight, None);
        let after = frame(&[1, 2, 3], 1.0, flight, None);
        before.sets[0].particles.ids.clear();
        let count = |share| between(&before, &after, &motion(share, 1.0)).sets[0].particles.len();
        assert_eq!((count(0.4), count(0.6)), (2, 3));
    }

    #[test]
    fn attributes_change_evenly_by_id_and_stay_with_who_is_in_one_frame_only() {
        fn rest(_: u64, t: f64) -> [f64; 3] {
            [t, 0.0, 0.0]
        }
        let before = frame(&[1, 2, 3], 2.0, rest, None);
        let after = frame(&[4, 3, 1], 6.0, rest, None);
        let with = |mut frame: SetFrame, values: &[f32]| {
            let attribute = Attribute { name: "p".into(), components: 2, values: values.to_vec() };
            frame.sets[0].particles.attributes = vec![attribute];
            frame
        };
        let before = with(before, &[1.0, 10.0, 2.0, 20.0, 3.0, 30.0]);
        let after = with(after, &[8.0, 80.0, 7.0, 70.0, 5.0, 50.0]);
        let of = |share: f64| {
            let particles = between(&before, &after, &motion(share, 4.0)).sets[0].particles.clone();
            let values = particles.attributes[0].values.chunks(2).map(<[f32]>::to_vec);
            let mut pairs: Vec<(u64, Vec<f32>)> = std::iter::zip(particles.ids, values).collect();
            pairs.sort_by_key(|(id, _)| *id);
            pairs
        };
        let expected = [(1, vec![2.0, 20.0]), (2, vec![2.0, 20.0]), (3, vec![4.0, 40.0])];
        assert_eq!(of(0.25), expected);
        let expected = [(1, vec![4.0, 40.0]), (3, vec![6.0, 60.0]), (4, vec![8.0, 80.0])];
        assert_eq!(of(0.75), expected);
    }

    #[test]
    fn broken_velocities_move_nobody() {
        let mut before = frame(&(0..50).collect::<Vec<_>>(), 0.0, flight, Some(1.0));
        let after = frame(&(0..50).collect::<Vec<_>>(), 0.1, flight, Some(1.0));
        before.sets[0].particles.attributes[0].values[..3].fill(f32::NAN);
        let middle = between(&before, &after, &motion(0.3, 0.1));
        assert!(middle.sets[0].particles.positions.iter().flatten().all(|c| c.is_finite()));
        assert_eq!(find(&middle, 0), Some(Vec3::ZERO));
    }
}
