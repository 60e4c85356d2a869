//! The packed bytes of an operator; all numbers little-endian.
//!
//! | what | bytes |
//! |---|---|
//! | `HMX1`, or `HMR1` for a rectangle | 4 |
//! | patches n; depth of the tree; 1 or 3 channels; planes | 4, 1, 1, 1 |
//! | the patch at each place, ⌈log₂ n⌉ bits each | to a whole byte |
//! | the weight of the patch at each place, 7 bits each | to a whole byte |
//! | of rectangles: receivers; those that receive anything; trees of these | 4, 4, 4 |
//! | of rectangles: the receiver at each place, ⌈log₂⌉ of their number bits each; first those that receive | to a whole byte |
//! | of every plane: unit, what values are relative to; how much of it is in red, green and blue (f32) | 16 |
//! | its blocks: pairs of clusters row by row (symmetric operators: a ≤ b), each followed by those that it splits into | see `block.rs` |
//!
//! A channel is the sum of the planes, each times its share. The first plane is luma; only it has tiles. A rectangle has
//! one channel and one plane: what it stores is relative to the weight of the column.

use crate::{
    Result,
    bits::{Reader, Writer},
    block::Block,
    cluster::Tree,
    colour::Colour,
    pairs::{Id, Pairs},
    report::Sizes,
};

const SYMMETRIC: u32 = u32::from_le_bytes(*b"HMX1");
const RECTANGULAR: u32 = u32::from_le_bytes(*b"HMR1");
/// The largest magnitude that a number in the file may have; sums of products of such stay finite.
const MOST: f32 = 1e9;

/// The largest weight.
pub const HEAVIEST: f32 = 127.0;

/// Rows or columns of a matrix.
#[derive(Clone)]
pub struct Axis {
    pub tree: Tree,
    /// The patch or receiver at each place; behind the places of the tree those that have no part in the matrix.
    pub order: Vec<u32>,
    /// √A at each place of the tree, [`HEAVIEST`] at most: what means are relative to.
    pub weights: Vec<i8>,
}

/// A packed operator, taken apart.
pub struct Parts {
    pub channels: usize,
    /// Senders.
    pub columns: Axis,
    /// Receivers of a rectangle; those of a symmetric operator are the senders.
    pub receivers: Option<Axis>,
    /// Luma, then colour.
    pub planes: Vec<Plane>,
}

/// A matrix that is part of every channel.
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
    /// Receivers.
    pub fn rows(&self) -> &Axis {
        self.receivers.as_ref().unwrap_or(&self.columns)
    }

    pub fn pairs(&self) -> Pairs {
        pairs(&self.columns, self.receivers.as_ref())
    }

    /// The bytes, and what they are spent on.
    pub fn write(&self) -> (Vec<u8>, Sizes) {
        let mut out = Writer::default();
        let mut sizes = Sizes::default();
        out.put(if self.receivers.is_some() { RECTANGULAR } else { SYMMETRIC }, 32);
        out.put(self.columns.tree.n as u32, 32);
        out.put(self.columns.tree.depth, 8);
        out.put(self.channels as u32, 8);
        out.put(self.planes.len() as u32, 8);
        write_order(&mut out, &self.columns.order);
        self.columns.weights.iter().for_each(|&weight| out.put(weight as u32, 7));
        out.align();
        if let Some(Axis { tree, order, .. }) = &self.receivers {
            [order.len(), tree.n, tree.roots].into_iter().for_each(|number| out.put(number as u32, 32));
            write_order(&mut out, order);
        }
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

    /// Takes bytes apart, those of a rectangle or of a symmetric operator.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Short`] and [`crate::Error::Damaged`] for bytes that are no such operator.
    pub fn read(bytes: &[u8], rectangular: bool) -> Result<Parts> {
        let mut input = Reader::new(bytes);
        let (magic, name) = if rectangular { (RECTANGULAR, "HMR1") } else { (SYMMETRIC, "HMX1") };
        let found = input.get(32)?;
        if found != magic {
            return input.damaged(format!("{found:#x}"), name);
        }
        let n = input.get(32)? as usize;
        let (depth, channels, planes) = (input.get(8)?, input.get(8)? as usize, input.get(8)? as usize);
        if n == 0 || depth > bits_of_place(n) || 1usize << depth > n {
            return input.damaged(format!("{n} patches, depth {depth}"), "a patch or more in every leaf");
        }
        let legal =
            if rectangular { (channels, planes) == (1, 1) } else { matches!((channels, planes), (1, 1) | (3, 1..=3)) };
        if !legal {
            return input
                .damaged(format!("{channels} channels, {planes} planes"), "1 or 3 channels, as many planes at most");
        }
        let tree = Tree { n, roots: 1, depth };
        let order = read_order(&mut input, n)?;
        input.need(n, 7)?;
        let weights = (0..n).map(|_| Ok(input.get(7)? as i8)).collect::<Result<_>>()?;
        input.align();
        let columns = Axis { tree, order, weights };
        let receivers = if rectangular { Some(Axis::read_receivers(&mut input, depth)?) } else { None };
        let pairs = pairs(&columns, receivers.as_ref());
        let planes = (0..planes).map(|number| Plane::read(&mut input, pairs, number)).collect::<Result<_>>()?;
        input.finish()?;
        Ok(Parts { channels, columns, receivers, planes })
    }
}

fn pairs(columns: &Axis, receivers: Option<&Axis>) -> Pairs {
    match receivers {
        None => Pairs::symmetric(columns.tree),
        Some(rows) => Pairs::rectangular(rows.tree, columns.tree),
    }
}

impl Axis {
    /// Receivers, all of one weight.
    pub fn receivers(tree: Tree, order: Vec<u32>) -> Axis {
        Axis { tree, order, weights: vec![HEAVIEST as i8; tree.n] }
    }

    fn read_receivers(input: &mut Reader, depth: u32) -> Result<Axis> {
        input.what = "the receivers";
        let [count, n, roots] = [input.get(32)? as usize, input.get(32)? as usize, input.get(32)? as usize];
        // Every leaf has a receiver; an operator without light has no tree.
        if n > count || roots.checked_mul(1 << depth).is_none_or(|leaves| leaves > n) || (roots == 0) != (n == 0) {
            return input
                .damaged(format!("{n} of {count} receivers in {roots} trees"), "a receiver or more in every leaf");
        }
        Ok(Axis::receivers(Tree { n, roots, depth }, read_order(input, count)?))
    }
}

impl Plane {
    fn read(input: &mut Reader, pairs: Pairs, number: usize) -> Result<Plane> {
        input.what = "a plane";
        let unit = input.get_f32(MOST)?;
        if unit <= 0.0 {
            return input.damaged(unit.to_string(), "a unit above 0");
        }
        let colour = [input.get_f32(MOST)?, input.get_f32(MOST)?, input.get_f32(MOST)?];
        if number == 0 && colour != [1.0; 3] {
            return input.damaged(format!("{colour:?}"), "all of luma in every channel");
        }
        let mut blocks = Vec::new();
        for id in pairs.of_level(pairs.first) {
            read_blocks(input, pairs, id, number == 0, &mut blocks)?;
        }
        Ok(Plane { unit, colour, blocks })
    }
}

fn write_order(out: &mut Writer, order: &[u32]) {
    order.iter().for_each(|&number| out.put(number, bits_of_place(order.len())));
    out.align();
}

fn read_order(input: &mut Reader, n: usize) -> Result<Vec<u32>> {
    input.what = "an order";
    // No operator has more places than bits, so this bounds the memory for few places of no bits, too.
    input.need(n, bits_of_place(n).max(1))?;
    let mut seen = vec![false; n];
    let mut order = Vec::with_capacity(n);
    for _ in 0..n {
        let number = input.get(bits_of_place(n))?;
        match seen.get_mut(number as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => return input.damaged(format!("number {number}"), "every number once"),
        }
        order.push(number);
    }
    input.align();
    Ok(order)
}

/// A block of the first level, and all below it.
fn read_blocks(input: &mut Reader, pairs: Pairs, id: Id, tiles: bool, blocks: &mut Vec<(Id, Block)>) -> Result<()> {
    let mut open = vec![id];
    while let Some(id) = open.pop() {
        let block = Block::read(input, pairs.shape(id))?;
        let leaf = pairs.is_leaf(id);
        let legal = match &block {
            Block::LowRank { triples, .. } => triples.is_empty() || leaf || !pairs.is_diagonal(id),
            Block::Tile(_) => leaf && tiles,
            Block::Split => !leaf,
        };
        if !legal {
            return input.damaged(format!("another kind of block at level {}", id.level), "one that its level has");
        }
        if block == Block::Split {
            let children: Vec<Id> = pairs.children(id).collect();
            open.extend(children.into_iter().rev());
        }
        blocks.push((id, block));
    }
    Ok(())
}
