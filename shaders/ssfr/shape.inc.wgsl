#define_import_path meniscus::shape

// How shapes are found, and the grid that neighbours are found in.
struct ShapeRule {
    // Corner of the grid in the world; cells are as long as the support.
    origin_world: vec3<f32>,
    support_world: f32,
    // Cells per axis less one, all of them powers of two: far cells share a place, near ones never do.
    last_cell: vec3<u32>,
    // 0: axes after variances, of the sphere's volume; 1: axes after standard deviations.
    form: u32,
    // Farthest shift of a centre, in supports.
    most_shift: f32,
    // How far from the mean of its neighbours a particle in a flat surface is, in supports.
    surface_shift: f32,
    strength: f32,
    ratio: f32,
    smoothing: f32,
    // Of half-axes after standard deviations: radii per support, and the longest, in radii.
    axis_scale: f32,
    longest_axis: f32,
    no_neighbours: f32,
    full_neighbours: f32,
    moved_neighbours: f32,
    // Variance below which neighbours are so close together that they say nothing.
    least_variance: f32,
    // In supports.
    lift: f32,
}

// A cell of the grid.
struct Cell {
    // Particles in it.
    count: u32,
    // Place of the first one that is kept, and how many are.
    first: u32,
    kept: u32,
}

// Most particles of a cell that are looked at, spread over it: several times what the bulk has. Data in which all particles are
// in one place would take forever otherwise.
const MOST_OF_A_CELL: u32 = 64u;
// Width of the texture that holds the particles by cell.
const ROW: u32 = 8192u;

// Every how manieth of so many particles of a cell is kept.
fn stride_of(count: u32) -> u32 {
    return (count + MOST_OF_A_CELL - 1u) / MOST_OF_A_CELL;
}

// Far outside of the grid, rounding takes over: what is there has few neighbours anyway.
fn cell_at(rule: ShapeRule, position_world: vec3<f32>) -> vec3<i32> {
    let at = (position_world - rule.origin_world) / rule.support_world;
    return vec3<i32>(floor(clamp(at, vec3(-1e6), vec3(1e6))));
}

fn cell_index(rule: ShapeRule, at: vec3<i32>) -> u32 {
    let wrapped = vec3<u32>(at) & rule.last_cell;
    return (wrapped.z * (rule.last_cell.y + 1u) + wrapped.y) * (rule.last_cell.x + 1u) + wrapped.x;
}

fn texel(place: u32) -> vec2<u32> {
    return vec2(place % ROW, place / ROW);
}

// What a particle is drawn as, relative to its sphere: where the centre is moved to, in most shifts, and a symmetric matrix
// whose eigenvalues are the half-axes in radii.
struct Shape {
    shift: vec3<f32>,
    // xx, yy, zz.
    diagonal: vec3<f32>,
    // xy, xz, yz.
    mixed: vec3<f32>,
}

// Longest half-axis, in radii, that can be stored.
const STORED_AXIS: f32 = 4.0;
const SHIFT_STEPS: f32 = 511.0;

fn pack_shape(shape: Shape) -> vec4<u32> {
    let shift = vec3<u32>(round(clamp(shape.shift, vec3(-1.0), vec3(1.0)) * SHIFT_STEPS) + 512.0);
    let diagonal = shape.diagonal / STORED_AXIS;
    let mixed = shape.mixed / STORED_AXIS;
    return vec4(
        pack2x16snorm(diagonal.xy),
        pack2x16snorm(vec2(diagonal.z, mixed.x)),
        pack2x16snorm(mixed.yz),
        shift.x | (shift.y << 10u) | (shift.z << 20u),
    );
}

fn unpack_shape(bits: vec4<u32>) -> Shape {
    let a = unpack2x16snorm(bits.x) * STORED_AXIS;
    let b = unpack2x16snorm(bits.y) * STORED_AXIS;
    let c = unpack2x16snorm(bits.z) * STORED_AXIS;
    let shift = vec3(bits.w & 1023u, (bits.w >> 10u) & 1023u, (bits.w >> 20u) & 1023u);
    return Shape((vec3<f32>(shift) - 512.0) / SHIFT_STEPS, vec3(a, b.x), vec3(b.y, c));
}
