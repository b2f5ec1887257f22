#define_import_path meniscus::brdf

const PI: f32 = 3.14159265358979;

fn fifth_power(x: f32) -> f32 {
    let x2 = x * x;
    return x2 * x2 * x;
}

// Unpolarised Fresnel reflectance of a dielectric with relative index eta = n_t / n_i, for the cosine of the angle of incidence.
fn fresnel_dielectric(cos_i: f32, eta: f32) -> f32 {
    let c = clamp(cos_i, 0.0, 1.0);
    let g2 = eta * eta - 1.0 + c * c;
    if g2 <= 0.0 {
        return 1.0;
    }
    // Cook & Torrance 1982: both polarisations from g = eta cos t.
    let g = sqrt(g2);
    let a = (g - c) / (g + c);
    let b = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    return 0.5 * a * a * (1.0 + b * b);
}

// GGX distribution times height-correlated Smith visibility (Heitz 2014): D * V; the BRDF is this times Fresnel.
fn ggx(n_l: f32, n_v: f32, n_h: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let q = n_h * n_h * (a2 - 1.0) + 1.0;
    let d = a2 / (PI * q * q);
    let v = 0.5 / (n_l * sqrt(n_v * n_v * (1.0 - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0 - a2) + a2));
    return d * v;
}

// Burley 2012 diffuse lobe without base colour, with the 1 / pi.
fn burley_diffuse(n_l: f32, n_v: f32, l_h: f32, roughness: f32) -> f32 {
    let f_d90 = 0.5 + 2.0 * l_h * l_h * roughness;
    return (1.0 + (f_d90 - 1.0) * fifth_power(1.0 - n_l)) * (1.0 + (f_d90 - 1.0) * fifth_power(1.0 - n_v)) / PI;
}
