//! The tree: clustered by obvhs in parts that lie together in space, so that memory stays bounded, and joined.

use std::ops::Range;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;

use super::node::Node;
use super::walk::MAX_DEPTH;

/// Most leaves of a part, and so of what obvhs holds at a time: 50 MB for each thread.
pub(super) const PART: usize = 1 << 17;

/// Depth that a part, or the tree over all parts, may have.
const MAX_PART_DEPTH: usize = MAX_DEPTH / 2;

/// obvhs converts trees by recursion.
const MAX_BINARY_DEPTH: usize = 64;

/// obvhs' preset that builds fastest; slower ones gain nothing on evenly spread spheres.
const PRESET: BvhBuildParams = BvhBuildParams::very_fast_build();

/// A tree over some leaves, its root first.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    /// The leaves in the order in which nodes count them.
    pub order: Vec<u32>,
    pub bounds: Aabb,
}

impl Tree {
    /// Over boxes, at least one.
    pub fn new(leaf_boxes: &[Aabb]) -> Self {
        let wide = build_wide(leaf_boxes);
        let mut tree = Self { nodes: vec![Node::default()], order: Vec::new(), bounds: wide.total_aabb };
        let mut todo = vec![(0, 0)];
        while let Some((from, to)) = todo.pop() {
            let Children { inner, leaves, axis } = Children::of(&wide, from, leaf_boxes);
            let boxes: Vec<Aabb> = inner.iter().chain(&leaves).map(|(_, aabb)| *aabb).collect();
            let (child_base, leaf_base) = (tree.nodes.len() as u32, tree.order.len() as u32);
            tree.nodes[to] = Node::new(&boxes, inner.len(), axis, child_base, leaf_base);
            tree.nodes.resize(tree.nodes.len() + inner.len(), Node::default());
            tree.order.extend(leaves.iter().map(|(leaf, _)| leaf));
            todo.extend(inner.iter().map(|(node, _)| *node as usize).zip(child_base as usize..));
        }
        tree
    }

    /// One tree over several, given with the place of their first leaf.
    pub fn join(mut parts: Vec<(Tree, u32)>) -> Vec<Node> {
        if let [(only, _)] = &mut parts[..] {
            return std::mem::take(&mut only.nodes);
        }
        let roots: Vec<Aabb> = parts.iter().map(|(part, _)| part.bounds).collect();
        let wide = build_wide(&roots);
        let mut nodes =
            Vec::with_capacity(wide.nodes.len() + parts.iter().map(|(part, _)| part.nodes.len()).sum::<usize>());
        nodes.push(Node::default());
        let mut todo = vec![(0, 0)];
        while let Some((from, to)) = todo.pop() {
            let Children { inner, leaves, .. } = Children::of(&wide, from, &roots);
            let mut children: Vec<(bool, u32, Aabb)> = inner.iter().map(|(node, aabb)| (true, *node, *aabb)).collect();
            children.extend(leaves.iter().map(|(part, aabb)| (false, *part, *aabb)));
            let axis = sort_along(&mut children, |(.., aabb)| *aabb);
            let boxes: Vec<Aabb> = children.iter().map(|(.., aabb)| *aabb).collect();
            let child_base = nodes.len();
            nodes[to] = Node::new(&boxes, boxes.len(), axis, child_base as u32, 0);
            nodes.resize(child_base + children.len(), Node::default());
            for ((is_inner, index, _), slot) in children.into_iter().zip(child_base..) {
                if is_inner {
                    todo.push((index as usize, slot));
                } else {
                    let (part, first_leaf) = std::mem::take(&mut parts[index as usize]);
                    graft(&mut nodes, slot, part.nodes, first_leaf);
                }
            }
        }
        nodes
    }
}

/// Puts a part's root at a place and all its other nodes at the end.
fn graft(nodes: &mut Vec<Node>, slot: usize, part: Vec<Node>, first_leaf: u32) {
    // The part's node 1 becomes the next one.
    let shift = nodes.len() as u32 - 1;
    let mut moved = part.into_iter().map(|node| node.moved(shift, first_leaf));
    if let Some(root) = moved.next() {
        nodes[slot] = root;
    }
    nodes.extend(moved);
}

/// The children of one of obvhs' nodes: their index and exact box.
struct Children {
    inner: Vec<(u32, Aabb)>,
    leaves: Vec<(u32, Aabb)>,
    /// Along which inner nodes are sorted.
    axis: usize,
}

impl Children {
    fn of(wide: &CwBvh, index: usize, leaf_boxes: &[Aabb]) -> Self {
        let node = &wide.nodes[index];
        let exact = |child: u32| wide.exact_node_aabbs.as_ref().map(|boxes| boxes[child as usize]);
        let (mut inner, mut leaves) = (Vec::new(), Vec::new());
        for child in (0..8).filter(|child| !node.is_child_empty(*child)) {
            if node.is_leaf(child) {
                let (first, count) = node.child_primitives(child);
                let primitives = &wide.primitive_indices[first as usize..(first + count) as usize];
                leaves.extend(primitives.iter().map(|leaf| (*leaf, leaf_boxes[*leaf as usize])));
            } else {
                let child_node = node.child_node_index(child);
                inner.push((child_node, exact(child_node).unwrap_or_else(|| node.child_aabb(child))));
            }
        }
        let axis = sort_along(&mut inner, |(_, aabb)| *aabb);
        Self { inner, leaves, axis }
    }
}

/// Sorts boxes by their middles along the axis in which these differ most, and returns it.
fn sort_along<T>(children: &mut [T], aabb: impl Fn(&T) -> Aabb) -> usize {
    let middles = children.iter().fold(Aabb::empty(), |all, child| all.union(&Aabb::from_point(aabb(child).center())));
    let axis = if children.is_empty() { 0 } else { (middles.max - middles.min).max_position() };
    children.sort_by(|a, b| aabb(a).center()[axis].total_cmp(&aabb(b).center()[axis]));
    axis
}

/// A wide tree, by obvhs' clustering where that is shallow enough, otherwise balanced in the order given.
fn build_wide(leaf_boxes: &[Aabb]) -> CwBvh {
    let indices: Vec<u32> = (0..leaf_boxes.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(leaf_boxes.len()).build(
        PRESET.ploc_search_distance,
        leaf_boxes,
        indices,
        PRESET.sort_precision,
        PRESET.search_depth_threshold,
    );
    if binary.max_depth <= 96 {
        ReinsertionOptimizer::default().run(&mut binary, PRESET.reinsertion_batch_ratio, None);
    }
    if binary_depth(&binary) <= MAX_BINARY_DEPTH {
        let wide = widen(&binary);
        if wide_depth(&wide) <= MAX_PART_DEPTH {
            return wide;
        }
    }
    widen(&balanced(leaf_boxes))
}

/// One body to a box: a box that is met costs less than a body, and holds it in more than half of all cases.
fn widen(binary: &Bvh2) -> CwBvh {
    bvh2_to_cwbvh(binary, 1, false, true)
}

/// Depth of a binary tree, without recursion.
fn binary_depth(tree: &Bvh2) -> usize {
    let mut stack = vec![(0usize, 1usize)];
    let mut deepest = 0;
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            stack.extend([0, 1].map(|child| (node.first_index as usize + child, depth + 1)));
        }
    }
    deepest
}

/// Depth of a wide tree, without recursion.
fn wide_depth(tree: &CwBvh) -> usize {
    let mut stack = vec![(0usize, 1usize)];
    let mut deepest = 0;
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[index];
        stack.extend((0..node.imask.count_ones() as usize).map(|c| (node.child_base_idx as usize + c, depth + 1)));
    }
    deepest
}

/// A binary tree that halves the leaves in the order given: as deep as the logarithm of their number.
fn balanced(leaf_boxes: &[Aabb]) -> Bvh2 {
    let mut tree = Bvh2 { nodes: vec![Bvh2Node::default()], ..Bvh2::default() };
    tree.primitive_indices = (0..leaf_boxes.len() as u32).collect();
    fill_balanced(&mut tree, leaf_boxes, 0, 0);
    tree.children_are_ordered_after_parents = true;
    tree
}

fn fill_balanced(tree: &mut Bvh2, leaf_boxes: &[Aabb], node: usize, first: usize) -> Aabb {
    if let [only] = leaf_boxes {
        tree.nodes[node] = Bvh2Node::new(*only, 1, first as u32);
        return *only;
    }
    let children = tree.nodes.len();
    tree.nodes.extend([Bvh2Node::default(); 2]);
    let half = leaf_boxes.len() / 2;
    let left = fill_balanced(tree, &leaf_boxes[..half], children, first);
    let right = fill_balanced(tree, &leaf_boxes[half..], children + 1, first + half);
    let both = left.union(&right);
    tree.nodes[node] = Bvh2Node::new(both, 0, children as u32);
    both
}

/// Cuts leaves that are sorted by key into parts of at most `PART`, where the highest bits of their keys differ.
pub(super) fn parts(range: Range<usize>, key: &impl Fn(usize) -> u64) -> Vec<Range<usize>> {
    let (mut todo, mut done) = (vec![range], Vec::new());
    while let Some(range) = todo.pop() {
        if range.len() <= PART {
            done.push(range);
            continue;
        }
        let (first, last) = (key(range.start), key(range.end - 1));
        let middle = match (first ^ last).checked_ilog2() {
            Some(bit) => first_with(&range, |leaf| key(leaf) >> bit & 1 == 1),
            None => range.start + range.len() / 2,
        };
        todo.extend([middle..range.end, range.start..middle]);
    }
    done
}

/// The first leaf of a range for which something holds that holds for all after it.
fn first_with(range: &Range<usize>, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (range.start, range.end);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_balanced_tree_is_shallow_and_holds_every_leaf() {
        let leaves: Vec<Aabb> = (0..1000).map(|i| Aabb::from_point(glam::Vec3A::splat(i as f32 * 100.0))).collect();
        let tree = balanced(&leaves);
        assert_eq!(binary_depth(&tree), 11);
        assert_eq!(tree.nodes.iter().filter(|node| node.is_leaf()).count(), 1000);
        assert!(wide_depth(&widen(&tree)) <= 8);
    }

    #[test]
    fn parts_follow_each_other_and_are_small() {
        // Half of the keys in one corner, and more than a part with the same key.
        let key = |leaf: usize| if leaf < 200_000 { (leaf as u64) >> 18 } else { (leaf as u64) << 40 };
        let parts = parts(0..400_000, &key);
        assert!(parts.iter().all(|part| !part.is_empty() && part.len() <= PART));
        assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert_eq!((parts[0].start, parts[parts.len() - 1].end), (0, 400_000));
    }
}
