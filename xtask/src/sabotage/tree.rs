//! A copy of the working tree in which mistakes may be made.

use std::{
    collections::HashSet,
    ffi::OsStr,
    io,
    os::unix::ffi::OsStrExt,
    path::{Path, PathBuf},
    process::Command,
};

use super::list::Edit;
use crate::{
    error::{Error, Result},
    process,
};

/// The copy.
pub struct Tree {
    pub root: PathBuf,
}

impl Tree {
    /// Makes `root` equal to the working tree of the repository at `workspace`: what git tracks and what it does not ignore.
    /// Files that are equal already are not touched, so that cargo need not compile them again; whatever an interrupted run
    /// left behind is put right.
    pub fn copy(workspace: &Path, root: PathBuf) -> Result<Self> {
        let mut git = Command::new("git");
        git.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]).current_dir(workspace);
        let listed = process::capture(&mut git)?;
        let names: HashSet<PathBuf> = listed
            .split(|byte| *byte == 0)
            .filter(|name| !name.is_empty())
            .map(|name| PathBuf::from(OsStr::from_bytes(name)))
            // Deleted and not yet committed.
            .filter(|name| workspace.join(name).is_file())
            .collect();
        for name in &names {
            let (from, to) = (workspace.join(name), root.join(name));
            copy_if_different(&from, &to).map_err(|source| Error::File { path: to, source })?;
        }
        remove_others(&root, &root, &names).map_err(|source| Error::File { path: root.clone(), source })?;
        Ok(Self { root })
    }

    /// Makes the edits. They are undone when the returned value is dropped.
    pub fn apply(&self, edits: &[Edit]) -> Result<Applied> {
        let mut applied = Applied(Vec::new());
        for edit in edits {
            let path = self.root.join(&edit.file);
            let changed = std::fs::read_to_string(&path).and_then(|text| {
                std::fs::write(&path, text.replacen(&edit.find, &edit.replace, 1))?;
                Ok(text)
            });
            match changed {
                Ok(original) => applied.0.push((path, original)),
                Err(source) => return Err(Error::File { path, source }),
            }
        }
        Ok(applied)
    }
}

/// Edited files and what they were.
pub struct Applied(Vec<(PathBuf, String)>);

impl Drop for Applied {
    fn drop(&mut self) {
        // Backwards: a file may have been edited twice. What cannot be undone here, the next copy undoes.
        for (path, original) in self.0.iter().rev() {
            let _ = std::fs::write(path, original);
        }
    }
}

fn copy_if_different(from: &Path, to: &Path) -> io::Result<()> {
    let wanted = std::fs::read(from)?;
    if std::fs::read(to).is_ok_and(|present| present == wanted) {
        return Ok(());
    }
    to.parent().map_or(Ok(()), std::fs::create_dir_all)?;
    std::fs::write(to, wanted)
}

/// Removes the files below `folder` that are not among `names`, which are relative to `root`.
fn remove_others(root: &Path, folder: &Path, names: &HashSet<PathBuf>) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            remove_others(root, &path, names)?;
        } else if path.strip_prefix(root).is_ok_and(|name| !names.contains(name)) {
            std::fs::remove_file(&path)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_copy_follows_the_working_tree_and_edits_are_undone() {
        let folder = tempfile::tempdir().unwrap();
        let (work, copy) = (folder.path().join("work"), folder.path().join("copy"));
        std::fs::create_dir_all(work.join("sub")).unwrap();
        for (name, text) in
            [("sub/a.txt", "one two"), ("b.txt", "b"), (".gitignore", "ignored"), ("ignored", "")]
        {
            std::fs::write(work.join(name), text).unwrap();
        }
        assert!(Command::new("git").arg("init").arg("-q").current_dir(&work).status().unwrap().success());
        let tree = Tree::copy(&work, copy.clone()).unwrap();
        let read = |name: &str| std::fs::read_to_string(copy.join(name)).ok();
        assert_eq!((read("sub/a.txt").as_deref(), read("ignored")), (Some("one two"), None));

        let edit = |find: &str, replace: &str| Edit {
            file: "sub/a.txt".into(),
            find: find.into(),
            replace: replace.into(),
        };
        let applied = tree.apply(&[edit("one", "1"), edit("two", "2")]).unwrap();
        assert_eq!(read("sub/a.txt").as_deref(), Some("1 2"));
        drop(applied);
        assert_eq!(read("sub/a.txt").as_deref(), Some("one two"));

        // An interrupted run left its edit, and a file has gone since.
        std::mem::forget(tree.apply(&[edit("one", "1")]).unwrap());
        std::fs::remove_file(work.join("b.txt")).unwrap();
        Tree::copy(&work, copy.clone()).unwrap();
        assert_eq!((read("sub/a.txt").as_deref(), read("b.txt")), (Some("one two"), None));
    }
}
