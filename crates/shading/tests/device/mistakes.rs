//! The conformance suite itself: a plain model passes it, and each mistake in that model is caught by the check that is there
//! for it.

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use meniscus_gpu::{HostField, HostStruct, Shader, host_fields};
use meniscus_shading::conformance::{Check, violations};
use meniscus_shading::twin::TwinInput;
use meniscus_shading::{
    Formula, LightingChoice, LightingRegistry, PixelModel, Promises, Surroundings, WaterScale,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::support::gpu;

/// Scene behind grey glass, with one of the mistakes below.
const SHADER: Shader = Shader {
    name: "test/glass",
    source: r"
#define_import_path meniscus::model
#import meniscus::lighting_inputs::{camera, distance_at, thickness_at, scene_color, attribute_color, coverage}
struct Glass { attenuation: vec3<f32>, spacing_world: f32, mistake: u32, pad_a: u32, pad_b: u32, pad_c: u32 }
@group(0) @binding(2) var<uniform> model: Glass;

fn scene_radiance(pixel: vec2<u32>) -> vec4<f32> {
    if model.mistake == 3u && distance_at(pixel) < 1e37 {
        return water_radiance(pixel);
    }
    let left_out = model.mistake == 6u && pixel.x + 1u == camera.size_px.x;
    let scene = textureLoad(scene_color, pixel, 0) * select(1.0, 0.99, model.mistake == 2u);
    return select(scene, vec4(-1.0), left_out);
}

fn water_radiance(pixel: vec2<u32>) -> vec4<f32> {
    let scene = textureLoad(scene_color, pixel, 0);
    let thickness = thickness_at(pixel);
    // Light that grows with the thickness, or falls too fast.
    let factor = select(select(-1.44269504, -1.6, model.mistake == 1u), 1.44269504, model.mistake == 5u);
    let tint = attribute_color(pixel);
    let through = exp2(factor * model.attenuation * thickness) * select(1.0, 1.2, model.mistake == 8u) * select(1.0, 0.9, model.mistake == 7u);
    let color = mix(scene.rgb * through, tint.rgb, select(tint.a, 0.0, model.mistake == 9u));
    let cover = select(coverage(thickness, model.spacing_world), 1.0, model.mistake == 7u);
    return mix(scene, vec4(color, select(1.0, 0.5, model.mistake == 4u)), cover);
}",
};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
struct GlassParams {
    #[schemars(inner(range(min = 0.0, max = 1000.0)))]
    attenuation_color: [f32; 3],
    mistake: u32,
}

impl Default for GlassParams {
    fn default() -> Self {
        Self { attenuation_color: [0.7, 0.3, 0.2], mistake: 0 }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct GlassUniform {
    attenuation: [f32; 3],
    spacing_world: f32,
    mistake: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

impl HostStruct for GlassUniform {
    const WGSL_NAME: &'static str = "Glass";
    const FIELDS: &'static [HostField] =
        host_fields!(GlassUniform { attenuation, spacing_world, mistake, pad_a, pad_b, pad_c });
}

impl Formula for GlassParams {
    const NAME: &'static str = "glass";
    const SHADER: Shader = SHADER;
    const PASS: &'static str = "test.glass";
    type Uniform = GlassUniform;

    fn promises(&self) -> Promises {
        Promises {
            fades_with_thickness: true,
            makes_no_light: true,
            // It does not reflect at all.
            reflects_by_fresnel: self.mistake == 10,
            absorbs_by_beer_lambert: true,
            shows_attributes: true,
        }
    }

    fn uniform(&self, scale: WaterScale, _: &Surroundings) -> GlassUniform {
        GlassUniform {
            attenuation: self.attenuation_color,
            spacing_world: scale.usable_spacing(),
            mistake: self.mistake,
            ..Zeroable::zeroed()
        }
    }

    fn shade_pixel(model: &GlassUniform, input: &TwinInput<'_>, [x, y]: [u32; 2]) -> [f32; 4] {
        let index = (y * input.camera.size_px[0] + x) as usize;
        let (distance, thickness) = (input.distance[index], input.thickness[index]);
        let scene = Vec4::from(input.scene_color[index]);
        if !(thickness > 0.0 && distance > 0.0 && distance < 1e37 && distance < input.scene_distance[index]) {
            return scene.to_array();
        }
        let tint = Vec4::from(input.surface_color_at(index));
        let through = (-thickness * Vec3::from(model.attenuation)).exp();
        let color = (scene.truncate() * through).lerp(tint.truncate(), tint.w);
        let t = (thickness / (0.5 * model.spacing_world).max(1e-30)).min(1.0);
        scene.lerp(color.extend(1.0), t * t * (3.0 - 2.0 * t)).to_array()
    }
}

#[test]
fn each_mistake_is_caught_by_its_check() {
    let gpu = gpu();
    let registry = LightingRegistry::builtin().with(GlassParams::NAME, PixelModel::<GlassParams>::make);
    let failed = |mistake: u32| -> Vec<Check> {
        let parameters = serde_json::json!({ "mistake": mistake }).as_object().unwrap().clone();
        let choice = LightingChoice { name: GlassParams::NAME.into(), parameters };
        violations(&gpu, &registry, &choice).unwrap().into_iter().map(|found| found.check).collect()
    };
    assert_eq!(failed(0), []);
    for (mistake, check) in [
        (1, Check::Twin),
        (1, Check::BeerLambert),
        (2, Check::NoWaterIsTheScene),
        (3, Check::ObjectsHideWater),
        (4, Check::AlphaIsCoverage),
        (5, Check::AbsurdInputs),
        (6, Check::OddSizes),
        (7, Check::FadesWithThickness),
        (8, Check::MakesNoLight),
        (9, Check::ShowsAttributes),
        (10, Check::Fresnel),
    ] {
        let found = failed(mistake);
        assert!(found.contains(&check), "mistake {mistake} was to fail {check:?}, but failed {found:?}");
    }
}
