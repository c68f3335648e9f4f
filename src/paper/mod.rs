//! A paper's formulas as they were published, its ten figures, and exact Mie beside them.
//!
//! The paper drew one droplet in three colours with a Henyey-Greenstein phase function. `mie-cloud paper` draws its figures
//! three ways, so that a reader sees which of its colours are light: by its code listing, by its equations, by exact Mie.
//! Theory (80)-(89) numbers its formulas. Nothing else uses this module, and it is no model for anything else.

mod bessel;
mod captions;
mod exact;
mod exact_column;
mod figures;
pub mod formulas;
mod geometry;
mod picture;
mod sheet;
mod study;
mod table;
mod tone;

pub use captions::{Claim, Verdict, judge};
pub use exact::ExactSphere;
pub use figures::{Channel, FIGURES, Figure, INDEX, WAVELENGTHS_NM};
pub use sheet::contact_sheet;
pub use study::{Column, Method, Numbers, PaperError, Study, make};
pub use table::{sensitivity, text, write_csv};
