// Sorts particles into the cells of a grid: counts them; with SCATTER, once every cell has room, puts them there. In no particular
// order within a cell: what is made of them does not depend on it.
#import meniscus::particle::KeptRange
#import meniscus::page::particle_at
#import meniscus::shape::{ShapeRule, Cell, stride_of, cell_at, cell_index, texel}
#import meniscus::splat::{half_to_float, share_of}

struct FillingCell {
    count: atomic<u32>,
    first: u32,
    kept: atomic<u32>,
}

@group(0) @binding(0) var<uniform> rule: ShapeRule;
@group(0) @binding(2) var<storage, read> ranges: array<KeptRange>;
@group(0) @binding(3) var<storage, read_write> cells: array<FillingCell>;
#ifdef SCATTER
@group(0) @binding(4) var by_cell: texture_storage_2d<rgba32float, write>;
#endif

const LANES: u32 = 64u;

@compute @workgroup_size(LANES)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let share = share_of(group, groups);
    for (var index = share.first; index < ranges[0].first; index += share.step) {
        let range = ranges[index + 1u];
        for (var i = lane; i < range.count; i += LANES) {
            let place = range.first + i;
            let particle = particle_at(place);
            let cell = cell_index(rule, cell_at(rule, particle.position_world));
#ifdef SCATTER
            // Of crowded cells always the same ones, whatever the order.
            if place % stride_of(atomicLoad(&cells[cell].count)) == 0u {
                let at = cells[cell].first + atomicAdd(&cells[cell].kept, 1u);
                let size = half_to_float(particle.packed >> 16u);
                textureStore(by_cell, texel(at), vec4(particle.position_world, min(size * size * size, 1.0)));
            }
#else
            atomicAdd(&cells[cell].count, 1u);
#endif
        }
    }
}
