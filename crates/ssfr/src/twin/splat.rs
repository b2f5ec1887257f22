use glam::{DMat3, DVec2, DVec3, Vec3};
use meniscus_gpu::role::{KeptRange, PackedParticle};

use super::{HostShape, HostView};
use crate::splats::closing;

/// A set of particles on the host.
#[derive(Clone, Copy, Debug)]
pub struct HostSet<'a> {
    /// One page.
    pub particles: &'a [PackedParticle],
    /// Its shapes, as the ranges say.
    pub shapes: &'a [HostShape],
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
    /// Of an ellipsoid: its axes in view space, relative to the radius, a sphere of which `axes * u` is drawn for.
    pub(crate) axes: Option<DMat3>,
}

impl Splat {
    pub(crate) fn distance(&self) -> f64 {
        -self.center_view.z
    }

    /// Distance that nothing of it comes nearer than.
    pub(crate) fn front(&self) -> f64 {
        self.distance() - self.radius * self.axes.map_or(1.0, |axes| axes.row(2).length())
    }

    /// Distances at which the ray enters and leaves the splat, and its length per distance (`algorithms.md` 1.1 with the
    /// perpendicular vector q); for a ray that passes by within `slack`, the point that comes nearest, twice. Of an ellipsoid, in the
    /// space in which it is a sphere (`algorithms.md` 1.3).
    pub(crate) fn chord(&self, (origin, step): (DVec3, DVec3), slack: f64) -> Option<(f64, f64, f64)> {
        let (step, p) = match self.axes.map(|axes| axes.inverse()) {
            Some(to_sphere) => (to_sphere * step, to_sphere * (self.center_view - origin)),
            None => (step, self.center_view - origin),
        };
        let stretch = step.length();
        let v = step / stretch;
        let b = v.dot(p);
        let q = p - b * v;
        let discriminant = self.radius * self.radius - q.length_squared();
        if discriminant < 0.0 && q.length() > self.radius + slack {
            return None;
        }
        let half = discriminant.max(0.0).sqrt();
        Some(((b - half) / stretch, (b + half) / stretch, stretch))
    }

    /// Pixels `[first, end)` that the splat may touch, and the larger half size of its bounding rectangle in pixels: the planes
    /// through the eye that touch it (`algorithms.md` 1.2).
    pub(crate) fn footprint(&self, view: &HostView) -> ([[usize; 2]; 2], f64) {
        let d = self.distance();
        let center = self.center_view.truncate();
        let axes = self.axes.unwrap_or(DMat3::IDENTITY) * self.radius;
        let reach = |n: DVec3| n.dot(axes * axes.transpose() * n);
        let (middle, half) = if view.is_parallel {
            (center, DVec2::new(reach(DVec3::X), reach(DVec3::Y)).map(f64::sqrt))
        } else {
            // With n = (1, 0, x) the plane of the tangent x touches where (n . c)^2 = n . Q n; likewise for y.
            let touching = |axis: DVec3, c: f64| {
                let mixed = axis.dot(axes * axes.transpose() * DVec3::Z);
                let (a, b, e) = (d * d - reach(DVec3::Z), c * d + mixed, c * c - reach(axis));
                (b / a, (b * b - a * e).sqrt() / a)
            };
            let (x, y) = (touching(DVec3::X, center.x), touching(DVec3::Y, center.y));
            (DVec2::new(x.0, y.0), DVec2::new(x.1, y.1))
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

/// The splats that the surface is drawn from: of all sets, those wholly beyond the near distance.
pub(crate) fn splats(view: &HostView, sets: &[HostSet<'_>]) -> Vec<Splat> {
    let mut found = Vec::new();
    for set in sets {
        for range in set.ranges {
            let indices = range.first as usize..(range.first + range.count) as usize;
            let shape = |index: usize| {
                let first = range.shape.checked_sub(1)? as usize;
                Some(&set.shapes[first + index - range.first as usize])
            };
            found.extend(indices.filter_map(|index| splat(view, set, index, range.keep, shape(index))));
        }
    }
    found
}

/// The same with spheres only.
pub(crate) fn spheres(view: &HostView, sets: &[HostSet<'_>]) -> Vec<Splat> {
    let mut found = Vec::new();
    for set in sets {
        for range in set.ranges {
            let indices = range.first as usize..(range.first + range.count) as usize;
            found.extend(indices.filter_map(|index| sphere(view, set, index, range.keep)));
        }
    }
    found
}

/// The sphere of particle `index`, if it is drawn.
pub(crate) fn sphere(view: &HostView, set: &HostSet<'_>, index: usize, keep: u32) -> Option<Splat> {
    splat(view, set, index, keep, None)
}

fn splat(
    view: &HostView,
    set: &HostSet<'_>,
    index: usize,
    keep: u32,
    shape: Option<&HostShape>,
) -> Option<Splat> {
    let particle = &set.particles[index];
    let relative = half::f16::from_bits((particle.packed >> 16) as u16).to_f64();
    let (weight, growth) =
        kept(particle.hash(), keep, closing(set.radius_world, set.volume_world.cbrt()).into());
    let position = shape.map_or(Vec3::from(particle.position_world).as_dvec3(), |shape| shape.center_world);
    let splat = Splat {
        center_view: view.view_from_world.transform_point3(position),
        radius: f64::from(set.radius_world) * relative * growth,
        volume: f64::from(set.volume_world) * relative.powi(3) * weight,
        axes: shape.map(|shape| DMat3::from_mat4(view.view_from_world) * shape.axes),
    };
    (splat.radius > 0.0 && splat.front() >= view.near_world).then_some(splat)
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
