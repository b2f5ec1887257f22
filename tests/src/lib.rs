//! The end-to-end tests' kit: run the program in a folder of its own, read what it wrote, measure pictures, and draw with
//! the pipeline as a library. The cases are in `tests/`: `program` runs the program as users do, `chain` measures what only
//! the library shows. Each is one executable with a module per idea, because linking costs more than running.

mod data;
mod film;
pub mod golden;
mod mask;
mod pixels;
mod program;
mod studio;

pub use data::data_dir;
pub use film::Film;
pub use mask::Mask;
pub use pixels::{Pixels, read_json};
pub use program::{Outcome, Program, Running};
pub use studio::{Shot, Studio, space};
