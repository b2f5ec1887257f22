#define_import_path meniscus::ellipsoid
#import meniscus::camera::Camera
#import meniscus::particle::PackedParticle
#import meniscus::shape::unpack_shape
#import meniscus::splat::{SplatSet, Splat, Grid, Outline, SurfacePixels, splat_of, rectangle, pixels_of}

// A particle that is drawn as an ellipsoid. Everything in x, y of view space and distance along the view axis.
struct Ellipsoid {
    // Of the sphere in its place; its centre is the ellipsoid's.
    splat: Splat,
    // Maps the ellipsoid's points around its centre to those of a sphere of the same radius.
    to_sphere: mat3x3<f32>,
    // The matrix Q of the quadric: n . Q n is the square of how far the ellipsoid reaches along the direction n.
    xx: f32,
    yy: f32,
    dd: f32,
    xy: f32,
    xd: f32,
    yd: f32,
}

// Where the line of sight through a pixel meets an ellipsoid.
struct Hit {
    // Square of half of the stretch of distances inside, times `a` squared; negative = miss.
    reachable: f32,
    a: f32,
    k: f32,
}

// A sphere that holds the ellipsoid of a particle, whatever its shape.
fn bounding_sphere(camera: Camera, splats: SplatSet, particle: PackedParticle, keep: u32) -> Splat {
    let splat = splat_of(camera, splats, particle, keep);
    return Splat(splat.center, splat.radius * splats.longest_axis + splats.most_shift_world, splat.volume);
}

fn ellipsoid_of(camera: Camera, splats: SplatSet, particle: PackedParticle, keep: u32, bits: vec4<u32>) -> Ellipsoid {
    let shape = unpack_shape(bits);
    var moved = particle;
    moved.position_world += shape.shift * splats.most_shift_world;
    let splat = splat_of(camera, splats, moved, keep);
    let v = camera.view_from_world;
    let turn = mat3x3(vec3(v[0].xy, -v[0].z), vec3(v[1].xy, -v[1].z), vec3(v[2].xy, -v[2].z));
    let d = shape.diagonal;
    let m = shape.mixed;
    let axes = turn * mat3x3(vec3(d.x, m.x, m.y), vec3(m.x, d.y, m.z), vec3(m.y, m.z, d.z));
    // The adjugate over the determinant: half-axes are a sixteenth of each other at least.
    let xx = d.y * d.z - m.z * m.z;
    let xy = m.y * m.z - m.x * d.z;
    let xz = m.x * m.z - m.y * d.y;
    let inverse = mat3x3(
        vec3(xx, xy, xz),
        vec3(xy, d.x * d.z - m.y * m.y, m.x * m.y - d.x * m.z),
        vec3(xz, m.x * m.y - d.x * m.z, d.x * d.y - m.x * m.x),
    ) * (1.0 / (d.x * xx + m.x * xy + m.y * xz));
    // Rows of the axes; a rotation on the left of `to_sphere` changes nothing.
    let rows = transpose(axes) * splat.radius;
    return Ellipsoid(
        splat,
        inverse * transpose(turn),
        dot(rows[0], rows[0]),
        dot(rows[1], rows[1]),
        dot(rows[2], rows[2]),
        dot(rows[0], rows[1]),
        dot(rows[0], rows[2]),
        dot(rows[1], rows[2]),
    );
}

// Nearest distance of the ellipsoid.
fn front_of(ellipsoid: Ellipsoid) -> f32 {
    return ellipsoid.splat.center.z - sqrt(ellipsoid.dd);
}

// As `is_drawn` of spheres.
fn is_ellipsoid_drawn(camera: Camera, ellipsoid: Ellipsoid) -> bool {
    return ellipsoid.splat.radius > 0.0 && front_of(ellipsoid) >= camera.near_world;
}

// Its exact outline: planes through the eye that touch it (algorithms.md 1.2), multiplied out, so that nothing of the order of distance
// to the fourth is subtracted.
fn ellipsoid_outline(grid: Grid, ellipsoid: Ellipsoid) -> Outline {
    let center = ellipsoid.splat.center;
    let own = vec2(ellipsoid.xx, ellipsoid.yy);
    let d = center.z;
    let dd = ellipsoid.dd;
    let across = vec2(ellipsoid.xd, ellipsoid.yd);
    let inverse = 1.0 / (d * d - dd);
    let square = d * d * own - 2.0 * d * center.xy * across + center.xy * center.xy * dd + across * across - own * dd;
    let mixed = d * d * ellipsoid.xy - d * (center.x * across.y + center.y * across.x) + center.x * center.y * dd
        + across.x * across.y - ellipsoid.xy * dd;
    // Selected, not branched on: see `footprint`.
    let is_perspective = grid.perspective > 0.0;
    let middle = select(center.xy, (center.xy * d - across) * inverse, is_perspective);
    let reach = select(own, max(square, vec2(0.0)) * (inverse * inverse), is_perspective);
    return Outline(middle, reach.x, select(ellipsoid.xy, mixed * (inverse * inverse), is_perspective), reach.y);
}

// Pixels that the ellipsoid is drawn to.
fn ellipsoid_pixels(grid: Grid, ellipsoid: Ellipsoid) -> SurfacePixels {
    let outline = ellipsoid_outline(grid, ellipsoid);
    let center = ellipsoid.splat.center;
    let point = select(center.xy, center.xy / center.z, grid.perspective > 0.0);
    return pixels_of(grid, rectangle(grid, outline.middle, sqrt(vec2(outline.xx, outline.yy)), point));
}

// Line of sight at `s` per distance, `o` from the centre where it is as far as that, against the ellipsoid; both mapped by
// `to_sphere` (algorithms.md 1.3). It is met at the centre's distance less (k + sqrt(reachable)) / a.
fn hit_at(ellipsoid: Ellipsoid, o: vec3<f32>, s: vec3<f32>) -> Hit {
    let a = dot(s, s);
    let k = dot(o, s);
    let radius = ellipsoid.splat.radius;
    return Hit(k * k + a * (radius * radius - dot(o, o)), a, k);
}
