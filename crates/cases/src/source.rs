use glam::DVec3;
use meniscus_core::{
    Attribute, Cancel, DEFAULT_RADIUS_PER_SPACING, Flaws, FrameError, FrameErrorKind, FrameRequest,
    FrameSource, Look, ParticleFrame, ParticleSet, RadiusChoice, SeriesSpace, SetFrame, SpacingSource,
};

use crate::case::CaseFlow;
use crate::{Case, CaseError, CaseFrame, CaseOptions};

/// A case as a series in memory: one `water` set, frames made when they are read.
///
/// Attributes on request: `velocity` (3 components, m/s), `density` (kg/m^3), `pressure` (Pa).
pub struct CaseSource {
    case: Case,
    options: CaseOptions,
    flow: CaseFlow,
    space: SeriesSpace,
}

impl CaseSource {
    /// Lays the particles out.
    ///
    /// # Errors
    /// [`CaseError`] when `options` are out of range.
    pub fn new(case: Case, options: CaseOptions) -> Result<Self, CaseError> {
        options.validate()?;
        let spacing = case.spacing(&options);
        let origin = match case {
            Case::SphereEntry | Case::DamBreak => DVec3::ZERO,
            Case::FjordTsunami => DVec3::new(500_000.0, 3_400_000.0, 175.0),
        };
        let space = SeriesSpace {
            origin,
            spacing,
            spacing_source: SpacingSource::User,
            radius: spacing * DEFAULT_RADIUS_PER_SPACING,
            radius_choice: RadiusChoice::FromSpacing,
            up: case.up(),
            metres_per_unit: 1.0,
        };
        Ok(Self { case, options, flow: CaseFlow::new(case, &options), space })
    }

    /// Origin, spacing, radius and up axis of the series; the spacing is the one it was made with.
    pub fn space(&self) -> SeriesSpace {
        self.space
    }

    /// Frame `index` in double precision with all arrays, as a file would hold it.
    ///
    /// # Errors
    /// [`FrameErrorKind::Usage`] when there is no such frame, [`FrameErrorKind::Cancelled`] on request.
    pub fn case_frame(&self, index: usize, cancel: &Cancel) -> Result<CaseFrame, FrameError> {
        if index >= self.options.frames {
            return Err(error(
                FrameErrorKind::Usage,
                format!("frame {index} of {}: this case has {} frames", self.case, self.options.frames),
            ));
        }
        let frame = self.flow.frame(self.case, &self.options, index, cancel);
        if cancel.is_cancelled() {
            return Err(error(FrameErrorKind::Cancelled, format!("frame {index} was cancelled")));
        }
        Ok(frame)
    }
}

impl FrameSource for CaseSource {
    fn frame_count(&self) -> usize {
        self.options.frames
    }

    fn time(&self, index: usize) -> Option<f64> {
        (index < self.options.frames).then(|| self.case.time(&self.options, index))
    }

    fn estimated_bytes(&self, _index: usize) -> u64 {
        self.options.particles * (12 + 8)
    }

    fn read(&self, index: usize, request: &FrameRequest, cancel: &Cancel) -> Result<SetFrame, FrameError> {
        if let Some(unknown) = request.attributes.iter().find(|name| !ATTRIBUTES.contains(&name.as_str())) {
            return Err(error(
                FrameErrorKind::Usage,
                format!("no attribute '{unknown}': {} has {}", self.case, ATTRIBUTES.join(", ")),
            ));
        }
        let frame = self.case_frame(index, cancel)?;
        let attributes = request.attributes.iter().map(|name| attribute(&frame, name)).collect();
        let origin = self.space.origin;
        let particles = ParticleFrame {
            positions: frame
                .positions
                .iter()
                .map(|&position| (DVec3::from(position) - origin).as_vec3().to_array())
                .collect(),
            ids: frame.ids.iter().map(|&id| id as u64).collect(),
            attributes,
            ..Default::default()
        };
        Ok(SetFrame {
            index,
            time: Some(frame.time),
            files: Vec::new(),
            origin,
            sets: vec![ParticleSet { name: "water".to_owned(), look: Look::Water, particles }],
            flaws: Flaws::default(),
            read: None,
        })
    }
}

const ATTRIBUTES: [&str; 3] = ["velocity", "density", "pressure"];

fn attribute(frame: &CaseFrame, name: &str) -> Attribute {
    let (components, values) = match name {
        "velocity" => (3, frame.velocities.as_flattened().to_vec()),
        "density" => (1, frame.density.clone()),
        _ => (1, frame.pressure.clone()),
    };
    Attribute { name: name.to_owned(), components, values }
}

fn error(kind: FrameErrorKind, message: String) -> FrameError {
    FrameError { kind, file: None, message }
}
