//! Positions of the target: tracked, predicted from the velocity, and tried when the whole frame is searched for it.

use super::Numbers;
use super::rounding::{FINE, POSITION, down, nearest, to_f64, to_i64};
use super::sampling::{Lattice, Shape};

/// Centre of the target in frame pixels, and its scale relative to the first box.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub x: f64,
    pub y: f64,
    pub scale: f64,
}

impl Place {
    pub fn inside(self, (width, height): (i64, i64)) -> Self {
        let within = |at: f64, size: i64| at.clamp(0.0, to_f64(size) - 1.0);
        Self { x: within(self.x, width), y: within(self.y, height), ..self }
    }

    /// Moves the centre by (`right`, `below`) pixels, each rounded down to 1/4096.
    pub fn moved(self, right: f64, below: f64) -> Self {
        Self { x: self.x + down(right, POSITION), y: self.y + down(below, POSITION), ..self }
    }

    /// Search window: the filter's cells and, on each side, `reach` more cells and one pixel for the gradients.
    pub fn window(self, numbers: &Numbers, shape: &Shape, reach: i64) -> Lattice {
        let side = |cells: i64| (cells + 2 * reach) * numbers.cell + 2;
        self.lattice(shape, side(shape.across), side(shape.down))
    }

    /// View in which the template is aligned: the template's size, and a margin on each side.
    pub fn view(self, numbers: &Numbers, shape: &Shape) -> Lattice {
        self.lattice(shape, shape.columns + 2 * numbers.margin, shape.rows + 2 * numbers.margin)
    }

    fn lattice(self, shape: &Shape, columns: i64, rows: i64) -> Lattice {
        let step = shape.step_at(self.scale);
        Lattice { x: self.x, y: self.y, step, step_down: step, columns, rows }
    }

    /// Box of the target (left, top, width, height); `size` is its width and height at scale 1.
    pub fn bbox(self, size: (i64, i64)) -> [f64; 4] {
        let side = |size: i64| nearest(to_f64(size) * self.scale, FINE);
        let (width, height) = (side(size.0), side(size.1));
        // Positions refer to pixel centres, which are half a pixel from the pixels' edges.
        let corner = |middle: f64, size: f64| down(middle + 0.5, FINE) - down(size / 2.0, FINE);
        [corner(self.x, width), corner(self.y, height), width, height]
    }
}

/// Rounds each edge of a box (left, top, width, height) to whole pixels; each side is at least 1.
pub fn whole_box([x, y, width, height]: [f64; 4]) -> [i64; 4] {
    let edge = |at: f64| to_i64(nearest(at, 1.0));
    let side = |from: f64, size: f64| (edge(from + size) - edge(from)).max(1);
    [edge(x), edge(y), side(x, width), side(y, height)]
}

/// Centres of the next search windows in the sweep for a lost target: at most `numbers.sweep` windows, from number
/// `number` on, all in one row. The frame is divided into equal tiles, one per window; a tile's sides are at most the
/// span of a search, twice `reach` cells.
pub fn sweep(numbers: &Numbers, shape: &Shape, frame: (i64, i64), scale: f64, number: i64) -> Vec<Place> {
    let covered = to_f64(2 * numbers.reach * numbers.cell) * shape.step_at(scale);
    let count = |size: i64| to_i64((to_f64(size) / covered).ceil());
    let (columns, rows) = (count(frame.0), count(frame.1));
    let (row, first) = (number / columns % rows, number % columns);
    let middle = |number: i64, count: i64, size: i64| {
        (down((to_f64(number) + 0.5) * to_f64(size) / to_f64(count), POSITION) - 0.5).max(0.0)
    };
    let place = |column: i64| Place { x: middle(column, columns, frame.0), y: middle(row, rows, frame.1), scale };
    (first..columns.min(first + numbers.sweep)).map(place).collect()
}
