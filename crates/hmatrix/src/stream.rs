//! The packed bytes of an operator; all numbers little-endian.
//!
//! | what | bytes |
//! |---|---|
//! | `HMX1` | 4 |
//! | patches n; depth of the tree; 1 or 3 channels; planes | 4, 1, 1, 1 |
//! | the patch at each place, ⌈log₂ n⌉ bits each | to a whole byte |
//! | the weight of the patch at each place, 7 bits each | to a whole byte |
//! | of every plane: unit, what values are relative to; how much of it is in red, green and blue (f32) | 16 |
//! | its blocks: pairs of clusters a ≤ b row by row, each followed by those that it splits into | see `block.rs` |
//!
//! A channel is the sum of the planes, each times its share. The first plane is luma; only it has tiles.

use crate::{
    Result,
    bits::{Reader, Writer},
    block::Block,
    cluster::Tree,
    colour::Colour,
    plan::{Id, first_level},
    report::Sizes,
};

const MAGIC: u32 = u32::from_le_bytes(*b"HMX1");
/// The largest magnitude that a number in the file may have; sums of products of such stay finite.
const MOST: f32 = 1e9;

/// The largest weight.
pub const HEAVIEST: f32 = 127.0;

/// A packed operator, taken apart.
pub struct Parts {
    pub tree: Tree,
    pub channels: usize,
    /// Patch at each place.
    pub order: Vec<u32>,
    /// √A of the patch at each place, [`HEAVIEST`] at most: what means are relative to.
    pub weights: Vec<i8>,
    /// Luma, then colour.
    pub planes: Vec<Plane>,
}

/// A symmetric matrix that is part of every channel.
pub struct Plane {
    /// What values are stored relative to.
    pub unit: f32,
    /// How much of it is in red, green and blue.
    pub colour: Colour,
    /// Every block, a split one before those that it splits into.
    pub blocks: Vec<(Id, Block)>,
}

fn bits_of_place(n: usize) -> u32 {
    n.next_power_of_two().ilog2()
}

impl Parts {
    /// The bytes, and what they are spent on.
    pub fn write(&self) -> (Vec<u8>, Sizes) {
        let mut out = Writer::default();
        let mut sizes = Sizes::default();
        out.put(MAGIC, 32);
        out.put(self.tree.n as u32, 32);
        out.put(self.tree.depth, 8);
        out.put(self.channels as u32, 8);
        out.put(self.planes.len() as u32, 8);
        self.order.iter().for_each(|&patch| out.put(patch, bits_of_place(self.tree.n)));
        out.align();
        self.weights.iter().for_each(|&weight| out.put(weight as u32, 7));
        out.align();
        sizes.structure = out.bytes.len();
        for (number, plane) in self.planes.iter().enumerate() {
            out.put_f32(plane.unit);
            plane.colour.iter().for_each(|&c| out.put_f32(c));
            let before = out.bytes.len();
            for (_, block) in &plane.blocks {
                let start = out.bytes.len();
                block.write(&mut out);
                sizes.count(block, out.bytes.len() - start);
            }
            if number > 0 {
                sizes.colour += 16 + out.bytes.len() - before;
            }
        }
        (out.bytes, sizes)
    }

    /// Takes bytes apart.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Short`] and [`crate::Error::Damaged`] for bytes that are no operator.
    pub fn read(bytes: &[u8]) -> Result<Parts> {
        let mut input = Reader::new(bytes);
        let magic = input.get(32)?;
        if magic != MAGIC {
            return input.damaged(format!("{magic:#x}"), "HMX1");
        }
        let n = input.get(32)? as usize;
        let (depth, channels, planes) = (input.get(8)?, input.get(8)? as usize, input.get(8)? as usize);
        if n == 0 || depth > bits_of_place(n) || 1usize << depth > n {
            return input.damaged(format!("{n} patches, depth {depth}"), "a patch or more in every leaf");
        }
        if !matches!((channels, planes), (1, 1) | (3, 1..=3)) {
            return input
                .damaged(format!("{channels} channels, {planes} planes"), "1 or 3 channels, as many planes at most");
        }
        let tree = Tree { n, depth };
        let order = read_order(&mut input, n)?;
        input.need(n, 7)?;
        let weights = (0..n).map(|_| Ok(input.get(7)? as i8)).collect::<Result<_>>()?;
        input.align();
        let planes = (0..planes).map(|number| Plane::read(&mut input, tree, number)).collect::<Result<_>>()?;
        input.finish()?;
        Ok(Parts { tree, channels, order, weights, planes })
    }
}

impl Plane {
    fn read(input: &mut Reader, tree: Tree, number: usize) -> Result<Plane> {
        input.what = "a plane";
        let unit = input.get_f32(MOST)?;
        if unit <= 0.0 {
            return input.damaged(unit.to_string(), "a unit above 0");
        }
        let colour = [input.get_f32(MOST)?, input.get_f32(MOST)?, input.get_f32(MOST)?];
        let mut blocks = Vec::new();
        for id in Id::of_level(first_level(tree)) {
            read_blocks(input, tree, id, number == 0, &mut blocks)?;
        }
        Ok(Plane { unit, colour, blocks })
    }
}

fn read_order(input: &mut Reader, n: usize) -> Result<Vec<u32>> {
    input.what = "the order of patches";
    // No operator has more patches than bits, so this bounds the memory for few patches of no bits, too.
    input.need(n, bits_of_place(n).max(1))?;
    let mut seen = vec![false; n];
    let mut order = Vec::with_capacity(n);
    for _ in 0..n {
        let patch = input.get(bits_of_place(n))?;
        match seen.get_mut(patch as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => return input.damaged(format!("patch {patch}"), "every patch once"),
        }
        order.push(patch);
    }
    input.align();
    Ok(order)
}

/// A block of the first level, and all below it.
fn read_blocks(input: &mut Reader, tree: Tree, id: Id, tiles: bool, blocks: &mut Vec<(Id, Block)>) -> Result<()> {
    let mut open = vec![id];
    while let Some(id) = open.pop() {
        let block = Block::read(input, id.shape(tree))?;
        let leaf = id.level == tree.depth;
        let legal = match &block {
            Block::LowRank { triples, .. } => triples.is_empty() || leaf || id.a != id.b,
            Block::Tile(_) => leaf && tiles,
            Block::Split => !leaf,
        };
        if !legal {
            return input.damaged(format!("another kind of block at level {}", id.level), "one that its level has");
        }
        if block == Block::Split {
            let children: Vec<Id> = id.children().collect();
            open.extend(children.into_iter().rev());
        }
        blocks.push((id, block));
    }
    Ok(())
}
