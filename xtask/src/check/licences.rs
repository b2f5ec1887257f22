//! Whose terms may come along with the product.

use spdx::{Expression, LicenseItem, ParseMode};

use super::graph::{Graph, Place};

/// Licences a dependency may be used under, each with the reason why it is harmless here. A new entry is a decision
/// of the maintainers, not a way to make the check green.
const ALLOWED: &[(&str, &str)] = &[
    ("MIT", "ours; asks for its notice only"),
    ("Apache-2.0", "ours; asks for its notice, grants patents"),
    ("BSD-2-Clause", "asks for its notice only"),
    ("BSD-3-Clause", "asks for its notice only, forbids advertising with the authors' names"),
    ("Zlib", "asks not to claim authorship; no notice needed in binaries"),
    ("ISC", "MIT in fewer words; libloading, through which wgpu finds Vulkan, has no other"),
    ("CC0-1.0", "public domain, nothing to pass on; notify, which watches folders, has no other"),
    ("OFL-1.1", "fonts: come along with any software, may not be sold alone"),
    ("Ubuntu-font-1.0", "fonts: as OFL-1.1; epaint_default_fonts, which has the font of overlays, has both"),
    ("Unicode-3.0", "asks for its notice only; covers the tables in unicode-ident, a part of every derive"),
];

/// Every dependency that cannot be used under the allowed licences alone.
pub fn offences(graph: &Graph) -> Vec<String> {
    let foreign = graph.packages.iter().filter(|package| package.place == Place::External);
    foreign
        .filter_map(|package| {
            let why = refusal(package.licence.as_deref())?;
            Some(format!("{} {}: {why}", package.name, package.version))
        })
        .collect()
}

/// Why the licence expression of a package is not acceptable; `None` if it is.
fn refusal(licence: Option<&str>) -> Option<String> {
    let Some(licence) = licence else {
        return Some("its manifest names no licence".to_owned());
    };
    // Old manifests write `MIT/Apache-2.0`, which only the lax mode reads.
    match Expression::parse_mode(licence, ParseMode::LAX) {
        Err(error) => Some(format!("licence `{licence}` cannot be read: {}", error.reason)),
        Ok(expression) if expression.evaluate(is_allowed) => None,
        Ok(_) => Some(format!("licence `{licence}` is not on the allow list of xtask/src/check/licences.rs")),
    }
}

/// An addition (`WITH ...`) only ever grants more, but which one is never guessed: those are refused.
fn is_allowed(requirement: &spdx::LicenseReq) -> bool {
    let LicenseItem::Spdx { id, .. } = &requirement.license else {
        return false;
    };
    requirement.addition.is_none() && ALLOWED.iter().any(|(name, _)| *name == id.name)
}

#[cfg(test)]
mod tests {
    use super::super::graph::fake;
    use super::*;

    #[test]
    fn expressions_are_judged_by_their_meaning() {
        for good in [
            "MIT",
            "MIT OR GPL-3.0",
            "MIT/Apache-2.0",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "Apache-2.0 WITH LLVM-exception OR Apache-2.0 OR MIT",
        ] {
            assert_eq!(refusal(Some(good)), None, "{good}");
        }
        for bad in ["GPL-3.0", "MPL-2.0", "MIT AND GPL-3.0", "LicenseRef-Own", "free for all", ""] {
            assert!(refusal(Some(bad)).is_some(), "{bad:?}");
        }
        assert!(refusal(None).is_some());
    }

    #[test]
    fn only_foreign_packages_are_judged_and_offenders_are_named() {
        let mut graph = fake::graph(&["meniscus-core: good bad"], &[]);
        for (name, licence) in [("good", "MIT"), ("bad", "GPL-3.0-only")] {
            let package = graph.packages.iter_mut().find(|package| package.name == name).unwrap();
            package.licence = Some(licence.to_owned());
        }
        let found = offences(&graph);
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("bad 1.0.0: licence `GPL-3.0-only`"), "{}", found[0]);
    }
}
