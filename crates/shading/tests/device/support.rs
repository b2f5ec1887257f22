//! Analytic water for tests: images as the surface stage would give them.

use glam::{Mat4, Vec2, Vec3};
use meniscus_core::{Aabb, Camera, UpAxis};
use meniscus_gpu::role::{
    EyeDistance, NO_SURFACE, Radiance, SceneColor, SceneDepth, SceneDistance, Thickness, ViewNormal,
};
use meniscus_gpu::{AdapterChoice, CameraUniform, Gpu, Image, Recorder, Texture, Timing};
use meniscus_scene::Scene;
use meniscus_shading::twin::{TwinInput, water_shadow};
use meniscus_shading::{
    LightingInputs, LightingModel, SceneGeometry, ScenePass, SunPath, Surroundings, WaterScale, WaterShadow,
};

pub fn gpu() -> Gpu {
    Gpu::new(&AdapterChoice::default()).expect("an adapter, at least mesa-vulkan-drivers")
}

/// Surface images of one view.
pub struct Water {
    pub distance: Vec<f32>,
    pub thickness: Vec<f32>,
    pub normal: Vec<u32>,
}

/// Octahedral map of a unit vector to two snorm16.
pub fn pack_normal(n: Vec3) -> u32 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let folded = Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y));
    let q = if n.z >= 0.0 { p } else { folded };
    let snorm = |x: f32| (x.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16 as u32;
    snorm(q.x) | snorm(q.y) << 16
}

/// Ray caster for a body given by a distance bound `inside(p)` (negative inside), above the plane y = 0.
pub fn cast(camera: &CameraUniform, bounds: Aabb, step: f32, body: impl Fn(Vec3) -> f32) -> Water {
    let [width, height] = camera.size_px;
    let world_from_view = Mat4::from_cols_array_2d(&camera.world_from_view);
    let view_from_world = Mat4::from_cols_array_2d(&camera.view_from_world);
    let bounds = bounds.inflated(step);
    let mut water = Water { distance: Vec::new(), thickness: Vec::new(), normal: Vec::new() };
    for i in 0..width * height {
        let px = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
        let ndc = px / Vec2::new(width as f32, height as f32) * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        let offset = ndc * Vec2::from(camera.half_extent);
        let (origin, along) = if camera.orthographic != 0 {
            (offset.extend(0.0), Vec3::NEG_Z)
        } else {
            (Vec3::ZERO, offset.extend(-1.0))
        };
        let origin = world_from_view.transform_point3(origin);
        let along = world_from_view.transform_vector3(along);
        let direction = along.normalize();
        let inverse = direction.recip();
        let (a, b) = ((bounds.min - origin) * inverse, (bounds.max - origin) * inverse);
        let floor = if direction.y < 0.0 { -origin.y / direction.y } else { f32::MAX };
        let (mut t, end) = (a.min(b).max_element().max(0.0), a.max(b).min_element().min(floor));
        let mut front = None;
        let mut thickness = 0.0;
        while t < end {
            let d = body(origin + t * direction);
            if d < 0.0 {
                if front.is_none() {
                    // Bisection of the last step.
                    let (mut out, mut within) = (t - step, t);
                    for _ in 0..12 {
                        let middle = 0.5 * (out + within);
                        if body(origin + middle * direction) < 0.0 { within = middle } else { out = middle }
                    }
                    front = Some(within);
                    thickness += t - within;
                }
                thickness += step.min(end - t);
            }
            t += if d < 0.0 { step } else { (0.6 * d).max(step) };
        }
        let Some(front) = front else {
            water.distance.push(NO_SURFACE);
            water.thickness.push(0.0);
            water.normal.push(0);
            continue;
        };
        let p = origin + front * direction;
        let e = 0.25 * step;
        let normal =
            Vec3::from([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| body(p + e * axis) - body(p - e * axis)));
        water.distance.push(front / along.length());
        water.thickness.push(thickness);
        water.normal.push(pack_normal(view_from_world.transform_vector3(normal.normalize_or(Vec3::Y))));
    }
    water
}

/// Everything a lighting model reads, on the GPU and on the host.
pub struct Frame {
    pub camera: CameraUniform,
    pub surroundings: Surroundings,
    pub scale: WaterScale,
    pub water: Water,
    pub scene_color: Vec<[f32; 4]>,
    pub scene_distance: Vec<f32>,
}

impl Frame {
    /// A frame over a scene of one colour at one distance.
    pub fn plain(
        camera: &Camera,
        size: [u32; 2],
        scene: &Scene,
        water: Water,
        color: [f32; 4],
        distance: f32,
    ) -> Self {
        let pixels = (size[0] * size[1]) as usize;
        Self {
            camera: CameraUniform::new(camera, size),
            surroundings: Surroundings::new(scene),
            scale: WaterScale { depth_world: 1.0, spacing_world: 0.05, metres_per_world: 1.0 },
            water,
            scene_color: vec![color; pixels],
            scene_distance: vec![distance; pixels],
        }
    }

    /// What the GPU makes of it.
    pub fn render(&self, gpu: &Gpu, model: &dyn LightingModel) -> Vec<[f32; 4]> {
        let size = self.camera.size_px;
        let scene_color = Texture::<SceneColor>::new(gpu, size).unwrap();
        let half: Vec<half::f16> =
            self.scene_color.iter().flatten().map(|&x| half::f16::from_f32(x)).collect();
        scene_color.write(gpu, &half.iter().flat_map(|h| h.to_le_bytes()).collect::<Vec<u8>>());
        let scene_distance = Texture::<SceneDistance>::new(gpu, size).unwrap();
        scene_distance.write(gpu, bytemuck::cast_slice(&self.scene_distance));
        let distance = Image::<EyeDistance>::from_pixels(gpu, size, &self.water.distance).unwrap();
        let thickness = Image::<Thickness>::from_pixels(gpu, size, &self.water.thickness).unwrap();
        let normal = Image::<ViewNormal>::from_pixels(gpu, size, &self.water.normal).unwrap();
        let sun_path = Image::<SunPath>::new(gpu, WaterShadow::size_blocks(size)).unwrap();
        let output = Image::<Radiance>::new(gpu, size).unwrap();
        let pass = model.compile(gpu).unwrap();
        let mut recorder = Recorder::new(gpu, Timing::Stamps);
        WaterShadow::new(gpu).unwrap().record(
            gpu,
            &mut recorder,
            &self.camera,
            &self.surroundings,
            self.scale,
            &distance,
            &thickness,
            &scene_distance,
            &sun_path,
        );
        let inputs = LightingInputs {
            camera: &self.camera,
            surroundings: &self.surroundings,
            scale: self.scale,
            distance: &distance,
            thickness: &thickness,
            normal: &normal,
            surface_color: &Image::new(gpu, [1, 1]).unwrap(),
            scene_color: &scene_color,
            scene_distance: &scene_distance,
            sun_path: &sun_path,
        };
        pass.record(gpu, &mut recorder, &inputs, &output);
        let _ = recorder.submit(gpu).unwrap();
        output.read(gpu).unwrap()
    }

    /// What the twin makes of it.
    pub fn twin(&self, model: &dyn LightingModel) -> Vec<[f32; 4]> {
        let sun_path = water_shadow(
            &self.camera,
            &self.surroundings,
            self.scale,
            &self.water.distance,
            &self.water.thickness,
            &self.scene_distance,
        );
        let input = TwinInput {
            camera: &self.camera,
            surroundings: &self.surroundings,
            scale: self.scale,
            distance: &self.water.distance,
            thickness: &self.water.thickness,
            normal: &self.water.normal,
            surface_color: &[],
            scene_color: &self.scene_color,
            scene_distance: &self.scene_distance,
            sun_path: &sun_path,
        };
        let [width, height] = self.camera.size_px;
        (0..width * height).map(|i| model.twin(&input, [i % width, i / width])).collect()
    }
}

/// A world with y up and a tiled floor at y = 0 under the unit box.
pub fn tiled_scene() -> Scene {
    Scene::around(Aabb { min: Vec3::ZERO, max: Vec3::new(2.0, 0.5, 1.0) }, UpAxis::Y, 0.0)
}

/// The drawn scene: colour and distance.
pub fn draw_scene(
    gpu: &Gpu,
    camera: &CameraUniform,
    scene: &Scene,
) -> (Texture<SceneColor>, Texture<SceneDistance>) {
    let size = camera.size_px;
    let color = Texture::<SceneColor>::new(gpu, size).unwrap();
    let distance = Texture::<SceneDistance>::new(gpu, size).unwrap();
    let depth = Texture::<SceneDepth>::new(gpu, size).unwrap();
    let geometry = SceneGeometry::new(gpu, scene).unwrap();
    let mut recorder = Recorder::new(gpu, Timing::Stamps);
    ScenePass::new(gpu).unwrap().record(gpu, &mut recorder, camera, &geometry, &color, &distance, &depth);
    let _ = recorder.submit(gpu).unwrap();
    (color, distance)
}
