//! The patches of one voxel size.

use radfile::Progress;
use scene::{Rays, Surfaces};

use crate::{
    Adapted, Error, Mode, Params,
    air::Air,
    assemble::assemble,
    attributes::colour,
    clip::clip,
    cut::{Count, cut},
    draft::Draft,
    faces::faces,
    gather::{self, count_small},
    grid::Grid,
    group::group,
    inside::coarsen,
    merge::{SMALL, merge},
    surface::Surface,
    visibility::seen,
};

/// Share of small patches above which they are gathered.
const CROWDED: f64 = 0.25;

/// What attempts have in common.
pub struct Bench<'a> {
    pub surface: &'a Surface<'a>,
    pub rays: Rays,
    pub params: &'a Params,
    pub progress: &'a dyn Progress,
}

/// Patches of one voxel size and which of them are kept.
pub struct Trial {
    pub voxel: f32,
    pub draft: Draft,
    pub cuts: Count,
    /// For every drafted patch, the one that it is part of; `None` if it sees nothing.
    pub owner: Vec<Option<u32>>,
    /// Visibility rays cast.
    pub rays: u64,
    /// Patches inside solids that have joined another.
    pub coarsened: usize,
    /// Small patches that have joined another or lie in a pocket.
    pub gathered: usize,
    /// What became of fine patches, if they were joined.
    pub adapted: Option<Adapted>,
}

impl Bench<'_> {
    /// Makes the patches for voxels of `voxel` metres and drops those that see nothing.
    pub fn attempt(&self, voxel: f32, extra_layers: [u32; 3]) -> Result<Trial, Error> {
        self.attempt_with_touches(voxel, extra_layers, SMALL * f64::from(voxel) * f64::from(voxel))
    }

    /// The same; the draft tells touches of all sheets smaller than `small` m².
    pub fn attempt_with_touches(&self, voxel: f32, extra_layers: [u32; 3], small: f64) -> Result<Trial, Error> {
        let grid = Grid::new(self.surface, voxel, extra_layers)?;
        self.progress.begin(&format!("patches of voxels of {voxel:.4} m"), 1);
        let clips = clip(self.surface, &grid);
        let (draft, cuts) = match self.params.mode {
            Mode::Clusters => {
                let tolerance = grid.tolerance(self.surface);
                let (clips, cuts) = cut(self.surface, &grid, clips, tolerance);
                let mut sheets = group(self.surface, &grid, &clips, tolerance, small);
                let merged = merge(&mut sheets, &grid);
                (assemble(self.surface, &grid, &clips, &sheets, &merged), cuts)
            }
            Mode::Faces => (faces(self.surface, &grid, &clips), Count::default()),
        };
        self.progress.advance(1);
        let count = self.params.visibility_rays;
        let (seen, rays) = seen(&draft.patches, &self.rays, count, self.params.seed, self.progress);
        if !seen.contains(&true) {
            return Err(Error::NothingSeen { patches: seen.len(), rays: count });
        }
        let owner = (0..).zip(&seen).map(|(p, &seen)| seen.then_some(p)).collect();
        Ok(Trial { voxel, draft, cuts, owner, rays, coarsened: 0, gathered: 0, adapted: None })
    }

    /// Fills in the colours of drafted patches.
    pub fn colour(&self, trial: &mut Trial, surfaces: &Surfaces) {
        self.progress.begin("colours of patches", 1);
        colour(&mut trial.draft, self.surface, surfaces, self.params.seed);
        self.progress.advance(1);
    }

    /// Spends patches where they count: coarser ones inside solids and, if small ones crowd out the others or
    /// `share` says so, shared ones for small parts. Returns whether they were shared.
    pub fn economise(&self, trial: &mut Trial, share: bool) -> bool {
        if self.params.mode == Mode::Faces {
            return false;
        }
        let patches = &trial.draft.patches;
        let kept: Vec<bool> = trial.owner.iter().map(Option::is_some).collect();
        let air = Air::explore(patches, &kept, &self.rays, self.params.seed);
        let before = trial.count();
        coarsen(patches, self.surface, &air, &mut trial.owner);
        trial.coarsened = before - trial.count();
        let crowded = count_small(patches, &trial.owner) as f64 > CROWDED * trial.count() as f64;
        if crowded || share {
            let before = trial.count();
            gather::gather(patches, self.surface, &self.rays, &air, &mut trial.owner);
            trial.gathered = before - trial.count();
        }
        crowded || share
    }
}

impl Trial {
    /// Number of patches.
    pub fn count(&self) -> usize {
        self.owner.iter().zip(0..).filter(|&(&owner, p)| owner == Some(p)).count()
    }
}
