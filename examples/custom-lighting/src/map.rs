/// Colours of a map.
pub const STOPS: usize = 9;

/// The colour map viridis (Smith and van der Walt 2015, CC0) at equal steps, sRGB: perceptually even, readable in grey and
/// with the common deficiencies of colour vision.
pub const VIRIDIS: [[u8; 3]; STOPS] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2d, 0x7b],
    [0x3b, 0x52, 0x8b],
    [0x2c, 0x72, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x28, 0xae, 0x80],
    [0x5e, 0xc9, 0x62],
    [0xad, 0xdc, 0x30],
    [0xfd, 0xe7, 0x25],
];

/// `VIRIDIS` as linear radiance, deep water dark; the fourth component pads.
pub(crate) fn linear_map() -> [[f32; 4]; STOPS] {
    let mut map = VIRIDIS.map(|color| {
        let [red, green, blue] = color.map(linear);
        [red, green, blue, 0.0]
    });
    map.reverse();
    map
}

/// Linear value of an 8-bit sRGB channel (IEC 61966-2-1).
fn linear(channel: u8) -> f32 {
    let c = f32::from(channel) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_gets_darker_with_depth() {
        let luminance = |c: &[f32; 4]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        assert!(linear_map().windows(2).all(|pair| luminance(&pair[0]) > luminance(&pair[1])));
        assert_eq!([linear(0), linear(255)], [0.0, 1.0]);
    }
}
