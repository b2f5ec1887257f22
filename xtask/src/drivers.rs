//! Is there a Vulkan driver? Looks where the Vulkan loader looks, before a test finds out the hard way.
//!
//! Order and names of the folders: "Driver Discovery on Linux" in the loader's `LoaderDriverInterface.md`.

use std::path::{Path, PathBuf};

/// A file system and the environment variables that steer the loader; tests bring their own.
pub struct Machine<'a> {
    /// `/`, except in tests.
    pub root: PathBuf,
    pub variable: &'a dyn Fn(&str) -> Option<String>,
}

/// What the loader will find.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Vulkan {
    /// The loader itself, `libvulkan.so.1`.
    pub loader: Option<PathBuf>,
    /// Manifests whose library exists.
    pub drivers: Vec<PathBuf>,
    /// Manifests that name a library which is not there, as in a container that was given half of a driver.
    pub broken: Vec<PathBuf>,
    /// Manifests of NVIDIA's container folder, where no loader looks: they must be passed on by name.
    pub unlisted: Vec<PathBuf>,
}

impl Vulkan {
    /// Whether a program can expect at least one adapter.
    pub fn is_usable(&self) -> bool {
        self.loader.is_some() && !(self.drivers.is_empty() && self.unlisted.is_empty())
    }
}

/// Folders in which Kubernetes device plugins mount NVIDIA's driver.
const NVIDIA_MOUNT: &str = "/usr/local/nvidia";

/// Searches the machine.
pub fn find(machine: &Machine) -> Vulkan {
    let mut vulkan = Vulkan { loader: machine.library("libvulkan.so.1"), ..Vulkan::default() };
    for manifest in machine.listed_manifests() {
        match machine.manifest_is_whole(&manifest) {
            true => vulkan.drivers.push(manifest),
            false => vulkan.broken.push(manifest),
        }
    }
    let mount = machine.inside(Path::new(NVIDIA_MOUNT)).join("share/vulkan/icd.d");
    vulkan.unlisted = manifests_in(&mount)
        .into_iter()
        .filter(|manifest| !vulkan.drivers.contains(manifest) && machine.manifest_is_whole(manifest))
        .collect();
    vulkan
}

impl Machine<'_> {
    /// The path below our root.
    fn inside(&self, path: &Path) -> PathBuf {
        self.root.join(path.strip_prefix("/").unwrap_or(path))
    }

    /// The folders or files of a colon-separated variable, empty when it is unset or empty.
    fn paths(&self, variable: &str) -> Vec<PathBuf> {
        let value = (self.variable)(variable).unwrap_or_default();
        value.split(':').filter(|path| !path.is_empty()).map(|path| self.inside(Path::new(path))).collect()
    }

    fn paths_or(&self, variable: &str, default: &[&str]) -> Vec<PathBuf> {
        match self.paths(variable) {
            paths if paths.is_empty() => default.iter().map(|path| self.inside(Path::new(path))).collect(),
            paths => paths,
        }
    }

    /// Every manifest the loader reads, each once.
    fn listed_manifests(&self) -> Vec<PathBuf> {
        let mut manifests = Vec::new();
        let mut forced = self.paths("VK_DRIVER_FILES");
        if forced.is_empty() {
            forced = self.paths("VK_ICD_FILENAMES");
        }
        let places = match forced.is_empty() {
            true => self.manifest_folders(),
            false => forced,
        };
        for place in self.paths("VK_ADD_DRIVER_FILES").into_iter().chain(places) {
            match place.is_dir() {
                true => manifests.extend(manifests_in(&place)),
                false if place.is_file() => manifests.push(place),
                false => {}
            }
        }
        let mut once = Vec::new();
        manifests.into_iter().for_each(|manifest| {
            if !once.contains(&manifest) {
                once.push(manifest);
            }
        });
        once
    }

    fn manifest_folders(&self) -> Vec<PathBuf> {
        let home = self.paths("HOME");
        let in_home = |path| home.iter().map(move |home| home.join(path)).collect::<Vec<_>>();
        let mut bases = self.paths("XDG_CONFIG_HOME");
        bases.extend(in_home(".config"));
        bases.extend(self.paths_or("XDG_CONFIG_DIRS", &["/etc/xdg"]));
        bases.extend(self.paths_or("SYSCONFDIR", &["/usr/local/etc", "/etc"]));
        bases.extend(self.paths("XDG_DATA_HOME"));
        bases.extend(in_home(".local/share"));
        bases.extend(self.paths_or("XDG_DATA_DIRS", &["/usr/local/share", "/usr/share"]));
        bases.iter().map(|base| base.join("vulkan/icd.d")).collect()
    }

    /// A manifest is worth something only if the library it names is there. The name is absolute, relative to the
    /// manifest, or a bare name for the dynamic linker.
    fn manifest_is_whole(&self, manifest: &Path) -> bool {
        let text = std::fs::read_to_string(manifest).unwrap_or_default();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        let Some(library) = json["ICD"]["library_path"].as_str() else {
            return false;
        };
        match (library.starts_with('/'), library.contains('/')) {
            (true, _) => self.inside(Path::new(library)).exists(),
            (false, true) => manifest.with_file_name(library).exists(),
            (false, false) => self.library(library).is_some(),
        }
    }

    /// The file that the dynamic linker would load for a bare library name.
    fn library(&self, name: &str) -> Option<PathBuf> {
        let mut folders = self.paths("LD_LIBRARY_PATH");
        for base in ["/usr/lib", "/usr/lib64", "/lib", "/lib64", "/usr/local/lib"] {
            let base = self.inside(Path::new(base));
            // Debian keeps libraries in a folder per architecture, as in /usr/lib/x86_64-linux-gnu.
            folders.push(base.join(format!("{}-linux-gnu", std::env::consts::ARCH)));
            folders.push(base);
        }
        folders.push(self.inside(Path::new(NVIDIA_MOUNT)).join("lib64"));
        folders.iter().map(|folder| folder.join(name)).find(|path| path.exists())
    }
}

/// The manifests of a folder in the order of their names; none if it cannot be read.
fn manifests_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut manifests: Vec<_> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .collect();
    manifests.sort();
    manifests
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file system in a temporary folder.
    struct Fake(tempfile::TempDir);

    impl Fake {
        fn new(files: &[(&str, &str)]) -> Self {
            let fake = Self(tempfile::tempdir().unwrap());
            for (path, text) in files {
                let path = fake.0.path().join(path.trim_start_matches('/'));
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, text).unwrap();
            }
            fake
        }

        fn find(&self, variables: &[(&str, &str)]) -> Vulkan {
            let variable = |name: &str| {
                variables.iter().find(|(listed, _)| *listed == name).map(|(_, value)| (*value).to_owned())
            };
            find(&Machine { root: self.0.path().to_owned(), variable: &variable })
        }

        fn path(&self, path: &str) -> PathBuf {
            self.0.path().join(path.trim_start_matches('/'))
        }
    }

    const LAVAPIPE: &str = "/usr/share/vulkan/icd.d/lvp_icd.json";
    const LAVAPIPE_TEXT: &str = r#"{"ICD": {"library_path": "/usr/lib/libvulkan_lvp.so"}}"#;

    #[test]
    fn an_empty_machine_has_nothing() {
        let vulkan = Fake::new(&[]).find(&[]);
        assert_eq!(vulkan, Vulkan::default());
        assert!(!vulkan.is_usable());
    }

    #[test]
    fn loader_and_driver_are_both_needed() {
        let driver = [(LAVAPIPE, LAVAPIPE_TEXT), ("/usr/lib/libvulkan_lvp.so", "")];
        let loader = ("/usr/lib64/libvulkan.so.1", "");
        assert!(!Fake::new(&driver).find(&[]).is_usable());
        assert!(!Fake::new(&[loader]).find(&[]).is_usable());
        let whole = Fake::new(&[driver[0], driver[1], loader]);
        let vulkan = whole.find(&[]);
        assert!(vulkan.is_usable());
        assert_eq!(vulkan.drivers, [whole.path(LAVAPIPE)]);
    }

    #[test]
    fn debians_folder_per_architecture_is_searched() {
        let loader = format!("/usr/lib/{}-linux-gnu/libvulkan.so.1", std::env::consts::ARCH);
        assert!(Fake::new(&[(&loader, "")]).find(&[]).loader.is_some());
    }

    #[test]
    fn a_manifest_without_its_library_is_broken() {
        for text in [LAVAPIPE_TEXT, r#"{"ICD": {"library_path": "libGLX_nvidia.so.0"}}"#, "{}", "not json"] {
            let fake = Fake::new(&[(LAVAPIPE, text), ("/usr/lib/libvulkan.so.1", "")]);
            let vulkan = fake.find(&[]);
            assert_eq!((vulkan.drivers.len(), vulkan.broken.len()), (0, 1), "{text}");
            assert!(!vulkan.is_usable());
        }
    }

    #[test]
    fn libraries_are_found_by_bare_and_by_relative_name() {
        for (library, path) in [
            ("libx.so", "/lib/libx.so"),
            ("./libx.so", "/etc/vulkan/icd.d/libx.so"),
            ("libx.so", "/opt/gpu/libx.so"),
        ] {
            let text = format!(r#"{{"ICD": {{"library_path": "{library}"}}}}"#);
            let fake = Fake::new(&[("/etc/vulkan/icd.d/x.json", &text), (path, "")]);
            let vulkan = fake.find(&[("LD_LIBRARY_PATH", "/opt/gpu")]);
            assert_eq!(vulkan.drivers.len(), 1, "{library} at {path}");
        }
    }

    #[test]
    fn named_manifests_replace_the_folders_and_may_be_folders_themselves() {
        let fake = Fake::new(&[
            (LAVAPIPE, LAVAPIPE_TEXT),
            ("/opt/a.json", LAVAPIPE_TEXT),
            ("/opt/b/b.json", LAVAPIPE_TEXT),
            ("/usr/lib/libvulkan_lvp.so", ""),
        ]);
        for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            let vulkan = fake.find(&[(name, "/opt/a.json:/opt/b:/opt/absent.json")]);
            assert_eq!(vulkan.drivers, [fake.path("/opt/a.json"), fake.path("/opt/b/b.json")], "{name}");
        }
        let vulkan = fake.find(&[("VK_ADD_DRIVER_FILES", "/opt/a.json")]);
        assert_eq!(vulkan.drivers, [fake.path("/opt/a.json"), fake.path(LAVAPIPE)]);
    }

    #[test]
    fn nvidias_mount_is_found_though_no_loader_lists_it() {
        let manifest = "/usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json";
        let fake = Fake::new(&[
            (manifest, r#"{"ICD": {"library_path": "libEGL_nvidia.so.0"}}"#),
            ("/usr/local/nvidia/lib64/libEGL_nvidia.so.0", ""),
            ("/usr/lib/libvulkan.so.1", ""),
        ]);
        let vulkan = fake.find(&[]);
        assert_eq!((vulkan.drivers.len(), &vulkan.unlisted), (0, &vec![fake.path(manifest)]));
        assert!(vulkan.is_usable());
        assert!(fake.find(&[("VK_DRIVER_FILES", manifest)]).unlisted.is_empty());
    }
}
