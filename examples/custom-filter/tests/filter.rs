//! The suite that every filter runs through, over this one.

use custom_filter::{PlaneFit, PlaneFitParams};
use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_ssfr::{FilterRegistry, conformance};

#[test]
fn the_plane_fit_conforms() {
    let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
    let registry = FilterRegistry::builtin().with_filter(PlaneFit::entry());
    conformance::assert_conforms(
        &gpu,
        &registry,
        PlaneFit::NAME,
        &[r#"{"sigma": 0.5, "passes": 2}"#, r#"{"sigma": 2.0, "range": 3.0, "passes": 4}"#],
    );
}

#[test]
fn parameters_out_of_range_are_named() {
    let message = |params: PlaneFitParams| params.validate().unwrap_err().to_string();
    assert!(
        message(PlaneFitParams { sigma: f32::NAN, ..Default::default() }).contains("filter.sigma is NaN")
    );
    assert!(message(PlaneFitParams { passes: 9, ..Default::default() }).contains("filter.passes is 9"));
}
