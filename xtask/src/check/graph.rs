//! The dependency graph of the workspace, reduced to what the checks ask of it.

use std::collections::{HashMap, HashSet, VecDeque};

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

/// Reads the graph of the workspace in the current directory.
pub fn read() -> Result<Graph> {
    Ok(from_metadata(&MetadataCommand::new().features(CargoOpt::AllFeatures).exec()?))
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
    fn this_workspace_is_read_with_its_places_and_arrows() {
        let graph = read().unwrap();
        let find = |name: &str| graph.packages.iter().find(|package| package.name == name).unwrap();
        assert_eq!(find("meniscus-core").place, Place::Pipeline);
        assert_eq!(find("xtask").place, Place::Around);
        assert_eq!(find("clap").place, Place::External);
        let dev_only: Vec<_> = find("xtask")
            .dependencies
            .iter()
            .map(|dependency| (graph.packages[dependency.to].name.as_str(), dependency.dev_only))
            .filter(|(name, _)| ["tempfile", "clap"].contains(name))
            .collect();
        assert_eq!(dev_only.len(), 2);
        assert!(dev_only.contains(&("tempfile", true)) && dev_only.contains(&("clap", false)));
    }
}
