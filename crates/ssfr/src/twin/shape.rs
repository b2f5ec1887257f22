use std::collections::HashMap;

use glam::{DMat3, DVec3, IVec3, Vec3};
use meniscus_gpu::role::PackedParticle;

use crate::shape::{FULL_NEIGHBOURS, LEAST_VARIANCE, LIFT, MOVED_NEIGHBOURS, NO_NEIGHBOURS, surface_shift};
use crate::{Anisotropy, AnisotropyParams};

/// What a particle is drawn as: the ellipsoid `center + radius * axes * u`, |u| <= 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HostShape {
    /// Its centre, world.
    pub center_world: DVec3,
    /// Symmetric; its eigenvalues are the half-axes relative to the particle's radius.
    pub axes: DMat3,
}

impl HostShape {
    /// The shape of `particle` that was packed into `bits`; `meniscus::shape::unpack_shape` of `shaders/ssfr/shape.inc.wgsl`.
    pub fn unpack(bits: [u32; 4], particle: &PackedParticle, rule: &ShapeRule) -> Self {
        let axis = |word: u32, shift: u32| {
            let steps = f64::from((word >> shift) as u16 as i16).max(-32767.0);
            4.0 * steps / 32767.0
        };
        let [[xx, yy], [zz, xy], [xz, yz]] =
            [bits[0], bits[1], bits[2]].map(|word| [axis(word, 0), axis(word, 16)]);
        let shift = [0, 10, 20].map(|first| (f64::from(bits[3] >> first & 1023) - 512.0) / 511.0);
        let position = Vec3::from(particle.position_world).as_dvec3();
        Self {
            center_world: position + DVec3::from(shift) * rule.most_shift_world(),
            axes: DMat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
        }
    }
}

/// What shapes depend on besides the particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeRule {
    /// Parameters.
    pub params: AnisotropyParams,
    /// Distance of neighbouring particles, world units.
    pub spacing_world: f64,
    /// Radius drawn, world units.
    pub radius_world: f64,
}

impl ShapeRule {
    fn support_world(&self) -> f64 {
        f64::from(self.params.support) * self.spacing_world
    }

    /// Farthest that a centre is moved.
    pub fn most_shift_world(&self) -> f64 {
        f64::from(AnisotropyParams::MAX_SHIFT_SPACINGS) * self.spacing_world
    }
}

/// The shape of every particle (`main-renderer.md` 5.6, `algorithms.md` 9.1).
pub fn shapes(particles: &[PackedParticle], rule: &ShapeRule) -> Vec<HostShape> {
    let support = rule.support_world();
    let position = |particle: &PackedParticle| Vec3::from(particle.position_world).as_dvec3();
    let cell = |at: DVec3| (at / support).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<usize>> = HashMap::new();
    for (index, particle) in particles.iter().enumerate() {
        cells.entry(cell(position(particle))).or_default().push(index);
    }
    let around = (0..27).map(|k| IVec3::new(k % 3, k / 3 % 3, k / 9) - 1);
    let shape = |particle: &PackedParticle| {
        let center = position(particle);
        let near = around.clone().filter_map(|offset| cells.get(&(cell(center) + offset))).flatten();
        let neighbours = near.map(|&other| {
            let relative = half::f16::from_bits((particles[other].packed >> 16) as u16).to_f64();
            ((position(&particles[other]) - center) / support, relative.powi(3).min(1.0))
        });
        Moments::of(neighbours).shape(center, rule)
    };
    particles.iter().map(shape).collect()
}

/// Weighted sums over a particle and its neighbours, around the particle, lengths in supports.
struct Moments {
    weight: f64,
    first: DVec3,
    second: DMat3,
}

impl Moments {
    /// `neighbours`: where they are and their volumes relative to the set's own.
    fn of(neighbours: impl Iterator<Item = (DVec3, f64)>) -> Self {
        let mut sums = Self { weight: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };
        for (at, volume) in neighbours {
            let weight = volume * (1.0 - at.length().powi(3)).max(0.0);
            sums.weight += weight;
            sums.first += weight * at;
            sums.second += DMat3::from_cols(at * at.x, at * at.y, at * at.z) * weight;
        }
        sums
    }

    fn shape(&self, center: DVec3, rule: &ShapeRule) -> HostShape {
        let params = &rule.params;
        let mean = self.first / self.weight;
        let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        let (variances, vectors) = eigen(self.second * self.weight.recip() - outer);

        // The mean weight over the support is 1/2; counted so, no neighbour enters or leaves with a step.
        let neighbours = 2.0 * (self.weight - 1.0);
        let enough = |full: f64| ((neighbours - NO_NEIGHBOURS) / (full - NO_NEIGHBOURS)).clamp(0.0, 1.0);
        let largest = variances.max_element();
        // Where all are in one place, there is no shape to be found.
        let spread = (largest / LEAST_VARIANCE).min(1.0);
        let blend = f64::from(params.strength) * enough(FULL_NEIGHBOURS) * spread;
        let lengths = half_axes(variances, rule);
        let lengths = DVec3::ONE + (lengths - 1.0) * blend;
        let axes = vectors * DMat3::from_diagonal(lengths) * vectors.transpose();

        // Being as far from the mean of its neighbours as a particle in a flat surface is not roughness but where the fluid ends.
        let usual = surface_shift(params.support.into());
        let away = mean.length();
        let outward = if away > 1e-6 { -mean / away } else { DVec3::ZERO };
        let t = (away / usual).min(1.0);
        let one_sided = t * t * (3.0 - 2.0 * t);
        let inwards = f64::from(params.smoothing) * enough(MOVED_NEIGHBOURS) * (away - usual * one_sided);
        let height = (axes * outward).length();
        let lift = LIFT * one_sided * (1.0 - height).max(0.0) * rule.radius_world / rule.support_world();
        let shift = outward * (lift - inwards) * rule.support_world();
        let most = rule.most_shift_world();
        HostShape { center_world: center + shift * (most / shift.length()).min(1.0), axes }
    }
}

/// Half-axes in radii, of the full anisotropy.
fn half_axes(variances: DVec3, rule: &ShapeRule) -> DVec3 {
    let params = &rule.params;
    let largest = variances.max_element().max(0.01 * LEAST_VARIANCE);
    let limited = variances.max(DVec3::splat(largest / f64::from(params.ratio)));
    match params.form() {
        Anisotropy::None => DVec3::ONE,
        Anisotropy::YuTurk => limited / (limited.x * limited.y * limited.z).cbrt(),
        Anisotropy::Zju => {
            let scale = f64::from(params.zju_scale) * rule.support_world() / rule.radius_world;
            (DVec3::new(limited.x.sqrt(), limited.y.sqrt(), limited.z.sqrt()) * scale)
                .min(DVec3::splat(AnisotropyParams::MAX_ZJU_AXIS.into()))
        }
    }
}

/// Eigenvalues and unit eigenvectors, as columns, of a symmetric matrix: cyclic Jacobi rotations (Golub and Van Loan, Matrix
/// Computations, 8.5), which no multiple or vanishing eigenvalue upsets.
fn eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let mut a = matrix.to_cols_array_2d();
    let mut vectors = DMat3::IDENTITY.to_cols_array_2d();
    for (p, q) in [(0, 1), (0, 2), (1, 2)].into_iter().cycle().take(3 * 12) {
        let off = a[p][q];
        if off.abs() <= 1e-300 {
            continue;
        }
        let theta = (a[q][q] - a[p][p]) / (2.0 * off);
        let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
        let c = 1.0 / t.hypot(1.0);
        let s = t * c;
        let rotate = |columns: &mut [[f64; 3]; 3]| {
            let (x, y) = (DVec3::from(columns[p]), DVec3::from(columns[q]));
            columns[p] = (c * x - s * y).to_array();
            columns[q] = (s * x + c * y).to_array();
        };
        for row in &mut a {
            (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
        }
        rotate(&mut a);
        rotate(&mut vectors);
    }
    (DVec3::new(a[0][0], a[1][1], a[2][2]), DMat3::from_cols_array_2d(&vectors))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AnisotropyParams;

    /// Moments of a continuum around a particle, up to the height `end` above it, in supports.
    fn continuum(end: f64) -> (DVec3, DMat3) {
        let cells = 100;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(cells);
        let side = || (-cells..cells).map(at);
        let points = side().flat_map(|x| side().flat_map(move |y| side().map(move |z| DVec3::new(x, y, z))));
        let sums = Moments::of(points.filter(|p| p.z < end).map(|p| (p, 1.0)));
        let mean = sums.first / sums.weight;
        let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        (mean, sums.second * sums.weight.recip() - outer)
    }

    /// The numbers of `algorithms.md` 9.1.
    #[test]
    fn variances_of_the_bulk_and_of_a_flat_surface() {
        let (mean, bulk) = continuum(f64::INFINITY);
        // Sums over cells of a hundredth are right to its square.
        assert!(mean.length() < 1e-12);
        assert!((bulk - DMat3::IDENTITY * 0.15).to_cols_array().iter().all(|c| c.abs() < 1e-4), "{bulk}");
        let (mean, surface) = continuum(0.0);
        assert!((mean.z + 0.3214).abs() < 1e-3, "{mean}");
        let (values, vectors) = eigen(surface);
        let along = (0..3).find(|&k| vectors.col(k).z.abs() > 0.9).unwrap();
        assert!((values[along] - 0.0467).abs() < 2e-4, "{values}");
        assert!((values[(along + 1) % 3] - 0.15).abs() < 2e-4, "{values}");
        let (mean, _) = continuum(0.2);
        assert!((mean.z + surface_shift(2.5)).abs() < 1e-3, "{mean}");
    }

    /// Half-axes of a surface through the particle are as 3.2 to 1 where they go with variances, 1.8 where with deviations.
    #[test]
    fn axes_have_the_ratio_of_their_form() {
        let variances = DVec3::new(0.15, 0.15, 0.0467);
        for (form, ratio) in [(Anisotropy::YuTurk, 3.2), (Anisotropy::Zju, 1.8)] {
            let params = AnisotropyParams { form: Some(form), ..Default::default() };
            let axes = half_axes(variances, &ShapeRule { params, spacing_world: 1.0, radius_world: 0.625 });
            assert!((axes.x / axes.z - ratio).abs() < 0.02, "{form:?} {axes}");
            if form == Anisotropy::YuTurk {
                assert!((axes.element_product() - 1.0).abs() < 1e-12, "the sphere's volume");
            }
        }
    }

    #[test]
    fn eigenvectors_of_any_symmetric_matrix() {
        let mut matrices = vec![DMat3::ZERO, DMat3::IDENTITY, DMat3::from_cols_array(&[1.0; 9])];
        matrices.push(DMat3::from_cols_array(&[2.0, 1e-9, 0.0, 1e-9, 2.0, 0.3, 0.0, 0.3, -1.0]));
        matrices.push(DMat3::from_cols_array(&[0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 5.0]));
        for matrix in matrices {
            let (values, vectors) = eigen(matrix);
            let back = vectors * DMat3::from_diagonal(values) * vectors.transpose();
            assert!((back - matrix).to_cols_array().iter().all(|c| c.abs() < 1e-12), "{matrix}");
            let unit = vectors * vectors.transpose() - DMat3::IDENTITY;
            assert!(unit.to_cols_array().iter().all(|c| c.abs() < 1e-12), "{matrix}");
        }
    }
}
