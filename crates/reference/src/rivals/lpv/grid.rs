//! Cells of a volume.

use glam::{IVec3, Vec3};

/// Cubic cells, x fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Lowest corner, metres.
    pub low: Vec3,
    /// Length of a cell's edge, metres.
    pub cell: f32,
    /// Cells along each axis.
    pub size: IVec3,
}

impl Grid {
    /// Cells over a box, `along` on its longest side, one of which on either end lies outside: walls on the box have
    /// cells before
    /// and behind them.
    pub fn over(low: Vec3, high: Vec3, along: u32) -> Grid {
        let along = along.max(3);
        let cell = (high - low).max_element().max(f32::MIN_POSITIVE) / (along - 2) as f32;
        // A hair less, so that rounding adds no layer.
        let size = ((high - low) / cell - 1e-3).ceil().as_ivec3() + 2;
        Grid { low: low - cell, cell, size: size.max(IVec3::splat(3)) }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.size.as_u64vec3().element_product() as usize
    }

    /// Number of a cell.
    pub fn index(&self, at: IVec3) -> Option<usize> {
        let inside = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.size).all();
        inside.then(|| (at.x + self.size.x * (at.y + self.size.y * at.z)) as usize)
    }

    /// The cell of a number.
    pub fn at(&self, index: usize) -> IVec3 {
        let (x, y) = (self.size.x as usize, self.size.y as usize);
        IVec3::new((index % x) as i32, (index / x % y) as i32, (index / x / y) as i32)
    }

    /// The cell that holds a point.
    pub fn cell_of(&self, point: Vec3) -> Option<usize> {
        self.index(((point - self.low) / self.cell).floor().as_ivec3())
    }

    /// Middle of a cell.
    pub fn middle(&self, at: IVec3) -> Vec3 {
        self.low + self.cell * (at.as_vec3() + 0.5)
    }

    /// The eight cells about a point with the weights of trilinear interpolation; those outside are left out.
    pub fn around(&self, point: Vec3) -> impl Iterator<Item = (usize, f32)> + use<> {
        let scaled = (point - self.low) / self.cell - 0.5;
        let (first, part) = (scaled.floor(), scaled - scaled.floor());
        let grid = *self;
        (0..8).filter_map(move |k| {
            let step = IVec3::new(k & 1, k >> 1 & 1, k >> 2);
            let weight = Vec3::select(step.cmpeq(IVec3::ONE), part, 1.0 - part).element_product();
            Some((grid.index(first.as_ivec3() + step)?, weight))
        })
    }

    /// How deep a point lies inside, in cells; 0 on the border and outside.
    pub fn depth(&self, point: Vec3) -> f32 {
        let scaled = (point - self.low) / self.cell;
        scaled.min(self.size.as_vec3() - scaled).min_element().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_of_the_box_lie_between_cells() {
        let grid = Grid::over(Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 3.0, 3.0), 8);
        assert_eq!((grid.cell, grid.size), (0.5, IVec3::new(8, 4, 3)));
        assert_eq!(grid.low + grid.cell, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(grid.len(), 8 * 4 * 3);
        assert!((0..grid.len()).all(|i| grid.index(grid.at(i)) == Some(i)));
        assert!((0..grid.len()).all(|i| grid.cell_of(grid.middle(grid.at(i))) == Some(i)));
    }

    #[test]
    fn interpolation_is_exact_for_linear_functions() {
        let grid = Grid::over(Vec3::ZERO, Vec3::new(2.0, 1.0, 1.0), 10);
        let f = |p: Vec3| 1.0 + p.dot(Vec3::new(0.3, -2.0, 0.7));
        for p in [Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.9, 0.9, 0.05)] {
            let found: f32 = grid.around(p).map(|(i, w)| w * f(grid.middle(grid.at(i)))).sum();
            assert!((found - f(p)).abs() < 1e-4, "{found}, expected {}", f(p));
        }
    }
}
