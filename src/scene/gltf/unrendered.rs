//! Notes what a file holds that is not rendered: one warning per kind, with a count and the first name.

use std::collections::BTreeMap;

use super::document::Document;
use super::extensions::{is_harmless, is_understood};
use crate::warning::Warning;

/// A kind of thing that is noticed once, however often it occurs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Mesh,
    BarePoints,
    OtherLight,
    SkinnedNode,
    MorphTarget,
    EmptyMark,
    SkewedDroplet,
    ZeroRadius,
    ZeroCount,
    ShrunkDroplet,
    LargeDrop,
    NoSphere,
    NoBox,
    OwnAttribute,
    IdleMark,
    IdleLightMark,
    CountedBox,
    IdleInstances,
}

impl Kind {
    /// What is said: `(singular, plural, what happens, remedy)`.
    fn words(self) -> [&'static str; 4] {
        match self {
            Kind::Mesh => [
                "mesh node",
                "mesh nodes",
                "not rendered: only droplets and fog are",
                "mark spheres with extras.mie_cloud.kind = \"droplet\" or --droplets GLOB, boxes with kind = \"fog\"",
            ],
            Kind::BarePoints => [
                "node of points without a _RADIUS",
                "nodes of points without a _RADIUS",
                "not rendered",
                "give them one with --radius",
            ],
            Kind::OtherLight => {
                ["point or spot light", "point and spot lights", "not rendered", "use directional lights"]
            }
            Kind::SkinnedNode => {
                ["skinned node", "skinned nodes", "placed by its own transform; the skin is left out", ""]
            }
            Kind::MorphTarget => ["mesh with morph targets", "meshes with morph targets", "read without them", ""],
            Kind::EmptyMark => [
                "node marked as droplet or fog has no mesh",
                "nodes marked as droplets or fog have no mesh",
                "not rendered",
                "put the mark on a node with a mesh",
            ],
            Kind::SkewedDroplet => [
                "transform of droplets with a non-uniform scale",
                "transforms of droplets with a non-uniform scale",
                "the spheres are scaled by the cube root of |det|",
                "apply a uniform scale",
            ],
            Kind::ZeroRadius => [
                "droplet of radius 0",
                "droplets of radius 0",
                "left out",
                "check whether a quantiser rounded the radii",
            ],
            Kind::ZeroCount => {
                ["particle with a _DROPLET_COUNT of 0", "particles with a _DROPLET_COUNT of 0", "left out", ""]
            }
            Kind::ShrunkDroplet => [
                "droplet drawn smaller than it is",
                "droplets drawn smaller than they are",
                "their _RADIUS is below _DROPLET_RADIUS_UM",
                "give a _RADIUS in metres under the node's scale, at least the droplet's own",
            ],
            Kind::LargeDrop => [
                "droplet of more than 5 mm radius",
                "droplets of more than 5 mm radius",
                "no such drops exist in air",
                "for a cloud give each a number of droplets (_DROPLET_COUNT, or droplet_count of its node) or mark balls of \
                 fog (kind = \"fog\"), for a magnified droplet give _DROPLET_RADIUS_UM, or check \
                 whether the radii are micrometres",
            ],
            Kind::NoSphere => [
                "droplet mesh that is no sphere",
                "droplet meshes that are no spheres",
                "drawn as the sphere through their farthest vertex",
                "use a UV sphere or an icosphere",
            ],
            Kind::NoBox => [
                "fog mesh that is no box",
                "fog meshes that are no boxes",
                "drawn as its bounding box",
                "POINTS with _RADIUS, marked as fog, make balls of it",
            ],
            Kind::OwnAttribute => [
                "vertex attribute of the file's own",
                "vertex attributes of the file's own",
                "not read",
                "known are _RADIUS, _DROPLET_RADIUS_UM, _DROPLET_COUNT, _MATERIAL",
            ],
            Kind::IdleMark => [
                "node says something of droplets and has no mesh",
                "nodes say something of droplets and have no mesh",
                "not used",
                "put it on the nodes with meshes, on their meshes or materials; children take nothing from their parents",
            ],
            Kind::IdleLightMark => [
                "node says something of a sun and has no light",
                "nodes say something of suns and have no light",
                "not used",
                "put `spectrum` and `angular_diameter_deg` on the node of a directional light, or on the light",
            ],
            Kind::CountedBox => [
                "fog box with a density and a droplet_count",
                "fog boxes with a density and a droplet_count",
                "filled to the density; the count is not used",
                "take one of them away",
            ],
            Kind::IdleInstances => [
                "node whose instances and points both have attributes of droplets",
                "nodes whose instances and points both have attributes of droplets",
                "those of the points are used",
                "take one of them away",
            ],
        }
    }
}

/// Counts what was noticed.
#[derive(Debug, Default)]
pub struct Unrendered {
    seen: BTreeMap<Kind, (u64, String)>,
}

impl Unrendered {
    /// Notes `count` of a kind; the first name is kept.
    pub fn note(&mut self, kind: Kind, count: u64, name: impl FnOnce() -> String) {
        if count > 0 {
            self.seen.entry(kind).or_insert_with(|| (0, name())).0 += count;
        }
    }

    /// One warning per kind, in a fixed order.
    pub fn into_warnings(self) -> Vec<Warning> {
        let warning = |(kind, (count, name)): (Kind, (u64, String))| {
            let [one, many, what, remedy] = kind.words();
            let subject = if count == 1 { one } else { many };
            let first = if count == 1 { "" } else { "first " };
            Warning::new(format!("{count} {subject} ({first}{name}): {what}"), remedy)
        };
        self.seen.into_iter().map(warning).collect()
    }
}

/// What stands at the top level of a file and is not rendered.
pub fn top_level(document: &Document, scene: u32) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let parts = [
        ("animations", document.animations.len()),
        ("skins", document.skins.len()),
        ("textures", document.textures.len().max(document.images.len())),
        ("scenes besides", document.scenes.len().saturating_sub(1)),
    ];
    for (what, count) in parts.iter().filter(|(_, count)| *count > 0) {
        let text = match *what {
            "scenes besides" => format!("scenes besides scenes[{scene}] ({count}) are not rendered"),
            _ => format!("{what} ({count}) are not rendered"),
        };
        warnings.push(Warning::new(text, ""));
    }
    if !document.materials.is_empty() {
        let what = format!("colours and surfaces of materials ({}) are not rendered", document.materials.len());
        warnings.push(Warning::new(what, ""));
    }
    let unknown: Vec<&str> =
        document.extensions_used.iter().map(String::as_str).filter(|n| !is_understood(n) && !is_harmless(n)).collect();
    if let Some(first) = unknown.first() {
        let first = crate::excerpt::excerpt(first);
        let more = if unknown.len() > 1 { format!(" and {} more", unknown.len() - 1) } else { String::new() };
        warnings.push(Warning::new(format!("extension {first}{more} is not understood and left out"), ""));
    }
    warnings
}
