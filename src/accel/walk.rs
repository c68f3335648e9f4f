//! Walks the tree along a ray, eight boxes at once and several nodes at a time.
//!
//! Nodes wait on a stack. Up to a batch of them are taken off together and tested one after the other without a branch that
//! depends on the outcome: what they meet is written behind the lists' ends, and only the lengths tell how much counts. So
//! the processor works on the next node while the last is still on its way from memory. What is looked at may differ between
//! processors in the last bit of a box; boxes are padded by more than that, so what is found does not.

use obvhs::ray::Ray;

use super::node::{Node, NodeRay, WIDTH};

/// How boxes are tested, found out once.
#[derive(Clone, Copy, Debug)]
pub(super) enum Walker {
    /// AVX2 and FMA: eight boxes at once.
    #[cfg(target_arch = "x86_64")]
    Eight(pulp::x86::V3),
    /// As the compiler does it for any processor.
    Plain,
}

/// What happens on the way; inlined into the walk, so that it is compiled for the same processor.
pub(super) trait Visitor {
    /// Looks at a primitive whose box the ray meets before `tmax`; may shorten the ray.
    fn visit(&mut self, primitive: usize, tmax: &mut f32);
}

/// Deepest tree that the stack holds.
pub(super) const MAX_DEPTH: usize = 36;

/// Length of the stack.
const STACK: usize = 512;

/// Most nodes that are tested before the bodies among their children are visited. Four are a tenth slower where rays meet
/// little, and no faster where they soon meet something.
const BATCH: usize = 8;

/// From here on nodes are taken one by one: each then adds at most seven, level by level.
const CROWDED: usize = STACK - BATCH * WIDTH - MAX_DEPTH * (WIDTH - 1);

/// Places of the bits of a byte that are set, in both orders.
const PLACES: [[[u8; WIDTH]; 256]; 2] = places();

const fn places() -> [[[u8; WIDTH]; 256]; 2] {
    let mut places = [[[0; WIDTH]; 256]; 2];
    let mut byte = 0;
    while byte < 256usize {
        let count = byte.count_ones() as usize;
        let (mut bit, mut n) = (0, 0);
        while bit < WIDTH {
            if byte >> bit & 1 == 1 {
                places[0][byte][n] = bit as u8;
                places[1][byte][count - 1 - n] = bit as u8;
                n += 1;
            }
            bit += 1;
        }
        byte += 1;
    }
    places
}

impl Walker {
    /// The fastest that this processor has.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Self::Eight(simd);
        }
        Self::Plain
    }

    /// Shows the visitor every primitive whose box the ray meets before `ray.tmax`.
    #[inline]
    pub fn walk(self, nodes: &[Node], ray: &Ray, mut visitor: impl Visitor) {
        let ray = NodeRay::new(ray);
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Eight(simd) => simd.vectorize(EightWide { simd, nodes, ray, visitor }),
            Self::Plain => walk(nodes, ray, &mut visitor, plain_boxes),
        }
    }
}

#[inline(always)]
fn walk<V: Visitor>(nodes: &[Node], mut ray: NodeRay, visitor: &mut V, test: impl Fn(&Node, &NodeRay) -> u32) {
    let mut stack = [0; STACK];
    let mut found = [0; (BATCH + 1) * WIDTH];
    let (mut waiting, mut n_found) = (1, 0);
    while waiting > 0 {
        let taken = if waiting > CROWDED { 1 } else { waiting.min(BATCH) };
        waiting -= taken;
        let mut batch = [(&nodes[0], 0); BATCH];
        for (slot, index) in batch.iter_mut().zip(&stack[waiting..waiting + taken]) {
            let node = &nodes[*index as usize];
            *slot = (node, test(node, &ray));
        }
        for (node, met) in &batch[..taken] {
            let (inner, bodies) = node.split(*met);
            append(&mut found, &mut n_found, node.body_base, bodies, false);
            // The nearest is taken off first.
            append(&mut stack, &mut waiting, node.child_base, inner, !node.is_reversed(&ray));
        }
        for primitive in &found[..n_found] {
            visitor.visit(*primitive as usize, &mut ray.tmax);
        }
        n_found = 0;
    }
}

/// Writes `base` plus the place of each bit of `hits` behind the end of a list, and moves the end.
#[inline(always)]
fn append(list: &mut [u32], len: &mut usize, base: u32, hits: u32, downward: bool) {
    let places = &PLACES[usize::from(downward)][(hits & 0xff) as usize];
    if let Some(end) = list.get_mut(*len..*len + WIDTH) {
        end.iter_mut().zip(places).for_each(|(to, place)| *to = base + u32::from(*place));
        *len += hits.count_ones() as usize;
    }
}

/// Which of a node's eight boxes the ray meets, one bit each.
#[inline(always)]
fn plain_boxes(node: &Node, ray: &NodeRay) -> u32 {
    let planes = node.planes(ray);
    let (mut t_in, mut t_out) = ([0.0f32; WIDTH], [ray.tmax; WIDTH]);
    for axis in 0..3 {
        let (side, slope, offset) = planes.side(ray, axis, false);
        t_in.iter_mut().zip(side).for_each(|(t, plane)| *t = t.max(f32::from(*plane) * slope + offset));
        let (side, slope, offset) = planes.side(ray, axis, true);
        t_out.iter_mut().zip(side).for_each(|(t, plane)| *t = t.min(f32::from(*plane) * slope + offset));
    }
    (0..WIDTH).map(|child| u32::from(t_in[child] <= t_out[child]) << child).sum()
}

#[cfg(target_arch = "x86_64")]
struct EightWide<'a, V> {
    simd: pulp::x86::V3,
    nodes: &'a [Node],
    ray: NodeRay,
    visitor: V,
}

#[cfg(target_arch = "x86_64")]
impl<V: Visitor> pulp::NullaryFnOnce for EightWide<'_, V> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { simd, nodes, ray, mut visitor } = self;
        walk(nodes, ray, &mut visitor, |node, ray| eight_boxes(simd, node, ray));
    }
}

/// Which of a node's eight boxes the ray meets, one bit each.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn eight_boxes(simd: pulp::x86::V3, node: &Node, ray: &NodeRay) -> u32 {
    let (avx, avx2) = (simd.avx, simd.avx2);
    let planes = node.planes(ray);
    let side = |axis: usize, leaves: bool| {
        let (side, slope, offset) = planes.side(ray, axis, leaves);
        let bytes = simd.sse2._mm_set_epi64x(0, i64::from_le_bytes(*side));
        let numbers = avx._mm256_cvtepi32_ps(avx2._mm256_cvtepu8_epi32(bytes));
        simd.fma._mm256_fmadd_ps(numbers, avx._mm256_set1_ps(slope), avx._mm256_set1_ps(offset))
    };
    let t_in = avx._mm256_max_ps(
        avx._mm256_max_ps(side(0, false), side(1, false)),
        avx._mm256_max_ps(side(2, false), avx._mm256_setzero_ps()),
    );
    let t_out = avx._mm256_min_ps(
        avx._mm256_min_ps(side(0, true), side(1, true)),
        avx._mm256_min_ps(side(2, true), avx._mm256_set1_ps(ray.tmax)),
    );
    // 18: less or equal, ordered, quiet.
    avx._mm256_movemask_ps(avx._mm256_cmp_ps::<18>(t_in, t_out)) as u32
}
