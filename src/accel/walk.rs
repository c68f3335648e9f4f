//! Walks the wide tree along a ray: obvhs' own tree and order, with eight boxes tested at once where the processor can.
//!
//! The walk is that of Ylitie, Karras & Laine (2017): groups of children on a stack, nearest octant first. What it looks
//! at may differ between processors in the last bit of a box; boxes are padded by more than that, so what is found does
//! not.

use glam::Vec3A;
use obvhs::cwbvh::node::{CwBvhNode, extract_byte64};
use obvhs::cwbvh::{CwBvh, firstbithigh};
use obvhs::ray::Ray;

use super::build::MAX_WIDE_DEPTH;

/// How boxes are tested, found out once.
#[derive(Clone, Copy, Debug)]
pub(super) enum Walker {
    /// AVX2 and FMA: eight boxes at once.
    #[cfg(target_arch = "x86_64")]
    Eight(pulp::x86::V3),
    /// As obvhs does it on any processor.
    Plain,
}

/// A group of children that wait: where the node's children begin, and which of them were hit, by priority.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    base: u32,
    hits: u32,
}

/// Bits of a group's hits that stand for inner nodes.
const INNER: u32 = 0xff00_0000;

impl Walker {
    /// The fastest that this processor has.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return Self::Eight(simd);
        }
        Self::Plain
    }

    /// Calls `visit` for every primitive whose box the ray meets before `ray.tmax`; `visit` may shorten the ray.
    #[inline]
    pub fn walk(self, tree: &CwBvh, ray: Ray, visit: impl FnMut(usize, &mut f32)) {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Eight(simd) => simd.vectorize(EightWide { simd, tree, ray, visit }),
            Self::Plain => {
                let octant = octant(ray.direction);
                walk(tree, ray, visit, |node, ray| node.intersect_ray(ray, octant));
            }
        }
    }
}

/// The ray's octant as obvhs stores it, in every byte: seven minus the signs' bits.
fn octant(direction: Vec3A) -> u32 {
    let bit = |component: f32, bit: u32| if component < 0.0 { 0 } else { bit };
    (bit(direction.x, 4) | bit(direction.y, 2) | bit(direction.z, 1)) * 0x0101_0101
}

#[inline(always)]
fn walk(
    tree: &CwBvh,
    mut ray: Ray,
    mut visit: impl FnMut(usize, &mut f32),
    mut test: impl FnMut(&CwBvhNode, &Ray) -> u32,
) {
    let octant = octant(ray.direction) & 7;
    let mut stack = [Group::default(); MAX_WIDE_DEPTH + 1];
    let mut waiting = 0;
    let mut group = Group { base: 0, hits: 0x8000_0000 };
    loop {
        while group.hits & INNER == 0 {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            group = stack[waiting];
        }
        let child = firstbithigh(group.hits);
        let slot = (child - 24) ^ octant;
        let before = (group.hits & !(u32::MAX << slot) & 0xff).count_ones();
        let node = &tree.nodes[(group.base + before) as usize];
        group.hits &= !(1 << child);
        if group.hits & INNER != 0 {
            stack[waiting] = group;
            waiting += 1;
        }
        let hits = test(node, &ray);
        let mut primitives = hits & !INNER;
        while primitives != 0 {
            let primitive = firstbithigh(primitives);
            primitives &= !(1 << primitive);
            visit((node.primitive_base_idx + primitive) as usize, &mut ray.tmax);
        }
        group = Group { base: node.child_base_idx, hits: (hits & INNER) | u32::from(node.imask) };
    }
}

#[cfg(target_arch = "x86_64")]
struct EightWide<'a, F> {
    simd: pulp::x86::V3,
    tree: &'a CwBvh,
    ray: Ray,
    visit: F,
}

#[cfg(target_arch = "x86_64")]
impl<F: FnMut(usize, &mut f32)> pulp::NullaryFnOnce for EightWide<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { simd, tree, ray, visit } = self;
        let octant = octant(ray.direction);
        walk(tree, ray, visit, |node, ray| {
            let (child_bits, bit_index) = node.get_child_and_index_bits(octant);
            let mut met = eight_boxes(simd, node, ray);
            let mut hits = 0;
            while met != 0 {
                let child = met.trailing_zeros() as usize;
                met &= met - 1;
                hits |= extract_byte64(child_bits, child) << extract_byte64(bit_index, child);
            }
            hits
        });
    }
}

/// Which of a node's eight boxes the ray meets, one bit each.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn eight_boxes(simd: pulp::x86::V3, node: &CwBvhNode, ray: &Ray) -> u32 {
    // The planes are whole numbers of the node's own grid, so the ray is taken there.
    let slope = node.compute_extent() * ray.inv_direction;
    let offset = (Vec3A::from(node.p) - ray.origin) * ray.inv_direction;
    let (avx, avx2) = (simd.avx, simd.avx2);
    let plane = |quantised: &[u8; 8], slope: f32, offset: f32| {
        let bytes = simd.sse2._mm_set_epi64x(0, i64::from_le_bytes(*quantised));
        let planes = avx._mm256_cvtepi32_ps(avx2._mm256_cvtepu8_epi32(bytes));
        simd.fma._mm256_fmadd_ps(planes, avx._mm256_set1_ps(slope), avx._mm256_set1_ps(offset))
    };
    let sorted = |min, max, direction: f32| if direction < 0.0 { (max, min) } else { (min, max) };
    let (x_in, x_out) = sorted(&node.child_min_x, &node.child_max_x, ray.direction.x);
    let (y_in, y_out) = sorted(&node.child_min_y, &node.child_max_y, ray.direction.y);
    let (z_in, z_out) = sorted(&node.child_min_z, &node.child_max_z, ray.direction.z);
    let t_in = avx._mm256_max_ps(
        avx._mm256_max_ps(plane(x_in, slope.x, offset.x), plane(y_in, slope.y, offset.y)),
        avx._mm256_max_ps(plane(z_in, slope.z, offset.z), avx._mm256_set1_ps(ray.tmin)),
    );
    let t_out = avx._mm256_min_ps(
        avx._mm256_min_ps(plane(x_out, slope.x, offset.x), plane(y_out, slope.y, offset.y)),
        avx._mm256_min_ps(plane(z_out, slope.z, offset.z), avx._mm256_set1_ps(ray.tmax)),
    );
    // 18: less or equal, ordered, quiet.
    avx._mm256_movemask_ps(avx._mm256_cmp_ps::<18>(t_in, t_out)) as u32
}
