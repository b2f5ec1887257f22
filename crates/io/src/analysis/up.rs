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
    }
    Ok(None)
}

/// The axis along which the pressure, of the particles `sample`, falls.
fn hydrostatic(positions: &[[f32; 3]], pressure: &[f32], sample: &[usize]) -> Option<UpAxis> {
    let rows = || {
        let all = std::iter::zip(sample, pressure)
            .map(|(&i, pressure)| (positions[i].map(f64::from), f64::from(*pressure)));
        all.filter(|(_, value)| value.is_finite())
    };
    let count = rows().count() as f64;
    if count < 10.0 {
        return None;
    }
    let (mut mean, mut mean_pressure) = ([0.0; 3], 0.0);
    for (p, value) in rows() {
        (0..3).for_each(|axis| mean[axis] += p[axis] / count);
        mean_pressure += value / count;
    }
    let (mut variance, mut covariance, mut variance_pressure) = ([0.0; 3], [0.0; 3], 0.0);
    for (p, value) in rows() {
        let dp = value - mean_pressure;
        variance_pressure += dp * dp;
        for axis in 0..3 {
            let d = p[axis] - mean[axis];
            variance[axis] += d * d;
            covariance[axis] += d * dp;
        }
    }
    let correlation: [f64; 3] = std::array::from_fn(|axis| {
        let scale = (variance[axis] * variance_pressure).sqrt();
        if scale > 0.0 { covariance[axis] / scale } else { 0.0 }
    });
    let best = (0..3).min_by(|&a, &b| correlation[a].total_cmp(&correlation[b]))?;
    let runner_up =
        (0..3).filter(|&axis| axis != best).map(|axis| correlation[axis].abs()).fold(0.0, f64::max);
    let clear = correlation[best] < -MIN_CORRELATION && -correlation[best] > runner_up + MIN_LEAD;
    clear.then_some(AXES[best])
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
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    let points = || sample.iter().map(|&i| positions[i]);
    for point in points() {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let layers = |axis: usize| {
        let bottom = points().filter(|p| p[axis] < low[axis] + spacing).count() as f32;
        let top = points().filter(|p| p[axis] > high[axis] - spacing).count() as f32;
        (bottom + 1.0) / (top + 1.0)
    };
    let (y, z) = (layers(1), layers(2));
    // A bottom layer with several times the particles of the top one, and clearly more so than along the other axis.
    if y.max(z) > 2.0 && (y / z).max(z / y) > 1.5 {
        let axis = if y > z { UpAxis::Y } else { UpAxis::Z };
        return Guess { axis, reason: "the lowest layer along it is full, the highest is not".into() };
    }
    let extent = |axis: usize| high[axis] - low[axis];
    if extent(1) < 0.8 * extent(2) {
        return Guess { axis: UpAxis::Y, reason: "the extent along it is smaller than along z".into() };
    }
    let reason = if extent(2) < 0.8 * extent(1) {
        "the extent along it is smaller than along y"
    } else {
        "nothing in the data tells"
    };
    Guess { axis: UpAxis::Z, reason: reason.into() }
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
    fn shapes() {
        let from_shape = |points: &[[f32; 3]], spacing, flat| {
            from_shape(points, &(0..points.len()).collect::<Vec<_>>(), spacing, flat)
        };
        // A full layer at the bottom, one splash above.
        let mut splash = block();
        splash.push([5.0, 5.0, 30.0]);
        assert_eq!(from_shape(&splash, 1.0, None).axis, UpAxis::Z);
        let turned: Vec<[f32; 3]> = splash.iter().map(|&[x, y, z]| [x, z, y]).collect();
        assert_eq!(from_shape(&turned, 1.0, None).axis, UpAxis::Y);
        let shallow: Vec<[f32; 3]> = block().iter().map(|&[x, y, z]| [x, y * 0.1, z]).collect();
        assert_eq!(from_shape(&shallow, 0.1, None).axis, UpAxis::Y);
        assert_eq!(from_shape(&block(), 1.0, Some(2)).axis, UpAxis::Y);
    }
}
