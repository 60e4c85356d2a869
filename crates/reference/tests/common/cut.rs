//! Patches made by halving triangles, and their form factors by rays: simple, and nothing of the bake's.

use glam::Vec3;
use radfile::{CUT, Cut, FormFactors, Mesh, PatchLocator, Patches, Piece};
use rayon::prelude::*;
use scene::{PatchSampler, Rays, Scene, Sobol, Surfaces, cosine_direction, land};

/// Patches of at most `largest` m² on the fronts of a scene without textures.
pub fn cut(scene: &Scene, largest: f32) -> Patches {
    let mesh = &scene.mesh;
    let surfaces = Surfaces::new(mesh, &scene.materials).expect("no textures");
    let locator = PatchLocator { cell_size: 1e3, face_start: vec![0], ..PatchLocator::default() };
    let mut patches = Patches { piece_start: vec![0], locator, ..Patches::default() };
    for triangle in 0..mesh.triangles.len() as u32 {
        let corners = mesh.corners(triangle as usize).map(Vec3::from);
        let entry = halve(&mut patches, corners, 2 * triangle, largest);
        patches.locator.cell_key.push(0);
        patches.locator.cell_patch.push(entry);
        let end = patches.locator.cell_key.len() as u32;
        patches.locator.face_start.extend([end; 2]); // its back has none
        patches.reflectance.resize(patches.len(), surfaces.reflectance(triangle, 0.3, 0.3));
    }
    patches.emission = vec![[0.0; 3]; patches.len()];
    patches.check().expect("patches");
    patches
}

/// A triangle as one patch, or cut from the middle of its longest edge; what the locator calls it.
fn halve(patches: &mut Patches, corners: [Vec3; 3], face: u32, largest: f32) -> u32 {
    let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    if 0.5 * cross.length() <= largest {
        patches.position.push((corners.iter().sum::<Vec3>() / 3.0).to_array());
        patches.normal.push(cross.normalize().to_array());
        patches.area.push(0.5 * cross.length());
        patches.pieces.push(Piece { corners: corners.map(|c| c.to_array()), face });
        patches.piece_start.push(patches.pieces.len() as u32);
        return patches.len() as u32 - 1;
    }
    let length = |k: &usize| corners[*k].distance(corners[(k + 1) % 3]);
    let k = (0..3).max_by(|a, b| length(a).total_cmp(&length(b))).expect("three edges");
    let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
    let middle = 0.5 * (a + b);
    let across = (c - middle).cross(cross).normalize();
    let across = if across.dot(b - middle) > 0.0 { across } else { -across };
    let [x, y, z] = across.to_array();
    let number = patches.locator.cuts.len();
    patches.locator.cuts.push(Cut { plane: [x, y, z, across.dot(middle)], child: [0; 2] });
    let child = [[a, middle, c], [middle, b, c]].map(|half| halve(patches, half, face, largest));
    patches.locator.cuts[number].child = child;
    CUT | number as u32
}

/// By `count` rays a patch, both estimates of a pair averaged.
pub fn by_rays(mesh: &Mesh, patches: &Patches, count: u32) -> FormFactors<'static> {
    let (n, rays, sampler) = (patches.len(), Rays::new(mesh), PatchSampler::new(patches));
    // A_i F_ij
    let measure = |i: usize| {
        let (mut row, sobol) = (vec![0.0; n], Sobol::new(i as u32));
        for k in 0..count {
            let [x, y, z, w] = sobol.sample(k);
            let from = sampler.point(i, x, y);
            let origin = rays.off_surface(from.position, from.normal);
            let direction = cosine_direction(from.normal, z, w);
            let landing = land(&rays, &patches.locator, origin, direction, from.triangle);
            if let Some(j) = landing.and_then(|l| l.patch) {
                row[j as usize] += patches.area[i] / count as f32;
            }
        }
        row
    };
    let exchange: Vec<Vec<f32>> = (0..n).into_par_iter().map(measure).collect();
    let both = |at: usize| 0.5 * (exchange[at / n][at % n] + exchange[at % n][at / n]) / patches.area[at / n];
    FormFactors { values: (0..n * n).map(both).collect(), sky: vec![0.0; n].into() }
}
