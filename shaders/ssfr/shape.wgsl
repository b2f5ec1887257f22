// The ellipsoid that a particle of the shell is drawn as: weighted principal components of its neighbourhood, centre smoothed
// (main-renderer.md 5.6, algorithms.md 9.1). All lengths in supports, around the particle itself, so that nothing cancels.
#import meniscus::particle::KeptRange
#import meniscus::page::particle_at
#import meniscus::shape::{ShapeRule, Cell, Shape, cell_at, cell_index, texel, pack_shape}
#import meniscus::splat::share_of

@group(0) @binding(0) var<uniform> rule: ShapeRule;
@group(0) @binding(2) var<storage, read> ranges: array<KeptRange>;
@group(0) @binding(3) var<storage, read> cells: array<Cell>;
@group(0) @binding(4) var by_cell: texture_2d<f32>;
@group(0) @binding(5) var<storage, read_write> shapes: array<vec4<u32>>;

const LANES: u32 = 64u;
// Sums are in fixed point, so that they do not depend on the order of the neighbours. Of these steps, those of all 27 cells that
// may be near, 64 particles each, fit the range.
const STEPS: f32 = 0x1p20f;

struct Sums {
    weight: i32,
    first: vec3<i32>,
    // xx, yy, zz.
    second: vec3<i32>,
    // xy, xz, yz.
    mixed: vec3<i32>,
}

fn sums_around(center: vec3<f32>) -> Sums {
    var sums = Sums(0, vec3(0), vec3(0), vec3(0));
    let own = cell_at(rule, center);
    let scale = 1.0 / rule.support_world;
    for (var z = -1; z <= 1; z++) {
        for (var y = -1; y <= 1; y++) {
            for (var x = -1; x <= 1; x++) {
                let cell = cell_index(rule, own + vec3(x, y, z));
                let first = cells[cell].first;
                let end = first + cells[cell].kept;
                for (var place = first; place < end; place++) {
                    let other = textureLoad(by_cell, texel(place), 0);
                    let at = (other.xyz - center) * scale;
                    let square = dot(at, at);
                    if square < 1.0 {
                        let weight = other.w * (1.0 - square * sqrt(square)) * STEPS;
                        let weighted = weight * at;
                        sums.weight += i32(weight);
                        sums.first += vec3<i32>(weighted);
                        sums.second += vec3<i32>(weighted * at);
                        sums.mixed += vec3<i32>(weighted.xxy * at.yzz);
                    }
                }
            }
        }
    }
    return sums;
}

// Eigenvalues and unit eigenvectors, as columns, of a symmetric matrix.
struct Eigen {
    values: vec3<f32>,
    vectors: mat3x3<f32>,
}

struct Rotation {
    c: f32,
    s: f32,
    // Change of the diagonal.
    step: f32,
}

// The rotation that brings `off` to 0 between the diagonal's entries `p` and `q` (Golub and Van Loan, Matrix Computations, 8.5).
fn rotation(p: f32, q: f32, off: f32) -> Rotation {
    if abs(off) < 1e-12 {
        return Rotation(1.0, 0.0, 0.0);
    }
    let theta = (q - p) / (2.0 * off);
    let t = select(1.0, -1.0, theta < 0.0) / (abs(theta) + sqrt(theta * theta + 1.0));
    let c = inverseSqrt(t * t + 1.0);
    return Rotation(c, t * c, t * off);
}

// Cyclic Jacobi rotations, which no multiple or vanishing eigenvalue upsets. Four sweeps bring what is off the diagonal below
// the rounding of single precision.
fn eigen(diagonal: vec3<f32>, mixed: vec3<f32>) -> Eigen {
    var d = diagonal;
    var xy = mixed.x;
    var xz = mixed.y;
    var yz = mixed.z;
    var u = vec3(1.0, 0.0, 0.0);
    var v = vec3(0.0, 1.0, 0.0);
    var w = vec3(0.0, 0.0, 1.0);
    for (var sweep = 0; sweep < 4; sweep++) {
        let a = rotation(d.x, d.y, xy);
        d += vec3(-a.step, a.step, 0.0);
        xy = 0.0;
        let a_xz = a.c * xz - a.s * yz;
        yz = a.s * xz + a.c * yz;
        xz = a_xz;
        let a_u = a.c * u - a.s * v;
        v = a.s * u + a.c * v;
        u = a_u;

        let b = rotation(d.x, d.z, xz);
        d += vec3(-b.step, 0.0, b.step);
        xz = 0.0;
        let b_xy = b.c * xy - b.s * yz;
        yz = b.s * xy + b.c * yz;
        xy = b_xy;
        let b_u = b.c * u - b.s * w;
        w = b.s * u + b.c * w;
        u = b_u;

        let c = rotation(d.y, d.z, yz);
        d += vec3(0.0, -c.step, c.step);
        yz = 0.0;
        let c_xy = c.c * xy - c.s * xz;
        xz = c.s * xy + c.c * xz;
        xy = c_xy;
        let c_v = c.c * v - c.s * w;
        w = c.s * v + c.c * w;
        v = c_v;
    }
    return Eigen(d, mat3x3(u, v, w));
}

// Half-axes in radii, of the full anisotropy.
fn half_axes(variances: vec3<f32>) -> vec3<f32> {
    let largest = max(max(variances.x, variances.y), max(variances.z, rule.least_variance * 0.01));
    let limited = max(variances, vec3(largest / rule.ratio));
    if rule.form == 0u {
        return limited / pow(limited.x * limited.y * limited.z, 1.0 / 3.0);
    }
    return min(sqrt(limited) * rule.axis_scale, vec3(rule.longest_axis));
}

// From 0 without neighbours enough to 1 at `full` of them.
fn enough(neighbours: f32, full: f32) -> f32 {
    return clamp((neighbours - rule.no_neighbours) / (full - rule.no_neighbours), 0.0, 1.0);
}

fn shape_of(sums: Sums) -> Shape {
    // The particle itself is among them. Of a crowded cell it may have been left out, but hardly alone.
    let scale = 1.0 / f32(max(sums.weight, 1));
    let mean = vec3<f32>(sums.first) * scale;
    let second = vec3<f32>(sums.second) * scale - mean * mean;
    let mixed = vec3<f32>(sums.mixed) * scale - mean.xxy * mean.yzz;
    let found = eigen(second, mixed);
    let variances = max(found.values, vec3(0.0));

    // The mean weight over the support is 1/2; counted so, no neighbour enters or leaves with a step.
    let neighbours = 2.0 * (f32(sums.weight) / STEPS - 1.0);
    // Where all are in one place, there is no shape to be found.
    let spread = min(max(variances.x, max(variances.y, variances.z)) / rule.least_variance, 1.0);
    let blend = rule.strength * enough(neighbours, rule.full_neighbours) * spread;
    let axes = 1.0 + (half_axes(variances) - 1.0) * blend;
    let u = found.vectors;
    let diagonal = u[0] * u[0] * axes.x + u[1] * u[1] * axes.y + u[2] * u[2] * axes.z;
    let products = u[0].xxy * u[0].yzz * axes.x + u[1].xxy * u[1].yzz * axes.y + u[2].xxy * u[2].yzz * axes.z;

    // Being as far from the mean of its neighbours as a particle in a flat surface is not roughness but where the fluid ends.
    let away = length(mean);
    let outward = select(vec3(0.0), -mean / away, away > 1e-6);
    let t = min(away / rule.surface_shift, 1.0);
    let one_sided = t * t * (3.0 - 2.0 * t);
    let inwards = rule.smoothing * enough(neighbours, rule.moved_neighbours) * (away - rule.surface_shift * one_sided);
    let along = outward * u * axes;
    // What the flatter shape would sink by.
    let lifted = rule.lift * one_sided * max(1.0 - length(along), 0.0);
    let shift = outward * ((lifted - inwards) / rule.most_shift);
    return Shape(shift / max(length(shift), 1.0), diagonal, products);
}

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let share = share_of(group, groups);
    for (var index = share.first; index < ranges[0].first; index += share.step) {
        let range = ranges[index + 1u];
        for (var i = lane; i < range.count; i += LANES) {
            let center = particle_at(range.first + i).position_world;
            shapes[range.shape - 1u + i] = pack_shape(shape_of(sums_around(center)));
        }
    }
}
