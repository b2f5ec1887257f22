use meniscus_gpu::role::NO_SURFACE;
use rayon::prelude::*;

use super::MOST_SIGMA_PX;
use crate::filter::HostSurface;
use crate::twin::HostView;

/// Distances or keys, `None` where there is no surface.
pub(super) type Values = Vec<Option<f64>>;

/// What is filtered, and how its pixels lie.
pub(super) struct Source<'a> {
    pub view: &'a HostView,
    pub surface: &'a HostSurface<'a>,
}

/// The surface as it is.
pub fn none(surface: &HostSurface<'_>) -> Vec<f32> {
    distances(surface).map(|d| d.unwrap_or(NO_SURFACE)).collect()
}

/// Whatever is no distance is no surface.
fn distances(surface: &HostSurface<'_>) -> impl Iterator<Item = Option<f32>> {
    surface.distance.iter().map(|&d| (f32::MIN_POSITIVE..1.7e38).contains(&d).then_some(d))
}

impl Source<'_> {
    pub fn distances(&self) -> Values {
        distances(self.surface).map(|d| d.map(f64::from)).collect()
    }

    pub fn keys(&self) -> Values {
        self.distances().into_iter().map(|d| d.map(|d| self.view.key(d))).collect()
    }

    /// The map of distances to keys is its own inverse.
    pub fn distance(&self, key: f64) -> f64 {
        self.view.key(key)
    }

    pub fn radius(&self, pixel: usize) -> f64 {
        self.surface.radius[pixel].into()
    }

    /// Keys per unit of distance at `key`.
    pub fn key_per_distance(&self, key: f64) -> f64 {
        if self.view.is_parallel { 1.0 } else { key * key }
    }

    /// Length in pixels of `spacings` particle spacings; a radius that is no number is none.
    pub fn spacings_px(&self, spacings: f32, pixel: usize, distance: f64) -> f64 {
        let world = f64::from(spacings) * f64::from(self.surface.spacing_per_radius) * self.radius(pixel);
        let px = world * self.view.px_per_world(distance);
        if px > 0.0 && px < 1e30 { px.min(MOST_SIGMA_PX) } else { 0.0 }
    }

    pub fn place(&self, pixel: usize) -> [i64; 2] {
        let width = self.view.size_px[0];
        [(pixel % width) as i64, (pixel / width) as i64]
    }

    /// Pixels from `pixel` to the nearer border along an axis.
    pub fn room(&self, pixel: usize, axis: usize) -> i64 {
        let at = self.place(pixel)[axis];
        at.min(self.view.size_px[axis] as i64 - 1 - at)
    }

    /// The pixel `offset` away, if it and its mirror image lie in the picture.
    pub fn pair(&self, pixel: usize, offset: [i64; 2]) -> Option<[usize; 2]> {
        let fits = |axis: usize| offset[axis].abs() <= self.room(pixel, axis);
        let step = offset[1] * self.view.size_px[0] as i64 + offset[0];
        (fits(0) && fits(1)).then(|| [step, -step].map(|step| (pixel as i64 + step) as usize))
    }

    /// A pass over all pixels with a surface.
    pub fn each(&self, values: &[Option<f64>], pass: impl Fn(usize, f64) -> f64 + Sync) -> Values {
        (0..values.len()).into_par_iter().map(|pixel| values[pixel].map(|value| pass(pixel, value))).collect()
    }

    pub fn image(&self, distances: impl Iterator<Item = Option<f64>>) -> Vec<f32> {
        distances.map(|d| d.map_or(NO_SURFACE, |d| d as f32)).collect()
    }
}
