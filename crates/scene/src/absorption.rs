/// Absorption of pure water in 1/m for red, green and blue light (Pope & Fry 1997, averaged over the bands of Rec. 709
/// primaries; `algorithms.md` 10).
pub const PURE_WATER_PER_METRE: [f32; 3] = [0.45, 0.07, 0.02];

/// Optical depth for red, green and blue light that a representative column of water gets where its unit is not known: it
/// transmits `exp(-CLEAR_WATER_OPTICAL_DEPTH)`. Pure water's order of colours with its ratio of 22 between red and blue
/// narrowed, so that long paths turn blue-green instead of pure blue.
pub const CLEAR_WATER_OPTICAL_DEPTH: [f32; 3] = [1.45, 0.32, 0.17];
