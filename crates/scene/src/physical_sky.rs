use glam::Vec3;

use crate::{Environment, Sun, UpFrame};

/// Turbidity of a clear day.
const TURBIDITY: f32 = 2.8;
/// Illuminance of the sun above the atmosphere, klx.
const SUN_KLX: f32 = 128.0;
/// Wavelengths that stand for red, green and blue, micrometres.
const WAVELENGTHS_UM: [f32; 3] = [0.615, 0.540, 0.465];
/// Below it, the model's sky gets dark and its colours wrong, degrees.
const LOWEST_ELEVATION_DEG: f32 = 2.0;
const SIZE: [usize; 2] = [512, 256];

/// A clear sky with the sun at `azimuth_deg` (from north, clockwise) and `elevation_deg` (in (0, 90]), and the sun: Preetham,
/// Shirley & Smits 1999, scaled to the brightness of the automatic scene. Below the horizon lies ground of this radiance
/// relative to the sky's brightness.
pub fn physical_sky(
    frame: UpFrame,
    azimuth_deg: f32,
    elevation_deg: f32,
    ground: [f32; 3],
) -> (Environment, Sun) {
    let elevation = elevation_deg.clamp(LOWEST_ELEVATION_DEG, 90.0).to_radians();
    let azimuth = azimuth_deg.to_radians();
    let sun = Vec3::new(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin());
    let preetham = Preetham::new(elevation);
    let sky = |d: Vec3| preetham.radiance(d.z.max(0.0), sun.dot(d).clamp(-1.0, 1.0).acos());
    let mean = sky(Vec3::Z).element_sum() / 3.0;
    let image = |d: Vec3| {
        let below = (-12.0 * d.z).clamp(0.0, 1.0);
        sky(d).lerp(Vec3::from(ground) * mean, below * below * (3.0 - 2.0 * below))
    };
    let mut environment = Environment::from_fn(SIZE, image);
    let given = Sun { direction: frame.world_of(sun), irradiance: sun_klx(elevation).to_array() };
    let sun = environment.split_sun(frame, Some(given));
    // The low sun of the model stands where the given one does.
    let lamp = frame.direction(azimuth, elevation_deg.to_radians());
    (environment, Sun { direction: lamp, ..sun })
}

/// Illuminance of the sun through the atmosphere: Rayleigh scattering and Angstrom's aerosols (Preetham et al. 1999, A.1).
fn sun_klx(elevation: f32) -> Vec3 {
    let zenith_deg = 90.0 - elevation.to_degrees();
    let mass = 1.0 / (elevation.sin() + 0.15 * (93.885 - zenith_deg).powf(-1.253));
    let aerosols = 0.046_083 * TURBIDITY - 0.045_865;
    Vec3::from(WAVELENGTHS_UM.map(|wavelength| {
        let rayleigh = 0.008_735 * wavelength.powf(-4.08);
        SUN_KLX * (-mass * (rayleigh + aerosols * wavelength.powf(-1.3))).exp()
    }))
}

/// Perez' distribution of luminance and chromaticity with Preetham's coefficients.
struct Preetham {
    zenith: [f32; 3],
    coefficients: [[f32; 5]; 3],
    at_zenith: [f32; 3],
}

impl Preetham {
    fn new(elevation: f32) -> Self {
        let t = TURBIDITY;
        let theta = std::f32::consts::FRAC_PI_2 - elevation;
        let chi = (4.0 / 9.0 - t / 120.0) * (std::f32::consts::PI - 2.0 * theta);
        // kcd / m^2.
        let luminance = (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192;
        let powers = [theta.powi(3), theta.powi(2), theta, 1.0];
        let chromaticity = |rows: [[f32; 4]; 3]| {
            let along = |row: [f32; 4]| row.iter().zip(powers).map(|(c, p)| c * p).sum::<f32>();
            t * t * along(rows[0]) + t * along(rows[1]) + along(rows[2])
        };
        let x = chromaticity([
            [0.00166, -0.00375, 0.00209, 0.0],
            [-0.02903, 0.06377, -0.03202, 0.00394],
            [0.11693, -0.21196, 0.06052, 0.25886],
        ]);
        let y = chromaticity([
            [0.00275, -0.00610, 0.00317, 0.0],
            [-0.04214, 0.08970, -0.04153, 0.00516],
            [0.15346, -0.26756, 0.06670, 0.26688],
        ]);
        let coefficients = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let at_zenith = coefficients.map(|c| perez(c, 1.0, theta));
        Self { zenith: [luminance.max(0.05), x, y], coefficients, at_zenith }
    }

    /// Linear Rec. 709, kcd / m^2, for the cosine of the zenith angle and the angle to the sun.
    fn radiance(&self, cos_zenith: f32, to_sun: f32) -> Vec3 {
        let [luminance, x, y] = [0, 1, 2].map(|i| {
            // The horizon itself is a pole of the formula.
            self.zenith[i] * perez(self.coefficients[i], cos_zenith.max(0.02), to_sun) / self.at_zenith[i]
        });
        let per_y = luminance.max(0.0) / y.max(1e-3);
        let (big_x, big_y, big_z) = (x * per_y, luminance.max(0.0), (1.0 - x - y) * per_y);
        // IEC 61966-2-1.
        Vec3::new(
            3.2406 * big_x - 1.5372 * big_y - 0.4986 * big_z,
            -0.9689 * big_x + 1.8758 * big_y + 0.0415 * big_z,
            0.0557 * big_x - 0.2040 * big_y + 1.0570 * big_z,
        )
        .max(Vec3::ZERO)
    }
}

fn perez([a, b, c, d, e]: [f32; 5], cos_zenith: f32, to_sun: f32) -> f32 {
    (1.0 + a * (b / cos_zenith).exp()) * (1.0 + c * (d * to_sun).exp() + e * to_sun.cos().powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_core::UpAxis;

    fn sky(elevation: f32) -> (Environment, Sun) {
        physical_sky(UpFrame::new(UpAxis::Z), 90.0, elevation, [0.3; 3])
    }

    #[test]
    fn a_high_sun_is_white_in_a_blue_sky_and_a_low_one_red() {
        let (environment, sun) = sky(60.0);
        let [red, _, blue] = sun.irradiance;
        assert!(red / blue < 1.6 && red > blue, "{:?}", sun.irradiance);
        let zenith = environment.at(Vec3::Z);
        assert!(zenith.z > 1.5 * zenith.x, "{zenith}");
        // A clear sky gives level ground a tenth to a third of its light.
        let from_sky = environment.irradiance(Vec3::Z).y;
        let from_sun = sun.irradiance[1] * sun.direction.z;
        assert!((0.1..0.5).contains(&(from_sky / (from_sky + from_sun))), "{from_sky} {from_sun}");
        let [red, _, blue] = sky(4.0).1.irradiance;
        assert!(red > 4.0 * blue, "{red} {blue}");
    }

    #[test]
    fn the_sky_is_brightest_around_the_sun() {
        for elevation in [0.5, 10.0, 45.0, 90.0] {
            let (environment, sun) = sky(elevation);
            assert!(environment.radiance().iter().flatten().all(|c| c.is_finite() && *c < 1e3));
            let towards = environment.at(sun.direction.with_z(sun.direction.z.max(0.05)).normalize());
            let away = environment.at(Vec3::new(-0.8, 0.0, 0.6));
            assert!(towards.y > 1.5 * away.y, "elevation {elevation}: {towards} {away}");
            assert!((sun.direction.z - elevation.to_radians().sin()).abs() < 1e-4);
        }
    }
}
