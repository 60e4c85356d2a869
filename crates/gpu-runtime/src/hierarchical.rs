//! The operator as hierarchical blocks on the GPU, and its product in three dispatches.
//!
//! Every cluster gathers, every lane takes what it carries, every row adds up (`shaders/hmatrix_*.wgsl`). Codes stay
//! bytes, four to a word; columns of tiles are laid out as triples are, 16 to a panel, so that one loop reads both.
//! A rectangle is the same, with other rows than columns (`last_gather.rs`).

use bytemuck::{Pod, Zeroable};
use hmatrix::{LANES, Layout, Leaf, ROWS};

use crate::{
    Gpu, Result,
    kernels::{self, Dispatch},
};

/// See `shaders/hmatrix_gather.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Panel {
    pub codes: u32,
    pub place: u32,
    pub len: u32,
    pub sums: u32,
}

/// See `shaders/hmatrix_exchange.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Term {
    pub factor: [f32; 3],
    pub source: u32,
}

/// See `shaders/hmatrix_scatter.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct ScatterParams {
    pub parts: u32,
    pub runs: u32,
    pub unused_a: u32,
    pub unused_b: u32,
    /// Irradiance of a whole sky, pi L.
    pub sky: [f32; 4],
}

/// What the kernels read.
#[derive(Default)]
struct Tables {
    panels: Vec<Panel>,
    /// [`LANES`] codes at a place or row.
    codes: Vec<[u8; LANES]>,
    /// The sender at each place, and the bits of what its light is multiplied by.
    places: Vec<[u32; 2]>,
    /// The receiver of each row and where its entries start, one more at the end.
    rows: Vec<[u32; 2]>,
    terms: Vec<Term>,
    mean_start: Vec<u32>,
    leaves: Vec<[u32; 4]>,
    /// Sender and bits of a number.
    apart: Vec<[u32; 2]>,
    params: ScatterParams,
}

/// The operator, ready for products.
pub struct Hierarchical {
    /// What is sent; behind it what lanes gather.
    pub x: wgpu::Buffer,
    /// The [`ScatterParams`].
    pub params: wgpu::Buffer,
    /// What is received.
    pub product: [Dispatch; 3],
    /// Bytes of the operator on the device.
    pub bytes: usize,
    /// Bytes of the operator that a product reads.
    pub bytes_read: usize,
}

const FEWER: &str = "bake fewer patches or allow the operator a larger error";

impl Hierarchical {
    /// Uploads an operator or a rectangle. `factors` holds what rows of the result `h` are divided by, √A, in its fourth
    /// component, and in its first the share of the sky that is added.
    ///
    /// # Errors
    ///
    /// [`crate::Error::TooLarge`].
    pub fn new(gpu: &Gpu, layout: &Layout, factors: &wgpu::Buffer, h: &wgpu::Buffer) -> Result<Hierarchical> {
        let tables = Tables::new(layout);
        let lanes = tables.mean_start[0] as usize;
        let x = gpu.vectors("senders", layout.order.len() + LANES * tables.panels.len(), FEWER)?;
        let carried = gpu.vectors("what lanes carry", 3 * lanes / 4, FEWER)?;
        let panels = gpu.storage("panels of the operator", &tables.panels, FEWER)?;
        let codes = gpu.storage("codes of the operator", tables.codes.as_flattened(), FEWER)?;
        let places = gpu.storage("columns of the operator", &tables.places, FEWER)?;
        let rows = gpu.storage("rows of the operator", &tables.rows, FEWER)?;
        let terms = gpu.storage("factors of the operator", &tables.terms, FEWER)?;
        let mean_start = gpu.storage("means of the operator", &tables.mean_start, FEWER)?;
        let leaves = gpu.storage("leaves of the operator", &tables.leaves, FEWER)?;
        let apart = gpu.storage("entries of the operator", &tables.apart, FEWER)?;
        let params = gpu.uniform("scatter", &tables.params);
        let prepare = |name, source, buffers: &[&wgpu::Buffer], groups| {
            let resources: Vec<_> = buffers.iter().map(|b| b.as_entire_binding()).collect();
            gpu.kernel(name, source).prepare(gpu, &resources, groups)
        };
        let gather = [&panels, &codes, &places, &x];
        let exchange = [&terms, &mean_start, &x, &carried];
        let scatter = [&params, &leaves, &codes, &carried, &x, &rows, &apart, factors, h];
        let parts = tables.leaves.len() / (tables.params.runs as usize + 1) * tables.params.parts as usize;
        Ok(Hierarchical {
            product: [
                prepare("hmatrix_gather", kernels::HMATRIX_GATHER, &gather, tables.panels.len().div_ceil(2)),
                prepare("hmatrix_exchange", kernels::HMATRIX_EXCHANGE, &exchange, lanes.div_ceil(64)),
                prepare("hmatrix_scatter", kernels::HMATRIX_SCATTER, &scatter, parts),
            ],
            x,
            params,
            bytes: tables.bytes(),
            // The codes of triples are read by the first step and by the last.
            bytes_read: tables.bytes() + size_of_val(layout.codes),
        })
    }
}

impl Tables {
    fn new(layout: &Layout) -> Tables {
        let senders = layout.order.len();
        let source = |lane: usize| (senders + lane) as u32;
        let panel = |(number, p): (usize, &hmatrix::Panel)| Panel {
            codes: p.codes as u32,
            place: p.place as u32,
            len: p.len as u32,
            sums: source(number * LANES),
        };
        let lane = |at: usize| {
            let (panel, lane) = (at / LANES, at % LANES);
            Term {
                factor: layout.factor[panel].map(|factor| factor[lane]),
                source: source(layout.partner[panel][lane] as usize),
            }
        };
        let mut tables = Tables {
            panels: layout.panels.iter().enumerate().map(panel).collect(),
            codes: layout.codes.iter().map(|codes| codes.map(i8::cast_unsigned)).collect(),
            terms: (0..LANES * layout.factor.len()).map(lane).collect(),
            places: layout.order.iter().zip(layout.scale).map(|(&sender, scale)| [sender, scale.to_bits()]).collect(),
            ..Tables::default()
        };
        // The first leaf has most rows, and all have as many clusters above.
        let (rows, above) = layout.leaves.first().map_or((ROWS, 0), |leaf| (leaf.rows.len(), leaf.above.len()));
        tables.params.parts = rows.div_ceil(ROWS) as u32;
        tables.params.runs = above as u32 + 1;
        for leaf in &layout.leaves {
            tables.add_leaf(leaf, layout);
        }
        tables.add_rest(&layout.receivers[tables.rows.len()..], rows);
        tables.rows.push([0, tables.apart.len() as u32]);
        let first = tables.terms.len() as u32;
        tables.mean_start = layout.mean_start.iter().map(|start| first + start).collect();
        let mean = |&(panel, factor): &(u32, [f32; 3])| Term { factor, source: source(panel as usize * LANES) };
        tables.terms.extend(layout.means.iter().map(mean));
        tables
    }

    /// Runs of panels, those of its tiles made here, and entries row by row.
    fn add_leaf(&mut self, leaf: &Leaf, layout: &Layout) {
        let (place, rows, near) = (leaf.rows.start, leaf.rows.len(), leaf.near);
        self.leaves.push([place as u32, rows as u32, 0, 0]);
        for c in &leaf.above {
            self.leaves.push([c.codes + place - c.place, c.len, c.first, c.count].map(|v| v as u32));
        }
        let (stride, columns) = (rows.next_multiple_of(ROWS), near.senders.len());
        let run = [self.codes.len(), stride, self.terms.len() / LANES, columns.div_ceil(LANES)];
        self.leaves.push(run.map(|v| v as u32));
        for first in (0..columns).step_by(LANES) {
            for row in 0..stride {
                let code = |column: usize| near.codes[row / ROWS * columns + column][row % ROWS];
                let code = |lane| if first + lane < columns { code(first + lane) } else { 0 };
                self.codes.push(std::array::from_fn(code));
            }
            let term = |column: usize| {
                let sender = near.senders.get(column);
                sender.map_or(Term::default(), |&(at, scale)| {
                    let at = at as usize;
                    Term { factor: [scale * layout.scale[at]; 3], source: layout.order[at] }
                })
            };
            self.terms.extend((first..first + LANES).map(term));
        }
        for row in 0..rows {
            self.rows.push([layout.receivers[place + row], self.apart.len() as u32]);
            let own = near.apart.iter().filter(|entry| entry.0 as usize == row);
            self.apart.extend(own.map(|&(_, at, value)| {
                let at = at as usize;
                [layout.order[at], (value * layout.scale[at]).to_bits()]
            }));
        }
    }

    /// Receivers of nothing, in leaves of `width` rows without panels.
    fn add_rest(&mut self, receivers: &[u32], width: usize) {
        for receivers in receivers.chunks(width) {
            self.leaves.push([self.rows.len() as u32, receivers.len() as u32, 0, 0]);
            self.leaves.extend((0..self.params.runs).map(|_| [0; 4]));
            self.rows.extend(receivers.iter().map(|&receiver| [receiver, self.apart.len() as u32]));
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.panels[..])
            + size_of_val(&self.codes[..])
            + size_of_val(&self.places[..])
            + size_of_val(&self.rows[..])
            + size_of_val(&self.terms[..])
            + size_of_val(&self.mean_start[..])
            + size_of_val(&self.leaves[..])
            + size_of_val(&self.apart[..])
    }
}
