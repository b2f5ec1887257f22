//! WGSL with imports: one pass, one file, one name. Files ending in `.inc.wgsl` are includes; they start with
//! `#define_import_path` and are imported by name.

use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

use naga::valid::Capabilities;
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};

use crate::GpuError;

/// A WGSL source and its name, `stage/pass`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shader {
    /// `stage/pass`, the path under `shaders/` without the ending.
    pub name: &'static str,
    /// The text.
    pub source: &'static str,
}

impl Shader {
    /// What an include is imported as.
    fn import_path(&self) -> Option<&'static str> {
        self.source.lines().find_map(|line| line.strip_prefix("#define_import_path ")).map(str::trim)
    }

    /// Whether it imports from the include of this `path`.
    fn imports(&self, path: &str) -> bool {
        let names =
            |line: &'static str| line.strip_prefix("#import ")?.strip_prefix(path)?.strip_prefix("::");
        self.source.lines().any(|line| names(line).is_some())
    }
}

/// `shader!("ssfr/depth")`: the file `shaders/ssfr/depth.wgsl` of this workspace; `shader!(include "common/camera")` the
/// file `shaders/common/camera.inc.wgsl`. For use in crates of `crates/`.
#[macro_export]
macro_rules! shader {
    (include $name:literal) => {
        $crate::Shader {
            name: $name,
            source: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/", $name, ".inc.wgsl")),
        }
    };
    ($name:literal) => {
        $crate::Shader {
            name: $name,
            source: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/", $name, ".wgsl")),
        }
    };
}

/// Includes that every shader may import: `meniscus::camera`, `meniscus::surface`, `meniscus::particle`,
/// `meniscus::page`, `meniscus::covered`, `meniscus::picture`, `meniscus::tally`.
pub const COMMON: &[Shader] = &[
    shader!(include "common/camera"),
    shader!(include "common/surface"),
    shader!(include "common/particle"),
    shader!(include "common/page"),
    shader!(include "common/covered"),
    shader!(include "common/picture"),
    shader!(include "common/tally"),
];

/// A preprocessor constant: `#ifdef NAME`, `#{NAME}`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Definition {
    /// Name as in the shader.
    pub name: &'static str,
    /// Value; integers can be inserted with `#{NAME}`.
    pub value: u32,
}

/// Compiles the variant of a pass that counts its work.
pub(crate) const COUNT: Definition = Definition { name: "COUNT", value: 1 };

/// Of passes that run on a GPU and not on a software driver.
pub(crate) const HARDWARE: Definition = Definition { name: "HARDWARE", value: 1 };

/// Resolves the imports of `shader` against `includes` (each listed after what it imports itself; [`COMMON`] is always
/// there) and validates the result.
///
/// # Errors
/// [`GpuError::Shader`] with the compiler's message and place.
pub fn compose(
    shader: &Shader,
    includes: &[Shader],
    definitions: &[Definition],
) -> Result<naga::Module, GpuError> {
    let includes: Vec<Shader> =
        COMMON.iter().filter(|c| !includes.contains(c)).chain(includes).copied().collect();
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let place = known.iter().position(|library| library.fits(&includes)).unwrap_or_else(|| {
        known.push(Library::new());
        known.len() - 1
    });
    let library = &mut known[place];
    library.add(&includes)?;
    library.compose(shader, &includes, definitions)
}

/// Includes that were parsed before. What compiles shaders is itself slow to make, and most passes share their includes.
static KNOWN: Mutex<Vec<Library>> = Mutex::new(Vec::new());

/// Variants may add to words of 64 bits, where the device can ([`crate::Gpu::has_wide_atomics`]).
fn capabilities() -> Capabilities {
    Capabilities::default() | Capabilities::SHADER_INT64 | Capabilities::SHADER_INT64_ATOMIC_ALL_OPS
}

/// Includes of which no two have the same import path.
struct Library {
    composer: Composer,
    includes: Vec<Shader>,
}

impl Library {
    fn new() -> Self {
        Self { composer: Composer::default().with_capabilities(capabilities()), includes: Vec::new() }
    }

    /// Whether none of `includes` would replace another one: the composer mixes up the places of errors when that happens.
    fn fits(&self, includes: &[Shader]) -> bool {
        let replaces =
            |a: &Shader| self.includes.iter().any(|b| a.import_path() == b.import_path() && a != b);
        !includes.iter().any(replaces)
    }

    fn add(&mut self, includes: &[Shader]) -> Result<(), GpuError> {
        for include in includes {
            if self.includes.contains(include) {
                continue;
            }
            // Definitions come with the passes.
            let added = self.composer.add_composable_module(ComposableModuleDescriptor {
                source: include.source,
                file_path: include.name,
                ..Default::default()
            });
            if let Err(error) = added.map(|_| ()) {
                return Err(failure(include.name, error.emit_to_string(&self.composer)));
            }
            self.includes.push(*include);
        }
        Ok(())
    }

    fn compose(
        &mut self,
        shader: &Shader,
        includes: &[Shader],
        definitions: &[Definition],
    ) -> Result<naga::Module, GpuError> {
        // What another pass brought along is not there for this one, whichever was compiled first.
        for other in self.includes.iter().filter(|other| !includes.contains(other)) {
            if let Some(path) = other.import_path().filter(|path| shader.imports(path)) {
                return Err(failure(shader.name, format!("imports {path}, which is not among its includes")));
            }
        }
        let module = self
            .composer
            .make_naga_module(NagaModuleDescriptor {
                source: shader.source,
                file_path: shader.name,
                shader_defs: definitions
                    .iter()
                    .map(|d| (d.name.to_owned(), ShaderDefValue::UInt(d.value)))
                    .collect(),
                ..Default::default()
            })
            .map_err(|e| failure(shader.name, e.emit_to_string(&self.composer)))?;
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities());
        validator.validate(&module).map_err(|e| failure(shader.name, format!("{:?}", e.into_inner())))?;
        Ok(module)
    }
}

fn failure(shader: &str, message: String) -> GpuError {
    GpuError::Shader { shader: shader.to_owned(), message }
}

pub(crate) fn module(device: &wgpu::Device, shader: &Shader, module: naga::Module) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(shader.name),
        source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    fn wgsl_files(folder: &Path) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                found.extend(wgsl_files(&path));
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                found.push(path);
            }
        }
        found.sort();
        found
    }

    /// Includes of the same folder, each after those it imports.
    fn dependencies_first(mut rest: Vec<Shader>) -> Vec<Shader> {
        let mut ordered: Vec<Shader> = Vec::new();
        while !rest.is_empty() {
            let free = |s: &&Shader| rest.iter().all(|other| !s.imports(other.import_path().unwrap()));
            let next = *rest.iter().find(free).expect("imports do not go round in circles");
            rest.retain(|s| *s != next);
            ordered.push(next);
        }
        ordered
    }

    /// Every file under `shaders/` composes and validates; all failures in one report.
    #[test]
    fn every_entry_point_validates() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
        let leak = |s: String| -> &'static str { Box::leak(s.into_boxed_str()) };
        let load = |path: &PathBuf| Shader {
            name: leak(path.strip_prefix(&root).unwrap().to_string_lossy().into_owned()),
            source: leak(std::fs::read_to_string(path).unwrap()),
        };
        let (includes, passes): (Vec<_>, Vec<_>) =
            wgsl_files(&root).iter().map(load).partition(|s| s.name.ends_with(".inc.wgsl"));
        // Those of `common` are always there.
        let includes =
            dependencies_first(includes.into_iter().filter(|s| !s.name.starts_with("common/")).collect());
        // A lighting model is a module that one pass is compiled with.
        let (models, passes): (Vec<_>, Vec<_>) =
            passes.into_iter().partition(|s| s.source.contains("#define_import_path meniscus::model"));
        let (of_models, passes): (Vec<_>, Vec<_>) =
            passes.into_iter().partition(|s| s.source.contains("#import meniscus::model::"));
        assert!(!passes.is_empty() && !models.is_empty() && of_models.len() == 1);
        let water = Definition { name: "WATER", value: 1 };
        let alone = passes.iter().flat_map(|pass| {
            [&[][..], &[COUNT], &[HARDWARE]].map(|definitions| compose(pass, &includes, definitions).err())
        });
        let with_models = models.iter().flat_map(|model| {
            let includes: Vec<_> = includes.iter().chain([model]).copied().collect();
            [&[][..], &[water], &[HARDWARE], &[water, HARDWARE]]
                .map(|definitions| compose(&of_models[0], &includes, definitions).err())
        });
        let failures: Vec<String> = alone.chain(with_models).flatten().map(|e| e.to_string()).collect();
        assert!(failures.is_empty(), "{}", failures.join("\n\n"));
    }

    #[test]
    fn a_broken_shader_is_reported_with_its_name_and_place() {
        let broken = Shader {
            name: "test/broken",
            source: "@compute @workgroup_size(1) fn main() { let x: u32 = 1.5; }",
        };
        let error = compose(&broken, &[], &[]).unwrap_err().to_string();
        assert!(error.contains("test/broken"), "{error}");
        let missing = Shader {
            name: "test/missing",
            source: "#import meniscus::nothing::f\n@compute @workgroup_size(1) fn main() { f(); }",
        };
        assert!(compose(&missing, &[], &[]).unwrap_err().to_string().contains("nothing"));
    }

    const ANSWER: Shader = Shader {
        name: "test/answer",
        source: "#define_import_path meniscus::answer\n#ifdef LARGE\nconst answer = 42u;\n#else\nconst answer = 4u;\n#endif",
    };
    const ASKS: Shader = Shader {
        name: "test/asks",
        source: "#import meniscus::answer::answer\n@compute @workgroup_size(answer) fn main() {}",
    };

    fn answer_of(includes: &[Shader], definitions: &[Definition]) -> Result<u32, GpuError> {
        compose(&ASKS, includes, definitions).map(|module| module.entry_points[0].workgroup_size[0])
    }

    /// Includes are kept from pass to pass; what a pass defines, and which include it means, is its own.
    #[test]
    fn passes_know_nothing_of_each_other() {
        let other =
            Shader { name: "test/other", source: "#define_import_path meniscus::answer\nconst answer = 7u;" };
        let large = Definition { name: "LARGE", value: 1 };
        for _ in 0..2 {
            assert_eq!(answer_of(&[ANSWER], &[]).unwrap(), 4);
            assert_eq!(answer_of(&[ANSWER], &[large]).unwrap(), 42);
            assert_eq!(answer_of(&[other], &[large]).unwrap(), 7);
            let error = answer_of(&[], &[]).unwrap_err().to_string();
            assert!(error.contains("test/asks") && error.contains("meniscus::answer"), "{error}");
        }
    }
}
