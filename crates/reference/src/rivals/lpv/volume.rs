//! Light that moves from cell to cell.
//!
//! Source: Kaplanyan and Dachsbacher 2010. A cell's light is an intensity by direction from its middle. Each of its six
//! neighbours is reached through the five faces that they do not share: the flux through a face is the solid angle of the
//! face times the intensity towards its middle, and goes on as a clamped cosine about the face's normal with the same flux.
//! So an even intensity loses nothing; two bands of a directed one are negative backwards, are cut at 0 there, and gain: a
//! clamped cosine along an axis 14 % at one step. It keeps 0.3 of its direction: light scatters.

use std::f32::consts::PI;

use glam::{IVec3, Vec3, Vec3A, Vec4};
use rayon::prelude::*;

use super::{
    blockers::Blockers,
    grid::Grid,
    harmonics::{Colours, basis, lobe},
};

/// Solid angles of the faces of a neighbour from the middle of a cell, sr: of the one opposite to the common face, and of
/// each of the four beside. One and four are a sixth of the sphere (with the 0.42344 that is often printed they would
/// not be).
const OPPOSITE: f32 = 0.400_669_7;
const BESIDE: f32 = 0.423_431_4;

/// Radiance is intensity over the area that a cell shows: a quarter of its surface in the mean over directions.
///
/// The paper divides by the square of half a cell instead, as if the light left a point there, and its light is scaled by
/// hand. This follows from what the cells hold, flux that passes them.
const SHOWN: f32 = 1.5;

/// Where light goes from a cell to its neighbour.
struct Way {
    axis: usize,
    up: bool,
    step: IVec3,
    faces: [Face; 5],
}

struct Face {
    /// From the middle of the cell to the middle of the face.
    direction: Vec3,
    basis: Vec4,
    solid_angle: f32,
    /// Which way it faces: +x, -x, +y, -y, +z, -z.
    side: usize,
}

/// What passes a volume, and what is in the way.
pub struct Propagation<'a> {
    grid: Grid,
    blockers: &'a Blockers,
    /// Whether what is stopped is reflected.
    bounces: bool,
    ways: [Way; 6],
}

/// Light that has passed each cell.
pub struct Volume {
    grid: Grid,
    /// Intensity by direction, W/sr.
    cells: Vec<Colours>,
}

impl<'a> Propagation<'a> {
    /// Over the grid of `blockers`.
    pub fn new(grid: Grid, blockers: &'a Blockers, bounces: bool) -> Propagation<'a> {
        Propagation { grid, blockers, bounces, ways: ways() }
    }

    /// All light of `steps` steps, the first included. `inflow` is what comes in from outside, by the middle of a cell
    /// there.
    pub fn run(&self, first: Vec<Colours>, inflow: impl Fn(Vec3) -> Colours + Sync, steps: u32) -> Volume {
        let (mut wave, mut cells) = (first.clone(), first);
        for step in 0..steps {
            // The first step passes everything: what is injected must not be stopped by what it lies on.
            let next = |i: usize| match step {
                0 => self.arriving(&wave, self.grid.at(i), false, &inflow),
                _ => self.arriving(&wave, self.grid.at(i), true, |_| Colours::default()),
            };
            wave = (0..self.grid.len()).into_par_iter().map(next).collect();
            cells.par_iter_mut().zip(&wave).for_each(|(sum, now)| sum.add(now, 1.0));
        }
        Volume { grid: self.grid, cells }
    }

    /// What is in a cell after a step.
    fn arriving(&self, wave: &[Colours], at: IVec3, blocked: bool, inflow: impl Fn(Vec3) -> Colours) -> Colours {
        let mut flux = [Vec3A::ZERO; 6];
        let mut reflected = Colours::default();
        let own = self.grid.index(at).map_or(Colours::default(), |i| wave[i]);
        for way in &self.ways {
            let from = at - way.step;
            let source = match self.grid.index(from) {
                Some(i) => wave[i],
                None => inflow(self.grid.middle(from)),
            };
            let blocker = self.blockers.between(from, way.axis, way.up);
            if !source.is_zero() {
                for face in &way.faces {
                    let passes = if blocked { 1.0 - blocker.stops(face.direction) } else { 1.0 };
                    flux[face.side] += passes * face.flux(&source);
                }
            }
            if blocked && self.bounces && !own.is_zero() {
                let ahead = self.blockers.between(at, way.axis, way.up);
                if !ahead.is_open() {
                    let stopped: Vec3A = way.faces.iter().map(|f| ahead.stops(f.direction) * f.flux(&own)).sum();
                    let colour = Vec3::from(stopped) * ahead.reflectance / PI;
                    reflected.add(&Colours::lobe(ahead.normal(), colour), 1.0);
                }
            }
        }
        reflected.add(&Colours::lobes(&flux), 1.0 / PI);
        reflected
    }
}

impl Face {
    /// Flux through it from the middle of a cell, W.
    fn flux(&self, intensity: &Colours) -> Vec3A {
        self.solid_angle * intensity.dot(self.basis).max(Vec3A::ZERO)
    }
}

impl Volume {
    /// Intensity at a point, interpolated, W/sr.
    pub fn at(&self, point: Vec3) -> Colours {
        let mut sum = Colours::default();
        for (i, weight) in self.grid.around(point) {
            sum.add(&self.cells[i], weight);
        }
        sum
    }

    /// Irradiance of a surface, W/m². Looked up half a cell before it: cells behind it hold no light of its side.
    ///
    /// Two bands send part of the light of a lit surface back to it. The paper damps that where light falls steeply along
    /// the normal; taking the lesser of this and of the light a cell further on changed nothing, so there is no damping.
    pub fn irradiance(&self, point: Vec3, normal: Vec3) -> Vec3 {
        let light = self.at(point + 0.5 * self.grid.cell * normal).dot(lobe(-normal)).max(Vec3A::ZERO);
        Vec3::from(light) / (SHOWN * self.grid.cell.powi(2))
    }

    /// Its cells.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }
}

fn ways() -> [Way; 6] {
    [0, 1, 2, 3, 4, 5].map(|number| {
        let (axis, up) = (number / 2, number % 2 == 0);
        let step = if up { IVec3::AXES[axis] } else { -IVec3::AXES[axis] };
        let back = number ^ 1;
        let mut sides = (0..6).filter(|&side| side != back);
        let faces = [(); 5].map(|()| {
            let side = sides.next().unwrap_or(number);
            let normal = if side % 2 == 0 { IVec3::AXES[side / 2] } else { -IVec3::AXES[side / 2] };
            let direction = (2 * step + normal).as_vec3().normalize();
            Face {
                direction,
                basis: basis(direction),
                solid_angle: if side == number { OPPOSITE } else { BESIDE },
                side,
            }
        });
        Way { axis, up, step, faces }
    })
}

#[cfg(test)]
mod tests {
    use radfile::Material;
    use scene::{Rays, Scene, Surfaces};

    use super::*;
    use crate::rivals::Setting;

    fn grid() -> Grid {
        Grid { low: Vec3::ZERO, cell: 1.0, size: IVec3::splat(13) }
    }

    const MIDDLE: IVec3 = IVec3::splat(6);

    /// The wave of one cell after some steps without anything in the way.
    fn after(steps: u32, light: Colours) -> Vec<Colours> {
        let grid = grid();
        let blockers = Blockers::none(grid);
        let propagation = Propagation::new(grid, &blockers, false);
        let mut wave = vec![Colours::default(); grid.len()];
        wave[grid.index(MIDDLE).unwrap()] = light;
        for _ in 0..steps {
            wave = (0..grid.len())
                .map(|i| propagation.arriving(&wave, grid.at(i), true, |_| Colours::default()))
                .collect();
        }
        wave
    }

    fn total(wave: &[Colours]) -> f32 {
        wave.iter().map(|c| c.integral().x).sum()
    }

    fn even() -> Colours {
        Colours([Vec3A::ONE, Vec3A::ZERO, Vec3A::ZERO, Vec3A::ZERO])
    }

    #[test]
    fn an_even_intensity_loses_nothing() {
        for steps in 1..6 {
            let kept = total(&after(steps, even())) / total(&[even()]);
            assert!((kept - 1.0).abs() < 1e-5, "{kept} after {steps} steps");
        }
    }

    #[test]
    fn a_clamped_cosine_gains_what_is_cut_off_behind() {
        let lobe = Colours::lobe(Vec3::X, Vec3::ONE);
        let gain = total(&after(1, lobe)) / total(&[lobe]);
        // Behind, 1/4 + 1/2 cos θ is -1/4 towards one face and 1/4 - 1/√5 towards four.
        let cut = 0.25 * OPPOSITE + 4.0 * (0.2f32.sqrt() - 0.25) * BESIDE;
        assert!((gain - 1.0 - cut / PI).abs() < 1e-5, "{gain}");
    }

    #[test]
    fn a_step_leaves_light_little_of_its_direction() {
        let wave = after(1, Colours::lobe(Vec3::X, Vec3::ONE));
        // Flux of lobes along +x less that along -x, over all flux: band 1 over band 0 as in one lobe.
        let along: f32 = wave.iter().map(|c| c.0[1].x).sum();
        let whole: f32 = wave.iter().map(|c| c.0[0].x).sum();
        let found = along / whole * 0.75f32.sqrt();
        // Towards a face at angle θ from the axis 1/4 + 1/2 cos θ: ahead one face of cos θ = 1 and four beside of 2/√5, which go
        // on along other axes; of each of four neighbours beside a face ahead of cos θ = 1/√5 and one behind that gets nothing.
        let (one, two) = (0.2f32.sqrt(), 0.8f32.sqrt());
        let to = |cos: f32| (0.25 + 0.5 * cos).max(0.0);
        let ahead = OPPOSITE * to(1.0) + 4.0 * BESIDE * to(one);
        let behind = 4.0 * BESIDE * to(-one);
        let aside = 4.0 * BESIDE * to(two) + 4.0 * (OPPOSITE + 2.0 * BESIDE) * to(0.0);
        let wanted = (ahead - behind) / (ahead + behind + aside);
        assert!((found - wanted).abs() < 1e-4 && (wanted - 0.3).abs() < 0.01, "{found}, expected {wanted}");
    }

    #[test]
    fn light_spreads_alike_along_all_axes() {
        let wave = after(4, even());
        let grid = grid();
        let amount = |d: IVec3| wave[grid.index(MIDDLE + d).unwrap()].integral().x;
        for d in [IVec3::new(1, 2, 3), IVec3::new(0, 1, 3), IVec3::new(2, 2, 0), IVec3::new(4, 0, 0)] {
            for turned in [IVec3::new(d.y, -d.x, d.z), IVec3::new(d.x, d.z, -d.y), IVec3::new(-d.z, d.y, d.x), -d] {
                assert!((amount(d) - amount(turned)).abs() <= 1e-6 * amount(d).abs(), "{d} and {turned}");
            }
        }
        assert!(amount(IVec3::new(4, 0, 0)) > 0.0 && amount(IVec3::new(5, 0, 0)) == 0.0, "a cell a step");
        // A lobe stays a lobe: light along +x moves to +x.
        let wave = after(3, Colours::lobe(Vec3::X, Vec3::ONE));
        let side = |sign: i32| -> f32 {
            let beyond = |i: &usize| (grid.at(*i).x - MIDDLE.x) * sign > 0;
            (0..grid.len()).filter(beyond).map(|i| wave[i].integral().x).sum()
        };
        assert!(side(1) > 3.0 * side(-1), "{} forwards, {} backwards", side(1), side(-1));
    }

    /// A sheet across the grid that looks at the middle from two cells further along x.
    fn wall() -> Scene {
        let mut scene = Scene::default();
        scene.mesh.positions = [[0.0, 0.0], [0.0, 13.0], [13.0, 13.0], [13.0, 0.0]].map(|[y, z]| [8.0, y, z]).to_vec();
        (scene.mesh.triangles, scene.mesh.triangle_material) = (vec![[0, 1, 2], [0, 2, 3]], vec![0; 2]);
        scene.materials.materials.push(Material {
            name: "grey".into(),
            reflectance: [0.5; 3],
            reflectance_texture: None,
            emission: [0.0; 3],
            emission_texture: None,
        });
        scene
    }

    #[test]
    fn a_wall_stops_most_and_sends_some_back() {
        let scene = wall();
        let (rays, surfaces) = (Rays::new(&scene.mesh), Surfaces::new(&scene.mesh, &scene.materials).unwrap());
        let setting = Setting { scene: &scene, surfaces: &surfaces, rays: &rays, receivers: &[] };
        let grid = grid();
        let mut first = vec![Colours::default(); grid.len()];
        first[grid.index(MIDDLE).unwrap()] = Colours::lobe(Vec3::X, Vec3::ONE);
        let light = |blockers: &Blockers, bounces: bool, beyond: bool| {
            let none = |_| Colours::default();
            let volume = Propagation::new(grid, blockers, bounces).run(first.clone(), none, 10);
            let there = |i: &usize| (grid.at(*i).x >= 8) == beyond;
            (0..grid.len()).filter(there).map(|i| volume.cells[i].integral().x).sum::<f32>()
        };
        let (open, shut) = (Blockers::none(grid), Blockers::new(&setting, grid));
        let (all, passed) = (light(&open, false, true), light(&shut, false, true));
        assert!(
            passed < 0.4 * all && passed > 0.0,
            "{passed} of {all} pass: a front stops 3/4 of what meets it head on"
        );
        let (dark, lit) = (light(&shut, false, false), light(&shut, true, false));
        assert!(lit > 1.05 * dark, "{lit} before a grey wall, {dark} before a black one");
    }
}
