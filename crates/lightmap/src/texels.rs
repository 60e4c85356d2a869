//! Receivers of a lightmap: one for each texel that the mesh touches, where it can be seen.

use radfile::{Lightmap, Mesh, Progress, Side};
use rayon::prelude::*;
use scene::Rays;
use serde::Serialize;

use crate::{
    Atlas,
    atlas::NO_CHART,
    coverage::{Fragment, fragments},
    flat::{Point, distance_squared, nearest},
    place::{Ground, Place},
    sides::sides,
    spread::{Spread, neighbours},
    view::View,
};

/// Places along an edge of a texel that are tried where its middle is hidden.
const TRIES: u32 = 4;

/// What was made, for people.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Pieces that the surface lies in.
    pub charts: usize,
    /// Texels that the mesh touches.
    pub touched: usize,
    /// Texels that receive.
    pub receivers: usize,
    /// Texels behind or inside other geometry, which show a receiver nearby.
    pub hidden: usize,
    /// Texels that receive off their middle, because that is hidden.
    pub moved: usize,
    /// Texels that two charts touch; they show the one that covers more.
    pub shared: usize,
    /// Triangles that show their back.
    pub turned: usize,
}

/// A texel that the mesh touches.
struct Texel<'f> {
    number: u32,
    chart: u32,
    /// Triangles of its chart, in increasing order.
    fragments: Vec<&'f Fragment>,
    shared: bool,
}

/// Places receivers in the texels of an atlas.
///
/// | argument | meaning |
/// |---|---|
/// | `atlas` | of this mesh |
/// | `rays` | over all triangles of `mesh` |
///
/// A receiver lies on its triangle, in the middle of its texel or, where that is off the mesh or hidden, as near to it as
/// may be; its normal is that of the side which is looked at. A chart that is hidden as a whole keeps its receivers: what
/// they gather is what is there. The same input gives the same lightmap, whatever the number of threads.
///
/// # Panics
///
/// If `atlas` belongs to another mesh: a bug in the caller.
pub fn texels(mesh: &Mesh, atlas: &Atlas, rays: &Rays, progress: &dyn Progress) -> (Lightmap, Report) {
    assert_eq!(atlas.corner_uv.len(), mesh.triangles.len(), "the atlas must belong to the mesh");
    progress.begin("sides of the lightmap", 0);
    let view = View { mesh, rays };
    let sides = sides(&view);
    let ground = Ground::new(view, atlas, sides);
    let fragments = fragments(atlas);
    let touched: Vec<Texel> = fragments.chunk_by(|a, b| a.texel == b.texel).map(|f| Texel::new(f, atlas)).collect();
    progress.begin("texels", touched.len() as u64);
    let found: Vec<Found> = touched
        .par_iter()
        .map(|texel| {
            progress.advance(1);
            texel.find(&ground)
        })
        .collect();
    let mut chart = vec![NO_CHART; (atlas.width * atlas.height) as usize];
    touched.iter().for_each(|t| chart[t.number as usize] = t.chart);
    let found = uncover(&touched, found, &chart, &ground);
    let receiving: Vec<(u32, &Place)> = touched
        .iter()
        .zip(&found)
        .filter(|(_, f)| !f.hidden)
        .filter_map(|(t, f)| Some((t.number, f.place.as_ref()?)))
        .collect();
    let texel: Vec<u32> = receiving.iter().map(|(number, _)| *number).collect();
    let report = Report {
        width: atlas.width,
        height: atlas.height,
        charts: atlas.charts(),
        touched: touched.len(),
        receivers: texel.len(),
        hidden: touched.len() - texel.len(),
        moved: found.iter().filter(|f| f.moved).count(),
        shared: touched.iter().filter(|t| t.shared).count(),
        turned: ground.sides.iter().filter(|s| **s == Side::Back).count(),
    };
    let lightmap = Lightmap {
        width: atlas.width,
        height: atlas.height,
        corner_uv: atlas.corner_uv.clone(),
        position: receiving.iter().map(|(_, p)| p.position.to_array()).collect(),
        normal: receiving.iter().map(|(_, p)| p.normal.to_array()).collect(),
        triangle: receiving.iter().map(|(_, p)| p.triangle).collect(),
        receiver: Spread { atlas, chart: &chart, texel: &texel }.receivers(),
        texel,
    };
    (lightmap, report)
}

/// Where a texel would receive.
struct Found {
    /// `None` on triangles without area.
    place: Option<Place>,
    hidden: bool,
    moved: bool,
}

/// Moves hidden receivers into the open where a texel beside them is, and gives up hiding charts that have no other.
fn uncover(touched: &[Texel], found: Vec<Found>, chart: &[u32], ground: &Ground) -> Vec<Found> {
    let mut open = vec![false; chart.len()];
    touched.iter().zip(&found).for_each(|(t, f)| open[t.number as usize] = !f.hidden);
    let beside_open =
        |t: &Texel| neighbours(ground.atlas, t.number).any(|x| open[x as usize] && chart[x as usize] == t.chart);
    let mut found: Vec<Found> = touched
        .par_iter()
        .zip(found)
        .map(|(texel, found)| match found.hidden && beside_open(texel) {
            true => texel.find_elsewhere(ground).unwrap_or(found),
            false => found,
        })
        .collect();
    let mut seen = vec![false; ground.atlas.charts()];
    let open = touched.iter().zip(&found).filter(|(_, f)| !f.hidden);
    open.for_each(|(t, _)| seen[t.chart as usize] = true);
    for (texel, found) in touched.iter().zip(&mut found) {
        found.hidden &= seen[texel.chart as usize] || found.place.is_none();
    }
    found
}

impl<'f> Texel<'f> {
    /// The texel of some fragments; it is of the chart that covers most of it.
    fn new(fragments: &'f [Fragment], atlas: &Atlas) -> Texel<'f> {
        let chart_of = |f: &Fragment| atlas.chart[f.triangle as usize];
        let mut charts: Vec<(u32, f32)> = fragments.iter().map(|f| (chart_of(f), f.area)).collect();
        charts.sort_by_key(|c| c.0);
        let areas = charts.chunk_by(|a, b| a.0 == b.0).map(|c| (c[0].0, c.iter().map(|c| c.1).sum::<f32>()));
        let (chart, _) = areas.clone().reduce(|a, b| if b.1 > a.1 { b } else { a }).expect("a texel has fragments");
        let own = fragments.iter().filter(|f| chart_of(f) == chart).collect();
        Texel { number: fragments[0].texel, chart, fragments: own, shared: areas.count() > 1 }
    }

    /// The middle of the texel if it is on the mesh, otherwise that of the part that is.
    fn find(&self, ground: &Ground) -> Found {
        let place = self.place(ground, self.middle(ground)).0;
        let hidden = place.as_ref().is_none_or(|place| ground.is_hidden(place, self.number));
        Found { place, hidden, moved: false }
    }

    /// The place nearest to the middle that is on the mesh and can be seen.
    fn find_elsewhere(&self, ground: &Ground) -> Option<Found> {
        let middle = self.middle(ground);
        let step = |k: u32| (f64::from(k) + 0.5) / f64::from(TRIES);
        let corner = self.corner(ground.atlas);
        let mut tries: Vec<Point> =
            (0..TRIES * TRIES).map(|k| [corner[0] + step(k % TRIES), corner[1] + step(k / TRIES)]).collect();
        tries.sort_by(|a, b| distance_squared(*a, middle).total_cmp(&distance_squared(*b, middle)));
        let on_mesh = tries.into_iter().map(|p| self.place(ground, p)).filter(|(_, distance)| *distance == 0.0);
        let place = on_mesh.filter_map(|(place, _)| place).find(|place| !ground.is_hidden(place, self.number))?;
        Some(Found { place: Some(place), hidden: false, moved: true })
    }

    /// The point of the atlas that stands for the texel.
    fn middle(&self, ground: &Ground) -> Point {
        let corner = self.corner(ground.atlas);
        let centre = corner.map(|x| x + 0.5);
        if self.place(ground, centre).1 == 0.0 {
            return centre;
        }
        // Parts without area count a little, so that the sum is never empty.
        let weight = |f: &Fragment| f64::from(f.area) + 1e-9;
        let sum: f64 = self.fragments.iter().map(|f| weight(f)).sum();
        [0, 1]
            .map(|k| corner[k] + self.fragments.iter().map(|f| weight(f) * f64::from(f.centroid[k])).sum::<f64>() / sum)
    }

    /// The place of the texel's triangles that is nearest to a point of the atlas, and the square of its distance, texels.
    fn place(&self, ground: &Ground, point: Point) -> (Option<Place>, f64) {
        let on = |f: &&Fragment| {
            let (weights, distance) = nearest(ground.atlas.corners(f.triangle), point);
            Some((ground.place(f.triangle, weights)?, distance))
        };
        let places = self.fragments.iter().filter_map(on);
        match places.min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((place, distance)) => (Some(place), distance),
            None => (None, f64::INFINITY),
        }
    }

    /// The texel's corner, in texels.
    fn corner(&self, atlas: &Atlas) -> Point {
        [f64::from(self.number % atlas.width), f64::from(self.number / atlas.width)]
    }
}
