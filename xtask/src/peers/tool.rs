//! Running a tool that prints what it measured.

use std::{path::PathBuf, process::Command};

use serde::de::DeserializeOwned;

use super::python::Vtk;
use crate::{
    error::{Error, Result},
    process,
};

/// Where everything is.
pub struct Tools {
    /// Folder of our programs.
    pub ours: PathBuf,
    /// Folder of the peers' scripts.
    pub scripts: PathBuf,
    /// For whoever draws.
    pub variables: Vec<(&'static str, String)>,
    /// `None` where it is not to be had.
    pub vtk: Option<Vtk>,
}

impl Tools {
    /// One of our programs.
    pub fn ours(&self, program: &str) -> Command {
        let mut command = Command::new(self.ours.join(program));
        command.envs(self.variables.iter().cloned());
        command
    }

    /// A script with the Python that has VTK; `None` without.
    pub fn script(&self, name: &str) -> Option<Command> {
        let mut command = Command::new(self.vtk.as_ref()?.python);
        command.arg(self.scripts.join(name)).envs(self.variables.iter().cloned());
        Some(command)
    }
}

/// Echoes and runs a command that prints JSON.
pub fn json<T: DeserializeOwned>(command: &mut Command) -> Result<T> {
    println!("$ {}", process::shown(command));
    let output = process::capture(command)?;
    serde_json::from_slice(&output)
        .map_err(|source| Error::Unexpected { command: process::shown(command), source })
}
