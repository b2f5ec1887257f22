//! How foamy a particle is: by its company, which says what is spray, and by how fast its neighbours run into it, which says where
//! air is trapped (Ihmsen et al., Unified spray, foam and air bubbles for particle-based fluids, 2012).

use glam::{IVec3, Vec3};
use meniscus_core::ParticleFrame;
use rayon::prelude::*;

use super::FoamOptions;
use super::air::Air;
use super::neighbours::{Candidates, Neighbours};
use crate::grid::CellOrder;

/// How far neighbours count, in spacings: four radii, the support of Ihmsen et al. The bulk has 32 there.
const REACH_SPACINGS: f32 = 2.0;
/// Company of up to 4, a thread of single particles, is spray; with 8, what a sheet of single particles has, it is none any more.
/// Between lie the 6 of Ihmsen et al.
const SPRAY: [f32; 2] = [8.0, 4.0];
/// From this many particles on, three quarters of the bulk's, a cell holds no spray.
const NO_SPRAY_FROM: usize = 12;
/// Mean of the directions away from the neighbours at which there begins to be air beside a particle, and at which there is for
/// sure: at a flat surface it is 0.35, a spacing below it 0.1, and in the bulk of a disordered liquid hardly more than that.
const BESIDE_AIR: [f32; 2] = [0.2, 0.35];
/// Cells that one job goes through.
const CELLS_PER_JOB: usize = 64;

/// What of a particle is foam, each 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Foaminess {
    /// It flies on its own or in small company.
    pub spray: f32,
    /// Air is trapped where it is.
    pub trapped: f32,
}

impl Foaminess {
    /// How foamy it is, 0 to 1.
    pub fn total(self) -> f32 {
        self.spray.max(self.trapped)
    }
}

/// Foaminess of every particle along the curve. O(n), the same whatever the number of threads.
pub(super) fn of(
    order: &CellOrder,
    frame: &ParticleFrame,
    spacing_world: f32,
    options: &FoamOptions,
) -> Vec<Foaminess> {
    if !(spacing_world > 0.0 && spacing_world.is_finite()) {
        return vec![Foaminess::default(); frame.len()];
    }
    let velocity = frame.attributes.iter().find(|a| Some(&a.name) == options.velocity.as_ref());
    let is_speed = options.speed > 0.0 && options.speed.is_finite();
    let usable = velocity.filter(|a| is_speed && a.components == 3 && a.values.len() == 3 * frame.len());
    let neighbours = Neighbours::new(order, frame, usable.map(|a| a.values.as_slice()));
    let walls = [options.walls.min, options.walls.max].map(|corner| order.grid().cell_of(corner).as_ivec3());
    let air = usable.map(|_| Air::new(neighbours.cells(), options.up.index(), walls));
    let finder = Finder { neighbours, air, reach_world: REACH_SPACINGS * spacing_world, options };
    let measured: Vec<Measured> =
        finder.over_cells(|cell, candidates, found| finder.measure(cell, candidates, found));
    finder.over_cells(|cell, candidates, found| finder.judge(cell, &measured, candidates, found))
}

/// What is around a particle.
#[derive(Clone, Copy)]
struct Measured {
    /// Number of neighbours.
    count: u8,
    /// How sure it is that there is air beside it, 0 to 1.
    air: f32,
    /// How much air is trapped where there is some, 0 to 1.
    trapped: f32,
}

impl Measured {
    /// In the midst of others.
    const CROWDED: Self = Self { count: u8::MAX, air: 0.0, trapped: 0.0 };

    fn may_be_foam(&self) -> bool {
        f32::from(self.count) < SPRAY[0] || self.trapped > 0.0
    }
}

struct Finder<'a> {
    neighbours: Neighbours,
    /// `None` where velocities do not count.
    air: Option<Air>,
    reach_world: f32,
    options: &'a FoamOptions,
}

impl Finder<'_> {
    /// What `of_cell` appends for each particle of each cell, in the order of the particles.
    fn over_cells<T: Send>(&self, of_cell: impl Fn(usize, &mut Candidates, &mut Vec<T>) + Sync) -> Vec<T> {
        let cells = self.neighbours.cells().len();
        let of_jobs: Vec<Vec<T>> = (0..cells.div_ceil(CELLS_PER_JOB))
            .into_par_iter()
            .map_init(Candidates::default, |candidates, job| {
                let mut found = Vec::new();
                let first = job * CELLS_PER_JOB;
                let last = (first + CELLS_PER_JOB).min(cells);
                (first..last).for_each(|cell| of_cell(cell, candidates, &mut found));
                found
            })
            .collect();
        of_jobs.into_iter().flatten().collect()
    }

    /// What is around the particles of a cell. Most are in the midst of others and away from air, and not looked at.
    fn measure(&self, cell: usize, candidates: &mut Candidates, found: &mut Vec<Measured>) {
        let slots = self.neighbours.slots_of(cell);
        let is_near_air = self.is_near_air(cell);
        if slots.len() >= NO_SPRAY_FROM && !is_near_air {
            found.extend(slots.map(|_| Measured::CROWDED));
            return;
        }
        self.neighbours.around(cell, candidates);
        found.extend(slots.map(|slot| self.around(slot, is_near_air, candidates)));
    }

    /// Whether there is air in a cell or in one around it.
    fn is_near_air(&self, cell: usize) -> bool {
        let Some(air) = &self.air else { return false };
        let at = self.neighbours.place_of(cell);
        (0..27).any(|k| air.is_in(at + IVec3::new(k % 3, k / 3 % 3, k / 9) - 1))
    }

    /// Number of neighbours, and the air that they trap: the potential `sum |v_ij| (1 - v_ij.x_ij) W` (Ihmsen et al. eq. 2) as a
    /// mean, over `sum W`, so that it is a speed and depends neither on the spacing nor on how many neighbours there are. `W` is
    /// their `1 - |x_ij| / h`. Neighbours whose velocity is no number do not count in it.
    fn around(&self, slot: usize, is_near_air: bool, candidates: &mut Candidates) -> Measured {
        let Self { neighbours, reach_world, options, .. } = self;
        let position = neighbours.position(slot);
        let mut count = 0u8;
        if !is_near_air {
            candidates.near(slot, position, *reach_world, |_, _| count = count.saturating_add(1));
            return Measured { count, air: 0.0, trapped: 0.0 };
        }
        let velocity = neighbours.velocity(slot);
        let (mut closing, mut moving) = (0.0, 0.0);
        let (mut away, mut weights) = (Vec3::ZERO, 0.0);
        candidates.near(slot, position, *reach_world, |other, square| {
            count = count.saturating_add(1);
            let distance = square.sqrt();
            let weight = 1.0 - distance / reach_world;
            let v = velocity - neighbours.velocity(other);
            // No direction in the same place.
            let x = (position - neighbours.position(other)) / distance.max(f32::MIN_POSITIVE);
            let speed = v.length() - v.dot(x);
            if speed.is_finite() {
                closing += weight * speed;
                moving += weight;
            }
            away += weight * x;
            weights += weight;
        });
        let share = |value: f32, [begin, all]: [f32; 2]| {
            let share = (value - begin) / (all - begin);
            // A comparison that what is no number fails.
            if share > 0.0 { share.min(1.0) } else { 0.0 }
        };
        Measured {
            count,
            air: share(away.length() / weights, BESIDE_AIR),
            trapped: share(closing / moving / options.speed, options.closing),
        }
    }

    /// What of the particles of a cell is foam, once it is known what is around all of them.
    fn judge(
        &self,
        cell: usize,
        measured: &[Measured],
        candidates: &mut Candidates,
        found: &mut Vec<Foaminess>,
    ) {
        let slots = self.neighbours.slots_of(cell);
        let mut is_gathered = false;
        found.extend(slots.map(|slot| {
            let Measured { mut count, mut air, trapped } = measured[slot];
            if !measured[slot].may_be_foam() {
                return Foaminess::default();
            }
            if !std::mem::replace(&mut is_gathered, true) {
                self.neighbours.around(cell, candidates);
            }
            // At a corner of calm water there are few neighbours as well, but theirs lie in the bulk. Air is taken under as far as
            // neighbours count.
            candidates.near(slot, self.neighbours.position(slot), self.reach_world, |other, _| {
                count = count.max(measured[other].count);
                air = air.max(measured[other].air);
            });
            let spray = (SPRAY[0] - f32::from(count)) / (SPRAY[0] - SPRAY[1]);
            Foaminess { spray: spray.clamp(0.0, 1.0), trapped: trapped * air }
        }));
    }
}
