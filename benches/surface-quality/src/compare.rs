//! How far one surface is from another.

use crate::surface::Surface;

/// Median and 95th percentile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    pub median: f64,
    pub p95: f64,
}

/// A surface against the reference, over the pixels that show both.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Angle between the normals, degrees.
    pub angle_deg: Spread,
    /// How far in front of the reference the surface lies along the view axis, and how it deviates from that.
    pub distance: Option<Distance>,
    /// Fractions of the pixels that show either: those that show only the surface, and only the reference.
    pub only_surface: f64,
    pub only_reference: f64,
}

/// Distances in particle radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Median of the signed distance, > 0 in front: where one defines a surface by spheres and the other by a density, this is a matter of
    /// definition.
    pub offset_radii: f64,
    /// What is left of the distance when the offset is taken off.
    pub spread_radii: Spread,
}

/// Compares `surface` with `reference`, a picture of the same size by the same camera; `None` where no pixel shows both.
/// `radius_world` is a particle's, half the spacing.
pub fn compare(surface: &Surface, reference: &Surface, radius_world: f64) -> Option<Comparison> {
    let pixels = 0..surface.normal.len();
    let count = |is_counted: &dyn Fn(usize) -> bool| pixels.clone().filter(|&i| is_counted(i)).count() as f64;
    let either = count(&|i| surface.covers(i) || reference.covers(i));
    let both: Vec<usize> = pixels.clone().filter(|&i| surface.covers(i) && reference.covers(i)).collect();
    let angle = |&i: &usize| {
        let (a, b) = (surface.normal[i].as_dvec3(), reference.normal[i].as_dvec3());
        // Of small angles, the cosine alone keeps no digits.
        a.cross(b).length().atan2(a.dot(b)).to_degrees()
    };
    let distance = surface.distance.as_ref().zip(reference.distance.as_ref()).and_then(|(d, reference)| {
        let in_front = |&i: &usize| f64::from(reference[i] - d[i]) / radius_world;
        let mut signed: Vec<f64> = both.iter().map(in_front).collect();
        let offset_radii = spread(&mut signed)?.median;
        let mut rest: Vec<f64> = signed.iter().map(|d| (d - offset_radii).abs()).collect();
        Some(Distance { offset_radii, spread_radii: spread(&mut rest)? })
    });
    Some(Comparison {
        angle_deg: spread(&mut both.iter().map(angle).collect::<Vec<_>>())?,
        distance,
        only_surface: count(&|i| surface.covers(i) && !reference.covers(i)) / either,
        only_reference: count(&|i| !surface.covers(i) && reference.covers(i)) / either,
    })
}

fn spread(values: &mut [f64]) -> Option<Spread> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize).copied();
    Some(Spread { median: at(0.5)?, p95: at(0.95)? })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// 100 pixels in a row: ten empty at the end, normals tilted by as many degrees as the pixel's number, each nearer by that many tenths.
    fn fan(tilted: bool) -> Surface {
        let normal = |i: usize| match (i, tilted) {
            (90.., _) => Vec3::ZERO,
            (_, false) => Vec3::Z,
            (_, true) => {
                let (sin, cos) = (i as f32).to_radians().sin_cos();
                Vec3::new(sin, 0.0, cos)
            }
        };
        let distance = |i: usize| 20.0 - if tilted { 0.1 * i as f32 } else { 0.0 };
        Surface { normal: (0..100).map(normal).collect(), distance: Some((0..100).map(distance).collect()) }
    }

    #[test]
    fn medians_and_percentiles_are_of_the_pixels_that_show_both() {
        let (mut surface, reference) = (fan(true), fan(false));
        surface.normal[0] = Vec3::ZERO;
        surface.normal[99] = Vec3::Z;
        // Pixels 1 to 89 show both; the 45th is in the middle.
        let found = compare(&surface, &reference, 0.5).unwrap();
        // Normals and distances are single precision.
        let is_near = |found: f64, expected: f64| (found - expected).abs() < 1e-4;
        assert!(is_near(found.angle_deg.median, 45.0) && is_near(found.angle_deg.p95, 85.0), "{found:?}");
        let distance = found.distance.unwrap();
        assert!(is_near(distance.offset_radii, 9.0), "{distance:?}");
        // Deviations of 0 to 8.8 radii, in steps of 0.2, each but the first twice: the 45th and the 85th.
        let Spread { median, p95 } = distance.spread_radii;
        assert!(is_near(median, 4.4) && is_near(p95, 8.4), "{distance:?}");
        assert_eq!((found.only_surface, found.only_reference), (1.0 / 91.0, 1.0 / 91.0));
    }

    #[test]
    fn surfaces_that_never_meet_are_not_compared() {
        let mut surface = fan(true);
        surface.normal.fill(Vec3::ZERO);
        assert_eq!(compare(&surface, &fan(false), 1.0), None);
        let unknown = Surface { distance: None, ..fan(true) };
        assert_eq!(compare(&unknown, &fan(false), 1.0).unwrap().distance, None);
    }
}
