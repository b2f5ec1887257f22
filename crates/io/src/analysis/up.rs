//! Which axis points up, from what gravity does to the data.

use meniscus_core::{Cancel, UpAxis};

use super::names;
use crate::Error;
use crate::frame_data::FrameData;
use crate::scalar::ToF32;

/// An axis and why.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Guess {
    pub axis: UpAxis,
    pub reason: String,
}

const AXES: [UpAxis; 3] = [UpAxis::X, UpAxis::Y, UpAxis::Z];

/// Smallest correlation of pressure with height that counts as hydrostatic, and its lead over the other axes.
const MIN_CORRELATION: f64 = 0.4;
const MIN_LEAD: f64 = 0.2;

/// What gravity did to the pressure or the velocity of a frame; `None` when neither tells. `sample`: indices of the
/// particles to look at.
pub(crate) fn from_attributes(
    frame: &FrameData,
    positions: &[[f32; 3]],
    sample: &[usize],
    cancel: &Cancel,
) -> Result<Option<Guess>, Error> {
    if let Some(pressure) = names::find(frame, names::PRESSURE, 1) {
        let values = frame.values_at(pressure, sample, &ToF32, cancel)?;
        if let Some(axis) = hydrostatic(positions, &values, sample) {
            let reason = format!("the attribute {:?} falls along it", pressure.name);
            return Ok(Some(Guess { axis, reason }));
        }
    }
    if let Some(velocity) = names::find(frame, names::VELOCITY, 3) {
        let values = frame.values_at(velocity, sample, &ToF32, cancel)?;
        if let Some(axis) = falling(values.as_chunks::<3>().0) {
            let reason = format!("the attribute {:?} points down it on average", velocity.name);
            return Ok(Some(Guess { axis, reason }));
        }
        if let Some(axis) = in_flight(positions, values.as_chunks::<3>().0, sample) {
            let reason = format!("the attribute {:?} changes along it as in free fall", velocity.name);
            return Ok(Some(Guess { axis, reason }));
        }
    }
    Ok(None)
}

/// The axis along which the pressure, of the particles `sample`, falls.
fn hydrostatic(positions: &[[f32; 3]], pressure: &[f32], sample: &[usize]) -> Option<UpAxis> {
    let correlation: [f64; 3] = std::array::from_fn(|axis| {
        let rows = std::iter::zip(sample, pressure)
            .map(|(&i, pressure)| (f64::from(positions[i][axis]), f64::from(*pressure)));
        Pair::of(rows).correlation()
    });
    let best = (0..3).min_by(|&a, &b| correlation[a].total_cmp(&correlation[b]))?;
    let runner_up =
        (0..3).filter(|&axis| axis != best).map(|axis| correlation[axis].abs()).fold(0.0, f64::max);
    let clear = correlation[best] < -MIN_CORRELATION && -correlation[best] > runner_up + MIN_LEAD;
    clear.then_some(AXES[best])
}

/// Two quantities of many particles.
struct Pair {
    means: [f64; 2],
    deviations: [f64; 2],
    covariance: f64,
}

impl Pair {
    /// Of `rows` whose values are finite.
    fn of(rows: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let rows = rows.filter(|(a, b)| a.is_finite() && b.is_finite());
        let count = rows.clone().count() as f64;
        let means = rows.clone().fold([0.0; 2], |[p, q], (a, b)| [p + a / count, q + b / count]);
        let sums = rows.fold([0.0; 3], |[aa, bb, ab], (a, b)| {
            let (a, b) = (a - means[0], b - means[1]);
            [aa + a * a, bb + b * b, ab + a * b]
        });
        // Fewer tell nothing.
        let [a, b, covariance] = if count < 10.0 { [0.0; 3] } else { sums.map(|sum| sum / count) };
        Self { means, deviations: [a.sqrt(), b.sqrt()], covariance }
    }

    /// Zero where one of them does not vary.
    fn correlation(&self) -> f64 {
        let scale = self.deviations[0] * self.deviations[1];
        if scale > 0.0 { self.covariance / scale } else { 0.0 }
    }
}

/// Smallest correlation of height with the squared velocity along it that counts as free fall: water that spreads over a floor stays
/// below 0.97, since its velocity, not the square, grows with the way.
const MIN_FALL: f64 = 0.985;

/// How little the velocity along any other axis varies in free flight, beside that along the height.
const MAX_SIDEWAYS: f64 = 0.2;

/// The axis, y or z, along which nearly all particles fall after they were thrown: the square of the velocity along it grows with the
/// depth, by twice the gravity, and nothing changes their velocity along the others, of which one is theirs from the start. What
/// slides down a slope was at rest.
fn in_flight(positions: &[[f32; 3]], velocities: &[[f32; 3]], sample: &[usize]) -> Option<UpAxis> {
    let heights_and_speeds = |axis: usize| {
        let rows = std::iter::zip(sample, velocities);
        rows.map(move |(&i, v)| (f64::from(positions[i][axis]), f64::from(v[axis])))
    };
    let along = [0, 1, 2].map(|axis| Pair::of(heights_and_speeds(axis)));
    let falls = |&axis: &usize| {
        let varies = along[axis].deviations[1];
        let others = || (0..3).filter(|other| *other != axis).map(|other| &along[other]);
        let squares = heights_and_speeds(axis).map(|(height, v)| (height, v * v));
        others().all(|other| other.deviations[1] < MAX_SIDEWAYS * varies)
            && others().any(|other| other.means[1].abs() > varies)
            && Pair::of(squares).correlation() < -MIN_FALL
    };
    [1, 2].into_iter().find(falls).map(|axis| AXES[axis])
}

/// The axis, y or z, down which the mean velocity points clearly.
fn falling(velocities: &[[f32; 3]]) -> Option<UpAxis> {
    let rows = || velocities.iter().filter(|v| v.iter().all(|c| c.is_finite()));
    let (mut mean, mut square, mut count) = ([0.0_f64; 3], 0.0, 0.0);
    for v in rows() {
        count += 1.0;
        for axis in 0..3 {
            mean[axis] += f64::from(v[axis]);
            square += f64::from(v[axis]).powi(2);
        }
    }
    if count < 10.0 || square == 0.0 {
        return None;
    }
    let speed = (square / count).sqrt();
    let down = |axis: usize| -mean[axis] / count / speed;
    // Water that falls or collapses moves mostly down; sloshing and drift along the walls leave less than half in any axis.
    let sideways = |axis: usize| {
        (0..3).filter(|&other| other != axis).map(|other| down(other).abs()).fold(0.0, f64::max)
    };
    [1, 2]
        .into_iter()
        .find(|&axis| down(axis) > 0.6 && down(axis) > 1.5 * sideways(axis))
        .map(|axis| AXES[axis])
}

/// Share of the sampled particles at either end of an axis that says nothing of the shape: a few that leaked through the bottom.
const FEW: f64 = 2e-3;

/// The axis, y or z, with a flat bottom and a ragged top; else the one with the smaller extent, of the particles `sample`, which are finite.
pub(crate) fn from_shape(
    positions: &[[f32; 3]],
    sample: &[usize],
    spacing: f32,
    flat_axis: Option<usize>,
) -> Guess {
    match flat_axis {
        Some(2) => return Guess { axis: UpAxis::Y, reason: "the data is flat along z".into() },
        Some(1) => return Guess { axis: UpAxis::Z, reason: "the data is flat along y".into() },
        _ => {}
    }
    let [y, z] = [1, 2].map(|axis| Profile::new(sample.iter().map(|&i| positions[i][axis]), spacing));
    // A bottom layer with several times the particles of the top one, and clearly more so than along the other axis.
    let (by_y, by_z) = (y.bottom_to_top, z.bottom_to_top);
    if by_y.max(by_z) > 2.0 && (by_y / by_z).max(by_z / by_y) > 1.5 {
        let axis = if by_y > by_z { UpAxis::Y } else { UpAxis::Z };
        return Guess { axis, reason: "the lowest layer along it is full, the highest is not".into() };
    }
    if y.extent < 0.8 * z.extent {
        return Guess {
            axis: UpAxis::Y,
            reason: "a guess: the extent along it is smaller than along z".into(),
        };
    }
    let reason = if z.extent < 0.8 * y.extent {
        "a guess: the extent along it is smaller than along y"
    } else {
        "a guess: nothing in the data tells"
    };
    Guess { axis: UpAxis::Z, reason: reason.into() }
}

/// How particles lie along an axis.
struct Profile {
    extent: f32,
    /// Particles in the lowest layer, a spacing thick, for each in the highest.
    bottom_to_top: f32,
}

impl Profile {
    fn new(values: impl Iterator<Item = f32>, spacing: f32) -> Self {
        let mut values: Vec<f32> = values.collect();
        values.sort_unstable_by(f32::total_cmp);
        // One of fewer than a few hundred may be all of a splash.
        let few = (values.len() as f64 * FEW) as usize;
        let (Some(&low), Some(&high)) = (values.get(few), values.iter().rev().nth(few)) else {
            return Self { extent: 0.0, bottom_to_top: 1.0 };
        };
        // A spacing may be lost in the rounding of the coordinates: then fewer than those few lie beyond it.
        let bottom = values.partition_point(|v| *v < low + spacing).saturating_sub(few);
        let top = (values.len() - values.partition_point(|v| *v <= high - spacing)).saturating_sub(few);
        Self { extent: high - low, bottom_to_top: (bottom as f32 + 1.0) / (top as f32 + 1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> Vec<[f32; 3]> {
        (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|c| c as f32)).collect()
    }

    #[test]
    fn pressure_falls_upwards() {
        let points = block();
        for axis in 0..3 {
            let pressure: Vec<f32> = points.iter().map(|p| 9.0 - p[axis]).collect();
            assert_eq!(hydrostatic(&points, &pressure, &(0..1000).collect::<Vec<_>>()), Some(AXES[axis]));
            let reversed: Vec<f32> = points.iter().map(|p| p[axis]).collect();
            assert_eq!(
                hydrostatic(&points, &reversed, &(0..1000).collect::<Vec<_>>()),
                None,
                "rising pressure tells nothing"
            );
        }
        assert_eq!(hydrostatic(&points, &vec![5.0; 1000], &(0..1000).collect::<Vec<_>>()), None);
    }

    #[test]
    fn water_falls_down() {
        assert_eq!(falling(&[[0.1, 0.0, -1.0]; 20]), Some(UpAxis::Z));
        assert_eq!(falling(&[[0.1, -1.0, 0.0]; 20]), Some(UpAxis::Y));
        assert_eq!(falling(&[[-1.0, 0.0, 0.0]; 20]), None);
        assert_eq!(falling(&[[-0.5, -0.1, -0.5]; 20]), None, "drift");
        assert_eq!(falling(&[[0.0; 3]; 20]), None);
    }

    #[test]
    fn a_jet_flies_in_a_parabola() {
        // Thrown along one axis and a little upwards, seen after up to 0.6 s; a thread three hundredths thick.
        let jet = |along: usize, up: usize| -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
            (0..2000)
                .map(|i| {
                    let (t, around) = (0.6 * i as f32 / 2000.0, i as f32);
                    let (mut p, mut v) = ([0.03 * around.cos(); 3], [0.0; 3]);
                    (p[along], v[along]) = (3.0 * t, 3.0);
                    (p[up], v[up]) = (t - 4.9 * t * t + 0.03 * around.sin(), 1.0 - 9.8 * t);
                    (p, v)
                })
                .unzip()
        };
        let all: Vec<usize> = (0..2000).collect();
        for (along, up) in [(0, 2), (0, 1), (1, 2), (2, 1)] {
            let (positions, velocities) = jet(along, up);
            assert_eq!(in_flight(&positions, &velocities, &all), Some(AXES[up]), "along {along}");
            let rising: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|c| -c)).collect();
            assert_eq!(in_flight(&rising, &velocities, &all), None, "faster the higher");
        }
        // What spreads towards the low end of y, deep, so that it sinks as well, and shallow; and what slides down a slope.
        let block: Vec<[f32; 3]> =
            (0..2000).map(|i| [i % 10, i / 10 % 20, i / 200].map(|c| c as f32)).collect();
        for velocity in [
            |[_, y, z]: [f32; 3]| [9.0, y - 19.0, -z],
            |[_, y, z]: [f32; 3]| [9.0, y - 19.0, -0.1 * z],
            |[_, y, _]: [f32; 3]| [0.0, -(19.0 - y).sqrt(), -0.1 * (19.0 - y).sqrt()],
        ] {
            let velocities: Vec<[f32; 3]> = block.iter().map(|p| velocity(*p)).collect();
            assert_eq!(in_flight(&block, &velocities, &all), None);
        }
        assert_eq!(in_flight(&block, &vec![[1.0; 3]; 2000], &all), None);
    }

    #[test]
    fn shapes() {
        let from_shape = |points: &[[f32; 3]], spacing, flat| {
            from_shape(points, &(0..points.len()).collect::<Vec<_>>(), spacing, flat)
        };
        // A full layer at the bottom, a splash of ten above.
        let mut splash = block();
        splash.extend((0..10).map(|i| [5.0, 5.0, 20.0 + i as f32]));
        assert_eq!(from_shape(&splash, 1.0, None).axis, UpAxis::Z);
        let turned: Vec<[f32; 3]> = splash.iter().map(|&[x, y, z]| [x, z, y]).collect();
        assert_eq!(from_shape(&turned, 1.0, None).axis, UpAxis::Y);
        let shallow: Vec<[f32; 3]> = block().iter().map(|&[x, y, z]| [x, y * 0.1, z]).collect();
        let guess = from_shape(&shallow, 0.1, None);
        assert_eq!(guess.axis, UpAxis::Y);
        assert!(guess.reason.starts_with("a guess: "), "extents alone tell little: {}", guess.reason);
        assert_eq!(from_shape(&block(), 1.0, Some(2)).axis, UpAxis::Y);
        // Lost in the rounding of the coordinates.
        assert!(from_shape(&block(), 0.0, None).reason.starts_with("a guess: "));
        // Two that have leaked through the bottom, in a thousand.
        let mut leaking = splash.clone();
        leaking.extend([[3.0, 5.0, -4.0], [5.0, 6.0, -2.0]]);
        assert_eq!(from_shape(&leaking, 1.0, None).axis, UpAxis::Z);
        let turned: Vec<[f32; 3]> = leaking.iter().map(|&[x, y, z]| [x, z, y]).collect();
        assert_eq!(from_shape(&turned, 1.0, None).axis, UpAxis::Y);
    }
}
