//! What a camera sees of a mesh.

use glam::{DVec2, DVec3, Vec3};
use meniscus_core::Camera;
use meniscus_gpu::CameraUniform;
use meniscus_gpu::role::NO_SURFACE;
use meniscus_ssfr::twin::HostView;

use crate::mesh::Mesh;
use crate::surface::Surface;

/// How far outside of a triangle, in its own coordinates, a hit still counts: rounding must not open seams.
const SEAM: f64 = 1e-9;

/// The nearest hit of the ray through every pixel's centre, its normal interpolated between those of the corners. Triangles of which
/// a corner is nearer than the camera's near distance are not seen.
pub fn cast(mesh: &Mesh, camera: &Camera, size: [u32; 2]) -> Surface {
    let view = HostView::new(&CameraUniform::new(camera, size));
    let to_view = camera.view_from_world().as_dmat4();
    let positions: Vec<DVec3> =
        mesh.positions.iter().map(|p| to_view.transform_point3(p.as_dvec3())).collect();
    let [width, height] = size.map(|side| side as usize);
    let mut distance = vec![NO_SURFACE; width * height];
    let mut normal = vec![Vec3::ZERO; width * height];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| positions[corner as usize]);
        if corners.iter().any(|corner| -corner.z < camera.near.into()) {
            continue;
        }
        let normals = triangle.map(|corner| mesh.normals[corner as usize].as_dvec3());
        let points = corners.map(|corner| view.project_px(corner));
        let [least, most] = [DVec2::min, DVec2::max].map(|of| of(of(points[0], points[1]), points[2]));
        // Centres lie at halves.
        let first = (least - 0.5).ceil().max(DVec2::ZERO).as_uvec2();
        let end = (most + 0.5).floor().max(DVec2::ZERO).as_uvec2();
        for y in first.y as usize..(end.y as usize).min(height) {
            for x in first.x as usize..(end.x as usize).min(width) {
                let ray = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
                let Some((d, weights)) = hit(ray, corners) else { continue };
                let pixel = y * width + x;
                if (d as f32) < distance[pixel] {
                    distance[pixel] = d as f32;
                    let interpolated: DVec3 = std::iter::zip(normals, weights).map(|(n, w)| n * w).sum();
                    let flat =
                        (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(DVec3::Z);
                    normal[pixel] = to_view.transform_vector3(interpolated).normalize_or(flat).as_vec3();
                }
            }
        }
    }
    Surface { normal, distance: Some(distance) }
}

/// Where the ray `origin + d * step` meets a triangle: d, and the weights of the corners there (Moeller and Trumbore 1997).
fn hit((origin, step): (DVec3, DVec3), corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
    let (edge1, edge2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let across = step.cross(edge2);
    let determinant = edge1.dot(across);
    let from = origin - corners[0];
    let turned = from.cross(edge1);
    let [u, v, d] = [from.dot(across), step.dot(turned), edge2.dot(turned)].map(|n| n / determinant);
    // Seen edge-on the determinant is 0, and no comparison holds.
    let is_inside = u >= -SEAM && v >= -SEAM && u + v <= 1.0 + SEAM;
    (is_inside && d.is_finite()).then_some((d, [1.0 - u - v, u, v]))
}

#[cfg(test)]
mod tests {
    use meniscus_core::Projection;

    use super::*;

    /// A sphere of radius 1 around the origin, of `n` x 2n quadrilaterals, with its true normals; at the end a triangle behind it that
    /// must not shine through.
    fn sphere(n: u32) -> Mesh {
        let at = |i: u32, j: u32| {
            let (polar, around) = (i as f32 / n as f32, j as f32 / n as f32);
            let (polar, around) = (polar * std::f32::consts::PI, around * std::f32::consts::PI);
            Vec3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos())
        };
        let mut positions: Vec<Vec3> = (0..=n).flat_map(|i| (0..2 * n).map(move |j| at(i, j))).collect();
        let index = |i: u32, j: u32| i * 2 * n + j % (2 * n);
        let square = |i, j| {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let mut triangles: Vec<[u32; 3]> =
            (0..n).flat_map(|i| (0..2 * n).flat_map(move |j| square(i, j))).collect();
        let mut normals = positions.clone();
        let behind = positions.len() as u32;
        positions.extend([[-0.1, 2.0, -0.1], [0.1, 2.0, -0.1], [0.0, 2.0, 0.1]].map(Vec3::from));
        normals.extend([Vec3::X; 3]);
        triangles.push([behind, behind + 1, behind + 2]);
        Mesh { positions, normals, triangles }
    }

    /// Distance and normal, in view space, of the unit sphere around the middle of the picture, `away` from the eye.
    fn of_sphere((origin, step): (DVec3, DVec3), away: f64) -> Option<(f64, DVec3)> {
        let center = DVec3::new(0.0, 0.0, -away);
        let (a, b) = (step.length_squared(), step.dot(center - origin));
        let root = b * b - a * ((center - origin).length_squared() - 1.0);
        let d = (b - root.max(0.0).sqrt()) / a;
        (root >= 0.0).then(|| (d, origin + d * step - center))
    }

    #[test]
    fn a_sphere_is_seen_where_and_as_it_is() {
        let size = [160, 120];
        let projections =
            [Projection::Perspective { fovy_rad: 0.6 }, Projection::Orthographic { height_world: 2.5 }];
        for projection in projections {
            let eye = Vec3::new(0.0, -5.0, 0.0);
            let camera = Camera { eye, target: Vec3::ZERO, up: Vec3::Z, projection, near: 0.1 };
            // A facet's middle lies 0.0003 inside of the sphere.
            let seen = cast(&sphere(100), &camera, size);
            let distance = seen.distance.clone().unwrap();
            let view = HostView::new(&CameraUniform::new(&camera, size));
            let mut compared = 0;
            for (pixel, &found) in distance.iter().enumerate() {
                let [x, y] = [pixel % 160, pixel / 160].map(|at| at as f64 + 0.5);
                let truth = of_sphere(view.ray(DVec2::new(x, y)), 5.0);
                let Some((d, normal)) = truth else {
                    assert!(!seen.covers(pixel), "{x}, {y} beside the sphere");
                    continue;
                };
                // At the rim, facets end before the sphere does.
                if normal.dot(-view.ray(DVec2::new(x, y)).1.normalize()) < 0.2 {
                    continue;
                }
                // 0.0003 divided by that cosine, and as much again for single precision.
                assert!((f64::from(found) - d).abs() < 2e-3, "{x}, {y}: {found}, {d}");
                assert!((seen.normal[pixel].as_dvec3() - normal).length() < 3e-3, "{x}, {y}: {normal}");
                compared += 1;
            }
            // The sphere has a disc of radius 39 or 48 pixels; a fifth of that lies too near to the rim.
            assert!(compared > 4000, "{compared}");
        }
    }

    /// Edge to edge, no ray passes between two triangles, and none is lost where it meets an edge or a corner.
    #[test]
    fn seams_hold() {
        let size = [8, 8];
        let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        let camera = Camera {
            eye: Vec3::new(0.0, 0.0, 3.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Orthographic { height_world: 2.0 },
            near: 0.1,
        };
        // The diagonal runs through the centres of pixels, as one edge does.
        let mesh = Mesh {
            positions: vec![
                corner(-0.875, -0.875),
                corner(0.875, -0.875),
                corner(0.875, 0.875),
                corner(-0.875, 0.875),
            ],
            normals: vec![Vec3::Z; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let seen = cast(&mesh, &camera, size);
        assert!((0..64).all(|pixel| seen.covers(pixel)), "{:?}", seen.normal);
        assert!(seen.distance.unwrap().iter().all(|d| (d - 3.0).abs() < 1e-6));
    }
}
