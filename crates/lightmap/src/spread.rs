//! Which receiver each texel shows.
//!
//! Hidden texels take one nearby of their own chart, ring by ring from those that have one. Then charts grow over the
//! empty texels around them, so that a filter at their border reads what lies just inside it.

use radfile::NO_RECEIVER;

use crate::{Atlas, atlas::NO_CHART};

/// Texels of an atlas on their way to a lightmap.
pub struct Spread<'a> {
    pub atlas: &'a Atlas,
    /// Chart of each texel that the mesh touches, [`NO_CHART`] elsewhere.
    pub chart: &'a [u32],
    /// Texel of each receiver.
    pub texel: &'a [u32],
}

impl Spread<'_> {
    /// The receiver of each texel.
    pub fn receivers(&self) -> Vec<u32> {
        let mut receiver = vec![NO_RECEIVER; self.chart.len()];
        for (number, &texel) in (0u32..).zip(self.texel) {
            receiver[texel as usize] = number;
        }
        let texels = || 0..self.chart.len() as u32;
        let touched = |x: &u32| self.chart[*x as usize] != NO_CHART;
        let mut hidden: Vec<u32> = texels().filter(touched).filter(|&x| receiver[x as usize] == NO_RECEIVER).collect();
        loop {
            let before = hidden.len();
            self.grow(&mut receiver, &mut hidden);
            if hidden.len() == before {
                break;
            }
        }
        let mut empty: Vec<u32> = texels().filter(|x| !touched(x)).collect();
        for _ in 0..self.atlas.padding {
            self.grow(&mut receiver, &mut empty);
        }
        receiver
    }

    /// Gives a receiver to those of `open` that are next to a texel which has one, and takes them off the list.
    fn grow(&self, receiver: &mut [u32], open: &mut Vec<u32>) {
        let found: Vec<u32> = open.iter().map(|&texel| self.nearest(receiver, texel)).collect();
        for (&texel, &found) in open.iter().zip(&found) {
            receiver[texel as usize] = found;
        }
        open.retain(|&texel| receiver[texel as usize] == NO_RECEIVER);
    }

    /// The nearest of the receivers that the eight texels around one show, of its own chart if it is of any.
    fn nearest(&self, receiver: &[u32], texel: u32) -> u32 {
        let own = self.chart[texel as usize];
        let fits =
            |r: &u32| *r != NO_RECEIVER && (own == NO_CHART || self.chart[self.texel[*r as usize] as usize] == own);
        let distance = |r: u32| {
            let ([x, y], [u, v]) = (self.place(texel), self.place(self.texel[r as usize]));
            x.abs_diff(u).pow(2) + y.abs_diff(v).pow(2)
        };
        let around = neighbours(self.atlas, texel).map(|x| receiver[x as usize]).filter(fits);
        around.min_by_key(|&r| (distance(r), r)).unwrap_or(NO_RECEIVER)
    }

    /// Column and row.
    fn place(&self, texel: u32) -> [u32; 2] {
        [texel % self.atlas.width, texel / self.atlas.width]
    }
}

/// The up to eight texels around one.
pub fn neighbours(atlas: &Atlas, texel: u32) -> impl Iterator<Item = u32> + use<> {
    let (width, height) = (atlas.width, atlas.height);
    let (x, y) = (texel % width, texel / width);
    let (columns, rows) = (x.saturating_sub(1)..=(x + 1).min(width - 1), y.saturating_sub(1)..=(y + 1).min(height - 1));
    rows.flat_map(move |v| columns.clone().map(move |u| v * width + u)).filter(move |&other| other != texel)
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: u32 = NO_CHART;
    const NONE: u32 = NO_RECEIVER;

    #[test]
    fn hidden_texels_take_the_nearest_of_their_chart_and_charts_grow_by_the_padding() {
        let atlas = Atlas { width: 7, height: 2, corner_uv: vec![], chart: vec![], padding: 1 };
        let chart = [0, 0, 0, X, X, 1, 1, 0, 0, 0, X, X, 1, 1];
        // Of chart 0 the first column has receivers, of chart 1 one texel.
        let spread = Spread { atlas: &atlas, chart: &chart, texel: &[0, 6, 7] };
        assert_eq!(spread.receivers(), [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2, 1, 1, 1]);
        let wider = Spread { atlas: &atlas, chart: &[0, 0, X, X, X, X, X, 0, 0, X, X, X, X, X], texel: &[1] };
        assert_eq!(wider.receivers(), [0, 0, 0, NONE, NONE, NONE, NONE, 0, 0, 0, NONE, NONE, NONE, NONE]);
    }

    #[test]
    fn texels_at_the_border_have_fewer_neighbours() {
        let atlas = Atlas { width: 3, height: 2, corner_uv: vec![], chart: vec![], padding: 1 };
        assert_eq!(neighbours(&atlas, 0).collect::<Vec<_>>(), [1, 3, 4]);
        assert_eq!(neighbours(&atlas, 4).count(), 5);
    }
}
