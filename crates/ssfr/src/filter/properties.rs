/// What a filter declares of itself. Everything declared is checked by [`conformance`](crate::conformance).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Properties {
    /// Planes of any tilt stay what they are under perspective, up to the picture's border.
    pub exact_on_tilted_planes_perspective: bool,
    /// The same in parallel projection.
    pub exact_on_tilted_planes_parallel: bool,
    /// Where planes are exact, they are so up to ragged silhouettes, too.
    pub exact_up_to_silhouettes: bool,
    /// Standard deviation, in projected spacings, of the response to a small bump on a plane facing the viewer; 0 = none.
    pub nominal_sigma: Option<f32>,
    /// Depth, in drawn radii, beyond which what lies in front or behind is another surface and is not mixed in.
    pub range_radii: Option<f32>,
    /// In close-ups, where taps are pixels apart, nothing is left that repeats from pixel to pixel: mirrors show a ten-thousandth of a
    /// particle's depth. Asked of sigmas of 0.8 to 1.5 spacings.
    pub even_in_close_ups: bool,
}

impl Properties {
    /// Exact on tilted planes in both projections, and nothing else.
    pub fn exact_on_tilted_planes() -> Self {
        Self {
            exact_on_tilted_planes_perspective: true,
            exact_on_tilted_planes_parallel: true,
            ..Default::default()
        }
    }
}
