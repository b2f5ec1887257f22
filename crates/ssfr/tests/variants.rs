//! Variants of passes are composed when they are drawn; here all of them are, whether another test draws them or not.

use meniscus_gpu::{AdapterChoice, Gpu};
use meniscus_ssfr::{
    Anisotropy, Coloring, FilterChoice, FilterRegistry, FoamSplats, ShapePasses, Ssfr, SsfrParams,
};

#[test]
fn all_variants_compose() {
    let gpu = Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers");
    let filters = FilterRegistry::builtin();
    for entry in filters.entries() {
        let mut params = SsfrParams {
            filter: FilterChoice { name: entry.name().to_owned(), ..Default::default() },
            ..Default::default()
        };
        params.anisotropy.form = Some(Anisotropy::YuTurk);
        let _ = Ssfr::new(&gpu, &filters, &params).unwrap();
    }
    let _ = (ShapePasses::new(&gpu).unwrap(), FoamSplats::new(&gpu));
    let _ = Coloring::new(&gpu, [4, 4], &[[0.0; 4]; 2]).unwrap();
    gpu.compose_variants().unwrap();
}
