//! The dependency graph of the workspace, reduced to what the checks ask of it.

use std::{
    collections::{HashMap, HashSet, VecDeque},
    path::Path,
};

use cargo_metadata::{CargoOpt, DependencyKind, Metadata, MetadataCommand};

use crate::error::Result;

/// Packages and the arrows between them, for all features and all platforms.
#[derive(Debug, Default)]
pub struct Graph {
    pub packages: Vec<Package>,
}

/// One package of the graph.
#[derive(Debug)]
pub struct Package {
    pub name: String,
    pub version: String,
    /// The licence expression of its manifest, if it has one.
    pub licence: Option<String>,
    pub place: Place,
    pub dependencies: Vec<Dependency>,
}

/// Where a package comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// `crates/`: part of the product, has a layer.
    Pipeline,
    /// Another member of the workspace (`tests/`, `benches/`, `xtask/`, `examples/`).
    Around,
    /// Somebody else's package.
    External,
}

/// An arrow to another package of the graph.
#[derive(Debug, Clone, Copy)]
pub struct Dependency {
    /// Index into [`Graph::packages`].
    pub to: usize,
    /// Only tests, benches and examples of the package use it.
    pub dev_only: bool,
}

/// Reads the graph of the workspace in the folder.
pub fn read(folder: &Path) -> Result<Graph> {
    let mut command = MetadataCommand::new();
    Ok(from_metadata(&command.current_dir(folder).features(CargoOpt::AllFeatures).exec()?))
}

fn from_metadata(metadata: &Metadata) -> Graph {
    let members: HashSet<_> = metadata.workspace_members.iter().collect();
    let index: HashMap<_, _> = metadata.packages.iter().enumerate().map(|(i, p)| (&p.id, i)).collect();
    let crates = metadata.workspace_root.join("crates");
    let mut packages: Vec<Package> = metadata
        .packages
        .iter()
        .map(|package| Package {
            name: package.name.to_string(),
            version: package.version.to_string(),
            licence: package.license.clone(),
            place: match (members.contains(&package.id), package.manifest_path.starts_with(&crates)) {
                (true, true) => Place::Pipeline,
                (true, false) => Place::Around,
                (false, _) => Place::External,
            },
            dependencies: Vec::new(),
        })
        .collect();
    for node in metadata.resolve.iter().flat_map(|resolve| &resolve.nodes) {
        packages[index[&node.id]].dependencies = node
            .deps
            .iter()
            .map(|dependency| Dependency {
                to: index[&dependency.pkg],
                dev_only: dependency.dep_kinds.iter().all(|kind| kind.kind == DependencyKind::Development),
            })
            .collect();
    }
    Graph { packages }
}

impl Graph {
    /// The shortest path of names, both ends included, from `start` to a package whose name `wanted` accepts,
    /// along the arrows that a user of `start` gets (dev-dependencies left out).
    pub fn path_to(&self, start: usize, wanted: impl Fn(&str) -> bool) -> Option<Vec<&str>> {
        let mut reached_from = HashMap::from([(start, start)]);
        let mut queue = VecDeque::from([start]);
        while let Some(at) = queue.pop_front() {
            if wanted(&self.packages[at].name) {
                return Some(self.trace(at, &reached_from));
            }
            for dependency in self.packages[at].dependencies.iter().filter(|d| !d.dev_only) {
                reached_from.entry(dependency.to).or_insert_with(|| {
                    queue.push_back(dependency.to);
                    at
                });
            }
        }
        None
    }

    fn trace(&self, end: usize, reached_from: &HashMap<usize, usize>) -> Vec<&str> {
        let mut path = vec![self.packages[end].name.as_str()];
        let mut at = end;
        while reached_from[&at] != at {
            at = reached_from[&at];
            path.push(&self.packages[at].name);
        }
        path.reverse();
        path
    }
}

#[cfg(test)]
pub mod fake {
    //! Graphs for tests, written as `"name: dependency dependency (dev-dependency)"`.

    use super::{Dependency, Graph, Package, Place};

    /// Builds a graph from one line per package. Names that start with `meniscus` are the pipeline's, unless they
    /// are listed in `around`; names that only occur on the right become packages without dependencies.
    pub fn graph(lines: &[&str], around: &[&str]) -> Graph {
        let mut graph = Graph::default();
        for line in lines {
            let (name, dependencies) = line.split_once(':').expect("a line is `name: dependencies`");
            let from = position(&mut graph, name, around);
            for word in dependencies.split_whitespace() {
                let name = word.trim_matches(['(', ')']);
                let to = position(&mut graph, name, around);
                let dependency = Dependency { to, dev_only: word.starts_with('(') };
                graph.packages[from].dependencies.push(dependency);
            }
        }
        graph
    }

    fn position(graph: &mut Graph, name: &str, around: &[&str]) -> usize {
        if let Some(position) = graph.packages.iter().position(|package| package.name == name) {
            return position;
        }
        let place = match name {
            _ if around.contains(&name) => Place::Around,
            _ if name.starts_with("meniscus") => Place::Pipeline,
            _ => Place::External,
        };
        graph.packages.push(Package {
            name: name.to_owned(),
            version: "1.0.0".to_owned(),
            licence: None,
            place,
            dependencies: Vec::new(),
        });
        graph.packages.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shortest_path_is_found_and_cycles_end() {
        let graph = fake::graph(&["a: b c", "b: d a", "c: e", "d: e", "e: f"], &[]);
        assert_eq!(graph.path_to(0, |name| name == "f"), Some(vec!["a", "c", "e", "f"]));
        assert_eq!(graph.path_to(0, |name| name == "z"), None);
    }

    #[test]
    fn dev_dependencies_are_not_followed() {
        let graph = fake::graph(&["a: (b)", "b: c"], &[]);
        assert_eq!(graph.path_to(0, |name| name == "c"), None);
    }

    #[test]
    fn a_workspace_is_read_with_its_places_arrows_and_licences() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let package = |path: &str, name: &str, more: &str| {
            write(&format!("{path}/src/lib.rs"), "");
            write(
                &format!("{path}/Cargo.toml"),
                &format!("[package]\nname = '{name}'\nlicense = 'MIT'\n{more}"),
            );
        };
        write(
            "Cargo.toml",
            "[workspace]\nmembers = ['crates/*', 'tests']\nexclude = ['else']\nresolver = '3'",
        );
        package("crates/a", "a", "[dependencies]\nb = { path = '../b', optional = true }");
        package("crates/b", "b", "[dev-dependencies]\nc = { path = '../../else/c' }");
        package(
            "tests",
            "t",
            "[dependencies]\na = { path = '../crates/a' }\n[dev-dependencies]\na.path = '../crates/a'",
        );
        package("else/c", "c", "");

        let graph = read(folder.path()).unwrap();
        let find = |name: &str| graph.packages.iter().find(|package| package.name == name).unwrap();
        let arrows = |name: &str| {
            let dependencies = find(name).dependencies.iter();
            dependencies.map(|d| (graph.packages[d.to].name.as_str(), d.dev_only)).collect::<Vec<_>>()
        };
        assert_eq!(["a", "b", "t", "c"].map(|name| find(name).place), {
            use Place::{Around, External, Pipeline};
            [Pipeline, Pipeline, Around, External]
        });
        assert_eq!(arrows("a"), [("b", false)], "an optional dependency counts");
        assert_eq!(arrows("b"), [("c", true)]);
        assert_eq!(arrows("t"), [("a", false)], "a dependency of both kinds is not one of tests only");
        assert_eq!(find("c").licence.as_deref(), Some("MIT"));
    }
}
