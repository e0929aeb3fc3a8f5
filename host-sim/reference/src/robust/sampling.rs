//! Resampling of the frame, so that the template has about the same number of pixels for a target of any size.

use super::Numbers;
use super::rounding::{FINE, POSITION, down, index, nearest, to_f64, to_i64};

pub struct Picture<'a> {
    pub pixels: &'a [u8],
    pub width: i64,
    pub height: i64,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    pub columns: i64,
    pub rows: i64,
    pub pixels: Vec<f64>,
}

impl Patch {
    /// Copies a rectangle of the patch; `None` if the rectangle reaches outside.
    pub fn cut(&self, x: i64, y: i64, columns: i64, rows: i64) -> Option<Self> {
        let inside = x >= 0 && y >= 0 && x + columns <= self.columns && y + rows <= self.rows;
        let pixels = || (y..y + rows).flat_map(|row| self.row(x, row, columns)).copied().collect();
        inside.then(|| Self { columns, rows, pixels: pixels() })
    }

    pub fn row(&self, x: i64, y: i64, count: i64) -> &[f64] {
        let from = index(y * self.columns + x);
        &self.pixels[from..from + index(count)]
    }
}

/// Size of the template in pixels (`columns`, `rows`) and of the filter in cells (`across`, `down`). `step` is the
/// distance of neighbouring template pixels at scale 1, in frame pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    pub columns: i64,
    pub rows: i64,
    pub across: i64,
    pub down: i64,
    pub step: f64,
}

impl Shape {
    /// Shape for a box of `width` x `height` frame pixels; `step` is sqrt(area of the box / `pixels`), at least
    /// `least_step`. The sides of filter and template are rounded, the template's to even numbers. The longer side of
    /// each is shortened until the filter has at most `most_cells` cells and the template at most `pixels` pixels.
    pub fn new(numbers: &Numbers, width: i64, height: i64) -> Self {
        let area = to_f64(width * height);
        let step = down((area / to_f64(numbers.pixels)).sqrt(), POSITION).max(numbers.least_step);
        let (filter, bbox) = numbers.filter_over_box;
        let cells = |size: i64| to_i64(nearest(filter * to_f64(size) / (bbox * to_f64(numbers.cell) * step), 1.0));
        let cells = |size: i64| cells(size).clamp(numbers.least_side, numbers.most_side);
        let (across, down) = fitting(cells(width), cells(height), numbers.most_cells);
        let half = |size: i64, cells: i64| {
            to_i64(nearest(to_f64(size) / (2.0 * step), 1.0)).clamp(2, (cells * numbers.cell).max(4) / 2)
        };
        let (columns, rows) = fitting(half(width, across), half(height, down), numbers.pixels / 4);
        Self { columns: 2 * columns, rows: 2 * rows, across, down, step }
    }

    pub fn step_at(&self, scale: f64) -> f64 {
        down(self.step * scale, POSITION).max(1.0 / POSITION)
    }
}

/// Shortens the longer side (`down` if the sides are equal) until the area is at most `most`.
fn fitting(mut across: i64, mut down: i64, most: i64) -> (i64, i64) {
    while across * down > most {
        if across > down {
            across -= 1;
        } else {
            down -= 1;
        }
    }
    (across, down)
}

/// Grid of sample positions around the centre (`x`, `y`): columns are `step` frame pixels apart, rows `step_down`.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    pub x: f64,
    pub y: f64,
    pub step: f64,
    pub step_down: f64,
    pub columns: i64,
    pub rows: i64,
}

/// Linear interpolation on one axis from block number `first` of frame pixels to `second`; `part`: weight of `second`.
struct Interpolation {
    first: i64,
    second: i64,
    part: f64,
}

impl Lattice {
    pub fn sample(&self, numbers: &Numbers, frame: &Picture<'_>) -> Patch {
        let block = self.block(numbers);
        let across = between(self.x, self.step, self.columns, &block, frame.width);
        let down = between(self.y, self.step_down, self.rows, &block, frame.height);
        let pixel = |row: &Interpolation, column: &Interpolation| {
            let mix = |row: i64| {
                let (left, right) = (block.mean(frame, column.first, row), block.mean(frame, column.second, row));
                left * (1.0 - column.part) + right * column.part
            };
            nearest(mix(row.first) * (1.0 - row.part) + mix(row.second) * row.part, 1.0)
        };
        let pixels = down.iter().flat_map(|row| across.iter().map(move |column| pixel(row, column))).collect();
        Patch { columns: self.columns, rows: self.rows, pixels }
    }

    /// Bounds (left, top, right, bottom) of the frame pixels that `sample` reads.
    pub fn region(&self, numbers: &Numbers, frame_size: (i64, i64)) -> [i64; 4] {
        let block = self.block(numbers);
        let extent = |centre: f64, step: f64, count: i64, size: i64| {
            let samples = between(centre, step, count, &block, size);
            let last = samples.last().map_or(0, |sample| sample.second);
            (samples.first().map_or(0, |sample| sample.first) * block.side, ((last + 1) * block.side).min(size))
        };
        let (left, right) = extent(self.x, self.step, self.columns, frame_size.0);
        let (top, bottom) = extent(self.y, self.step_down, self.rows, frame_size.1);
        [left, top, right, bottom]
    }

    /// Block to average before interpolation: its side doubles from 1 pixel until twice the side exceeds the mean of
    /// `step` and `step_down`.
    fn block(&self, numbers: &Numbers) -> Block {
        let mut side = 1;
        while (self.step + self.step_down) / 2.0 / to_f64(side) >= 2.0 {
            side *= 2;
        }
        Block::new(side, numbers.read_per_side)
    }
}

/// Square block of frame pixels, of which only the offsets in `read` are read on each axis.
struct Block {
    side: i64,
    read: Vec<i64>,
}

impl Block {
    /// Divides each axis into `parts` equal parts and reads each part's middle pixel (the second of two middle pixels).
    fn new(side: i64, parts: i64) -> Self {
        let middle = |part: i64| to_i64((to_f64(side) * (to_f64(part) + 0.5) / to_f64(parts)).floor());
        Self { side, read: (0..parts).map(middle).collect() }
    }

    fn middle(&self) -> f64 {
        mean(self.read.iter().map(|&at| to_f64(at)))
    }

    /// Mean of the pixels that are read, in whole gray levels. Beyond the frame its edge pixels are repeated.
    fn mean(&self, frame: &Picture<'_>, column: i64, row: i64) -> f64 {
        let pixel = |x: i64, y: i64| {
            let (x, y) = (x.min(frame.width - 1), y.min(frame.height - 1));
            f64::from(frame.pixels[index(y * frame.width + x)])
        };
        let all = self.read.iter().flat_map(|down| self.read.iter().map(move |across| (across, down)));
        nearest(mean(all.map(|(across, down)| pixel(column * self.side + across, row * self.side + down))), 1.0)
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Interpolations for `count` sample positions on one axis. The first and last whole blocks repeat outward.
fn between(centre: f64, step: f64, count: i64, block: &Block, size: i64) -> Vec<Interpolation> {
    let first_pixel = centre - down(to_f64(count - 1) * step / 2.0, POSITION);
    let side = to_f64(block.side);
    let first = down((first_pixel - block.middle()) / side, POSITION);
    let step = down(step / side, POSITION);
    let last_block = (size / block.side).max(1) - 1;
    let sample = |number: i64| {
        let position = (first + to_f64(number) * step).clamp(0.0, to_f64(last_block));
        let block = to_i64(position.floor());
        Interpolation { first: block, second: (block + 1).min(last_block), part: down(position.fract(), FINE) }
    };
    (0..count).map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_larger_blocks_four_pixels_are_read() {
        let read = |side| (Block::new(side, 2).read, Block::new(side, 2).middle());
        assert_eq!(read(1), (vec![0, 0], 0.0));
        assert_eq!(read(2), (vec![0, 1], 0.5));
        assert_eq!(read(4), (vec![1, 3], 2.0));
        assert_eq!(read(1024), (vec![256, 768], 512.0));
        // Only the second and fourth columns of each four are read; the frame's only row is repeated.
        let frame = Picture { pixels: &[9, 10, 9, 20, 9, 30, 9, 50], width: 8, height: 1 };
        let lattice = Lattice { x: 4.0, y: 0.0, step: 4.0, step_down: 4.0, columns: 2, rows: 1 };
        assert_eq!(lattice.sample(&Numbers::refined(), &frame).pixels, [15.0, 40.0]);
    }

    #[test]
    fn large_and_small_boxes_have_templates_of_about_as_many_pixels() {
        let shape = |width, height| {
            let Shape { columns, rows, across, down, step } = Shape::new(&Numbers::refined(), width, height);
            (columns, rows, across, down, step)
        };
        assert_eq!(shape(80, 80), (40, 40, 14, 14, 2.0));
        assert_eq!(shape(10, 8), (20, 16, 7, 6, 0.5));
        assert_eq!(shape(1, 1), (4, 4, 4, 4, 0.5));
        assert_eq!(shape(1000, 10), (128, 4, 32, 4, 2.5));
    }
}
