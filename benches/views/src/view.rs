use glam::Vec3;
use meniscus_cases::{Case, CaseOptions, CaseSource};
use meniscus_core::{Camera, Cancel, FrameRequest, FrameSource, ParticleFrame, Projection, SeriesSpace};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// A case at a moment, seen by a camera: one of the files beside this package.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Name in reports, and of the file.
    pub name: String,
    /// Why this view is measured.
    pub why: String,
    /// The particles.
    #[serde(deserialize_with = "case_by_name")]
    pub case: Case,
    /// Their number.
    pub particles: u64,
    /// Frame of the case's 60.
    pub frame: usize,
    /// Picture size in pixels.
    pub size: [u32; 2],
    /// Eye, world (metres from the series' origin, z up).
    pub eye: [f32; 3],
    /// Point looked at, world.
    pub target: [f32; 3],
    /// Vertical field of view, degrees.
    pub fovy_deg: f32,
    /// Drawn radius at the target, pixels, for `particles` and `size`.
    pub radius_px: f32,
    /// Fraction of the picture that shows water, at least 0.4.
    pub covered_fraction: f32,
}

fn case_by_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Case, D::Error> {
    String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
}

/// Reads a committed view; the tests read all of them.
fn committed(text: &str) -> View {
    toml::from_str(text).expect("a committed view")
}

impl View {
    /// The collapsing column of the published dam break.
    pub fn dam_break() -> Self {
        committed(include_str!("../dam-break.toml"))
    }

    /// The sphere's cavity at full HD.
    pub fn sphere_entry() -> Self {
        committed(include_str!("../sphere-entry.toml"))
    }

    /// A stretch of the fjord from the air.
    pub fn fjord_tsunami() -> Self {
        committed(include_str!("../fjord-tsunami.toml"))
    }

    /// The front of the dam break, from a hand's breadth away.
    pub fn close_up() -> Self {
        committed(include_str!("../close-up.toml"))
    }

    /// Every committed view.
    pub fn all() -> [Self; 4] {
        [Self::dam_break(), Self::sphere_entry(), Self::fjord_tsunami(), Self::close_up()]
    }

    /// The same view for a run that only has to work: few particles, a small picture.
    pub fn tiny(self) -> Self {
        let size = [self.size[0] / 8, self.size[1] / 8];
        // As many pixels to a radius at an eighth of the size.
        let particles = self.particles / 512;
        Self { particles, size, ..self }
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        let (eye, target) = (Vec3::from(self.eye), Vec3::from(self.target));
        Camera {
            eye,
            target,
            up: Vec3::Z,
            projection: Projection::Perspective { fovy_rad: self.fovy_deg.to_radians() },
            near: eye.distance(target) * 1e-3,
        }
    }

    /// Origin, spacing and radius.
    pub fn space(&self) -> SeriesSpace {
        self.source().space()
    }

    /// The particles, made anew by every call.
    pub fn read(&self) -> ParticleFrame {
        let frame = self.source().read(self.frame, &FrameRequest::default(), &Cancel::default());
        frame.expect("a frame of a valid case").sets.swap_remove(0).particles
    }

    /// The case as a series in memory.
    pub fn source(&self) -> CaseSource {
        let options = CaseOptions { particles: self.particles, ..CaseOptions::published(self.case) };
        CaseSource::new(self.case, options).expect("valid options")
    }

    /// The positions in the order of cells of some eight spacings, neighbours together, as level of detail would hand them to
    /// the splats.
    pub fn ordered_positions(&self) -> Vec<[f32; 3]> {
        ordered(self.read().positions, 8.0 * self.space().spacing as f32)
    }
}

/// `positions` in the order of cells of this size, neighbours together.
pub fn ordered(mut positions: Vec<[f32; 3]>, cell_world: f32) -> Vec<[f32; 3]> {
    positions.sort_by_cached_key(|&p| morton(p, cell_world));
    positions
}

/// Place of a position's cell on the z-order curve.
fn morton(position: [f32; 3], cell_world: f32) -> u64 {
    let spread = |coordinate: f32| {
        // Cells count from far outside of the data: 2^20 is more than a fjord has.
        let cell = ((coordinate / cell_world).floor() as i64 + (1 << 20)) as u64;
        (0..21).fold(0, |bits, i| bits | (cell >> i & 1) << (3 * i))
    };
    position.into_iter().enumerate().fold(0, |key, (axis, c)| key | spread(c) << axis)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// A file that nobody measures, or one that is measured under another name, would go unnoticed.
    #[test]
    fn every_file_is_a_view_of_its_name() {
        let folder = std::fs::read_dir(env!("CARGO_MANIFEST_DIR")).unwrap();
        let paths = folder.map(|entry| entry.unwrap().path());
        let names = paths
            .filter(|path| path.extension().is_some_and(|e| e == "toml") && !path.ends_with("Cargo.toml"))
            .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned());
        let files: BTreeSet<String> = names.collect();
        assert_eq!(files, View::all().map(|view| view.name).into());
    }

    /// What the files say of themselves holds, and is enough.
    #[test]
    fn views_are_as_they_say() {
        for view in View::all() {
            let camera = view.camera();
            camera.validate().unwrap();
            let px_per_world = camera.px_per_world(view.size, camera.eye.distance(camera.target));
            let radius_px = view.space().radius as f32 * px_per_world;
            assert!((radius_px - view.radius_px).abs() < 0.006, "{}: radius {radius_px} px", view.name);

            // An eighth of the particles, twice as far apart, covers the same but for a rim.
            let distance = View { particles: view.particles / 8, ..view.clone() }.splat();
            let covered = distance.iter().filter(|d| **d < f32::MAX).count() as f32 / distance.len() as f32;
            assert!((covered - view.covered_fraction).abs() < 0.02, "{}: covered {covered}", view.name);
            assert!(view.covered_fraction >= 0.4, "{}", view.name);
        }
    }
}
