use std::f32::consts::{PI, TAU};
use std::path::Path;

use glam::Vec3;
use image::{ImageError, ImageReader, Limits};

use crate::{SceneError, Sun, UpFrame};

/// Radiance from all directions, equirectangular, linear Rec. 709: rows from straight up to straight down, columns clockwise
/// seen from above, north in the middle. Every value is finite and in [0, [`Self::MAX_RADIANCE`]].
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    size: [usize; 2],
    radiance: Vec<[f32; 3]>,
}

impl Environment {
    /// Brightest radiance: what half floats hold.
    pub const MAX_RADIANCE: f32 = 6e4;
    /// Most columns that are kept: a tenth of a degree each would be 3600.
    const MAX_WIDTH: usize = 2048;
    /// Files with more pixels are not read.
    const MAX_PIXELS: u64 = 1 << 27;
    /// Irradiance that level ground gets, sun and sky together, as in the automatic scene: a white floor comes out near 1.
    const GROUND_IRRADIANCE: f32 = 3.2;
    /// Radiance above this multiple of the mean belongs to the sun: to a lamp that casts shadows and glints.
    const SUN_CONTRAST: f32 = 12.0;

    /// From a function of the unit direction in the components of `UpFrame`: east, north, up. Values that are not finite or
    /// negative count as 0.
    pub fn from_fn(size: [usize; 2], radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let at = |i: usize| radiance(direction(size, i % size[0], i / size[0])).to_array().map(usable);
        Self { size, radiance: (0..size[0] * size[1]).map(at).collect() }
    }

    /// Reads an `.hdr` or `.exr` picture, which its shape tells to be equirectangular (twice as wide as high), a horizontal
    /// cross of cube faces (4 to 3) or a strip of them (6 to 1: +x, -x, +y, -y, +z, -z with y up and -z north).
    ///
    /// # Errors
    /// [`SceneError::Environment`] with the file and what is wrong with it.
    pub fn read(file: &Path) -> Result<Self, SceneError> {
        let fail = |message: String| SceneError::Environment { file: file.display().to_string(), message };
        let mut reader = ImageReader::open(file)
            .and_then(ImageReader::with_guessed_format)
            .map_err(|e| fail(format!("cannot be read: {e}")))?;
        let known = [image::ImageFormat::Hdr, image::ImageFormat::OpenExr];
        if !reader.format().is_some_and(|format| known.contains(&format)) {
            return Err(fail("is neither Radiance .hdr nor OpenEXR; convert it to one of them".into()));
        }
        let mut limits = Limits::default();
        limits.max_image_width = Some(1 << 16);
        limits.max_image_height = Some(1 << 16);
        limits.max_alloc = Some(Self::MAX_PIXELS * 16);
        reader.limits(limits);
        let picture = match reader.decode() {
            Ok(picture) => picture.into_rgb32f(),
            Err(ImageError::Limits(_)) => {
                return Err(fail(format!("has more than {} pixels; make it smaller", Self::MAX_PIXELS)));
            }
            Err(e) => return Err(fail(format!("is damaged or cut off: {e}"))),
        };
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let texels: Vec<[f32; 3]> = picture.pixels().map(|pixel| pixel.0.map(usable)).collect();
        let shape = Shape::of(width, height).ok_or_else(|| {
            fail(format!(
                "is {width} x {height}; expected an equirectangular picture, twice as wide as high, or cube faces in a \
                 cross (4 to 3) or a strip (6 to 1)"
            ))
        })?;
        if texels.iter().all(|texel| *texel == [0.0; 3]) {
            return Err(fail("is black all over; nothing would be seen".into()));
        }
        Ok(match shape {
            Shape::Equirectangular => Self { size: [width, height], radiance: texels }.reduced(),
            Shape::Cross | Shape::Strip => {
                let side = if shape == Shape::Cross { width / 4 } else { height };
                let size = [(4 * side).min(Self::MAX_WIDTH), (2 * side).min(Self::MAX_WIDTH / 2)];
                Self::from_fn(size, |d| {
                    let (face, u, v) = cube_face(d);
                    let [column, row] = shape.face(face);
                    let place = |at: f32| ((at * side as f32) as usize).min(side - 1);
                    texels[(row * side + place(v)) * width + column * side + place(u)].into()
                })
            }
        })
    }

    /// `[columns, rows]`, both at least 1.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Row by row.
    pub fn radiance(&self) -> &[[f32; 3]] {
        &self.radiance
    }

    /// Turned clockwise seen from above.
    #[must_use]
    pub fn turned(mut self, degrees: f32) -> Self {
        let columns = (degrees / 360.0 * self.size[0] as f32).rem_euclid(self.size[0] as f32) as usize;
        for row in self.radiance.chunks_mut(self.size[0]) {
            row.rotate_right(columns.min(row.len()));
        }
        self
    }

    /// Nearest texel in the unit direction (east, north, up).
    pub fn at(&self, direction: Vec3) -> Vec3 {
        let [width, height] = self.size;
        let u = direction.x.atan2(direction.y) / TAU + 0.5;
        let v = direction.z.clamp(-1.0, 1.0).acos() / PI;
        let x = ((u * width as f32) as usize).min(width - 1);
        let y = ((v * height as f32) as usize).min(height - 1);
        self.radiance[y * width + x].into()
    }

    /// Irradiance on a surface that faces `normal` (east, north, up).
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.integral(|d, radiance| radiance * d.dot(normal).max(0.0))
    }

    /// Takes the sun out of the picture and brings everything to the brightness of the automatic scene: radiance far
    /// above the mean becomes a lamp, so that it throws shadows and glints instead of being missed or hit at random. Returns
    /// the lamp; `given` is one that the picture lacks, on the picture's own scale.
    pub fn split_sun(&mut self, frame: UpFrame, given: Option<Sun>) -> Sun {
        let mean = luminance(self.integral(|_, radiance| radiance)) / (4.0 * PI);
        let cap = Self::SUN_CONTRAST * mean;
        let (mut irradiance, mut towards) = (Vec3::ZERO, Vec3::ZERO);
        let [width, height] = self.size;
        for y in 0..height {
            let solid_angle = self.solid_angle(y);
            for x in 0..width {
                let texel = &mut self.radiance[y * width + x];
                let radiance = Vec3::from(*texel);
                let bright = luminance(radiance);
                if bright > cap {
                    let kept = radiance * (cap / bright);
                    irradiance += (radiance - kept) * solid_angle;
                    towards += (bright - cap) * solid_angle * direction(self.size, x, y);
                    *texel = kept.to_array();
                }
            }
        }
        let found = Sun {
            direction: frame.world_of(towards.normalize_or(Vec3::new(0.0, -0.5, 0.866))),
            irradiance: irradiance.to_array(),
        };
        let sun = given.unwrap_or(found);
        let height = sun.direction.dot(frame.up).max(0.0);
        let ground = luminance(self.irradiance(Vec3::Z) + height * Vec3::from(sun.irradiance));
        let scale = if ground.is_normal() { Self::GROUND_IRRADIANCE / ground } else { 1.0 };
        self.scale(scale);
        Sun { irradiance: sun.irradiance.map(|e| (e * scale).min(Self::MAX_RADIANCE)), ..sun }
    }

    /// Times `factor` >= 0.
    pub fn scale(&mut self, factor: f32) {
        self.radiance.iter_mut().for_each(|texel| *texel = texel.map(|c| usable(c * factor)));
    }

    fn solid_angle(&self, row: usize) -> f32 {
        let [width, height] = self.size;
        let edge = |y: usize| (PI * y as f32 / height as f32).cos();
        (edge(row) - edge(row + 1)) * TAU / width as f32
    }

    fn integral(&self, of: impl Fn(Vec3, Vec3) -> Vec3) -> Vec3 {
        let [width, height] = self.size;
        let row = |y: usize| {
            let texels = self.radiance[y * width..][..width].iter().enumerate();
            let sum: Vec3 = texels.map(|(x, t)| of(direction(self.size, x, y), Vec3::from(*t))).sum();
            sum * self.solid_angle(y)
        };
        (0..height).map(row).sum()
    }

    /// Halved until it is no wider than [`Self::MAX_WIDTH`].
    fn reduced(mut self) -> Self {
        while self.size[0] > Self::MAX_WIDTH {
            self = self.halved();
        }
        self
    }

    /// Means of two by two texels; odd last ones go with none.
    #[must_use]
    pub fn halved(&self) -> Self {
        let [width, height] = self.size;
        let size = [(width / 2).max(1), (height / 2).max(1)];
        let texel = |i: usize| {
            let (x, y) = (2 * (i % size[0]), 2 * (i / size[0]));
            let at = |dx: usize, dy: usize| {
                Vec3::from(self.radiance[(y + dy).min(height - 1) * width + (x + dx).min(width - 1)])
            };
            (0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1))).to_array()
        };
        Self { size, radiance: (0..size[0] * size[1]).map(texel).collect() }
    }
}

/// Unit direction (east, north, up) of the middle of a texel.
fn direction(size: [usize; 2], x: usize, y: usize) -> Vec3 {
    let azimuth = TAU * ((x as f32 + 0.5) / size[0] as f32 - 0.5);
    let polar = PI * (y as f32 + 0.5) / size[1] as f32;
    Vec3::new(polar.sin() * azimuth.sin(), polar.sin() * azimuth.cos(), polar.cos())
}

/// Rec. 709.
fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn usable(channel: f32) -> f32 {
    if channel.is_nan() { 0.0 } else { channel.clamp(0.0, Environment::MAX_RADIANCE) }
}

/// What a picture's shape says about its layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Equirectangular,
    Cross,
    Strip,
}

impl Shape {
    fn of(width: usize, height: usize) -> Option<Self> {
        [(Self::Equirectangular, 2, 1), (Self::Cross, 4, 3), (Self::Strip, 6, 1)]
            .into_iter()
            .find_map(|(shape, w, h)| (width > 0 && width * h == height * w).then_some(shape))
    }

    /// Column and row of a face, faces in the order of the strip.
    fn face(self, face: usize) -> [usize; 2] {
        match self {
            Self::Cross => [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]][face],
            _ => [face, 0],
        }
    }
}

/// Face and place on it, from its top left, of a direction (east, north, up): x is east, y up, -z north. Faces are seen
/// from inside, as in OpenGL; +z, behind the viewer in the front view, is the middle of the cross.
fn cube_face(d: Vec3) -> (usize, f32, f32) {
    let (x, y, z) = (d.x, d.z, -d.y);
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let (face, u, v, major) = if ax >= ay && ax >= az {
        if x > 0.0 { (0, -z, -y, ax) } else { (1, z, -y, ax) }
    } else if ay >= az {
        if y > 0.0 { (2, x, z, ay) } else { (3, x, -z, ay) }
    } else if z > 0.0 {
        (4, x, -y, az)
    } else {
        (5, -x, -y, az)
    };
    (face, 0.5 * (u / major + 1.0), 0.5 * (v / major + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_core::UpAxis;

    const NORTH: Vec3 = Vec3::Y;

    #[test]
    fn white_surroundings_have_the_irradiance_of_pi() {
        let white = Environment::from_fn([64, 32], |_| Vec3::ONE);
        for normal in [Vec3::Z, NORTH, Vec3::new(0.6, 0.0, -0.8)] {
            // 1 %: the rule of midpoints on 64 x 32 texels.
            assert!((white.irradiance(normal) / PI - 1.0).abs().max_element() < 1e-2, "{normal}");
        }
    }

    #[test]
    fn directions_and_texels_belong_together() {
        let image = Environment::from_fn([64, 32], |d| d * 0.5 + 0.5);
        for d in [Vec3::Z, NORTH, Vec3::X, Vec3::new(-0.6, -0.48, 0.64), Vec3::NEG_Z] {
            // 0.08: half a texel of 5.6 degrees, along both axes.
            assert!((2.0 * image.at(d) - 1.0).distance(d) < 0.08, "{d}: {}", image.at(d));
        }
        let quarter = image.turned(90.0);
        // What was north is east.
        assert!((2.0 * quarter.at(Vec3::X) - 1.0).distance(NORTH) < 0.08);
    }

    #[test]
    fn the_sun_becomes_a_lamp_and_nothing_gets_lost() {
        let towards = Vec3::new(0.48, 0.6, 0.64);
        let lit = |d: Vec3| if d.dot(towards) > 0.9996 { Vec3::splat(4e4) } else { Vec3::splat(0.5) };
        let mut image = Environment::from_fn([512, 256], lit);
        let before = image.irradiance(Vec3::Z);
        let frame = UpFrame::new(UpAxis::Z);
        let sun = image.split_sun(frame, None);
        // Two texels of 0.7 degrees.
        assert!(sun.direction.distance(towards) < 0.025, "{}", sun.direction);
        let after = image.irradiance(Vec3::Z) + sun.direction.z * Vec3::from(sun.irradiance);
        assert!((luminance(after) / Environment::GROUND_IRRADIANCE - 1.0).abs() < 1e-3);
        let share = |all: Vec3, sky: Vec3| luminance(sky) / luminance(all);
        assert!(luminance(before) > 1.0 && share(after, image.irradiance(Vec3::Z)) < 0.2);
        // What is left of the sun is no brighter than the contrast that is allowed, against a mean that it was part of.
        let mean = luminance(image.integral(|_, radiance| radiance)) / (4.0 * PI);
        assert!(luminance(image.at(towards)) > mean);
    }

    #[test]
    fn cube_faces_meet_and_point_where_they_say() {
        for (d, face) in
            [(Vec3::X, 0), (Vec3::NEG_X, 1), (Vec3::Z, 2), (Vec3::NEG_Z, 3), (-NORTH, 4), (NORTH, 5)]
        {
            assert_eq!(cube_face(d), (face, 0.5, 0.5), "{d}");
        }
        // Left in the picture of the front face, seen from inside looking towards +z, lies -x; up lies up.
        let (face, u, v) = cube_face(Vec3::new(-0.5, -0.7, 0.3).normalize());
        assert!(face == 4 && u < 0.5 && v < 0.5);
    }

    fn written(
        name: &str,
        width: u32,
        height: u32,
        texel: [f32; 3],
    ) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        image::Rgb32FImage::from_pixel(width, height, image::Rgb(texel)).save(&file).unwrap();
        (folder, file)
    }

    #[test]
    fn both_formats_and_all_shapes_are_read() {
        for name in ["sky.hdr", "sky.exr"] {
            for (width, height) in [(64, 32), (64, 48), (96, 16)] {
                let (_folder, file) = written(name, width, height, [0.5, 1.0, 2.0]);
                let image = Environment::read(&file).unwrap();
                // 1 %: the shared exponent of .hdr.
                assert!((image.at(NORTH) - Vec3::new(0.5, 1.0, 2.0)).abs().max_element() < 0.02, "{name}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_in_a_file_gives_finite_light() {
        let (_folder, file) = written("odd.exr", 64, 32, [f32::NAN, f32::INFINITY, -1.0]);
        let mut image = Environment::read(&file).unwrap();
        let sun = image.split_sun(UpFrame::new(UpAxis::Z), None);
        assert!(image.radiance().iter().flatten().chain(&sun.irradiance).all(|c| c.is_finite() && *c >= 0.0));
    }

    #[test]
    fn mistakes_name_the_file() {
        let message = |file: &Path| Environment::read(file).unwrap_err().to_string();
        let missing = message(Path::new("no/such.hdr"));
        assert!(missing.contains("no/such.hdr") && missing.contains("cannot be read"), "{missing}");
        let (_folder, square) = written("square.hdr", 32, 32, [1.0; 3]);
        assert!(message(&square).contains("32 x 32"));
        let (_folder, black) = written("black.exr", 32, 16, [0.0; 3]);
        assert!(message(&black).contains("black"));
        let (folder, whole) = written("sky.exr", 256, 128, [1.0; 3]);
        let bytes = std::fs::read(&whole).unwrap();
        let cut = folder.path().join("cut.exr");
        std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
        assert!(message(&cut).contains("damaged"), "{}", message(&cut));
        let other = folder.path().join("sky.png");
        std::fs::write(&other, "particles").unwrap();
        assert!(message(&other).contains("neither"));
    }
}
