//! What droplets are made of and how they scatter: materials, size distributions, size bins, phase tables.

mod bin_optics;
pub mod bins;
pub mod cache;
pub mod count;
pub mod csv;
pub mod distribution;
mod distribution_error;
mod distribution_parse;
pub mod ensemble;
pub mod hg_draine;
mod index_table;
pub mod material;
pub mod peak;
mod phase_blur;
pub mod phase_build;
mod phase_cell;
pub mod phase_function;
pub mod phase_model;
mod phase_shape;
pub mod phase_table;
pub mod quadrature;
pub mod size_average;
pub mod size_law;
pub mod size_nodes;
pub mod tables;
mod turns;

pub use bin_optics::BinOptics;
pub use distribution_error::DistributionError;

/// Reads the text of a file that a description names; the caller decides which files may be read.
pub type ReadText<'a> = &'a dyn Fn(&str) -> Result<String, String>;

/// What a group of droplets has in common; particles refer to it by index.
#[derive(Clone, Debug, PartialEq)]
pub struct DropletClass {
    /// What the droplets are made of.
    pub material: material::Material,
    /// How their phase function is modelled.
    pub phase: phase_model::PhaseModel,
    /// The sizes in a parcel or fog box that names no radius.
    pub distribution: distribution::SizeDistribution,
    /// Overrides the single-scattering albedo (comparisons with other solvers), in 0 ..= 1.
    pub albedo: Option<f64>,
}
