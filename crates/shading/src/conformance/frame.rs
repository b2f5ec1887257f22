use glam::{Mat4, Vec2, Vec3};
use meniscus_core::{Aabb, Camera};
use meniscus_gpu::role::{NO_SURFACE, Radiance, SceneColor, SceneDistance, Sunlight};
use meniscus_gpu::{CameraUniform, Covered, Gpu, Recorder, Texture, Timing};
use meniscus_scene::Scene;

use crate::twin::TwinInput;
use crate::{
    EnvironmentMap, LightingInputs, LightingModel, LightingPass, ObjectBounds, ShadingError, SunlightPass,
    Surroundings, WaterScale,
};

/// Surface images of one view, row by row from the top left.
#[derive(Clone, Debug)]
pub struct Water {
    /// Along the view axis; `f32::MAX` = none.
    pub distance: Vec<f32>,
    /// Length of water along the view ray.
    pub thickness: Vec<f32>,
    /// Octahedral view-space normals.
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

/// Everything a lighting model reads, on the host.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The camera.
    pub camera: CameraUniform,
    /// Sun, sky and floor.
    pub surroundings: Surroundings,
    /// The scene that `surroundings` come from, for a picture of it.
    pub scene: Scene,
    /// Box around all objects in it, world; `None` where there is nothing but the floor.
    pub objects: Option<Aabb>,
    /// Lengths of the data.
    pub scale: WaterScale,
    /// The water.
    pub water: Water,
    /// What an attribute gives the water, or nothing.
    pub surface_color: Vec<[f32; 4]>,
    /// The opaque scene; values that half floats hold.
    pub scene_color: Vec<[f32; 4]>,
    /// Its distance.
    pub scene_distance: Vec<f32>,
    /// What becomes of the sun's light, per block or a single value.
    pub sunlight: Vec<[u32; 2]>,
}

impl Frame {
    /// A frame over a scene of one colour at one distance, with a water depth of 1 and a spacing of 0.05.
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
            scene: scene.clone(),
            objects: None,
            scale: WaterScale { depth_world: 1.0, spacing_world: 0.05, metres_per_world: 1.0 },
            water,
            surface_color: vec![[0.0; 4]],
            scene_color: vec![color; pixels],
            scene_distance: vec![distance; pixels],
            sunlight: vec![Sunlight::UNCHANGED],
        }
    }

    /// Other surroundings for the same water.
    pub fn set_scene(&mut self, scene: Scene) {
        self.surroundings = Surroundings::new(&scene);
        self.scene = scene;
    }

    /// Shadows of all depths, and light focused to half and to one and a half.
    pub fn dapple(&mut self) {
        let [width, height] = SunlightPass::size_blocks(self.camera.size_px);
        let depth = self.scale.depth_world;
        let value = |i: u32| {
            let (x, y) = ((i % width) as f32, (i / width) as f32);
            Sunlight::pack(
                depth * (0.3 * x).sin().max(0.0),
                1.0 + 0.5 * (0.7 * y).sin(),
                0.5 + 0.5 * (0.2 * (x + y)).cos(),
            )
        };
        self.sunlight = (0..width * height).map(value).collect();
    }

    /// What the GPU makes of it.
    ///
    /// # Errors
    /// The GPU's.
    pub fn draw(&self, gpu: &Gpu, pass: &dyn LightingPass) -> Result<Vec<[f32; 4]>, ShadingError> {
        self.draw_with(gpu, |recorder, inputs, output| pass.record(gpu, recorder, inputs, output))
    }

    /// What the passes that `record` records make of it.
    ///
    /// # Errors
    /// The GPU's.
    pub fn draw_with(
        &self,
        gpu: &Gpu,
        record: impl FnOnce(&mut Recorder, &LightingInputs<'_>, &Texture<Radiance>),
    ) -> Result<Vec<[f32; 4]>, ShadingError> {
        let size = self.camera.size_px;
        let scene_color = Texture::<SceneColor>::from_floats(gpu, size, &self.scene_color)?;
        let scene_distance = Texture::<SceneDistance>::from_texels(gpu, size, &self.scene_distance)?;
        let one_or = |len: usize, size: [u32; 2]| if len == 1 { [1, 1] } else { size };
        let color_size = one_or(self.surface_color.len(), size);
        let sunlight_size = one_or(self.sunlight.len(), SunlightPass::size_blocks(size));
        let shows = |pixel: usize| self.water.distance[pixel] < NO_SURFACE;
        let inputs = LightingInputs {
            camera: &self.camera,
            surroundings: &self.surroundings,
            environment: &EnvironmentMap::new(gpu, &self.scene)?,
            objects: self.objects,
            scale: self.scale,
            covered: &Covered::of(gpu, size, shows)?,
            distance: &Texture::from_texels(gpu, size, &self.water.distance)?,
            thickness: &Texture::from_texels(gpu, size, &self.water.thickness)?,
            normal: &Texture::from_texels(gpu, size, &self.water.normal)?,
            surface_color: &Texture::from_texels(gpu, color_size, &self.surface_color)?,
            scene_color: &scene_color,
            scene_distance: &scene_distance,
            sunlight: &Texture::from_texels(gpu, sunlight_size, &self.sunlight)?,
            has_sunlight: self.sunlight != [Sunlight::UNCHANGED],
        };
        // What a pass forgets to write is then seen.
        let output = Texture::<Radiance>::from_floats(gpu, size, &vec![[-1.0; 4]; self.scene_color.len()])?;
        let mut recorder = Recorder::new(gpu, Timing::Stamps);
        record(&mut recorder, &inputs, &output);
        let _ = recorder.submit(gpu)?;
        Ok(output.read_floats(gpu)?)
    }

    /// What the twin makes of it.
    pub fn twin(&self, model: &dyn LightingModel) -> Vec<[f32; 4]> {
        self.on_host(|input, pixel| model.twin(input, pixel))
    }

    /// What `twin` makes of every pixel.
    pub fn on_host(&self, twin: impl Fn(&TwinInput<'_>, [u32; 2]) -> [f32; 4]) -> Vec<[f32; 4]> {
        let input = TwinInput {
            camera: &self.camera,
            surroundings: &self.surroundings,
            environment: &EnvironmentMap::texels_of(&self.scene),
            objects: self.objects.map(ObjectBounds::from),
            scale: self.scale,
            distance: &self.water.distance,
            thickness: &self.water.thickness,
            normal: &self.water.normal,
            surface_color: &self.surface_color,
            scene_color: &self.scene_color,
            scene_distance: &self.scene_distance,
            sunlight: &self.sunlight,
        };
        let [width, height] = self.camera.size_px;
        (0..width * height).map(|i| twin(&input, [i % width, i / width])).collect()
    }

    /// A pixel's place, for messages.
    pub fn place(&self, pixel: usize) -> String {
        let [width, height] = self.camera.size_px;
        format!("pixel ({}, {}) of {width}x{height}", pixel as u32 % width, pixel as u32 / width)
    }
}
