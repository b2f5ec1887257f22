//! Generated particle cases for tests, benches and `meniscus make`.
//!
//! The three [`Case`]s stand in for published simulations: same particle numbers, same kind of shape and motion, same
//! attributes. They are analytic - jittered lattices under moving free surfaces, with droplets - and made for size and
//! regression, **not for realism**: nothing is simulated, and no number taken from them says anything about water.
//!
//! What does hold: exactly the particle number asked for; the same bytes for the same options, whatever the number of
//! threads; particles that keep their identity and move continuously; volume preserved by every motion, so that the local
//! spacing stays that of [`Case::spacing`].
//!
//! [`lattice`] has the simplest bodies of all, with volumes known exactly.

mod case;
mod dam_break;
mod fjord;
mod fjord_ground;
mod flight;
mod flow;
mod golden;
pub mod lattice;
mod source;
mod sphere_entry;

pub use case::{Case, CaseError, CaseFrame, CaseOptions, Ground};
pub use source::CaseSource;
