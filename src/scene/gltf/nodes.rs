//! The node graph: checked to be a forest, then walked in scene order with world transforms in double precision.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::document::{Children, Document, Node, label};
use crate::scene::error::{SceneError, SceneFault, SceneResult};
use crate::scene::model::WORLD_LIMIT_M;

/// A node on its way through the scene.
pub struct Visit<'a> {
    /// The node itself.
    pub node: Node<'a>,
    /// From the node's frame to the world.
    pub world_from_node: DAffine3,
    /// As named in messages.
    pub element: String,
}

/// Calls `each` for every node below `roots`, depth first, parents before children. Deep chains take no stack.
///
/// # Errors
/// When the graph is no forest, a transform is not finite, or `each` fails.
pub fn walk<'a>(
    document: &'a Document<'a>,
    roots: &[u32],
    scene: &str,
    mut each: impl FnMut(Visit<'a>) -> SceneResult<()>,
) -> SceneResult<()> {
    check_forest(document, roots, scene)?;
    // A frame is a list of siblings, the next of them to visit, and their parent's transform.
    let mut frames = vec![(roots.to_vec(), 0, DAffine3::IDENTITY)];
    while let Some((siblings, next, world_from_parent)) = frames.last_mut() {
        let Some(&index) = siblings.get(*next) else {
            frames.pop();
            continue;
        };
        *next += 1;
        let node: Node = document.nodes.get("nodes", index, scene)?;
        let element = label("nodes", index, node.name.as_deref());
        let world_from_node = place(*world_from_parent, &node, &element)?;
        let children: Children = document.nodes.get("nodes", index, scene)?;
        each(Visit { node, world_from_node, element })?;
        if !children.children.is_empty() {
            frames.push((children.children, 0, world_from_node));
        }
    }
    Ok(())
}

fn place(world_from_parent: DAffine3, node: &Node, element: &str) -> SceneResult<DAffine3> {
    let world = world_from_parent * local_transform(node, element)?;
    let largest = world.translation.abs().max_element();
    if world.is_finite() && largest <= WORLD_LIMIT_M {
        return Ok(world);
    }
    let value = if world.is_finite() { largest } else { f64::INFINITY };
    let what = "its position or scale in the world".into();
    Err(SceneError::at(element, SceneFault::Range { what, value, expected: "at most 1e12 m from the origin" }))
}

fn local_transform(node: &Node, element: &str) -> SceneResult<DAffine3> {
    if let Some(m) = node.matrix {
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            let what = "the last row of its matrix (sum)".into();
            let value = m[3] + m[7] + m[11] + m[15];
            return Err(SceneError::at(element, SceneFault::Range { what, value, expected: "0, 0, 0, 1" }));
        }
        let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
        let linear = DMat3::from_cols(column(0), column(1), column(2));
        return Ok(DAffine3 { matrix3: linear, translation: column(3) });
    }
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    if !(rotation.length() > 0.0 && rotation.length().is_finite()) {
        let (what, value) = ("the length of its rotation".into(), rotation.length());
        return Err(SceneError::at(element, SceneFault::Range { what, value, expected: "a unit quaternion" }));
    }
    let scale = DVec3::from_array(node.scale.unwrap_or([1.0; 3]));
    let translation = DVec3::from_array(node.translation.unwrap_or([0.0; 3]));
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation.normalize(), translation))
}

/// No parent yet.
const ORPHAN: u32 = u32::MAX;

/// Every node has one parent at most, no node is its own ancestor, and roots have none.
fn check_forest(document: &Document, roots: &[u32], scene: &str) -> SceneResult<()> {
    let parents = parents(document)?;
    check_cycles(&parents)?;
    let mut listed = vec![false; parents.len()];
    for &root in roots {
        let Some(seen) = listed.get_mut(root as usize) else {
            let fault = SceneFault::Index { target: "nodes", index: root.into(), len: parents.len() };
            return Err(SceneError::at(scene, fault));
        };
        if std::mem::replace(seen, true) {
            return Err(SceneError::at(scene, SceneFault::NodeGraph(format!("lists nodes[{root}] twice"))));
        }
        let parent = parents[root as usize];
        if parent != ORPHAN {
            let problem = format!("lists nodes[{root}] as a root, but it is a child of nodes[{parent}]");
            return Err(SceneError::at(scene, SceneFault::NodeGraph(problem)));
        }
    }
    Ok(())
}

fn parents(document: &Document) -> SceneResult<Vec<u32>> {
    let mut parents = vec![ORPHAN; document.nodes.len()];
    // More nodes than u32 can count would need a file of 12 GB.
    for index in 0..u32::try_from(parents.len()).unwrap_or(ORPHAN) {
        let element = || format!("nodes[{index}]");
        let children: Children = document.nodes.get("nodes", index, "")?;
        for child in children.children {
            let len = parents.len();
            let Some(parent) = parents.get_mut(child as usize) else {
                let fault = SceneFault::Index { target: "nodes", index: child.into(), len };
                return Err(SceneError::at(element(), fault));
            };
            if *parent != ORPHAN {
                let problem = format!("nodes[{child}] is a child of both nodes[{}] and nodes[{index}]", *parent);
                return Err(SceneError::at(element(), SceneFault::NodeGraph(problem)));
            }
            *parent = index;
        }
    }
    Ok(parents)
}

/// Follows parents upward from every node; a node met twice on one way up lies on a cycle.
fn check_cycles(parents: &[u32]) -> SceneResult<()> {
    let mut met_from = vec![ORPHAN; parents.len()];
    for start in 0..parents.len() {
        let mut at = start as u32;
        while at != ORPHAN && met_from[at as usize] == ORPHAN {
            met_from[at as usize] = start as u32;
            at = parents[at as usize];
        }
        if at != ORPHAN && met_from[at as usize] == start as u32 {
            let problem = "is its own ancestor".into();
            return Err(SceneError::at(format!("nodes[{at}]"), SceneFault::NodeGraph(problem)));
        }
    }
    Ok(())
}

/// The scale of lengths under a transform: the cube root of |det|, and whether all directions share it.
///
/// # Errors
/// When the transform flattens space.
pub fn length_scale(linear: DMat3, element: &str) -> SceneResult<(f64, Uniformity)> {
    let (a, b, c) = (linear.x_axis.length(), linear.y_axis.length(), linear.z_axis.length());
    let scale = linear.determinant().abs().cbrt();
    let smallest = a.min(b).min(c);
    // A determinant that is zero next to the axes' lengths leaves no volume to put a sphere in.
    if !(scale.is_finite() && smallest > 0.0 && scale > 1e-9 * a.max(b).max(c)) {
        let what = "its scale (cube root of the determinant)".into();
        return Err(SceneError::at(
            element,
            SceneFault::Range { what, value: scale, expected: "a scale that is not 0" },
        ));
    }
    // 1e-4: single-precision rotations and scales that exporters round deviate by less.
    let product = a * b * c;
    let uniform = a.max(b).max(c) <= smallest * (1.0 + 1e-4) && (scale.powi(3) - product).abs() <= 1e-4 * product;
    Ok((scale, if uniform { Uniformity::Uniform } else { Uniformity::Skewed }))
}

/// Whether a transform keeps spheres round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Uniformity {
    Uniform,
    Skewed,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_are_found_and_chains_are_not() {
        assert!(check_cycles(&[ORPHAN, 0, 1, 1]).is_ok());
        assert!(check_cycles(&[1, 0]).is_err());
        assert!(check_cycles(&[ORPHAN, 3, 1, 2, 3]).is_err());
        assert!(check_cycles(&[0]).is_err());
        let chain: Vec<u32> = (0..100_000_u32).map(|i| if i == 0 { ORPHAN } else { i - 1 }).collect();
        assert!(check_cycles(&chain).is_ok());
    }

    #[test]
    fn scales_are_cube_roots_and_skew_is_noticed() -> SceneResult<()> {
        let mirrored = DMat3::from_diagonal(DVec3::new(-2.0, 2.0, 2.0));
        assert_eq!(length_scale(mirrored, "")?, (2.0, Uniformity::Uniform));
        let (scale, uniformity) = length_scale(DMat3::from_diagonal(DVec3::new(1.0, 2.0, 4.0)), "")?;
        assert!((scale - 2.0).abs() < 1e-15 && uniformity == Uniformity::Skewed);
        assert!(length_scale(DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)), "").is_err());
        let rotated = DMat3::from_quat(DQuat::from_rotation_y(0.7)) * 1e-6;
        assert_eq!(length_scale(rotated, "")?.1, Uniformity::Uniform);
        Ok(())
    }
}
