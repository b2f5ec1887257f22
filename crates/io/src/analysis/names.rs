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
/// Kinds of particles, for [`is_kind`]; those that mean kinds most likely come first.
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
    "parttype",
    "fluid",
    "isfluid",
    "boundary",
    "isboundary",
    "body",
    "zone",
    "label",
    "object",
    "obj",
];

/// Whether `name` is one of [`KIND`], `kind`, however it is spelt: `Material_ID`, `matId`, `is_boundary`. Not `pid`, which mostly is
/// the process that computed a particle: one whose water stands still would be taken for walls.
pub(crate) fn is_kind(name: &str, kind: &str) -> bool {
    let bare: String =
        name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
    bare == kind || bare.strip_suffix("id") == Some(kind)
}

/// The first attribute with `components` numbers whose name is in `names`; earlier names win.
pub(crate) fn find<'a>(frame: &'a FrameData, names: &[&str], components: usize) -> Option<&'a AttributeInfo> {
    names.iter().find_map(|name| {
        frame.attributes().iter().find(|a| a.components == components && a.name.eq_ignore_ascii_case(name))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_recognised_however_they_are_spelt() {
        let is_any = |name: &str| KIND.iter().any(|kind| is_kind(name, kind));
        for name in ["type", "Mk", "Material_ID", "matId", "is_boundary", "isFluid", "object-id"] {
            assert!(is_any(name), "{name}");
        }
        for name in ["pid", "p", "id", "ids", "pressure", "rank", "fluidity"] {
            assert!(!is_any(name), "{name}");
        }
    }
}
