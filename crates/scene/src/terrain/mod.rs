//! Elevation grids, and the triangles that are drawn of them.

mod esri;
mod usgs;

use std::path::Path;

use glam::{DVec2, DVec3, Vec3};

use crate::{Mesh, SceneError, UpFrame};

/// Squares along a side of a block.
const BLOCK: usize = 64;

/// Heights over a regular grid of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    /// East and north of the south-western point, file coordinates.
    south_west: DVec2,
    /// Distances of neighbours to the east and to the north, file units, > 0.
    spacing: DVec2,
    /// Points from west to east.
    columns: usize,
    /// Heights in file units, west to east in rows from south to north; NaN where there is none.
    heights: Vec<f32>,
}

impl Terrain {
    /// More points are thinned out: a vertex takes 32 bytes of GPU memory and its two triangles 24.
    pub const MOST_POINTS: usize = 4 << 20;

    /// Larger files are not read, bytes.
    const MOST_BYTES: u64 = 1 << 30;

    /// Reads an ESRI ASCII grid or a USGS DEM, which its first word tells.
    ///
    /// # Errors
    /// [`SceneError::Terrain`] with the file, the place in it and what is wrong there.
    pub fn read(file: &Path) -> Result<Self, SceneError> {
        let fail = |message: String| SceneError::Terrain { file: file.display().to_string(), message };
        let metadata = std::fs::metadata(file).map_err(|e| fail(format!("cannot be read: {e}")))?;
        if !metadata.is_file() {
            return Err(fail("is not a regular file; give an ESRI ASCII grid or a USGS DEM".into()));
        }
        if metadata.len() > Self::MOST_BYTES {
            let (found, most) = (metadata.len() >> 20, Self::MOST_BYTES >> 20);
            return Err(fail(format!("has {found} MiB, expected at most {most}; make the grid coarser")));
        }
        let bytes = std::fs::read(file).map_err(|e| fail(format!("cannot be read: {e}")))?;
        if esri::is_esri(&bytes) { esri::parse(&bytes) } else { usgs::parse(&bytes) }.map_err(fail)
    }

    /// From heights of points `spacing` apart, the first of them in the south-west, `columns` of them in each row from west to
    /// east, rows from south to north; all in file units. NaN where there is none.
    ///
    /// # Panics
    /// When `heights` are no whole rows.
    pub fn new(south_west: DVec2, spacing: DVec2, columns: usize, heights: Vec<f32>) -> Self {
        assert!(columns > 0 && heights.len().is_multiple_of(columns), "heights fill their rows");
        Self { south_west, spacing, columns, heights }
    }

    /// Points to the east and to the north.
    pub fn size(&self) -> [usize; 2] {
        [self.columns, self.heights.len() / self.columns]
    }

    /// Distances of neighbouring points that are drawn, to the east and to the north, file units.
    pub fn spacing(&self) -> DVec2 {
        self.spacing * self.step() as f64
    }

    /// Every how many points of a row and a column one is taken, so that no more than [`Self::MOST_POINTS`] are.
    pub fn step(&self) -> usize {
        let taken = |step: &usize| self.size().map(|points| points.div_ceil(*step)).iter().product::<usize>();
        (1..).find(|step| taken(step) <= Self::MOST_POINTS).unwrap_or(1)
    }

    /// Its upper side in world space, thinned out by [`Self::step`]; `origin` (file) is where world space starts. Squares with a
    /// missing corner are left out.
    pub fn mesh(&self, frame: UpFrame, origin: DVec3) -> Mesh {
        let step = self.step();
        let [columns, rows] = self.size().map(|points| points.div_ceil(step));
        let along = |axis: Vec3| origin.dot(axis.as_dvec3());
        let from = self.south_west - DVec2::new(along(frame.east), along(frame.north));
        let spacing = self.spacing();
        let height =
            |column: usize, row: usize| f64::from(self.heights[row * step * self.columns + column * step]);
        let mut mesh = Mesh::default();
        // Vertex of every point that is there.
        let mut vertices = vec![None; columns * rows];
        for row in 0..rows {
            for column in 0..columns {
                let here = height(column, row);
                if here.is_nan() {
                    continue;
                }
                let place = from + spacing * DVec2::new(column as f64, row as f64);
                let at = |column: Option<usize>, row: Option<usize>| {
                    let inside = column.filter(|&column| column < columns).zip(row.filter(|&row| row < rows));
                    inside.map(|(column, row)| height(column, row))
                };
                let (west, east) = (at(column.checked_sub(1), Some(row)), at(Some(column + 1), Some(row)));
                let (south, north) = (at(Some(column), row.checked_sub(1)), at(Some(column), Some(row + 1)));
                let normal = DVec3::new(
                    -slope(west, here, east, spacing.x),
                    -slope(south, here, north, spacing.y),
                    1.0,
                )
                .normalize();
                vertices[row * columns + column] = Some(mesh.positions.len() as u32);
                let position = DVec3::new(place.x, place.y, here - along(frame.up)).as_vec3();
                mesh.positions.push(frame.world_of(position).to_array());
                mesh.normals.push(frame.world_of(normal.as_vec3()).to_array());
            }
        }
        // Square by square of squares, so that triangles that follow each other lie together.
        for block in blocks([columns, rows]) {
            for (column, row) in block {
                let corners = [(column - 1, row - 1), (column, row - 1), (column, row), (column - 1, row)]
                    .map(|(column, row)| vertices[row * columns + column]);
                if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                    mesh.indices.extend([a, b, c, a, c, d]);
                }
            }
        }
        mesh
    }
}

/// By central differences, one-sided at the border and beside what is missing; level where both sides are.
fn slope(before: Option<f64>, here: f64, after: Option<f64>, spacing: f64) -> f64 {
    let there = |height: Option<f64>| height.filter(|height| !height.is_nan());
    match (there(before), there(after)) {
        (Some(before), Some(after)) => (after - before) / (2.0 * spacing),
        (Some(before), None) => (here - before) / spacing,
        (None, Some(after)) => (after - here) / spacing,
        (None, None) => 0.0,
    }
}

/// North-eastern points of the squares between `size` points, in blocks of [`BLOCK`] squares each way.
fn blocks([columns, rows]: [usize; 2]) -> impl Iterator<Item = impl Iterator<Item = (usize, usize)>> {
    let starts =
        move |points: usize| (1..points).step_by(BLOCK).map(move |start| start..points.min(start + BLOCK));
    starts(rows).flat_map(move |rows| {
        starts(columns).map(move |columns| {
            let columns = columns.clone();
            rows.clone().flat_map(move |row| columns.clone().map(move |column| (column, row)))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_core::{Aabb, UpAxis};

    /// A plane that rises by 0.5 to the east and falls by 0.25 to the north.
    fn plane(columns: usize, rows: usize) -> Terrain {
        let heights =
            (0..columns * rows).map(|i| (i % columns) as f32 - 0.5 * (i / columns) as f32).collect();
        Terrain::new(DVec2::new(5e5, 3.4e6), DVec2::new(2.0, 2.0), columns, heights)
    }

    #[test]
    fn a_plane_lies_where_the_map_has_it_for_every_up_axis() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            let frame = UpFrame::new(up);
            let origin =
                5e5 * frame.east.as_dvec3() + 3.4e6 * frame.north.as_dvec3() + 10.0 * frame.up.as_dvec3();
            let mesh = plane(4, 3).mesh(frame, origin);
            assert_eq!((mesh.positions.len(), mesh.indices.len()), (12, 6 * 6));
            let expected = Aabb::of_points(&[
                frame.world(0.0, 0.0, -11.0).to_array(),
                frame.world(6.0, 4.0, -7.0).to_array(),
            ]);
            assert_eq!(Aabb::of_points(&mesh.positions), expected, "{up:?}");
            let normal = frame.world(-0.5, 0.25, 1.0).normalize();
            for triangle in mesh.indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(mesh.positions[triangle[i] as usize]));
                // 1e-6: rounding of f32.
                assert!((b - a).cross(c - a).normalize().distance(normal) < 1e-6, "faces up");
            }
            assert!(mesh.normals.iter().all(|&n| Vec3::from(n).distance(normal) < 1e-6));
        }
    }

    #[test]
    fn what_is_missing_leaves_a_hole() {
        let mut terrain = plane(5, 5);
        terrain.heights[12] = f32::NAN;
        let frame = UpFrame::new(UpAxis::Z);
        let mesh = terrain.mesh(frame, DVec3::new(5e5, 3.4e6, 0.0));
        // The four squares around the point are gone, and nothing is drawn of it.
        assert_eq!((mesh.positions.len(), mesh.indices.len()), (24, 12 * 6));
        let normal = Vec3::new(-0.5, 0.25, 1.0).normalize();
        assert!(mesh.normals.iter().all(|&n| Vec3::from(n).distance(normal) < 1e-6));
        terrain.heights.fill(f32::NAN);
        assert_eq!(terrain.mesh(frame, DVec3::ZERO), Mesh::default());
    }

    #[test]
    fn large_grids_are_thinned_out_evenly() {
        let terrain = plane(5000, 1000);
        assert_eq!(terrain.step(), 2);
        let mesh = terrain.mesh(UpFrame::new(UpAxis::Z), DVec3::new(5e5, 3.4e6, 0.0));
        assert_eq!(mesh.positions.len(), 2500 * 500);
        assert_eq!(mesh.positions[1], [4.0, 0.0, 2.0]);
        // Every square once: the first corner of the first of two triangles is its own.
        let mut squares: Vec<u32> = mesh.indices.chunks_exact(6).map(|square| square[0]).collect();
        squares.sort_unstable();
        let expected = (0..499u32).flat_map(|row| (0..2499).map(move |column| row * 2500 + column));
        assert!(squares.into_iter().eq(expected));
        assert_eq!(plane(2048, 2048).step(), 1);
    }

    #[test]
    fn other_files_are_refused_with_what_was_expected() {
        let folder = tempfile::tempdir().unwrap();
        let message = |name: &str, bytes: &[u8]| {
            let file = folder.path().join(name);
            std::fs::write(&file, bytes).unwrap();
            Terrain::read(&file).unwrap_err().to_string()
        };
        for (name, bytes) in [
            ("a.tif", &b"II*\0"[..]),
            ("empty.asc", b""),
            ("blank.dem", &[b' '; 2048]),
            ("zero.dem", &[0; 4096]),
        ] {
            let message = message(name, bytes);
            assert!(message.contains(name) && message.contains("ESRI ASCII grid"), "{message}");
        }
        let missing = Terrain::read(&folder.path().join("none.asc")).unwrap_err().to_string();
        assert!(missing.contains("none.asc: cannot be read"), "{missing}");
        assert!(Terrain::read(folder.path()).unwrap_err().to_string().contains("not a regular file"));
    }
}
