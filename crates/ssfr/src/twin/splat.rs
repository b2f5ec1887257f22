use glam::{DVec2, DVec3, Vec3};
use meniscus_gpu::role::{KeptRange, PackedParticle};

use super::HostView;
use crate::splats::closing;

/// A set of particles on the host.
#[derive(Clone, Copy, Debug)]
pub struct HostSet<'a> {
    /// One page.
    pub particles: &'a [PackedParticle],
    /// What of it is drawn.
    pub ranges: &'a [KeptRange],
    /// Radius drawn, world units.
    pub radius_world: f32,
    /// Volume per particle, world units cubed.
    pub volume_world: f32,
}

/// A particle ready to be drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat {
    pub(crate) center_view: DVec3,
    pub(crate) radius: f64,
    pub(crate) volume: f64,
}

impl Splat {
    pub(crate) fn distance(&self) -> f64 {
        -self.center_view.z
    }

    /// Distances at which the ray enters and leaves the sphere, and its length per distance (`algorithms.md` 1.1 with the
    /// perpendicular vector q); for a ray that passes by within `slack`, the point that comes nearest, twice.
    pub(crate) fn chord(&self, (origin, step): (DVec3, DVec3), slack: f64) -> Option<(f64, f64, f64)> {
        let stretch = step.length();
        let v = step / stretch;
        let p = self.center_view - origin;
        let b = v.dot(p);
        let q = p - b * v;
        let discriminant = self.radius * self.radius - q.length_squared();
        if discriminant < 0.0 && q.length() > self.radius + slack {
            return None;
        }
        let half = discriminant.max(0.0).sqrt();
        Some(((b - half) / stretch, (b + half) / stretch, stretch))
    }

    /// Pixels `[first, end)` that the sphere may touch, and the larger half size of its bounding rectangle in pixels:
    /// the tangents from the eye in the xz and yz planes (`algorithms.md` 1.2 for a sphere).
    pub(crate) fn footprint(&self, view: &HostView) -> ([[usize; 2]; 2], f64) {
        let d = self.distance();
        let (middle, half) = if view.is_parallel {
            (self.center_view.truncate(), DVec2::splat(self.radius))
        } else {
            let a = d * d - self.radius * self.radius;
            let c = self.center_view.truncate();
            let root = DVec2::new((c.x * c.x + a).sqrt(), (c.y * c.y + a).sqrt());
            (c * d / a, root * self.radius / a)
        };
        let size = DVec2::new(view.size_px[0] as f64, view.size_px[1] as f64);
        let to_px = size / (2.0 * view.half_extent);
        let middle_px = size * 0.5 + middle * to_px * DVec2::new(1.0, -1.0);
        let half_px = half * to_px;
        let range = |axis: usize| {
            let low = (middle_px[axis] - half_px[axis] - 1.0).floor().clamp(0.0, size[axis]);
            let high = (middle_px[axis] + half_px[axis] + 1.0).ceil().clamp(0.0, size[axis]);
            [low as usize, high as usize]
        };
        ([range(0), range(1)], half_px.max_element())
    }
}

/// The splats of all sets that are drawn: those wholly beyond the near distance.
pub(crate) fn splats(view: &HostView, sets: &[HostSet<'_>]) -> Vec<Splat> {
    let mut found = Vec::new();
    for set in sets {
        for range in set.ranges {
            let indices = range.first as usize..(range.first + range.count) as usize;
            found.extend(indices.filter_map(|index| particle_splat(view, set, index, range.keep)));
        }
    }
    found
}

/// The splat of particle `index`, if it is drawn.
pub(crate) fn particle_splat(view: &HostView, set: &HostSet<'_>, index: usize, keep: u32) -> Option<Splat> {
    let particle = &set.particles[index];
    let relative = half::f16::from_bits((particle.packed >> 16) as u16).to_f64();
    let (weight, growth) =
        kept(particle.hash(), keep, closing(set.radius_world, set.volume_world.cbrt()).into());
    let position = Vec3::from(particle.position_world).as_dvec3();
    let splat = Splat {
        center_view: view.view_from_world.transform_point3(position),
        radius: f64::from(set.radius_world) * relative * growth,
        volume: f64::from(set.volume_world) * relative.powi(3) * weight,
    };
    (splat.radius > 0.0 && splat.distance() - splat.radius >= view.near_world).then_some(splat)
}

/// Weight and growth of a particle kept with probability `keep / 65536` (`main-renderer.md` 3.3;
/// `shaders/common/particle.inc.wgsl`).
fn kept(hash: u16, keep: u32, closing: f64) -> (f64, f64) {
    if keep >= KeptRange::KEEP_ALL {
        return (1.0, 1.0);
    }
    let p = f64::from(keep) / 65536.0;
    let u = (f64::from(hash) + 0.5) / 65536.0;
    let ramp = (0.2 * p).min(1.0 - p);
    let fade = ((p - u) / ramp).clamp(0.0, 1.0);
    let mean_fade = 1.0 - 0.5 * ramp / p;
    let share = ((0.75 - p) / (0.75 - 0.4)).clamp(0.0, 1.0);
    let growth = 1.0 + ((closing * p.powf(-1.0 / 3.0)).clamp(1.0, 2.0) - 1.0) * share;
    (fade / (mean_fade * p), growth * fade.cbrt())
}
