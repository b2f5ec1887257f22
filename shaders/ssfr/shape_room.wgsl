// Gives every cell of the grid room for its particles: runs of cells side by side, the runs in no particular order.
#import meniscus::shape::{ShapeRule, Cell}

@group(0) @binding(0) var<uniform> rule: ShapeRule;
@group(0) @binding(1) var<storage, read_write> cells: array<Cell>;
@group(0) @binding(2) var<storage, read_write> taken: atomic<u32>;

// Cells that one invocation looks at: no grid has fewer.
const RUN: u32 = 16u;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let size = rule.last_cell + 1u;
    let first = (id.y * groups.x * 64u + id.x) * RUN;
    if first >= size.x * size.y * size.z {
        return;
    }
    var needed = 0u;
    for (var i = first; i < first + RUN; i++) {
        needed += cells[i].count;
    }
    if needed == 0u {
        return;
    }
    var next = atomicAdd(&taken, needed);
    for (var i = first; i < first + RUN; i++) {
        cells[i].first = next;
        next += cells[i].count;
    }
}
