#define_import_path meniscus::particle

struct PackedParticle {
    position_world: vec3<f32>,
    // Low 16 bits: identity hash. High 16 bits: radius relative to the set's, IEEE half.
    packed: u32,
}

// A run of particles. Of a list of runs, the first element's `first` is the number of runs that follow.
struct KeptRange {
    first: u32,
    count: u32,
    // Keep probability in 1/65536.
    keep: u32,
    // 1 + the place of the first one's shape, those of the others following; 0: all are spheres.
    shape: u32,
}

// A run of particles and where it would show.
struct Occludee {
    range: KeptRange,
    // Distance that none of the spheres comes nearer than.
    front: f32,
    // First and last tile, inclusive: column in the low, row in the high 16 bits.
    first_tile: u32,
    last_tile: u32,
    pad: u32,
}

// A sphere in place of a group of particles.
struct StandIn {
    center_world: vec3<f32>,
    // Low 16 bits: volume in those of a particle. High 16 bits: radius in spacings. Both IEEE halves.
    packed: u32,
}

// What level of detail makes of one kept particle.
struct Kept {
    // Factor on the particle's volume; its expectation over the hash is 1 / probability over the kept ones.
    weight: f32,
    // Factor on the drawn radius.
    radius: f32,
}

// Fraction of the keep probability over which particles fade in (main-renderer.md 3.3).
const RAMP: f32 = 0.2;
// Keep probabilities below which splats begin to grow, and below which they have grown by p^(-1/3), to close holes; and most
// that they grow by.
const GROWS_BELOW: f32 = 0.75;
const GROWN_BELOW: f32 = 0.4;
const MAX_GROWTH: f32 = 2.0;

// Horvitz-Thompson weight and size of a particle with identity hash `packed & 0xffff` kept with probability keep / 65536.
// `closing`, at most 1: how much of the growth closes holes, the less the larger the radius is from the beginning. The ramp narrows to nothing as the probability goes to 1, so that full detail is reached without a step.
fn kept(packed: u32, keep: u32, closing: f32) -> Kept {
    if keep >= 65536u {
        return Kept(1.0, 1.0);
    }
    let p = f32(keep) / 65536.0;
    let u = (f32(packed & 0xffffu) + 0.5) / 65536.0;
    let ramp = min(RAMP * p, 1.0 - p);
    let fade = clamp((p - u) / ramp, 0.0, 1.0);
    // Mean of the fade over u in [0, p).
    let mean_fade = 1.0 - 0.5 * ramp / p;
    let share = clamp((GROWS_BELOW - p) / (GROWS_BELOW - GROWN_BELOW), 0.0, 1.0);
    let growth = 1.0 + (clamp(closing * pow(p, -1.0 / 3.0), 1.0, MAX_GROWTH) - 1.0) * share;
    return Kept(fade / (mean_fade * p), growth * pow(fade, 1.0 / 3.0));
}
