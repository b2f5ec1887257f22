//! What is known beforehand about shapes of particles; lengths in supports, variances in their squares.

use bytemuck::{Pod, Zeroable};
use glam::{UVec3, Vec3};
use meniscus_core::Aabb;
use meniscus_gpu::{HostField, HostStruct};

use crate::{Anisotropy, AnisotropyParams};

/// Up to so many neighbours a particle is a sphere, from so many on an ellipsoid in full (\[Z\] 2.2).
pub(crate) const NO_NEIGHBOURS: f64 = 8.0;
pub(crate) const FULL_NEIGHBOURS: f64 = 30.0;
/// From so many neighbours on it is moved to their middle in full: as many as a particle in the corner of a block has, which would
/// stick out as a knob.
pub(crate) const MOVED_NEIGHBOURS: f64 = 14.0;
/// Below this variance, a seventh of that in the bulk, neighbours are so close together that the shape goes back to a sphere.
pub(crate) const LEAST_VARIANCE: f64 = 0.02;
/// Part of what a particle in a flat surface lost in height that it is moved outward by: with this, the mean height of a flat surface is
/// half a spacing above its particles, where the fluid ends.
pub(crate) const LIFT: f64 = 0.7;

/// How far from the mean of its neighbourhood a particle is that lies half a spacing below a flat surface, of a continuum with a
/// support of `support_spacings` (`algorithms.md` 9.1; the integrals of w = 1 - t^3 over a ball that the surface cuts).
pub(crate) fn surface_shift(support_spacings: f64) -> f64 {
    let h = 0.5 / support_spacings;
    let below = |h: f64| 0.3 * h - h.powi(3) / 6.0 + h.powi(6) / 30.0;
    let moment = |h: f64| 0.15 * h.powi(2) - h.powi(4) / 8.0 + h.powi(7) / 35.0;
    (moment(1.0) - moment(h)) / (below(1.0) + below(h))
}

/// `meniscus::shape::ShapeRule` of `shaders/ssfr/shape.inc.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ShapeUniform {
    origin_world: [f32; 3],
    support_world: f32,
    last_cell: [u32; 3],
    form: u32,
    most_shift: f32,
    surface_shift: f32,
    strength: f32,
    ratio: f32,
    smoothing: f32,
    axis_scale: f32,
    longest_axis: f32,
    no_neighbours: f32,
    full_neighbours: f32,
    moved_neighbours: f32,
    least_variance: f32,
    lift: f32,
}

impl HostStruct for ShapeUniform {
    const WGSL_NAME: &'static str = "ShapeRule";
    const FIELDS: &'static [HostField] = meniscus_gpu::host_fields!(ShapeUniform {
        origin_world,
        support_world,
        last_cell,
        form,
        most_shift,
        surface_shift,
        strength,
        ratio,
        smoothing,
        axis_scale,
        longest_axis,
        no_neighbours,
        full_neighbours,
        moved_neighbours,
        least_variance,
        lift,
    });
}

/// Most cells of a grid: 24 MB of them.
const MOST_CELLS: u32 = 1 << 21;

impl ShapeUniform {
    /// For particles in `bounds` that are drawn with `radius_world` and `spacing_world` apart.
    pub(crate) fn new(
        params: &AnisotropyParams,
        bounds: &Aabb,
        radius_world: f32,
        spacing_world: f32,
    ) -> Self {
        let support_world = params.support * spacing_world;
        Self {
            origin_world: bounds.min.to_array(),
            support_world,
            last_cell: (cells_of(bounds, support_world) - 1).to_array(),
            form: u32::from(params.form() == Anisotropy::Zju),
            most_shift: AnisotropyParams::MAX_SHIFT_SPACINGS / params.support,
            surface_shift: surface_shift(params.support.into()) as f32,
            strength: params.strength,
            ratio: params.ratio,
            smoothing: params.smoothing,
            axis_scale: params.zju_scale * support_world / radius_world,
            longest_axis: AnisotropyParams::MAX_ZJU_AXIS,
            no_neighbours: NO_NEIGHBOURS as f32,
            full_neighbours: FULL_NEIGHBOURS as f32,
            moved_neighbours: MOVED_NEIGHBOURS as f32,
            least_variance: LEAST_VARIANCE as f32,
            lift: LIFT as f32 * radius_world / support_world,
        }
    }

    /// Number of cells of the grid.
    pub(crate) fn cells(&self) -> u32 {
        self.last_cell.iter().map(|last| last + 1).product()
    }
}

/// Cells per axis: powers of two that hold `bounds`, or fewer where that were too many. At least four, so that a cell and those
/// around it are all different.
fn cells_of(bounds: &Aabb, support_world: f32) -> UVec3 {
    let wanted = (bounds.extent() / support_world).max(Vec3::ZERO).min(Vec3::splat(0.5 * MOST_CELLS as f32));
    let mut cells = (wanted.as_uvec3() + 1).max(UVec3::splat(4)).map(u32::next_power_of_two);
    while cells.as_u64vec3().element_product() > u64::from(MOST_CELLS) {
        let longest = cells.to_array().iter().position(|&n| n == cells.max_element()).unwrap_or(0);
        cells[longest] /= 2;
    }
    cells
}

#[cfg(test)]
mod tests {
    use meniscus_gpu::shader;

    use super::*;
    use crate::passes::INCLUDES;

    #[test]
    fn the_rule_has_the_layout_of_its_shader() {
        ShapeUniform::check_layout(&shader!("ssfr/shape"), INCLUDES).unwrap();
    }

    /// `algorithms.md` 9.1: 0.32 for a particle at the surface; the bulk has none.
    #[test]
    fn a_flat_surface_shifts_the_mean_by_a_third_of_the_support() {
        assert!((surface_shift(f64::INFINITY) - 0.3214).abs() < 1e-4);
        assert!(surface_shift(0.5).abs() < 1e-12);
        assert!((surface_shift(2.0) - 0.187).abs() < 1e-3);
    }

    #[test]
    fn grids_have_powers_of_two_of_cells_within_bounds() {
        let of = |extent: [f32; 3]| {
            cells_of(&Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(-1.0) + Vec3::from(extent) }, 0.5)
        };
        assert_eq!(of([0.0; 3]), UVec3::splat(4));
        assert_eq!(of([8.0, 7.9, 40.0]), UVec3::new(32, 16, 128));
        let huge = of([1e30, 1e9, f32::MAX]);
        assert!(huge.element_product() <= MOST_CELLS && huge.min_element() >= 4, "{huge}");
        assert_eq!(cells_of(&Aabb::EMPTY, 0.5), UVec3::splat(4));
    }
}
