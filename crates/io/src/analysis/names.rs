//! Names under which particle codes write well-known quantities, in lower case.

use crate::frame_data::{AttributeInfo, FrameData};

pub(crate) const PRESSURE: &[&str] = &["pressure", "p", "press", "pres"];
pub(crate) const VELOCITY: &[&str] = &["velocity", "v", "vel", "u", "velocities"];
pub(crate) const DENSITY: &[&str] = &["density", "rho", "rhop", "dens"];
pub(crate) const MASS: &[&str] = &["mass", "m"];
pub(crate) const RADIUS: &[&str] = &["radius", "particle_radius", "particleradius", "radii", "rad", "r"];
pub(crate) const DIAMETER: &[&str] = &["diameter", "particle_diameter", "particlediameter", "diam", "d"];
pub(crate) const VOLUME: &[&str] = &["volume", "particle_volume", "particlevolume", "vol"];
pub(crate) const SMOOTHING_LENGTH: &[&str] = &["smoothing_length", "smoothinglength", "hsml", "h"];
/// Kinds of particles.
pub(crate) const KIND: &[&str] = &[
    "type",
    "mk",
    "tag",
    "phase",
    "kind",
    "group",
    "material",
    "mat",
    "ptype",
    "particletype",
    "particle_type",
    "boundary",
    "isboundary",
    "is_boundary",
    "body",
    "zone",
    "label",
];

/// The first attribute with `components` numbers whose name is in `names`; earlier names win.
pub(crate) fn find<'a>(frame: &'a FrameData, names: &[&str], components: usize) -> Option<&'a AttributeInfo> {
    names.iter().find_map(|name| {
        frame.attributes().iter().find(|a| a.components == components && a.name.eq_ignore_ascii_case(name))
    })
}
