//! As many patches as wanted, small where light changes and large where it does not.
//!
//! The scene is cut to voxels much smaller than the wanted number allows. A coarse bake, direct light of the fine
//! patches and one gather tell their light under many lamps (`pilot`, `lamps`, `field`); neighbours are joined where
//! that loses least (`ward`), and small separate parts where they must (`near`), until the wanted number is left.
//!
//! What was kept apart for voxels stays apart: patches are joined that touch with no wall between them and share their
//! air, or that a ray links.

use glam::{DVec3, Vec3};
use radfile::Patches;
use scene::Surfaces;
use serde::Serialize;

use crate::{
    Error, Pilot,
    air::Air,
    field::{Field, memory_needed},
    grid::MEMORY_LIMIT,
    inside::inside,
    lamps::hang,
    near::{Parts, pairs},
    regions::regions,
    trial::{Bench, Trial},
    ward::{Forest, Node, Weights},
};

/// Fine voxels along a voxel of the wanted number.
const FINER: f32 = 4.0;
/// Lamps that are tried.
const LAMPS: u32 = 120;
/// What unlike places count, against unlike light on average.
const PLACE: f64 = 3.0;
/// What unlike reflectances count, against unlike light.
const REFLECTANCE: f64 = 0.1;
/// Mean square of light that is expected where no lamp was, relative to that of all.
const DARK: f64 = 0.01;
/// Cells within which small parts may be joined from the start, in voxels of the wanted number.
const REACHES: [f32; 4] = [1.0, 2.0, 4.0, 8.0];
/// Sizes of uniform voxels for which errors are told, relative to those of the wanted number.
const SIZES: [f32; 5] = [2.0, 1.4, 1.0, 0.7, 0.5];

/// What became of the patches, for people.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Adapted {
    /// Lamps that were tried.
    pub lamps: usize,
    /// Patches of the fine voxels before they were joined.
    pub fine_patches: usize,
    /// Patches by size, the smallest first.
    pub levels: Vec<Level>,
    /// Errors that the lamps let expect, of some numbers of patches.
    pub expected: Vec<Expected>,
}

/// Patches of about one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Level {
    /// Edge of the voxels whose sides are about as large, metres.
    pub edge: f32,
    /// How many.
    pub patches: usize,
}

/// Expected error of irradiance that is constant on each patch, RMS relative to that of the irradiance. It is told by
/// lamps that the patches were not made for, at the resolution of the fine voxels: what is finer comes on top.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Number of patches.
    pub patches: usize,
    /// Adaptive ones.
    pub adaptive: f64,
    /// Those of uniform voxels.
    pub uniform: Option<f64>,
}

/// Makes the patches.
pub fn adapt(bench: &Bench, surfaces: &Surfaces, pilot: &Pilot, wanted: usize) -> Result<Trial, Error> {
    let size = pilot.patches.locator.cell_size * (pilot.patches.len() as f32 / wanted as f32).sqrt();
    let mut trial = bench.attempt_with_touches(size / FINER, [0; 3], f64::INFINITY)?;
    let need = memory_needed(trial.draft.patches.len(), LAMPS as usize);
    if need > MEMORY_LIMIT {
        let patches = trial.draft.patches.len();
        return Err(Error::AdaptiveMemory { wanted, patches, need: need >> 20, limit: MEMORY_LIMIT >> 20 });
    }
    bench.colour(&mut trial, surfaces);
    let kept: Vec<bool> = trial.owner.iter().map(Option::is_some).collect();
    let patches = &trial.draft.patches;
    let air = Air::explore(patches, &kept, &bench.rays, bench.params.seed);
    let field = field(bench, pilot, patches, &kept);
    bench.progress.begin("joining patches", 1);
    let touches = trial.draft.touches.iter().filter(|pair| pair.iter().all(|&p| kept[p as usize]));
    let workshop =
        Workshop { bench, patches, kept: &kept, touches: touches.copied().collect(), air: &air, field, size };
    let (owner, adapted) = workshop.join_until(wanted);
    bench.progress.advance(1);
    Ok(Trial { owner, adapted: Some(adapted), ..trial })
}

/// Light of the fine patches under lamps that hang where the pilot says that there is room.
fn field(bench: &Bench, pilot: &Pilot, patches: &Patches, kept: &[bool]) -> Field {
    let (rays, seed) = (&bench.rays, bench.params.seed);
    let all = vec![true; pilot.patches.len()];
    let air = Air::explore(&pilot.patches, &all, rays, seed);
    let owner: Vec<Option<u32>> = (0..pilot.patches.len() as u32).map(Some).collect();
    let mut outside = all;
    inside(&pilot.patches, bench.surface, &air, &owner).into_iter().for_each(|p| outside[p] = false);
    let lamps = hang(&pilot.patches, &outside, LAMPS, rays, seed);
    Field::gather(patches, kept, pilot, &lamps, rays, seed, bench.progress)
}

/// Fine patches and what is known of them.
struct Workshop<'a> {
    bench: &'a Bench<'a>,
    patches: &'a Patches,
    kept: &'a [bool],
    touches: Vec<[u32; 2]>,
    air: &'a Air,
    field: Field,
    /// Edge of voxels that would make about the wanted number of patches, metres.
    size: f32,
}

impl Workshop<'_> {
    /// Joins patches; returns for each the one that it is part of.
    fn join_until(&self, wanted: usize) -> (Vec<Option<u32>>, Adapted) {
        let nodes = self.nodes();
        let uniform = SIZES.map(|scale| regions(self.patches, self.kept, &self.touches, scale * self.size));
        let weights = Weights { place: PLACE * self.steepness(&nodes, &uniform[2]), reflectance: REFLECTANCE };
        let mut forest = Forest::new(nodes, self.kept, weights);
        forest.link(self.touches.iter().copied(), true);
        let whole = regions(self.patches, self.kept, &self.touches, f32::INFINITY);
        let mut area = vec![0.0; self.patches.len()];
        (0..).zip(&whole).for_each(|(p, part)| part.iter().for_each(|&q| area[q as usize] += self.area(p)));
        for reach in REACHES {
            self.link_near(&mut forest, reach * self.size, &whole, &area);
        }

        let mut stops: Vec<(usize, Option<usize>)> =
            uniform.iter().map(|owner| count(owner)).zip((0..).map(Some)).collect();
        stops.push((wanted, None));
        stops.sort_by(|a, b| b.cmp(a));
        let (mut owner, mut expected) = (vec![], vec![]);
        for (patches, voxels) in stops {
            self.join_all(&mut forest, patches);
            let now = self.owner(&mut forest);
            let error = |owner: &[Option<u32>]| self.field.error(self.patches, owner);
            let uniform = voxels.map(|k| error(&uniform[k]));
            expected.push(Expected { patches: count(&now), adaptive: error(&now), uniform });
            if voxels.is_none() {
                owner = now;
            }
        }
        expected.reverse();
        let fine_patches = self.kept.iter().filter(|&&k| k).count();
        let levels = self.levels(&owner);
        (owner, Adapted { lamps: self.field.lamps, fine_patches, levels, expected })
    }

    /// Joins until `wanted` are left, small parts over longer and longer ways.
    fn join_all(&self, forest: &mut Forest, wanted: usize) {
        forest.join_until(wanted);
        let extent = (self.bench.surface.upper - self.bench.surface.lower).max_element() as f32;
        let mut reach = REACHES[REACHES.len() - 1] * self.size;
        while forest.count() > wanted && reach < extent {
            reach *= 2.0;
            let owner = self.owner(forest);
            let area: Vec<f64> = (0..self.patches.len() as u32).map(|p| forest.node(p).area).collect();
            self.link_near(forest, reach, &owner, &area);
            forest.join_until(wanted);
        }
    }

    fn link_near(&self, forest: &mut Forest, size: f32, part: &[Option<u32>], area: &[f64]) {
        let Bench { surface, rays, .. } = self.bench;
        forest.link(pairs(self.patches, surface, rays, self.air, size, &Parts { part, area }), false);
    }

    fn owner(&self, forest: &mut Forest) -> Vec<Option<u32>> {
        (0..self.patches.len() as u32).map(|p| self.kept[p as usize].then(|| forest.root(p))).collect()
    }

    fn area(&self, patch: usize) -> f64 {
        f64::from(self.patches.area[patch])
    }

    fn nodes(&self) -> Vec<Node> {
        let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
        let node = |p: usize| {
            let light: Vec<f64> = self.field.of(p).collect();
            let shines = self.bench.surface.shines(self.patches.pieces_of(p));
            Node {
                area: self.area(p),
                normal: self.area(p) * vector(self.patches.normal[p]),
                mass: self.area(p) * (DARK + light.iter().map(|h| h * h).sum::<f64>()),
                light,
                place: vector(self.patches.position[p]),
                reflectance: vector(self.patches.reflectance[p]) / 3.0f64.sqrt(),
                kind: 2 * self.air.space(p) + u32::from(shines),
            }
        };
        (0..self.patches.len()).map(node).collect()
    }

    /// How much light changes within voxels, squared and relative, a squared metre.
    fn steepness(&self, nodes: &[Node], voxels: &[Option<u32>]) -> f64 {
        let mut sums = vec![(0.0, DVec3::ZERO); nodes.len()];
        let (mut mass, mut squares) = (0.0, 0.0);
        for (node, voxel) in nodes.iter().zip(voxels).filter_map(|(n, v)| Some((n, (*v)?))) {
            let sum = &mut sums[voxel as usize];
            *sum = (sum.0 + node.mass, sum.1 + node.mass * node.place);
            mass += node.mass;
            squares += node.mass * node.place.length_squared();
        }
        let within = squares - sums.iter().filter(|s| s.0 > 0.0).map(|s| s.1.length_squared() / s.0).sum::<f64>();
        let light = self.field.error(self.patches, voxels).powi(2);
        if within > 0.0 { light * mass / within } else { 0.0 }
    }

    /// Patches by their area, in fine voxels' edges and powers of two.
    fn levels(&self, owner: &[Option<u32>]) -> Vec<Level> {
        let fine = self.size / FINER;
        let mut area = vec![0.0; owner.len()];
        (0..).zip(owner).for_each(|(p, q)| q.iter().for_each(|&q| area[q as usize] += self.area(p)));
        let mut levels: Vec<usize> = Vec::new();
        for area in area.into_iter().filter(|&a| a > 0.0) {
            let level = (area.sqrt() / f64::from(fine)).log2().round().max(0.0) as usize;
            levels.resize(levels.len().max(level + 1), 0);
            levels[level] += 1;
        }
        let level = |(k, patches): (i32, usize)| Level { edge: fine * 2.0f32.powi(k), patches };
        (0..).zip(levels).map(level).collect()
    }
}

/// Number of patches that own themselves.
fn count(owner: &[Option<u32>]) -> usize {
    (0..).zip(owner).filter(|&(p, &owner)| owner == Some(p)).count()
}
