//! Pictures of VTK beside ours, small enough to be committed.

use std::path::{Path, PathBuf};

use super::{
    fluid::Files,
    samples::Samples,
    tool::{Tools, json},
};
use crate::{
    error::{Error, Result},
    process,
};

/// What is drawn by both.
#[derive(Debug, PartialEq)]
struct Subject {
    /// Of the files.
    name: &'static str,
    data: Data,
    /// Of the water, as `meniscus render` finds it for its absorption.
    depth: f64,
}

/// Where its particles come from.
#[derive(Debug, PartialEq)]
enum Data {
    /// A file of `benches/views`, without its ending: made, with a camera.
    View(&'static str),
    /// A case of `meniscus make`, with the land around it.
    Made { case: &'static str, view: FixedView },
    /// A frame of a series in the folder of third-party data, of which a part is water.
    Series { path: &'static str, frame: &'static str, water: &'static str, view: FixedView },
}

/// What a view has and a series has not, in the coordinates of the series.
#[derive(Debug, PartialEq)]
struct FixedView {
    size: [u32; 2],
    camera: &'static str,
    radius: f64,
}

const SUBJECTS: [Subject; 3] = [
    Subject { name: "sphere-entry", data: Data::View("sphere-entry"), depth: 0.306 },
    Subject {
        name: "pysph-dam-break",
        data: Data::Series {
            path: "pysph_dam_break/dam.pvd",
            frame: "6",
            water: "type == 0",
            // What `meniscus render` chooses, rounded.
            view: FixedView {
                size: [1280, 720],
                camera: "1.731,-2.012,1.246/0.634,-0.057,0.197/0,0,1/26.9",
                radius: 0.0281,
            },
        },
        depth: 0.46,
    },
    Subject {
        name: "fjord-tsunami",
        data: Data::Made {
            case: "fjord-tsunami",
            view: FixedView {
                size: [1280, 720],
                camera: "500900,3398900,480/499400,3399900,120/0,0,1/45",
                radius: 1.967,
            },
        },
        depth: 116.5,
    },
];

/// Towards the sun of our automatic scene, for data that are not much longer to the north than to the east and have z up.
const SUN: &str = "-0.181,-0.644,0.743";

/// Towards the sun of the scene that comes with made land.
const SUN_OF_LAND: &str = "-0.628,-0.439,0.643";

/// How much of VTK's attenuation the depth of the water makes: about as deep a colour as ours.
const VTK_ABSORPTION: f64 = 2.5;

/// No particle is near enough to be drawn, and none throws a shadow: what is left is what surrounds the water.
const WITHOUT_WATER: [&str; 4] = ["--param", "lod.far=1e-9", "--param", "scene.shadows=false"];

/// Land throws shadows without water, too.
const LAND_WITHOUT_WATER: [&str; 4] = ["--param", "lod.far=1e-9", "--lighting", "vtk"];

/// Faces of the cube that VTK reflects: where to look and what is up, in the order and the sense of a cube map.
const FACES: [(&str, [f64; 3], &str); 6] = [
    ("px", [1.0, 0.0, 0.0], "0,1,0"),
    ("nx", [-1.0, 0.0, 0.0], "0,1,0"),
    ("py", [0.0, 1.0, 0.0], "0,0,-1"),
    ("ny", [0.0, -1.0, 0.0], "0,0,1"),
    ("pz", [0.0, 0.0, 1.0], "0,1,0"),
    ("nz", [0.0, 0.0, -1.0], "0,1,0"),
];

/// What both draw, and how.
struct Drawing {
    particles: PathBuf,
    camera: String,
    size: String,
    radius: String,
    attenuation_scale: f64,
    land: Option<Land>,
}

/// What `meniscus make` writes beside particles that stand on land.
struct Land {
    scene: PathBuf,
    grid: PathBuf,
}

/// Draws every subject of which there are data with both, beside each other, to `output`; `scratch` keeps what is in between.
pub fn draw(tools: &Tools, scratch: &Path, output: &Path, data: Option<&Path>) -> Result<()> {
    let Some(vtk) = &tools.vtk else {
        println!("SKIPPED: no gallery without VTK");
        return Ok(());
    };
    let theirs = format!("VTK {}, best settings", vtk.version);
    std::fs::create_dir_all(output).map_err(|source| Error::File { path: output.to_owned(), source })?;
    for subject in &SUBJECTS {
        let folder = scratch.join(subject.name);
        std::fs::create_dir_all(&folder).map_err(|source| Error::File { path: folder.clone(), source })?;
        let drawing = match subject.drawing(tools, &folder, data)? {
            Ok(drawing) => drawing,
            Err(reason) => {
                println!("SKIPPED: {}: {reason}", subject.name);
                continue;
            }
        };
        let [left, right] = ["vtk.png", "meniscus.png"].map(|name| folder.join(name));
        drawing.theirs(tools, &folder, &left)?;
        drawing.ours(tools, &drawing.camera, &drawing.size, &[], &right)?;
        let picture = output.join(subject.picture());
        let mut pair = tools.script("vtk_pair.py").expect("VTK is there");
        pair.args([&left, &right, &picture]).args(["--captions", &theirs, drawing.caption()]);
        process::run(&mut pair)?;
        match std::fs::metadata(&picture) {
            Ok(file) if file.len() > 0 => println!("wrote {} ({} kB)", picture.display(), file.len() / 1000),
            _ => return Err(Error::NotWritten { path: picture }),
        }
    }
    Ok(())
}

impl Subject {
    fn picture(&self) -> String {
        format!("{}.jpg", self.name)
    }

    /// Makes or selects the particles; the inner error says why there are none.
    fn drawing(
        &self,
        tools: &Tools,
        folder: &Path,
        data: Option<&Path>,
    ) -> Result<std::result::Result<Drawing, String>> {
        match &self.data {
            Data::View(view) => {
                let files: Files = json(tools.ours("bench-peers").args(["make", view]).arg(folder))?;
                Ok(Ok(Drawing {
                    attenuation_scale: VTK_ABSORPTION / self.depth,
                    particles: files.raw,
                    camera: files.camera,
                    size: format!("{}x{}", files.size[0], files.size[1]),
                    radius: files.radius.to_string(),
                    land: None,
                }))
            }
            Data::Made { case, view } => {
                process::run(tools.ours("meniscus").args(["make", case, "--quiet", "-o"]).arg(folder))?;
                let stem = case.replace('-', "_");
                let file = |ending: &str| folder.join(format!("{stem}_{ending}"));
                let land = Land { scene: file("scene.toml"), grid: file("ground.asc") };
                Ok(Ok(self.fixed(view, file("0000.vtu"), Some(land))))
            }
            Data::Series { path, frame, water, view } => {
                let series = match third_party(data, path) {
                    Ok(series) => series,
                    Err(reason) => return Ok(Err(reason)),
                };
                let particles = folder.join("water.vtu");
                let mut convert = tools.ours("meniscus");
                convert.arg("convert").arg(series).arg("-o").arg(&particles);
                process::run(convert.args(["--frame", frame, "--where", water, "--quiet"]))?;
                Ok(Ok(self.fixed(view, particles, None)))
            }
        }
    }

    fn fixed(&self, view: &FixedView, particles: PathBuf, land: Option<Land>) -> Drawing {
        Drawing {
            attenuation_scale: VTK_ABSORPTION / self.depth,
            particles,
            camera: view.camera.to_owned(),
            size: format!("{}x{}", view.size[0], view.size[1]),
            radius: view.radius.to_string(),
            land,
        }
    }
}

/// A file of the third-party data, or what to do to have it.
fn third_party(data: Option<&Path>, path: &str) -> std::result::Result<PathBuf, String> {
    let folder = data.ok_or("no third-party data beside the workspace; set MENISCUS_DATA")?;
    let file = folder.join(path);
    if file.is_file() { Ok(file) } else { Err(format!("{} is missing; set MENISCUS_DATA", file.display())) }
}

impl Drawing {
    fn ours(&self, tools: &Tools, camera: &str, size: &str, flags: &[&str], picture: &Path) -> Result<()> {
        let mut render = tools.ours("meniscus");
        render.arg("render").arg(&self.particles).args(["--quiet", "--camera", camera, "--size", size]);
        if let Some(land) = &self.land {
            render.arg("--scene").arg(&land.scene);
        }
        process::run(render.args(["--radius", &self.radius]).args(flags).arg("--output").arg(picture))
    }

    fn caption(&self) -> &'static str {
        if self.land.is_some() { "meniscus, no flags but --scene" } else { "meniscus, no flags" }
    }

    /// VTK's water among what surrounds ours.
    fn theirs(&self, tools: &Tools, folder: &Path, picture: &Path) -> Result<()> {
        let around = |name: &str| folder.join(format!("{name}.png"));
        let without_water = if self.land.is_some() { LAND_WITHOUT_WATER } else { WITHOUT_WATER };
        self.ours(tools, &self.camera, &self.size, &without_water, &around("background"))?;
        for (name, towards, up) in FACES {
            let camera = looking(&self.camera, towards, up);
            self.ours(tools, &camera, "512x512", &without_water, &around(name))?;
        }
        let mut vtk = tools.script("vtk_fluid.py").expect("VTK is there");
        vtk.arg(&self.particles).arg(picture).args(["--camera", &self.camera, "--size", &self.size]);
        vtk.args(["--radius", &self.radius, "--look", "best", "--frames", "0"]);
        vtk.args(["--attenuation-scale", &self.attenuation_scale.to_string()]);
        let sun = if self.land.is_some() { SUN_OF_LAND } else { SUN };
        vtk.arg("--surroundings").arg(folder).arg(format!("--sun={sun}"));
        if let Some(land) = &self.land {
            vtk.arg("--ground").arg(&land.grid);
        }
        json::<Samples>(&mut vtk).map(|_| ())
    }
}

/// A square view of 90 degrees from where `camera` is.
fn looking(camera: &str, towards: [f64; 3], up: &str) -> String {
    let eye = camera.split('/').next().unwrap_or_default();
    let target = eye.split(',').zip(towards).map(|(at, step)| {
        let at: f64 = at.parse().expect("cameras of views are numbers");
        (at + step).to_string()
    });
    format!("{eye}/{}/{up}/90", target.collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_that_are_not_there_are_skipped_with_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        for data in [None, Some(folder.path())] {
            let reason = third_party(data, "dam/dam.pvd").unwrap_err();
            assert!(reason.ends_with("set MENISCUS_DATA"), "{reason}");
        }
        std::fs::create_dir(folder.path().join("dam")).unwrap();
        let file = folder.path().join("dam/dam.pvd");
        std::fs::write(&file, "").unwrap();
        assert_eq!(third_party(Some(folder.path()), "dam/dam.pvd"), Ok(file));
    }

    #[test]
    fn faces_are_seen_from_the_eye_and_none_twice() {
        let camera = "1,2.5,-3/0,0,0/0,0,1/26";
        assert_eq!(looking(camera, [0.0, -1.0, 0.0], "0,0,1"), "1,2.5,-3/1,1.5,-3/0,0,1/90");
        let seen: std::collections::BTreeSet<_> =
            FACES.map(|(_, towards, up)| looking(camera, towards, up)).into();
        assert_eq!(seen.len(), FACES.len());
    }

    /// Pictures that are committed are those of the subjects, and few enough bytes for a repository.
    #[test]
    fn the_committed_gallery_is_complete_and_small() {
        let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/beside-vtk");
        let text = std::fs::read_to_string(gallery.join("README.md")).unwrap();
        for subject in &SUBJECTS {
            let size = std::fs::metadata(gallery.join(subject.picture())).unwrap().len();
            assert!((1..150_000).contains(&size), "{}: {size} bytes", subject.name);
            assert!(text.contains(&subject.picture()), "{} is not in README.md", subject.name);
        }
    }
}
