//! Procedural patterns.

use glam::Vec2;

const PATTERN_TILES: u32 = 1;
const PATTERN_CONCRETE: u32 = 2;
const PATTERN_SOIL: u32 = 3;

fn cell_hash(cell: Vec2) -> f32 {
    let c = cell.clamp(Vec2::splat(-1e6), Vec2::splat(1e6));
    let mut h = (c.x as i32 as u32).wrapping_mul(0x9e37_79b1) ^ (c.y as i32 as u32).wrapping_mul(0x85eb_ca77);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^= h >> 15;
    (h >> 8) as f32 * 5.960_464_5e-8
}

fn noise(p: Vec2, footprint: f32) -> f32 {
    let fade = (1.5 - 2.0 * footprint).clamp(0.0, 1.0);
    if fade == 0.0 {
        return 0.0;
    }
    let cell = p.floor();
    let f = p - cell;
    let u = f * f * (3.0 - 2.0 * f);
    let mix = |a: f32, b: f32, t: f32| a * (1.0 - t) + b * t;
    let bottom = mix(cell_hash(cell), cell_hash(cell + Vec2::X), u.x);
    let top = mix(cell_hash(cell + Vec2::Y), cell_hash(cell + Vec2::ONE), u.x);
    fade * (2.0 * mix(bottom, top, u.y) - 1.0)
}

fn joint_coverage(x: f32, footprint: f32, half_width: f32) -> f32 {
    let w = footprint.max(1e-4);
    let lo = x - 0.5 * w + half_width;
    let hi = x + 0.5 * w + half_width;
    let within = |x: f32| x.floor() + ((x - x.floor()) / (2.0 * half_width)).min(1.0);
    ((within(hi) - within(lo)) * 2.0 * half_width / w).clamp(0.0, 1.0)
}

fn joints(p: Vec2, footprint: Vec2, half_width: f32) -> f32 {
    let x = joint_coverage(p.x, footprint.x, half_width);
    let y = joint_coverage(p.y, footprint.y, half_width);
    1.0 - (1.0 - x) * (1.0 - y)
}

/// Factor on the base colour at pattern coordinates `p`, over a pixel's footprint in the same coordinates.
pub(crate) fn pattern_tone(pattern: u32, p: Vec2, footprint: Vec2) -> f32 {
    let wide = footprint.max_element();
    match pattern {
        PATTERN_TILES => {
            let joint = joints(p, footprint, 0.012);
            let tone = (cell_hash(p.floor()) - 0.5) * (1.25 - wide).clamp(0.0, 1.0);
            let cloud = noise(p * 5.3, wide * 5.3);
            (1.0 + 0.09 * tone + 0.035 * cloud) * (1.0 - 0.48 * joint)
        }
        PATTERN_CONCRETE => {
            let joint = joints(p, footprint, 0.006);
            let cloud = noise(p * 2.7, wide * 2.7) + 0.5 * noise(p * 6.9 + 17.0, wide * 6.9);
            let pores = noise(p * 61.0, wide * 61.0);
            (1.0 + 0.09 * cloud + 0.05 * pores) * (1.0 - 0.4 * joint)
        }
        PATTERN_SOIL => {
            let coarse = noise(p * 3.1, wide * 3.1);
            let middle = noise(p * 11.0 + 5.0, wide * 11.0);
            let fine = noise(p * 47.0, wide * 47.0);
            1.0 + 0.14 * coarse + 0.12 * middle + 0.12 * fine
        }
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_keep_their_mean_under_any_footprint() {
        let share = |footprint: f32| {
            let samples = 1000;
            let sum: f32 = (0..samples)
                .map(|i| joint_coverage(-2.0 + 5.0 * i as f32 / samples as f32, footprint, 0.02))
                .sum();
            sum / samples as f32
        };
        for footprint in [1e-6, 0.01, 0.3, 1.0, 7.5] {
            // 0.002: a thousand samples of lines a fiftieth wide.
            assert!((share(footprint) - 0.04).abs() < 0.002, "{footprint}: {}", share(footprint));
        }
    }

    #[test]
    fn patterns_fade_to_an_even_tone_at_the_horizon() {
        for pattern in [PATTERN_TILES, PATTERN_CONCRETE, PATTERN_SOIL] {
            let tones =
                (0..100).map(|i| pattern_tone(pattern, Vec2::new(i as f32 * 0.77, 3.3), Vec2::splat(40.0)));
            let (lo, hi) = tones.fold((f32::MAX, f32::MIN), |(lo, hi), t| (lo.min(t), hi.max(t)));
            // A fortieth of the joints' contrast: the box filter's own ripple.
            assert!(hi - lo < 0.015 && lo > 0.5, "pattern {pattern}: {lo} to {hi}");
        }
    }
}
