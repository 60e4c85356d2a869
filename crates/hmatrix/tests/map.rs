//! The map of blocks covers the matrix and accounts for every byte.

#[path = "../../dxt-pack/tests/common/mod.rs"]
mod common;

use common::room;
use hmatrix::{BlockKind, Params, compress};
use radfile::Quiet;

#[test]
fn blocks_cover_every_entry_once_and_bytes_add_up() {
    let room = room(9, 1);
    let n = room.patches.len();
    let params = Params { leaf: 24, ..Params::error(0.05) };
    let (matrix, report) = compress(&room.operator, &room.patches, &params, &Quiet).expect("a room");
    let map = matrix.map().expect("own bytes");
    let (order, dense) = (matrix.layout().order, matrix.decode(0).expect("own bytes"));
    assert_eq!(map.planes.len(), 1, "grey");
    let mut times = vec![0; n * n];
    for block in &map.planes[0] {
        let before: usize = times.iter().sum();
        for (i, j) in block.rows.clone().flat_map(|i| block.columns.clone().map(move |j| (i, j))) {
            times[i * n + j] += 1;
            if block.mirrored {
                times[j * n + i] += 1;
            }
            let entry = dense[order[i] as usize * n + order[j] as usize];
            assert!(block.kind != BlockKind::Zero || entry == 0.0, "{entry} in a block of zeros");
        }
        assert_eq!(times.iter().sum::<usize>() - before, block.entries());
    }
    assert!(times.iter().all(|t| *t == 1));
    let of_blocks: usize = map.planes[0].iter().map(|block| block.bytes).sum();
    assert_eq!(of_blocks + map.structure, matrix.to_bytes().len());
    let count = |fits: &dyn Fn(BlockKind) -> bool| map.planes[0].iter().filter(|block| fits(block.kind)).count();
    let sizes = &report.sizes;
    assert_eq!(count(&|kind| matches!(kind, BlockKind::LowRank(_))), sizes.low_rank_blocks);
    assert_eq!(count(&|kind| matches!(kind, BlockKind::Tile(_))), sizes.tile_blocks);
    assert_eq!(count(&|kind| kind == BlockKind::Mean), sizes.mean_blocks);
}
