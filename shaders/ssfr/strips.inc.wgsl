#define_import_path meniscus::strips
#import meniscus::particle::KeptRange

// Splats of many pixels are not drawn by the invocation that comes across them: all others of its workgroup would wait for it, and
// lavapipe ends all loops of an invocation after 65 536 turns in all, whatever is left to do. They are cut into strips of rows, which
// the variants compiled with STRIPS draw, a workgroup a strip. Those compiled with SMALL are for sets that have none.

// A splat, and the first of the rows to be drawn.
struct Strip {
    particle: u32,
    keep: u32,
    // 1 + place of its shape; 0: a sphere.
    shape: u32,
    first_row: i32,
}

struct Strips {
    count: atomic<u32>,
    pad: array<u32, 3>,
    strips: array<Strip>,
}

@group(0) @binding(13) var<storage, read> ranges: array<KeptRange>;
#ifndef SMALL
@group(0) @binding(14) var<storage, read_write> strips: Strips;
#endif

// Most pixels of a splat that one invocation draws (`MOST_PX` of `passes/pages.rs`). On a GPU others wait for it: an NVIDIA H100 draws
// spheres of 5 and 10 px three and six times faster in strips; for a software driver strips are a detour, as long as
// the splats of an invocation, every 64th of a range of 512, stay below its limit (benches/RESULTS.md).
#ifdef HARDWARE
const MOST_PX: i32 = 32;
#else
const MOST_PX: i32 = 4096;
#endif
// About as many has a strip, at least one row.
const STRIP_PX: i32 = 4096;
// First row of a strip that is void.
const NO_ROW: i32 = -1;
// The lanes of a workgroup side by side in a strip.
const COLUMNS: u32 = 16u;
const ROWS: u32 = 4u;

// What an invocation draws of a rectangle of pixels: every `step` from `first` to `last`; nothing where `last.y` < `first.y`, else at least
// one.
struct Part {
    first: vec2<i32>,
    last: vec2<i32>,
    step: vec2<i32>,
    // Pixels that it counts as visited.
    visited: u32,
}

fn rows_of_strip(width: i32) -> i32 {
    return max(STRIP_PX / width, 1);
}

#ifndef SMALL
// Whether there was room for all strips of the splat.
fn leave(origin: Strip, first: vec2<i32>, last: vec2<i32>) -> bool {
    let size = last - first + 1;
    let rows = rows_of_strip(size.x);
    let count = u32((size.y + rows - 1) / rows);
    let place = atomicAdd(&strips.count, count);
    let room = arrayLength(&strips.strips);
    let fits = place + count <= room;
    for (var i = 0u; i < count && place + i < room; i++) {
        let row = select(NO_ROW, first.y + i32(i) * rows, fits);
        strips.strips[place + i] = Strip(origin.particle, origin.keep, origin.shape, row);
    }
    return fits;
}
#endif

// The part of the splat `origin`, whose pixels are `first` to `last`, that falls to this invocation.
fn part_of(origin: Strip, first: vec2<i32>, last: vec2<i32>, lane: u32) -> Part {
    let size = last - first + 1;
    let nothing = Part(vec2(0), vec2(-1), vec2(1), 0u);
    if any(size <= vec2(0)) {
        return nothing;
    }
#ifdef STRIPS
    let end = min(origin.first_row + rows_of_strip(size.x) - 1, last.y);
    let begin = vec2(first.x, origin.first_row) + vec2<i32>(vec2(lane % COLUMNS, lane / COLUMNS));
    if begin.x > last.x {
        return nothing;
    }
    let visited = select(0u, u32(size.x * (end - origin.first_row + 1)), lane == 0u);
    return Part(begin, vec2(last.x, end), vec2<i32>(vec2(COLUMNS, ROWS)), visited);
#else
    let area = size.x * size.y;
#ifndef SMALL
    if area > MOST_PX && leave(origin, first, last) {
        return nothing;
    }
#endif
    return Part(first, last, vec2(1), u32(area));
#endif
}

// What a workgroup takes at once: a range, whose splats its lanes share, or a strip, of which each lane draws a part.
struct Item {
    first: Strip,
    count: u32,
}

fn item_count() -> u32 {
#ifdef STRIPS
    return min(atomicLoad(&strips.count), arrayLength(&strips.strips));
#else
    return ranges[0].first;
#endif
}

fn item_at(index: u32) -> Item {
#ifdef STRIPS
    let strip = strips.strips[index];
    return Item(strip, select(0u, 1u, strip.first_row != NO_ROW));
#else
    let range = ranges[index + 1u];
    return Item(Strip(range.first, range.keep, range.shape, 0), range.count);
#endif
}

// The first splat of an item that a lane draws.
fn first_of_lane(lane: u32) -> u32 {
#ifdef STRIPS
    return 0u;
#else
    return lane;
#endif
}

fn splat_of_item(item: Item, i: u32) -> Strip {
    let shape = select(0u, item.first.shape + i, item.first.shape > 0u);
    return Strip(item.first.particle + i, item.first.keep, shape, item.first.first_row);
}
