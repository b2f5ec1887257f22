/// Lighting parameters of VTK's fluid mapper and ours.
pub const VTK_NAMES: [(&str, &str); 9] = [
    ("RefractiveIndex", "refractive_index"),
    ("RefractionScale", "refraction_scale"),
    ("AdditionalReflection", "additional_reflection"),
    ("AttenuationColor", "attenuation_color"),
    ("AttenuationScale", "attenuation_scale"),
    ("OpaqueColor", "color"),
    ("ParticleColorPower", "particle_color_power"),
    ("ParticleColorScale", "particle_color_scale"),
    ("DisplayMode", "display_mode"),
];

/// Our name of a parameter that VTK calls `name`.
pub(crate) fn ours(name: &str) -> Option<&'static str> {
    VTK_NAMES.iter().find_map(|(vtk, ours)| (*vtk == name).then_some(*ours))
}
