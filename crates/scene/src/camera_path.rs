//! A camera that moves: key positions in a TOML file and a curve through them.

use glam::{DVec3, Vec3};
use meniscus_core::{Camera, Projection, UpAxis, hermite_weights};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::{FOVY_RAD, SceneError};

/// What the positions of a path are counted in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// Seconds of the film.
    #[default]
    Film,
    /// Time of the simulation.
    Data,
    /// From 0 at the first picture to 1 at the last.
    Share,
}

/// How the camera gets from key to key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Curve {
    /// Without a kink.
    #[default]
    Smooth,
    /// Straight.
    Linear,
}

/// A camera path file. Coordinates are the particle file's own.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraPath {
    /// What `at` counts.
    #[serde(default)]
    pub clock: Clock,
    /// How the camera gets from key to key.
    #[serde(default)]
    pub curve: Curve,
    /// `[[key]]`, in the order of `at`. Before the first and after the last the camera stands still.
    #[serde(rename = "key")]
    pub keys: Vec<CameraKey>,
}

/// `[[key]]`: where the camera is at one time.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// When.
    pub at: f64,
    /// Eye.
    pub eye: [f64; 3],
    /// Point looked at.
    pub target: [f64; 3],
    /// What points up in the picture; left out: the up axis.
    pub up: Option<[f64; 3]>,
    /// Vertical field of view in degrees, 0.1 to 175; left out: that of automatic cameras.
    pub fovy_deg: Option<f64>,
}

/// All numbers of a key.
type Pose = [f64; 10];

impl CameraPath {
    /// Parses a camera path; `file` is its name for messages.
    ///
    /// # Errors
    /// [`SceneError::Toml`] with line and column; no key, keys in another order than in time, numbers out of range.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, SceneError> {
        let path: Self = toml::from_str(text).map_err(|e| SceneError::Toml {
            file: file.to_owned(),
            message: e.to_string().trim_end().to_owned(),
        })?;
        let refuse = |key: String, found: String, expected| {
            Err(SceneError::OutOfRange { file: file.to_owned(), key, found, expected })
        };
        if path.keys.is_empty() {
            return refuse("key".into(), "empty".into(), "at least one [[key]]");
        }
        for (i, key) in path.keys.iter().enumerate() {
            let numbers =
                [key.at].into_iter().chain(key.eye).chain(key.target).chain(key.up.unwrap_or_default());
            if let Some(found) = numbers.into_iter().find(|number| !number.is_finite()) {
                return refuse(format!("key {i}"), found.to_string(), "finite numbers");
            }
            if i > 0 && key.at <= path.keys[i - 1].at {
                return refuse(
                    format!("key {i}.at"),
                    key.at.to_string(),
                    "a later time than that of the key before",
                );
            }
            if let Some(fovy) = key.fovy_deg
                && !(0.1..=175.0).contains(&fovy)
            {
                return refuse(format!("key {i}.fovy_deg"), fovy.to_string(), "0.1 to 175");
            }
        }
        Ok(path)
    }

    /// The camera at `at`, in world space: `origin` is the series' origin, `near_world` the nearest distance drawn. It may be
    /// unusable where the path leads the eye through its target ([`Camera::validate`]).
    pub fn camera(&self, at: f64, origin: DVec3, up: UpAxis, near_world: f32) -> Camera {
        let pose = |key: &CameraKey| -> Pose {
            let key_up = key.up.unwrap_or_else(|| up.vector().as_dvec3().to_array());
            let fovy = key.fovy_deg.unwrap_or(f64::from(FOVY_RAD).to_degrees());
            let mut pose = [fovy; 10];
            pose[..3].copy_from_slice(&key.eye);
            pose[3..6].copy_from_slice(&key.target);
            pose[6..9].copy_from_slice(&key_up);
            pose
        };
        let keys: Vec<(f64, Pose)> = self.keys.iter().map(|key| (key.at, pose(key))).collect();
        let [ex, ey, ez, tx, ty, tz, ux, uy, uz, fovy] = along(&keys, at, self.curve);
        let world = |x, y, z| (DVec3::new(x, y, z) - origin).as_vec3();
        Camera {
            eye: world(ex, ey, ez),
            target: world(tx, ty, tz),
            up: Vec3::new(ux as f32, uy as f32, uz as f32),
            // A curve may swing beyond its keys.
            projection: Projection::Perspective { fovy_rad: fovy.clamp(0.1, 175.0).to_radians() as f32 },
            near: near_world,
        }
    }
}

/// The pose at `at`; `keys` are not empty and rise.
fn along(keys: &[(f64, Pose)], at: f64, curve: Curve) -> Pose {
    let next = keys.partition_point(|(time, _)| *time <= at);
    if next == 0 || next == keys.len() {
        return keys[next.saturating_sub(1).min(keys.len() - 1)].1;
    }
    let [(from, a), (to, b)] = [keys[next - 1], keys[next]];
    let (length, share) = (to - from, (at - from) / (to - from));
    std::array::from_fn(|i| match curve {
        Curve::Linear => a[i] + share * (b[i] - a[i]),
        Curve::Smooth => {
            let slopes = [slope(keys, next - 1, i) * length, slope(keys, next, i) * length];
            let [w0, w1, w2, w3] = hermite_weights(share);
            w0 * a[i] + w1 * slopes[0] + w2 * b[i] + w3 * slopes[1]
        }
    })
}

/// Slope of number `i` at a key: that of the parabola through it and its neighbours; at the ends the camera starts and stops.
fn slope(keys: &[(f64, Pose)], key: usize, i: usize) -> f64 {
    if key == 0 || key + 1 == keys.len() {
        return 0.0;
    }
    let [(t0, a), (t1, b), (t2, c)] = [keys[key - 1], keys[key], keys[key + 1]];
    let (before, after) = ((b[i] - a[i]) / (t1 - t0), (c[i] - b[i]) / (t2 - t1));
    (before * (t2 - t1) + after * (t1 - t0)) / (t2 - t0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "
        [[key]]
        at = 1
        eye = [500000, 0, 10]
        target = [500000, 0, 0]
        up = [0, 1, 0]
        [[key]]
        at = 2
        eye = [500004, 0, 10]
        target = [500000, 0, 0]
        fovy_deg = 40
        [[key]]
        at = 4
        eye = [500004, 8, 10]
        target = [500000, 0, 0]
        fovy_deg = 40
    ";

    fn eye(path: &CameraPath, at: f64) -> Vec3 {
        path.camera(at, DVec3::new(5e5, 0.0, 0.0), UpAxis::Z, 0.1).eye
    }

    #[test]
    fn the_camera_is_at_its_keys_and_stands_before_and_after() {
        for curve in ["smooth", "linear"] {
            let path = CameraPath::from_toml(&format!("curve = \"{curve}\"\n{PATH}"), "p").unwrap();
            for (at, expected) in [
                (-5.0, Vec3::new(0.0, 0.0, 10.0)),
                (1.0, Vec3::new(0.0, 0.0, 10.0)),
                (2.0, Vec3::new(4.0, 0.0, 10.0)),
                (4.0, Vec3::new(4.0, 8.0, 10.0)),
                (9.0, Vec3::new(4.0, 8.0, 10.0)),
            ] {
                assert!(eye(&path, at).distance(expected) < 1e-5, "{curve} {at}");
            }
        }
        let path = CameraPath::from_toml(PATH, "p").unwrap();
        let camera = path.camera(2.0, DVec3::ZERO, UpAxis::Z, 0.1);
        assert_eq!((camera.up, camera.near), (Vec3::Z, 0.1));
        assert_eq!(camera.projection, Projection::Perspective { fovy_rad: 40_f64.to_radians() as f32 });
    }

    #[test]
    fn smooth_ways_have_no_kink_and_straight_ones_no_curve() {
        let smooth = CameraPath::from_toml(PATH, "p").unwrap();
        let speed = |at: f64| (eye(&smooth, at + 1e-3) - eye(&smooth, at - 1e-3)) / 2e-3;
        let change = |at: f64| speed(at + 2e-3).distance(speed(at - 2e-3));
        // Where there is no kink, speed changes by acceleration (below 30) times 4 ms.
        for at in [1.0, 1.5, 2.0, 3.0, 4.0] {
            assert!(change(at) < 0.12, "{at}: {}", change(at));
        }
        assert!(speed(2.0).length() > 1.0, "it does not stop at keys on its way");
        let linear = CameraPath::from_toml(&format!("curve = \"linear\"\n{PATH}"), "p").unwrap();
        assert!(eye(&linear, 3.0).distance(Vec3::new(4.0, 4.0, 10.0)) < 1e-5);
    }

    #[test]
    fn mistakes_are_named() {
        let message = |text: &str| CameraPath::from_toml(text, "path.toml").unwrap_err().to_string();
        assert!(message("key = []").contains("at least one"));
        assert!(message("[[key]]\nat = 0\neye = [0, 0]\ntarget = [0, 0, 0]").contains("path.toml"));
        let key = |at: &str, rest: &str| {
            format!("[[key]]\nat = {at}\neye = [1, 0, 0]\ntarget = [0, 0, 0]\n{rest}\n")
        };
        assert!(message(&(key("1", "") + &key("1", ""))).contains("key 1.at"));
        assert!(message(&key("0", "fovy_deg = 180")).contains("0.1 to 175"));
        assert!(message(&key("nan", "")).contains("finite"));
        assert!(message(&key("0", "roll = 3")).contains("roll"));
    }
}
