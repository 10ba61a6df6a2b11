//! Where to cut a set of boxes in two: the surface area heuristic over bins of centroids.
//!
//! Wald 2007, "On fast construction of SAH-based bounding volume hierarchies", Sections 3 and 4. Areas are f64, so that
//! boxes of 1e18 metres do not overflow. Bins only hold minima, maxima and counts, so that the result does not depend on
//! the order or the grouping of the primitives: parallel binning is deterministic.

use glam::Vec4;
use rayon::prelude::*;

pub const BINS: usize = 16;
/// Cost of visiting a node over the cost of one primitive, for a choice between leaf and split. Measured by `benches/rays`.
pub const NODE_COST: f64 = 1.0;
/// Below this many primitives a task bins alone.
const PARALLEL_BINNING: usize = 1 << 16;

/// A primitive's box; the w of `lo` carries its number and kind, w of `hi` nothing.
#[derive(Clone, Copy)]
pub struct Ref {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Ref {
    /// `id` stays below 2^28: as a float it is a small positive number, never a NaN that a copy might change.
    pub fn new(lo: [f32; 3], hi: [f32; 3], id: u32) -> Ref {
        Ref { lo: Vec4::new(lo[0], lo[1], lo[2], f32::from_bits(id)), hi: Vec4::new(hi[0], hi[1], hi[2], 0.0) }
    }

    pub fn id(&self) -> u32 {
        self.lo.w.to_bits()
    }

    /// Half the centre, which cannot overflow.
    fn centroid(&self) -> Vec4 {
        self.lo * 0.25 + self.hi * 0.25
    }
}

#[derive(Clone, Copy)]
pub struct Bounds {
    pub lo: Vec4,
    pub hi: Vec4,
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    pub fn grow(&mut self, lo: Vec4, hi: Vec4) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }

    pub fn union(mut self, other: Bounds) -> Bounds {
        self.grow(other.lo, other.hi);
        self
    }

    /// Half the surface area; 0 when empty.
    pub fn half_area(&self) -> f64 {
        let d = (self.hi.as_dvec4() - self.lo.as_dvec4()).truncate();
        if d.x >= 0.0 { d.x * d.y + d.y * d.z + d.z * d.x } else { 0.0 }
    }
}

/// Box of the primitives and box of their (half) centroids.
#[derive(Clone, Copy)]
pub struct Extent {
    pub bounds: Bounds,
    pub centroids: Bounds,
}

pub fn extent(refs: &[Ref]) -> Extent {
    let fold = |refs: &[Ref]| {
        let mut e = Extent { bounds: Bounds::EMPTY, centroids: Bounds::EMPTY };
        for r in refs {
            e.bounds.grow(r.lo, r.hi);
            let c = r.centroid();
            e.centroids.grow(c, c);
        }
        e
    };
    let join =
        |a: Extent, b: Extent| Extent { bounds: a.bounds.union(b.bounds), centroids: a.centroids.union(b.centroids) };
    if refs.len() < PARALLEL_BINNING {
        return fold(refs);
    }
    let empty = Extent { bounds: Bounds::EMPTY, centroids: Bounds::EMPTY };
    refs.par_chunks(PARALLEL_BINNING / 4).map(fold).reduce(|| empty, join)
}

/// A plane between two bins.
pub struct Split {
    pub axis: usize,
    pub first_right_bin: usize,
    /// Expected cost of the two sides, in primitive tests, given that the parent is entered.
    pub cost: f64,
    map: BinMap,
}

impl Split {
    pub fn is_left(&self, r: &Ref) -> bool {
        self.map.bin(r)[self.axis] < self.first_right_bin as i32
    }
}

#[derive(Clone, Copy)]
struct BinMap {
    origin: Vec4,
    scale: Vec4,
}

impl BinMap {
    fn new(centroids: &Bounds) -> BinMap {
        let extent = centroids.hi - centroids.lo;
        // An extent of 0, or one so small that the quotient overflows, puts all into bin 0: then there is no split there.
        let scale = Vec4::splat(BINS as f32 * 0.999_999) / extent;
        let usable = scale.is_finite_mask();
        BinMap { origin: centroids.lo, scale: Vec4::select(usable, scale, Vec4::ZERO) }
    }

    fn bin(&self, r: &Ref) -> [i32; 4] {
        let b = (r.centroid() - self.origin) * self.scale;
        let last = BINS as i32 - 1;
        [(b.x as i32).clamp(0, last), (b.y as i32).clamp(0, last), (b.z as i32).clamp(0, last), 0]
    }
}

#[derive(Clone)]
struct Bins {
    bounds: [[Bounds; BINS]; 3],
    count: [[u32; BINS]; 3],
}

impl Bins {
    fn empty() -> Bins {
        Bins { bounds: [[Bounds::EMPTY; BINS]; 3], count: [[0; BINS]; 3] }
    }

    fn add(&mut self, refs: &[Ref], map: &BinMap) {
        for r in refs {
            let b = map.bin(r);
            for axis in 0..3 {
                let k = b[axis] as usize;
                self.bounds[axis][k].grow(r.lo, r.hi);
                self.count[axis][k] += 1;
            }
        }
    }

    fn merge(mut self, other: Bins) -> Bins {
        for axis in 0..3 {
            for k in 0..BINS {
                self.bounds[axis][k] = self.bounds[axis][k].union(other.bounds[axis][k]);
                self.count[axis][k] += other.count[axis][k];
            }
        }
        self
    }
}

/// The cheapest plane of all three axes; None when every plane leaves one side empty.
pub fn best_split(refs: &[Ref], extent: &Extent) -> Option<Split> {
    let map = BinMap::new(&extent.centroids);
    let bins = if refs.len() < PARALLEL_BINNING {
        let mut bins = Bins::empty();
        bins.add(refs, &map);
        bins
    } else {
        let fold = |chunk: &[Ref]| {
            let mut bins = Bins::empty();
            bins.add(chunk, &map);
            bins
        };
        refs.par_chunks(PARALLEL_BINNING / 4).map(fold).reduce(Bins::empty, Bins::merge)
    };
    let parent_area = extent.bounds.half_area();
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        let mut right_cost = [0.0; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for k in (1..BINS).rev() {
            bounds = bounds.union(bins.bounds[axis][k]);
            count += bins.count[axis][k];
            right_cost[k] = if count == 0 { f64::INFINITY } else { bounds.half_area() * f64::from(count) };
        }
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for k in 1..BINS {
            bounds = bounds.union(bins.bounds[axis][k - 1]);
            count += bins.count[axis][k - 1];
            // A parent of area 0 (denormal coordinates) makes the quotient NaN, which is never the best.
            let cost = (bounds.half_area() * f64::from(count) + right_cost[k]) / parent_area;
            if count > 0 && cost < best.as_ref().map_or(f64::INFINITY, |b| b.cost) {
                best = Some(Split { axis, first_right_bin: k, cost, map });
            }
        }
    }
    best
}

/// Orders by the centroid on `axis`, then by number, so that a median cut is the same on every run.
pub fn median_order(axis: usize) -> impl Fn(&Ref, &Ref) -> std::cmp::Ordering {
    move |a, b| a.centroid()[axis].total_cmp(&b.centroid()[axis]).then(a.id().cmp(&b.id()))
}

pub fn widest_axis(centroids: &Bounds) -> usize {
    let d = centroids.hi - centroids.lo;
    if d.x >= d.y && d.x >= d.z {
        0
    } else if d.y >= d.z {
        1
    } else {
        2
    }
}
