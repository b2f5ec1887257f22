use meniscus_core::CameraError;

/// Why no selection can be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LodError {
    /// The threshold is NaN or outside 0..=1.
    #[error(
        "level of detail threshold is {0}, expected a number from 0 (nothing) to 1 (everything); change --lod"
    )]
    Threshold(f32),
    /// Another parameter is out of range.
    #[error("lod.{name} is {found}, expected {expected}; change --param lod.{name}")]
    Parameter {
        /// Which one.
        name: &'static str,
        /// As given.
        found: f32,
        /// The range in words.
        expected: &'static str,
    },
    /// The spacing is not a positive length.
    #[error("particle spacing is {0}, expected a positive length in world units; change --spacing")]
    Spacing(f32),
    /// The drawn radius is not a positive length.
    #[error("drawn radius is {0}, expected a positive length in world units; change --radius")]
    Radius(f32),
    /// The picture has no pixel.
    #[error("picture size is {}x{}, expected at least 1x1 pixels; change --size", .0[0], .0[1])]
    EmptyPicture([u32; 2]),
    /// The camera defines no picture.
    #[error(transparent)]
    Camera(#[from] CameraError),
}
