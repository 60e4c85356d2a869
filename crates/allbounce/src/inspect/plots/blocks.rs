//! Where the hierarchical operator is what: a map of its blocks, one for luma and one for each plane of colour.

use hmatrix::{BlockKind, Map, MapBlock};
use plot::{Content, Key, PICTURE_PIXELS, Panel, Sheet};
use serde::Serialize;

use super::{Plot, subject::Subject};
use crate::{memory, numbers};

const NAME: &str = "blocks";
/// Terms of a low-rank block that is as dark as can be; few have more.
const DARKEST_RANK: f32 = 16.0;
/// Bits of a tile that is as dark as can be.
const DARKEST_BITS: f32 = 8.0;
/// Blocks of fewer pixels have no edge drawn.
const SMALLEST_WITH_EDGE: usize = 6;
/// Lightest and darkest of each kind, sRGB.
const LOW_RANK: [[f32; 3]; 2] = [[190.0, 219.0, 243.0], [8.0, 48.0, 107.0]];
const TILE: [[f32; 3]; 2] = [[253.0, 224.0, 178.0], [166.0, 40.0, 4.0]];
const ZERO: [u8; 3] = [255, 255, 255];
const MEAN: [u8; 3] = [214, 230, 204];

#[derive(Serialize)]
struct Numbers {
    patches: usize,
    bytes: usize,
    /// Patches at their places, weights, and where blocks are split.
    structure_bytes: usize,
    planes: Vec<Plane>,
}

#[derive(Serialize)]
struct Plane {
    plane: String,
    zero: Share,
    mean: Share,
    low_rank: Share,
    tile: Share,
}

/// What blocks of a kind have of a plane.
#[derive(Default, Serialize)]
struct Share {
    blocks: usize,
    /// Of the matrix, with mirror images.
    entries: usize,
    bytes: usize,
}

pub fn draw(subject: &Subject) -> anyhow::Result<Plot> {
    let matrix = match &subject.packed {
        Some(relight::Operator::Hierarchical(matrix, _)) => matrix,
        Some(relight::Operator::Textures(_)) => {
            let reason = "The operator is packed as textures, whose blocks are all alike; bake without --operator textures, or run \
                          hmatrix, to have hierarchical blocks.";
            return Ok(Plot::missing(NAME, reason));
        }
        None => {
            return Ok(Plot::missing(
                NAME,
                "The container has no packed operator; run hmatrix to have hierarchical blocks.",
            ));
        }
    };
    let (map, n, bytes) = (matrix.map()?, matrix.patches(), matrix.to_bytes().len());
    let planes: Vec<Plane> = map.planes.iter().enumerate().map(|(number, blocks)| plane(number, blocks)).collect();
    let panel = |(blocks, plane): (&Vec<MapBlock>, &Plane)| Panel {
        title: format!("{}: {}", plane.plane, shares(plane, bytes)),
        content: Content::Picture { pixels: pixels(blocks, n), key: key() },
    };
    let sheet = Sheet {
        title: "The blocks of the hierarchical operator".into(),
        subtitle: format!(
            "{n} patches in the order of their clusters, rows receive, columns send. {} in all, of which {} say where patches and \
             blocks are; shares are of all bytes.",
            memory::size(bytes as u64),
            numbers::percent(map.structure as f64 / bytes as f64)
        ),
        panels: map.planes.iter().zip(&planes).map(panel).collect(),
    };
    let sentence = sentence(&planes, &map, bytes);
    Plot::new(NAME, sheet, &Numbers { patches: n, bytes, structure_bytes: map.structure, planes }, sentence)
}

fn plane(number: usize, blocks: &[MapBlock]) -> Plane {
    let name = if number == 0 { "luma".into() } else { format!("colour {number}") };
    let [zero, mean, low_rank, tile] = Default::default();
    let mut plane = Plane { plane: name, zero, mean, low_rank, tile };
    for block in blocks {
        let share = match block.kind {
            BlockKind::Zero => &mut plane.zero,
            BlockKind::Mean => &mut plane.mean,
            BlockKind::LowRank(_) => &mut plane.low_rank,
            BlockKind::Tile(_) => &mut plane.tile,
        };
        share.blocks += 1;
        share.entries += block.entries();
        share.bytes += block.bytes;
    }
    plane
}

/// Bytes of a plane by kind, relative to all.
fn shares(plane: &Plane, bytes: usize) -> String {
    let of = |share: &Share| numbers::percent(share.bytes as f64 / bytes as f64);
    format!("low rank {}, tiles {}, means {}", of(&plane.low_rank), of(&plane.tile), of(&plane.mean))
}

fn sentence(planes: &[Plane], map: &Map, bytes: usize) -> String {
    let luma = &planes[0];
    let entries = (luma.zero.entries + luma.mean.entries + luma.low_rank.entries + luma.tile.entries) as f64;
    let of = |share: &Share| numbers::percent(share.entries as f64 / entries);
    format!(
        "The hierarchical operator in {} blocks of {} plane(s), {}; of the entries of luma {} are 0, {} a mean, {} of low rank and \
         {} in tiles.",
        map.planes.iter().flatten().count(),
        planes.len(),
        memory::size(bytes as u64),
        of(&luma.zero),
        of(&luma.mean),
        of(&luma.low_rank),
        of(&luma.tile)
    )
}

fn colour(kind: BlockKind) -> [u8; 3] {
    match kind {
        BlockKind::Zero => ZERO,
        BlockKind::Mean => MEAN,
        BlockKind::LowRank(rank) => between(LOW_RANK, (rank as f32).ln() / DARKEST_RANK.ln()),
        BlockKind::Tile(bits) => between(TILE, (bits as f32 - 2.0) / (DARKEST_BITS - 2.0)),
    }
}

fn between([light, dark]: [[f32; 3]; 2], at: f32) -> [u8; 3] {
    let at = at.clamp(0.0, 1.0);
    std::array::from_fn(|c| (light[c] + at * (dark[c] - light[c])).round() as u8)
}

/// Every block as a rectangle with a darker edge, and its mirror image.
fn pixels(blocks: &[MapBlock], n: usize) -> Vec<[u8; 3]> {
    let at = |place: usize| place * PICTURE_PIXELS / n;
    let mut pixels = vec![ZERO; PICTURE_PIXELS * PICTURE_PIXELS];
    for block in blocks {
        let fill = colour(block.kind);
        let edge = fill.map(|c| (f32::from(c) * 0.75) as u8);
        let (rows, columns) =
            (at(block.rows.start)..at(block.rows.end), at(block.columns.start)..at(block.columns.end));
        let edged = rows.len().min(columns.len()) >= SMALLEST_WITH_EDGE;
        for (y, x) in rows.clone().flat_map(|y| columns.clone().map(move |x| (y, x))) {
            let is_edge = edged && (y == rows.start || x == columns.start);
            let shade = if is_edge { edge } else { fill };
            pixels[y * PICTURE_PIXELS + x] = shade;
            if block.mirrored {
                pixels[x * PICTURE_PIXELS + y] = shade;
            }
        }
    }
    pixels
}

fn key() -> Key {
    let rank = |rank: usize| (colour(BlockKind::LowRank(rank)), format!("rank {rank}"));
    let tile = |bits: u32| (colour(BlockKind::Tile(bits)), format!("tile, {bits} bits an entry"));
    let more = (colour(BlockKind::LowRank(DARKEST_RANK as usize)), format!("rank {DARKEST_RANK} and more"));
    Key::Names(vec![
        (ZERO, "zero".into()),
        (MEAN, "one mean".into()),
        rank(1),
        tile(2),
        rank(4),
        tile(4),
        more,
        tile(8),
    ])
}
