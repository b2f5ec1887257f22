//! What is looked at: a frame of particles, seen as `meniscus render` would see it.

use std::error::Error;
use std::path::Path;

use meniscus_cases::{Case, CaseOptions, CaseSource};
use meniscus_core::{Camera, Cancel, FrameSource, SeriesSpace, SetFrame};
use meniscus_io::{Series, SeriesOptions};
use meniscus_pipeline::{Settings, World};
use meniscus_scene::{above_ground, automatic_camera};

/// The picture's size in pixels.
pub const SIZE: [u32; 2] = [1280, 720];

/// Where particles come from.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// Of tables.
    pub name: &'static str,
    data: Data,
    frame: usize,
}

#[derive(Clone, Copy, Debug)]
enum Data {
    /// A series in the folder of third-party data, and which of its particles are water.
    Series { path: &'static str, water: Option<&'static str> },
    /// Made, with about as many particles.
    Made { case: Case, particles: u64 },
}

/// Simulated twice by others' codes, and made: what the shape of a cavity, of a breaking wave and of a jet with its crown ask for.
pub const SUBJECTS: [Subject; 3] = [
    Subject {
        name: "sphere_entry, frame 10",
        data: Data::Series { path: "sphere_entry/fluid.pvd", water: None },
        frame: 10,
    },
    Subject {
        name: "PySPH dam break, frame 4",
        data: Data::Series { path: "pysph_dam_break/dam.pvd", water: Some("type == 0") },
        frame: 4,
    },
    Subject {
        name: "made dam break, frame 30",
        data: Data::Made { case: Case::DamBreak, particles: 200_000 },
        frame: 30,
    },
];

/// A subject, read, and the view of it.
pub struct View {
    pub particles: SetFrame,
    pub world: World,
    pub camera: Camera,
}

impl Subject {
    /// Reads the frame and places the camera, `None` where the data are not there: `data` is their folder.
    ///
    /// # Errors
    /// The reader's, or a series that is not water of equal particles alone.
    pub fn open(&self, data: &Path, settings: &Settings) -> Result<Option<View>, Box<dyn Error>> {
        let (source, space): (Box<dyn FrameSource>, SeriesSpace) = match self.data {
            Data::Series { path, water } => {
                let path = data.join(path);
                if !path.is_file() {
                    return Ok(None);
                }
                let options = SeriesOptions { where_expr: water.map(str::to_owned), ..Default::default() };
                let series = Series::open(&path, &options)?;
                let space = *series.space();
                (Box::new(series), space)
            }
            Data::Made { case, particles } => {
                let options = CaseOptions { particles, ..CaseOptions::published(case) };
                let source = CaseSource::new(case, options)?;
                let space = source.space();
                (Box::new(source), space)
            }
        };
        let world = World::of_series(&*source, space, settings)?;
        let particles = source.read(self.frame, world.request(), &Cancel::default())?;
        if particles.sets.len() != 1 || !particles.sets[0].particles.sizes.is_empty() {
            return Err(format!("{}: expected one set of equal particles", self.name).into());
        }
        let camera = above_ground(automatic_camera(world.outline(), space.up, SIZE), space.up);
        Ok(Some(View { particles, world, camera }))
    }
}

impl View {
    /// Turns the camera around its target until the eye stands at `elevation_rad` above the horizon.
    pub fn look_from(&mut self, elevation_rad: f32) {
        let camera = &mut self.camera;
        let (up, away) = (camera.up.normalize(), camera.eye - camera.target);
        let level = away.reject_from_normalized(up).normalize_or(up.any_orthonormal_vector());
        let (sin, cos) = elevation_rad.sin_cos();
        camera.eye = camera.target + away.length() * (cos * level + sin * up);
    }

    /// Of all particles, world.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.particles.sets[0].particles.positions
    }

    /// Half the spacing, world: the radius that distances are told in. What is drawn is larger.
    pub fn particle_radius(&self) -> f64 {
        self.world.space().spacing / 2.0
    }
}
