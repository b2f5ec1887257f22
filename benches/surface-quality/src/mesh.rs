//! The reference: a mesh reconstructed from the particles by `splashsurf_lib`, as its authors recommend it for water.

use std::error::Error;

use glam::Vec3;
use splashsurf_lib::mesh::{Mesh3d, TriMesh3d};
use splashsurf_lib::nalgebra::Vector3;
use splashsurf_lib::postprocessing::{
    marching_cubes_cleanup, par_laplacian_smoothing_inplace, par_laplacian_smoothing_normals_inplace,
};
use splashsurf_lib::sph_interpolation::SphInterpolator;
use splashsurf_lib::{Parameters, SurfaceReconstruction, reconstruct_surface};

/// A closed surface.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// World.
    pub positions: Vec<Vec3>,
    /// Unit, outwards, one per position.
    pub normals: Vec<Vec3>,
    /// Corners, as indices of `positions`.
    pub triangles: Vec<[u32; 3]>,
}

/// How finely and how smoothly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reconstruction {
    /// Edge of the cubes of the grid, in particle radii.
    pub cube_radii: f32,
    /// Steps of the weighted Laplacian smoothing of positions.
    pub smoothing_steps: usize,
    /// Steps of the smoothing of normals.
    pub normal_steps: usize,
}

impl Default for Reconstruction {
    /// `-c=0.5 --mesh-smoothing-weights=on --mesh-smoothing-iters=25 --normals-smoothing-iters=10`: the example of splashsurf's
    /// documentation.
    fn default() -> Self {
        Self { cube_radii: 0.5, smoothing_steps: 25, normal_steps: 10 }
    }
}

/// Smoothing length in particle radii; the kernel reaches twice as far: `-l=2.0`.
const SMOOTHING_LENGTH_RADII: f32 = 2.0;
/// Fraction of the density at rest where the surface lies: `-t=0.6`.
const THRESHOLD: f32 = 0.6;
/// kg/m^3. Cancels out.
const REST_DENSITY: f32 = 1000.0;
/// Weighted number of neighbours from which on a vertex is smoothed in full: splashsurf's default.
const NEIGHBORS_INSIDE: f32 = 13.0;

impl Reconstruction {
    /// The mesh around `positions` (world) of particles `spacing` (world) apart.
    ///
    /// # Errors
    /// splashsurf's.
    pub fn mesh(&self, positions: &[[f32; 3]], spacing: f32) -> Result<Mesh, Box<dyn Error>> {
        let radius = spacing / 2.0;
        let particles: Vec<Vector3<f32>> = positions.iter().map(|&p| p.into()).collect();
        let parameters = Parameters {
            rest_density: REST_DENSITY,
            iso_surface_threshold: THRESHOLD,
            global_neighborhood_list: true,
            ..Parameters::new_relative(radius, 2.0 * SMOOTHING_LENGTH_RADII, self.cube_radii)
        };
        let mut surface = reconstruct_surface::<i64, f32>(&particles, &parameters)?;
        marching_cubes_cleanup(&mut surface.mesh, &surface.grid, None, 5, false);
        let weights = smoothing_weights(&particles, &surface, &parameters)?;
        let mut mesh = surface.mesh;
        let connected = mesh.vertex_vertex_connectivity();
        par_laplacian_smoothing_inplace(&mut mesh, &connected, self.smoothing_steps, 1.0, &weights);
        Ok(self.with_normals(&mesh, &connected))
    }

    fn with_normals(&self, mesh: &TriMesh3d<f32>, connected: &[Vec<usize>]) -> Mesh {
        let mut normals: Vec<_> = mesh.par_vertex_normals().into_iter().map(|n| n.into_inner()).collect();
        par_laplacian_smoothing_normals_inplace(&mut normals, connected, self.normal_steps);
        let world = |v: &Vector3<f32>| Vec3::new(v.x, v.y, v.z);
        // Of degenerate triangles, which the cleaning leaves a few of, there is no normal.
        let unit = |v: &Vector3<f32>| if world(v).is_finite() { world(v) } else { Vec3::ZERO };
        Mesh {
            positions: mesh.vertices.iter().map(world).collect(),
            normals: normals.iter().map(unit).collect(),
            triangles: mesh.triangles.iter().map(|t| t.map(|corner| corner as u32)).collect(),
        }
    }
}

/// How far each vertex is smoothed, 0 to 1: in full inside of the fluid, not at all around single particles, which would shrink
/// (Loeschner et al. 2023, "Weighted Laplacian smoothing for surface reconstruction of particle-based fluids").
fn smoothing_weights(
    particles: &[Vector3<f32>],
    surface: &SurfaceReconstruction<i64, f32>,
    parameters: &Parameters<f32>,
) -> Result<Vec<f32>, Box<dyn Error>> {
    let densities = surface.particle_densities.as_ref().ok_or("splashsurf gave no densities")?;
    let neighbors = surface.particle_neighbors.as_ref().ok_or("splashsurf gave no neighbours")?;
    let reach = parameters.compact_support_radius;
    let weighted_number = |(particle, neighbors): (&Vector3<f32>, &Vec<usize>)| -> f32 {
        let closeness =
            |&other: &usize| 1.0 - ((particles[other] - particle).norm() / reach).powi(2).min(1.0);
        neighbors.iter().map(closeness).sum()
    };
    let numbers: Vec<f32> = particles.iter().zip(neighbors).map(weighted_number).collect();
    let mass = parameters.rest_density * (2.0 * parameters.particle_radius).powi(3);
    let interpolator = SphInterpolator::new(particles, densities, mass, reach);
    let at_vertices = interpolator.interpolate_scalar_quantity(&numbers, &surface.mesh.vertices, true);
    let weight = |number: f32| {
        let x = (number / NEIGHBORS_INSIDE).clamp(0.0, 1.0);
        x.powi(3) * (x * (6.0 * x - 15.0) + 10.0)
    };
    Ok(at_vertices.into_iter().map(weight).collect())
}
