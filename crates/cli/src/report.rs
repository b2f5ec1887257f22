//! JSON for machines: the render report and errors.

use std::path::Path;

use glam::{DVec3, Vec3};
use meniscus_core::{Camera, Choice, Flaws, FrameReport, Projection};
use meniscus_export::{ExportError, write_text};
use meniscus_gpu::{AdapterSummary, Gpu};
use meniscus_io::Series;
use serde::Serialize;
use serde_json::json;

use crate::failure::Failure;
use crate::picture::Studio;

/// What of the device decides how a picture is made.
#[derive(Debug, Serialize)]
struct DeviceReport {
    features: Vec<String>,
    time_stamps_believed: bool,
    max_storage_buffer_binding_size: u64,
    max_buffer_size: u64,
    max_texture_dimension_2d: u32,
    max_compute_workgroups_per_dimension: u32,
}

impl DeviceReport {
    fn of(gpu: &Gpu) -> Self {
        let limits = gpu.limits();
        Self {
            features: gpu.features().iter_names().map(|(name, _)| name.to_owned()).collect(),
            time_stamps_believed: gpu.trusts_time_stamps(),
            max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size,
            max_buffer_size: limits.max_buffer_size,
            max_texture_dimension_2d: limits.max_texture_dimension_2d,
            max_compute_workgroups_per_dimension: limits.max_compute_workgroups_per_dimension,
        }
    }
}

/// The camera in the file's own coordinates.
#[derive(Debug, Serialize)]
struct CameraReport {
    eye: [f64; 3],
    target: [f64; 3],
    up: [f32; 3],
    projection: Projection,
    near: f32,
}

impl CameraReport {
    fn of(camera: &Camera, origin: DVec3) -> Self {
        let in_file = |point: Vec3| (point.as_dvec3() + origin).to_array();
        Self {
            eye: in_file(camera.eye),
            target: in_file(camera.target),
            up: camera.up.to_array(),
            projection: camera.projection,
            near: camera.near,
        }
    }
}

/// `--report`.
#[derive(Debug, Serialize)]
pub struct RenderReport {
    version: &'static str,
    adapter: AdapterSummary,
    device: DeviceReport,
    size: [u32; 2],
    camera: CameraReport,
    space: meniscus_core::SeriesSpace,
    settings: serde_json::Value,
    choices: Vec<Choice>,
    /// Of the series and of all frames.
    pub flaws: Flaws,
    frames: Vec<FrameReport>,
}

impl RenderReport {
    /// A report without frames.
    pub fn new(studio: &Studio, series: &Series) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            adapter: studio.renderer.gpu().summary().clone(),
            device: DeviceReport::of(studio.renderer.gpu()),
            size: studio.size,
            camera: CameraReport::of(&studio.camera, series.space().origin),
            space: *series.space(),
            settings: studio.renderer.settings().effective(studio.renderer.registry(), Some(&studio.world)),
            choices: studio.choices.clone(),
            flaws: studio.flaws.clone(),
            frames: Vec::new(),
        }
    }

    /// Adds a frame and its flaws.
    pub fn add(&mut self, frame: FrameReport) {
        self.flaws.merge(&frame.flaws);
        self.frames.push(frame);
    }
}

/// Writes `report` to `path`.
pub fn write(path: &Path, report: &RenderReport) -> Result<(), Failure> {
    let unwritable =
        |e: serde_json::Error| ExportError::Encode { path: path.to_owned(), message: e.to_string() };
    let text = serde_json::to_string_pretty(report).map_err(unwritable)?;
    Ok(write_text(path, &(text + "\n"))?)
}

/// What `--json` prints for an error.
pub fn error_json(failure: &Failure) -> serde_json::Value {
    json!({ "error": { "kind": failure.kind(), "message": failure.to_string(), "file": failure.file() } })
}
