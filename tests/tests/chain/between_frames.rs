//! Films of real data: a frame that is left out is found again between its neighbours.

use glam::Vec3;
use meniscus_core::{Cancel, FrameRequest, FrameSource, SetFrame};
use meniscus_io::{Series, SeriesOptions};
use meniscus_tests::data_dir;
use meniscus_timeline::{Motion, between};

/// Root mean square of the distances between particles of the same id.
fn distance(a: &SetFrame, b: &SetFrame) -> f64 {
    let by_id = |frame: &SetFrame| {
        let particles = &frame.sets[0].particles;
        let mut all: Vec<(u64, Vec3)> =
            particles.ids.iter().copied().zip(particles.positions.iter().map(|p| Vec3::from(*p))).collect();
        all.sort_by_key(|(id, _)| *id);
        all
    };
    let (a, b) = (by_id(a), by_id(b));
    assert!(a.len() > 1000 && a.iter().zip(&b).all(|(a, b)| a.0 == b.0), "the same particles");
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| f64::from(a.1.distance_squared(b.1))).sum();
    (squares / a.len() as f64).sqrt()
}

#[test]
fn particles_of_a_real_flow_are_where_the_solver_had_them() {
    let Some(data) = data_dir() else { return };
    let series =
        Series::open(&data.join("sphere_entry/fluid.pvd"), &SeriesOptions::default()).expect("a series");
    assert!(series.has_ids());
    let velocity = series.velocity().expect("velocities");
    let request = FrameRequest { attributes: vec![velocity.to_owned()] };
    let read = |index| series.read(index, &request, &Cancel::default()).expect("a frame");
    let spacing = series.space().spacing;
    // Steps of 4 ms while the sphere enters, of 16 ms at the end.
    for [first, left_out, last] in [[4, 5, 6], [10, 11, 12], [17, 18, 19]] {
        let [a, b, c] = [first, left_out, last].map(read);
        let [at, from, to] = [&b, &a, &c].map(|frame| frame.time.expect("a time"));
        let found = |velocity: Option<&str>| {
            let (share, step) = ((at - from) / (to - from), to - from);
            distance(&between(&a, &c, &Motion { share, step, velocity, spacing_world: spacing as f32 }), &b)
        };
        let held = distance(&a, &b).min(distance(&c, &b));
        let (curved, straight) = (found(Some(velocity)), found(None));
        // Measured, in spacings: held 0.14, 0.13 and 0.47, straight 0.039, 0.026 and 0.25, curved 0.018, 0.009 and 0.15. Without
        // the curve there would be nothing between the last two.
        assert!(straight < 0.7 * held, "{straight} {held}");
        assert!(curved < 0.7 * straight, "{curved} {straight}");
    }
}
