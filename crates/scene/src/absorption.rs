/// Absorption of pure water in 1/m for red, green and blue light (Pope & Fry 1997, averaged over the bands of Rec. 709
/// primaries; `algorithms.md` 10).
pub const PURE_WATER_PER_METRE: [f32; 3] = [0.45, 0.07, 0.02];

/// Absorption coefficients: transmittance over a path `L` is `exp(-per_world * L)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Absorption {
    /// Red, green and blue, 1/world unit, >= 0.
    pub per_world: [f32; 3],
}

impl Absorption {
    /// Optical depth per channel of the representative column under [`Self::auto`]: pure water's order of colours with its
    /// ratio of 22 between red and blue narrowed, so that long paths turn blue-green instead of pure blue.
    pub const OPTICAL_DEPTH: [f32; 3] = [1.18, 0.28, 0.17];

    /// Clear water in which the representative column `depth_world` (e.g. the vertical extent of the water, world units)
    /// transmits `exp(-OPTICAL_DEPTH)`. A depth that is not a positive number gives water without absorption.
    pub fn auto(depth_world: f32) -> Self {
        let usable = depth_world.is_normal() && depth_world > 0.0;
        let per_depth = if usable { depth_world.recip() } else { 0.0 };
        Self { per_world: Self::OPTICAL_DEPTH.map(|tau| tau * per_depth) }
    }

    /// Pure water, for data whose unit is known and large enough to show its colour.
    pub fn pure_water(metres_per_world: f32) -> Self {
        Self { per_world: PURE_WATER_PER_METRE.map(|k| k * metres_per_world) }
    }

    /// Transmittance over `length_world` (Beer-Lambert).
    pub fn transmittance(&self, length_world: f32) -> [f32; 3] {
        self.per_world.map(|k| (-k * length_world).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_representative_column_still_transmits_in_any_unit() {
        for depth in [1e-3, 0.5, 800.0] {
            let t = Absorption::auto(depth).transmittance(depth);
            assert!(t[0] > 0.3 && t[0] < t[1] && t[1] < t[2] && t[2] < 0.9, "{t:?}");
        }
    }

    #[test]
    fn absurd_depths_do_not_absorb() {
        for depth in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-42] {
            assert_eq!(Absorption::auto(depth).per_world, [0.0; 3]);
        }
    }
}
