//! Fresnel and GGX.

use std::f32::consts::PI;

/// Unpolarised Fresnel reflectance of a dielectric with relative index `eta = n_t / n_i` >= 0 for the cosine `cos_i` of the
/// angle of incidence in [0, 1] (Cook & Torrance 1982, which is exact); in [0, 1].
pub fn fresnel_dielectric(cos_i: f32, eta: f32) -> f32 {
    let c = cos_i.clamp(0.0, 1.0);
    let g2 = eta * eta - 1.0 + c * c;
    if g2 <= 0.0 {
        return 1.0;
    }
    let g = g2.sqrt();
    let a = (g - c) / (g + c);
    let b = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    0.5 * a * a * (1.0 + b * b)
}

/// GGX distribution times height-correlated Smith visibility (Heitz 2014); the BRDF is this times Fresnel. Cosines in
/// (0, 1], `alpha` > 0.
pub fn ggx(n_l: f32, n_v: f32, n_h: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let q = n_h * n_h * (a2 - 1.0) + 1.0;
    let d = a2 / (PI * q * q);
    let v = 0.5 / (n_l * (n_v * n_v * (1.0 - a2) + a2).sqrt() + n_v * (n_l * n_l * (1.0 - a2) + a2).sqrt());
    d * v
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both polarisations by Snell's law, in f64.
    fn closed_form(cos_i: f64, eta: f64) -> f64 {
        let sin_t = (1.0 - cos_i * cos_i).sqrt() / eta;
        if sin_t >= 1.0 {
            return 1.0;
        }
        let cos_t = (1.0 - sin_t * sin_t).sqrt();
        let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        0.5 * (s * s + p * p)
    }

    #[test]
    fn fresnel_is_the_closed_form_from_normal_to_grazing() {
        for eta in [1.333f64, 1.5, 2.4, 1.0 / 1.333] {
            let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
            // 1e-6: f32 rounding of values up to 1.
            assert!((f64::from(fresnel_dielectric(1.0, eta as f32)) - normal).abs() < 1e-6);
            assert_eq!(fresnel_dielectric(0.0, eta as f32), 1.0);
            for i in 1..100 {
                let c = f64::from(i) / 100.0;
                let found = f64::from(fresnel_dielectric(c as f32, eta as f32));
                // 2e-6, and 2e-4 just beyond total reflection, where the slope is infinite and g cancels.
                let tolerance = if eta < 1.0 { 2e-4 } else { 2e-6 };
                assert!((found - closed_form(c, eta)).abs() < tolerance, "eta {eta} cos {c}: {found}");
            }
        }
        assert!(fresnel_dielectric(0.5, 1.0).abs() < 1e-12, "no boundary, no reflection");
    }

    #[test]
    fn ggx_reflects_no_more_than_arrives() {
        for alpha in [0.05f32, 0.3, 1.0] {
            for n_v in [0.1f32, 0.5, 1.0] {
                let v = glam::Vec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v);
                let mut albedo = 0.0;
                const N: usize = 400;
                for i in 0..N {
                    for j in 0..N {
                        // Uniform in cosine and azimuth: each sample stands for 2 pi / N^2.
                        let n_l = (i as f32 + 0.5) / N as f32;
                        let phi = std::f32::consts::TAU * (j as f32 + 0.5) / N as f32;
                        let s = (1.0 - n_l * n_l).sqrt();
                        let l = glam::Vec3::new(s * phi.cos(), s * phi.sin(), n_l);
                        albedo += ggx(n_l, n_v, (l + v).normalize().z, alpha) * n_l;
                    }
                }
                albedo *= std::f32::consts::TAU / (N * N) as f32;
                // 1.02: the midpoint rule on a narrow lobe.
                assert!(albedo < 1.02, "alpha {alpha} n_v {n_v}: {albedo}");
                if n_v == 1.0 && alpha == 1.0 {
                    // By hand: the integral of c / (1 + c) over the cosine.
                    assert!((albedo - (1.0 - 2f32.ln())).abs() < 1e-3, "{albedo}");
                } else if n_v == 1.0 && alpha < 0.1 {
                    assert!(albedo > 0.97, "a mirror loses nothing: {albedo}");
                }
            }
        }
    }
}
