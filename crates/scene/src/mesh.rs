use glam::Vec3;
use meniscus_core::Aabb;

/// Which sides of a surface are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Both.
    Both,
    /// Only the side that the normals point to: a tank's wall between camera and water is not drawn.
    Front,
}

/// Triangles in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// World space.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, as many as positions.
    pub normals: Vec<[f32; 3]>,
    /// Three indices per triangle.
    pub indices: Vec<u32>,
}

impl Mesh {
    /// Adds the parallelogram `corner + s * a + t * b`, s and t in [0, 1], facing `a x b`.
    pub fn push_quad(&mut self, corner: Vec3, a: Vec3, b: Vec3) {
        let first = self.positions.len() as u32;
        let normal = a.cross(b).normalize_or_zero().to_array();
        self.positions.extend([corner, corner + a, corner + a + b, corner + b].map(|p| p.to_array()));
        self.normals.extend([normal; 4]);
        self.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }

    /// The six faces of `bounds`, facing outwards.
    pub fn cuboid(bounds: Aabb) -> Self {
        let (lo, hi, e) = (bounds.min, bounds.max, bounds.extent());
        let (x, y, z) = (Vec3::X * e.x, Vec3::Y * e.y, Vec3::Z * e.z);
        let mut mesh = Self::default();
        for (a, b) in [(x, y), (y, z), (z, x)] {
            mesh.push_quad(lo, b, a);
            mesh.push_quad(hi, -b, -a);
            // The second quad spans from the far corner, and (-b) x (-a) = b x a would face like the first.
            let last = mesh.normals.len() - 4;
            for normal in &mut mesh.normals[last..] {
                *normal = (-Vec3::from(*normal)).to_array();
            }
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cuboid_faces_outwards_on_six_sides() {
        let bounds = Aabb { min: Vec3::new(-1.0, 2.0, 0.0), max: Vec3::new(3.0, 4.0, 5.0) };
        let mesh = Mesh::cuboid(bounds);
        assert_eq!((mesh.positions.len(), mesh.indices.len()), (24, 36));
        let mut seen = Vec::new();
        for (face, normal) in mesh.positions.chunks(4).zip(mesh.normals.chunks(4)) {
            let center = face.iter().map(|&p| Vec3::from(p)).sum::<Vec3>() / 4.0;
            let normal = Vec3::from(normal[0]);
            assert!((center - bounds.center()).dot(normal) > 0.0);
            assert!(!seen.contains(&normal));
            seen.push(normal);
        }
        assert_eq!(Aabb::of_points(&mesh.positions), bounds);
    }
}
