//! What can be wrong with a recipe, and what to change.

use thiserror::Error;

use crate::scene::model::WORLD_LIMIT_M;
use crate::units::format_bytes;

/// A cloud could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum GenerateError {
    /// No particles were asked for.
    #[error("a cloud needs at least one particle: set `--count` to 1 or more")]
    NoParticles,
    /// A length of the shape is zero, negative, infinite or NaN.
    #[error("`--size` {size_m:e} m is not a length between 1e-9 m and 1e9 m")]
    Size { size_m: f64 },
    /// A grown shape is too flat, or too slender, to grow in.
    #[error(
        "`--shape {shape}` grows in boxes up to {most} times as long as their shortest side, not {ratio:.0} times: use a fuller `--size`, or `--shape slab` or `box`"
    )]
    Aspect { shape: &'static str, ratio: f64, most: f64 },
    /// Nothing grew where the optical depth is counted.
    #[error(
        "with `--seed {seed}` nothing grows along the shortest side through the centre, where the optical depth is counted: choose another `--seed`, or a fuller `--size`"
    )]
    NoMiddle { seed: u64 },
    /// The shape takes another number of lengths.
    #[error("`--shape {shape}` takes {expected} in `--size`, not {found}")]
    SizeCount { shape: &'static str, expected: &'static str, found: usize },
    /// No such shape.
    #[error("there is no shape `{name}`: `--shape` is one of {known}")]
    Shape { name: String, known: String },
    /// The cloud does not fit in a GLB file.
    #[error(
        "{count} particles take {}, more than the {} of a GLB file: lower `--count` to {max_count} (a parcel stands for many droplets)",
        format_bytes(u64::try_from(*.bytes).unwrap_or(u64::MAX)), format_bytes(*.limit_bytes)
    )]
    TooLarge { count: u64, bytes: u128, limit_bytes: u64, max_count: u64 },
    /// The cloud does not fit in memory.
    #[error(
        "{count} particles need about {} of memory, and {} may be used: lower `--count` (a parcel stands for many droplets), or raise `--memory-limit` if there is more",
        format_bytes(*.bytes), format_bytes(*.limit_bytes)
    )]
    Memory { count: u64, bytes: u64, limit_bytes: u64 },
    /// The size distribution gives a radius that no droplet has.
    #[error("`--distribution` gives a droplet of radius {radius_m:e} m: radii must lie between 1 pm and 1 km")]
    DropletRadius { radius_m: f64 },
    /// Liquid water or optical depth is zero, negative, infinite or NaN.
    #[error("`{flag}` {value} must be a positive, finite number")]
    Content { flag: &'static str, value: f64 },
    /// The droplets are beyond the reach of Mie theory.
    #[error(
        "a droplet of radius {radius_m:.4e} m has a size parameter of {size_parameter:.3e} at 550 nm: Mie theory is validated from {least:e} to {most:e}, radii up to {largest_m:.3e} m; change `--distribution`"
    )]
    SizeParameter { radius_m: f64, size_parameter: f64, least: f64, most: f64, largest_m: f64 },
    /// The extinction efficiency that was given for a radius cannot be used.
    #[error(
        "the extinction efficiency of a droplet of radius {radius_m:e} m is {q_ext}, not a positive number: check material and `--distribution`"
    )]
    Extinction { radius_m: f64, q_ext: f64 },
    /// Real droplets would fill the shape more densely than spheres can.
    #[error(
        "{count} droplets would fill {fraction:.3} of the shape, more than spheres can: raise `--size`{}",
        if *.max_count > 0 { format!(", or lower `--count` to {max_count}") } else { String::new() }
    )]
    Crowded { count: u64, fraction: f64, max_count: u64 },
    /// Few droplets that stand for many would be drawn larger than the cloud.
    #[error(
        "{count} droplets would have to be drawn with a radius of {radius_m:e} m in a shape {size_m:e} m across: raise `--count` to {min_count} or more, or use `--kind parcels`"
    )]
    Magnified { count: u64, radius_m: f64, size_m: f64, min_count: u64 },
    /// Particles would be drawn smaller than a reader takes them.
    #[error(
        "particles would be drawn with a radius of {radius_m:e} m, and below {least_m:e} m, an atom, none is read: lower `--count`, or ask for more with `--size`, `--liquid-water` or `--optical-depth`"
    )]
    Tiny { radius_m: f64, least_m: f64 },
    /// There are fewer droplets than parcels to put them in.
    #[error(
        "{parcels} parcels would share only {droplets:.3} droplets: use `--kind droplets`, lower `--count`, or ask for more water with `--liquid-water` or `--optical-depth`"
    )]
    EmptyParcels { parcels: u64, droplets: f64 },
    /// A parcel would hold more droplets than its attribute can say.
    #[error(
        "a parcel would hold {droplets:e} droplets, more than a scene may have in one (1e36): raise `--count`, or lower `--liquid-water` or `--optical-depth`"
    )]
    FullParcels { droplets: f64 },
    /// Patchiness outside 0 ..= 1.
    #[error("`--patchiness` {value} must lie between 0 (even) and 1 (banks with clear air between)")]
    Patchiness { value: f64 },
    /// Parcels that do not touch, or far too large ones.
    #[error("`--overlap` {value} must lie between 0.62 (parcels fill the space once) and 4")]
    Overlap { value: f64 },
    /// Camera or sun cannot be placed.
    #[error(
        "{what} must be finite and at most {WORLD_LIMIT_M:e} m away, with the camera away from what it looks at and a field of view between 0 and 180 degrees"
    )]
    View { what: &'static str },
}
