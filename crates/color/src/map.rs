use std::fmt;
use std::str::FromStr;

use glam::{Mat3, Vec3};
use meniscus_core::srgb;

use crate::ColorError;

/// A perceptual colour map: from 0 to 1, colours that are told apart equally well all along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorMap {
    /// Blue, green, yellow (van der Walt & Smith, matplotlib).
    #[default]
    Viridis,
    /// Black, purple, orange, yellow.
    Inferno,
    /// Blue, magenta, yellow.
    Plasma,
    /// Black, purple, flesh.
    Magma,
    /// Blue to yellow, the same for those who are red-green blind (Nuñez, Anderton & Renslow 2018).
    Cividis,
    /// All hues, for fine differences (Mikhailov 2019).
    Turbo,
    /// Blue, grey, red, for what has a middle (Moreland 2009); ParaView's default.
    CoolToWarm,
    /// Black to white.
    Grayscale,
}

/// Names that are printed; what users type may be in any case, with blanks, and end in "(matplotlib)" as ParaView's do.
const NAMES: [(&str, ColorMap); 8] = [
    ("viridis", ColorMap::Viridis),
    ("inferno", ColorMap::Inferno),
    ("plasma", ColorMap::Plasma),
    ("magma", ColorMap::Magma),
    ("cividis", ColorMap::Cividis),
    ("turbo", ColorMap::Turbo),
    ("cool-to-warm", ColorMap::CoolToWarm),
    ("grayscale", ColorMap::Grayscale),
];

impl ColorMap {
    /// Linear Rec. 709 colour at `t`, which is brought into 0..=1; NaN counts as 0.
    pub fn linear(self, t: f64) -> Vec3 {
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let gradient = match self {
            Self::Viridis => colorous::VIRIDIS,
            Self::Inferno => colorous::INFERNO,
            Self::Plasma => colorous::PLASMA,
            Self::Magma => colorous::MAGMA,
            Self::Cividis => colorous::CIVIDIS,
            Self::Turbo => colorous::TURBO,
            Self::CoolToWarm => return cool_to_warm(t as f32),
            // Even steps of lightness, not of light.
            Self::Grayscale => return Vec3::splat(lightness_to_light(t as f32)),
        };
        let color = gradient.eval_continuous(t);
        Vec3::from([color.r, color.g, color.b].map(|c| srgb::decode(f32::from(c) / 255.0)))
    }

    /// The same as it is displayed, sRGB, 0 to 1.
    pub fn srgb(self, t: f64) -> Vec3 {
        self.linear(t).map(srgb::encode)
    }

    /// The name that is printed.
    pub fn name(self) -> &'static str {
        NAMES.iter().find(|(_, map)| *map == self).map_or("", |(name, _)| name)
    }
}

impl fmt::Display for ColorMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ColorMap {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, ColorError> {
        let bare = |text: &str| -> String {
            text.chars().filter(|c| c.is_ascii_alphanumeric()).map(|c| c.to_ascii_lowercase()).collect()
        };
        let wanted = bare(text.trim().trim_end_matches("(matplotlib)"));
        NAMES.iter().find(|(name, _)| bare(name) == wanted).map(|(_, map)| *map).ok_or_else(|| {
            let names: Vec<&str> = NAMES.iter().map(|(name, _)| *name).collect();
            ColorError::UnknownMap { found: text.to_owned(), available: names.join(", ") }
        })
    }
}

/// CIE L* / 100 to luminance.
fn lightness_to_light(lightness: f32) -> f32 {
    let f = (100.0 * lightness + 16.0) / 116.0;
    if f > 6.0 / 29.0 { f * f * f } else { (f - 4.0 / 29.0) * 3.0 * (6.0_f32 / 29.0).powi(2) }
}

/// Moreland, "Diverging Color Maps for Scientific Visualization" (2009): straight ways in Msh, a polar form of CIELAB, from a blue
/// and a red to the same grey, whose hue is set so that no other hue comes in between.
fn cool_to_warm(t: f32) -> Vec3 {
    const BLUE: Vec3 = Vec3::new(80.0, 1.08, -1.1);
    const RED: Vec3 = Vec3::new(80.0, 1.08, 0.5);
    let (end, grey_hue, share) = if t < 0.5 { (BLUE, -1.661, 2.0 * t) } else { (RED, 1.061, 2.0 - 2.0 * t) };
    let [m, s, h] = end.lerp(Vec3::new(88.0, 0.0, grey_hue), share).to_array();
    let [l, a, b] = [m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()];
    let y = (l + 16.0) / 116.0;
    let white = Vec3::new(0.9505, 1.0, 1.089);
    let xyz = white
        * Vec3::new(y + a / 500.0, y, y - b / 200.0).map(|f| lightness_to_light((116.0 * f - 16.0) / 100.0));
    let rgb_from_xyz = Mat3::from_cols(
        Vec3::new(3.2406, -0.9689, 0.0557),
        Vec3::new(-1.5372, 1.8758, -0.2040),
        Vec3::new(-0.4986, 0.0415, 1.0570),
    );
    (rgb_from_xyz * xyz).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_have_their_published_colours() {
        for (map, t, expected) in [
            (ColorMap::Viridis, 0.0, [68, 1, 84]),
            (ColorMap::Viridis, 1.0, [253, 231, 37]),
            (ColorMap::Inferno, 0.0, [0, 0, 4]),
            (ColorMap::CoolToWarm, 0.0, [59, 76, 192]),
            (ColorMap::CoolToWarm, 0.5, [221, 221, 221]),
            (ColorMap::CoolToWarm, 1.0, [180, 4, 38]),
            (ColorMap::Grayscale, 0.5, [119, 119, 119]),
        ] {
            let found = map.srgb(t).to_array().map(|c| (255.0 * c).round() as i32);
            // 1: the papers round, and so does the library.
            let off = std::iter::zip(found, expected).map(|(a, b)| (a - b).abs()).max();
            assert!(off <= Some(1), "{map} at {t}: {found:?} instead of {expected:?}");
        }
        assert_eq!(ColorMap::Turbo.linear(f64::NAN), ColorMap::Turbo.linear(-3.0));
    }

    #[test]
    fn one_colour_maps_rise_in_lightness_all_along() {
        for map in
            [ColorMap::Viridis, ColorMap::Inferno, ColorMap::Plasma, ColorMap::Magma, ColorMap::Grayscale]
        {
            let light = |i: u32| map.linear(f64::from(i) / 64.0).dot(Vec3::new(0.2126, 0.7152, 0.0722));
            assert!((1..=64).all(|i| light(i) > light(i - 1)), "{map}");
        }
    }

    #[test]
    fn names_are_those_of_paraview_too() {
        for (text, map) in [
            ("viridis", ColorMap::Viridis),
            ("Viridis (matplotlib)", ColorMap::Viridis),
            ("Cool to Warm", ColorMap::CoolToWarm),
            ("Turbo", ColorMap::Turbo),
        ] {
            assert_eq!(text.parse::<ColorMap>().unwrap(), map);
            assert_eq!(map.name().parse::<ColorMap>().unwrap(), map);
        }
        let error = "rainbow".parse::<ColorMap>().unwrap_err().to_string();
        assert!(error.contains("rainbow") && error.contains("cool-to-warm"), "{error}");
    }
}
