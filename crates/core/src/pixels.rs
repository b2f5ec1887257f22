/// What the pixels of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelDepth {
    /// For a display, 8 bits per channel.
    Display8,
    /// For a display, 16 bits per channel.
    Display16,
    /// Radiance as it was computed.
    Linear,
}

impl PixelDepth {
    /// In words, as an adjective of pixels.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Display8 => "8-bit",
            Self::Display16 => "16-bit",
            Self::Linear => "linear",
        }
    }
}

/// The pixels of a picture, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// sRGB, red in the lowest byte, alpha in the highest.
    Display8(Vec<u32>),
    /// sRGB; red, green, blue, alpha.
    Display16(Vec<[u16; 4]>),
    /// Linear radiance, Rec. 709 primaries; red, green, blue, and alpha by which they are not multiplied.
    Linear(Vec<[f32; 4]>),
}

/// A number per pixel beside the colours of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// `layer.channel`, e.g. `depth.Z`.
    pub name: String,
    /// Row by row from the top left.
    pub values: Vec<f32>,
}

impl Pixels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Display8(pixels) => pixels.len(),
            Self::Display16(pixels) => pixels.len(),
            Self::Linear(pixels) => pixels.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What they are.
    pub fn depth(&self) -> PixelDepth {
        match self {
            Self::Display8(_) => PixelDepth::Display8,
            Self::Display16(_) => PixelDepth::Display16,
            Self::Linear(_) => PixelDepth::Linear,
        }
    }
}
