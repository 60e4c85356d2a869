//! Which side of each triangle the lightmap shows.
//!
//! It is the front, as in most renderers, unless the mesh is turned there: the front looks into the inside of a solid and
//! the back does not, or the front sees nothing and the back does. The second alone would turn the walls of a building
//! that stands alone, too, whose fronts see nothing but sky. Their backs are the inside of a solid: they see backs of
//! triangles whose fronts see something. In a room that is modelled inside out all fronts see nothing but sky.
//! Triangles that go on in each other have one side, which most of their area chooses.

use glam::Vec3;
use radfile::{Mesh, Side};
use rayon::prelude::*;
use scene::{Sobol, hash, square_to_triangle};

use crate::{
    edges::{Sets, edges},
    view::View,
};

/// Rays a side.
const RAYS: u32 = 16;
/// A front that sees so many fronts is no inside of a solid.
const FRONTS: u32 = 2;
const SEED: u32 = 0x51de;

/// What a front side sees.
#[derive(Clone, Copy, PartialEq)]
enum Outlook {
    /// Fronts of others, or a bit of all.
    Open,
    /// Nothing.
    Sky,
    /// Back sides.
    Inside,
}

/// The side of each triangle that receives.
pub fn sides(view: &View) -> Vec<Side> {
    let count = view.mesh.triangles.len() as u32;
    if view.mesh.one_sided {
        return vec![Side::Front; count as usize];
    }
    let outlook: Vec<Outlook> = (0..count).into_par_iter().map(|t| front_outlook(view, t)).collect();
    let better = |t: u32| match outlook[t as usize] {
        Outlook::Open => Side::Front,
        seen => better_back(view, t, seen, &outlook),
    };
    let better: Vec<Side> = (0..count).into_par_iter().map(better).collect();
    agree(view.mesh, &better)
}

/// The side of each sheet of triangles that is the better one for most of its area.
fn agree(mesh: &Mesh, better: &[Side]) -> Vec<Side> {
    let mut sheets = Sets::new(better.len());
    for edge in edges(mesh).chunk_by(|a, b| a.ends == b.ends) {
        // Two triangles of one sheet run along their edge in opposite directions.
        if let [a, b] = edge
            && a.forward != b.forward
        {
            sheets.join(a.triangle, b.triangle);
        }
    }
    let triangles = || 0..better.len() as u32;
    let mut in_favour = vec![0.0; better.len()];
    for t in triangles() {
        let sign = if better[t as usize] == Side::Back { 1.0 } else { -1.0 };
        in_favour[sheets.root(t) as usize] += sign * crate::area(mesh, t);
    }
    triangles().map(|t| if in_favour[sheets.root(t) as usize] > 0.0 { Side::Back } else { Side::Front }).collect()
}

fn front_outlook(view: &View, triangle: u32) -> Outlook {
    let (mut fronts, mut backs, mut sky) = (0, 0, 0);
    for hit in looks(view, triangle, Side::Front) {
        match hit {
            None => sky += 1,
            Some((_, Side::Front)) => fronts += 1,
            Some((_, Side::Back)) => backs += 1,
        }
        if fronts == FRONTS {
            return Outlook::Open;
        }
    }
    match () {
        _ if sky == RAYS => Outlook::Sky,
        _ if backs > RAYS - FRONTS => Outlook::Inside,
        _ => Outlook::Open,
    }
}

/// The back, if it is better than a front that sees nothing good.
fn better_back(view: &View, triangle: u32, front: Outlook, outlook: &[Outlook]) -> Side {
    let speaks_for_it = |hit: &Option<(u32, Side)>| match hit {
        None => front == Outlook::Inside,
        Some((_, Side::Front)) => true,
        Some((other, Side::Back)) => front == Outlook::Sky && outlook[*other as usize] == Outlook::Sky,
    };
    let good = looks(view, triangle, Side::Back).filter(speaks_for_it).count();
    if good as u32 > RAYS / 2 { Side::Back } else { Side::Front }
}

/// What the rays of a side meet, triangles and their sides; nothing for a triangle without area.
fn looks<'a>(view: &'a View<'a>, triangle: u32, side: Side) -> impl Iterator<Item = Option<(u32, Side)>> + use<'a> {
    let sequence = Sobol::new(hash(SEED, 2 * triangle + side as u32));
    let [a, b, c] = view.mesh.corners(triangle as usize).map(Vec3::from);
    view.normal(triangle, side).into_iter().flat_map(move |normal| {
        (0..RAYS).map(move |ray| {
            let [x, y, z, w] = sequence.sample(ray);
            let (u, v) = square_to_triangle(x, y);
            let from = a + u * (b - a) + v * (c - a);
            view.look(triangle, from, normal, [z, w]).map(|hit| (hit.triangle, hit.side))
        })
    })
}
