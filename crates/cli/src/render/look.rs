//! From where each picture is looked at.

use std::path::Path;

use glam::DVec3;
use meniscus_core::{Camera, UpAxis};
use meniscus_export::FrameRate;
use meniscus_pipeline::World;
use meniscus_scene::{CameraPath, Clock};

use super::shots::Part;
use crate::failure::Failure;

/// One camera for all pictures, or one on its way.
pub enum Look {
    Still(Camera),
    Moving(Box<Moving>),
}

pub struct Moving {
    path: CameraPath,
    rate: FrameRate,
    range: [usize; 2],
    origin: DVec3,
    up: UpAxis,
    near: f32,
}

impl Look {
    /// `file`: a camera path for pictures of these numbers.
    pub fn open(
        still: Camera,
        file: Option<&Path>,
        world: &World,
        rate: FrameRate,
        range: [usize; 2],
    ) -> Result<Self, Failure> {
        let Some(file) = file else { return Ok(Self::Still(still)) };
        let text = std::fs::read_to_string(file)
            .map_err(|error| Failure::Usage(format!("--camera-path {}: {error}", file.display())))?;
        let path = CameraPath::from_toml(&text, &file.display().to_string())
            .map_err(|error| Failure::Usage(error.to_string()))?;
        let space = world.space();
        Ok(Self::Moving(Box::new(Moving {
            path,
            rate,
            range,
            origin: space.origin,
            up: space.up,
            near: still.near,
        })))
    }

    /// The camera of `part` of a picture.
    pub fn at(&self, part: &Part) -> Result<Camera, Failure> {
        let moment = &part.moment;
        let moving = match self {
            Self::Still(camera) => return Ok(*camera),
            Self::Moving(moving) => moving,
        };
        let [first, last] = moving.range;
        let since = (moment.number - first) as f64 + part.later;
        let at = match moving.path.clock {
            Clock::Film => since * moving.rate.seconds(1),
            Clock::Share => since / (last - first).max(1) as f64,
            Clock::Data => moment.time.ok_or_else(|| {
                Failure::Usage(
                    "--camera-path: its clock is \"data\", but the series states no times; give --dt".into(),
                )
            })?,
        };
        let camera = moving.path.camera(at, moving.origin, moving.up, moving.near);
        camera
            .validate()
            .map_err(|error| Failure::Usage(format!("--camera-path, picture {}: {error}", moment.number)))?;
        Ok(camera)
    }
}
