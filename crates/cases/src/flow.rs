use glam::DVec3;
use meniscus_core::Cancel;
use rayon::prelude::*;

use crate::CaseFrame;
use crate::flight::{Flight, GRAVITY};
use crate::golden::Dice;

/// Largest displacement from the lattice along each axis, spacings.
pub(crate) const JITTER: f64 = 0.1;

/// Rest density of water, kg/m^3.
const REST_DENSITY: f64 = 1000.0;

/// Particles per parallel task: long enough to pay for the task, short enough to cancel soon.
const TASK: usize = 1 << 15;

/// Where a particle is when nothing throws it out of the fluid.
pub(crate) struct Placed {
    /// File space, m.
    pub position: DVec3,
    /// Below the free surface, m.
    pub depth: f64,
}

/// A motion that preserves volume and carries strands - columns or sheets - of particles.
pub(crate) trait Flow: Sync {
    /// What the particles of one strand share at one time.
    type Strand;

    /// The first particle of each strand, and the particle number at the end.
    fn starts(&self) -> &[u64];

    /// Number `strand` at `time` (s).
    fn strand_at(&self, strand: usize, time: f64) -> Self::Strand;

    /// Particle `rank` of the `count` in `strand`.
    fn place(&self, strand: &Self::Strand, rank: u64, count: u64) -> Placed;

    /// Whether and how particle `rank` of the `count` in `strand` is thrown out of the fluid.
    fn flight(&self, strand: usize, rank: u64, count: u64, dice: &mut Dice) -> Option<Flight>;
}

/// What [`fill`] needs besides the motion.
pub(crate) struct FillOptions<'a> {
    pub seed: u64,
    /// Physical distance of neighbours, m.
    pub spacing: f64,
    /// Simulation time, s.
    pub time: f64,
    /// Half the interval of the central difference that gives the velocity, s.
    pub time_step: f64,
    /// Stops the work; the frame is then incomplete.
    pub cancel: &'a Cancel,
}

/// All particles of `flow` at one time.
pub(crate) fn fill<F: Flow>(flow: &F, options: &FillOptions<'_>) -> CaseFrame {
    let count = flow.starts().last().copied().unwrap_or(0) as usize;
    let mut frame = CaseFrame {
        positions: vec![[0.0; 3]; count],
        velocities: vec![[0.0; 3]; count],
        density: vec![0.0; count],
        pressure: vec![0.0; count],
        ids: (0..count as i64).collect(),
        time: options.time,
        spacing: options.spacing,
    };
    let tasks = frame
        .positions
        .par_chunks_mut(TASK)
        .zip(frame.velocities.par_chunks_mut(TASK))
        .zip(frame.density.par_chunks_mut(TASK).zip(frame.pressure.par_chunks_mut(TASK)));
    tasks.enumerate().for_each(|(task, ((positions, velocities), (density, pressure)))| {
        if options.cancel.is_cancelled() {
            return;
        }
        let mut strands = Strands::new(flow, (task * TASK) as u64, options);
        for i in 0..positions.len() {
            let particle = strands.next_particle();
            positions[i] = particle.position.to_array();
            velocities[i] = particle.velocity.as_vec3().to_array();
            density[i] = particle.density as f32;
            pressure[i] = particle.pressure as f32;
        }
    });
    frame
}

struct Particle {
    position: DVec3,
    velocity: DVec3,
    density: f64,
    pressure: f64,
}

/// Walks through the particles in order and keeps the current strand at the three times of the central difference.
struct Strands<'a, F: Flow> {
    flow: &'a F,
    options: &'a FillOptions<'a>,
    strand: usize,
    at: [F::Strand; 3],
    next: u64,
}

impl<'a, F: Flow> Strands<'a, F> {
    fn new(flow: &'a F, first: u64, options: &'a FillOptions<'a>) -> Self {
        let strand = flow.starts().partition_point(|&start| start <= first) - 1;
        Self { flow, options, strand, at: Self::at_three_times(flow, strand, options), next: first }
    }

    fn at_three_times(flow: &F, strand: usize, options: &FillOptions<'_>) -> [F::Strand; 3] {
        Self::times(options).map(|time| flow.strand_at(strand, time))
    }

    fn times(options: &FillOptions<'_>) -> [f64; 3] {
        [options.time, options.time - options.time_step, options.time + options.time_step]
    }

    fn next_particle(&mut self) -> Particle {
        let starts = self.flow.starts();
        if starts[self.strand + 1] <= self.next {
            while starts[self.strand + 1] <= self.next {
                self.strand += 1;
            }
            self.at = Self::at_three_times(self.flow, self.strand, self.options);
        }
        let (rank, count) = (self.next - starts[self.strand], starts[self.strand + 1] - starts[self.strand]);
        let mut dice = Dice::new(self.options.seed, self.next);
        self.next += 1;

        let jitter = DVec3::from_array(std::array::from_fn(|_| dice.between(-JITTER, JITTER)));
        let flight = self.flow.flight(self.strand, rank, count, &mut dice);
        let offset = |time| flight.and_then(|flight| flight.offset(time));
        let placed = self.at.each_ref().map(|strand| self.flow.place(strand, rank, count));
        let airborne = offset(self.options.time);
        let [now, before, after] = std::array::from_fn(|i| {
            placed[i].position + offset(Self::times(self.options)[i]).unwrap_or(DVec3::ZERO)
        });
        let (density, pressure) = match airborne {
            Some(_) => (REST_DENSITY / 3.0, 0.0),
            None => weight_of(placed[0].depth, self.options.spacing),
        };
        Particle {
            position: now + jitter * self.options.spacing,
            velocity: (after - before) / (2.0 * self.options.time_step),
            density,
            pressure,
        }
    }
}

/// Density (kg/m^3) and pressure (Pa) at `depth` below the free surface. The density is that of an SPH sum, which misses
/// the neighbours above the surface within a kernel of two spacings; the pressure is hydrostatic.
fn weight_of(depth: f64, spacing: f64) -> (f64, f64) {
    let filled = 0.5 + 0.5 * (depth / (2.0 * spacing)).clamp(0.0, 1.0);
    (REST_DENSITY * filled, REST_DENSITY * GRAVITY * depth.max(0.0))
}

/// Smooth step from 0 at `x <= 0` to 1 at `x >= 1`.
pub(crate) fn ramp(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
