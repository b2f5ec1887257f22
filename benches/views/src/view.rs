use glam::Vec3;
use meniscus_cases::{Case, CaseOptions, CaseSource};
use meniscus_core::{Camera, Cancel, FrameRequest, FrameSource, ParticleFrame, Projection, SeriesSpace};

/// A case at a moment, seen by a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Name in reports.
    pub name: &'static str,
    /// Why this view is measured.
    pub why: &'static str,
    /// The particles.
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

/// The collapsing column of the published dam break.
pub const DAM_BREAK: View = View {
    name: "dam-break",
    why: "a million particles in one body of water, the size users have; the yardstick of the speed goals",
    case: Case::DamBreak,
    particles: 1_131_712,
    frame: 20,
    size: [1280, 720],
    eye: [4.2, -2.2, 1.9],
    target: [1.4, 0.5, 0.15],
    fovy_deg: 20.0,
    radius_px: 2.52,
    covered_fraction: 0.45,
};

/// The sphere's cavity at full HD.
pub const SPHERE_ENTRY: View = View {
    name: "sphere-entry",
    why: "fewer, larger splats and more pixels: cost per pixel rather than per particle",
    case: Case::SphereEntry,
    particles: 459_472,
    frame: 40,
    size: [1920, 1080],
    eye: [0.75, -0.6, 0.75],
    target: [0.15, 0.25, 0.23],
    fovy_deg: 26.0,
    radius_px: 6.38,
    covered_fraction: 0.47,
};

/// A stretch of the fjord from the air.
pub const FJORD: View = View {
    name: "fjord-tsunami",
    why: "18 million particles, most of them outside of the picture or smaller than a pixel: culling and tiny splats",
    case: Case::FjordTsunami,
    particles: 17_988_089,
    frame: 30,
    size: [1280, 720],
    eye: [0.0, -1500.0, 900.0],
    target: [0.0, 0.0, 0.0],
    fovy_deg: 32.0,
    radius_px: 1.48,
    covered_fraction: 0.41,
};

impl View {
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
        let cell_world = 8.0 * self.space().spacing as f32;
        let mut positions = self.read().positions;
        positions.sort_by_cached_key(|&p| morton(p, cell_world));
        positions
    }
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
    use super::*;

    /// What the constants say of themselves holds, and is enough.
    #[test]
    fn views_are_as_they_say() {
        for view in [DAM_BREAK, SPHERE_ENTRY, FJORD] {
            let camera = view.camera();
            camera.validate().unwrap();
            let px_per_world = camera.px_per_world(view.size, camera.eye.distance(camera.target));
            let radius_px = view.space().radius as f32 * px_per_world;
            assert!((radius_px - view.radius_px).abs() < 0.006, "{}: radius {radius_px} px", view.name);

            // An eighth of the particles, twice as far apart, covers the same but for a rim.
            let distance = View { particles: view.particles / 8, ..view }.splat();
            let covered = distance.iter().filter(|d| **d < f32::MAX).count() as f32 / distance.len() as f32;
            assert!((covered - view.covered_fraction).abs() < 0.02, "{}: covered {covered}", view.name);
            assert!(view.covered_fraction >= 0.4, "{}", view.name);
        }
    }
}
