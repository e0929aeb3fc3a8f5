//! NCC: the correlation coefficient, by exact sums over boxes.

use super::{Canvas, Patch};

/// The correlation coefficient at every position of a canvas: exact sums, divided in f64.
pub(super) struct Correlation<'a> {
    canvas: &'a Canvas,
    template: Patch<'a>,
    /// Over all pixels above and to the left: how many times is the sum of a box read, once is it computed.
    sums: Vec<[u64; 2]>,
    template_sum: i64,
    template_spread: i64,
}

impl<'a> Correlation<'a> {
    pub fn new(canvas: &'a Canvas, template: Patch<'a>) -> Self {
        let sum = template.pixels.iter().map(|&g| u64::from(g)).sum();
        let squares = template.pixels.iter().map(|&g| u64::from(g).pow(2)).sum();
        let pixels = template.pixels.len() as u64;
        let (template_sum, template_spread) = (signed(sum), spread(pixels, sum, squares));
        Self { canvas, template, sums: Self::sums(canvas), template_sum, template_spread }
    }

    /// The sums of pixels and of their squares, one row and one column more than the canvas has.
    fn sums(canvas: &Canvas) -> Vec<[u64; 2]> {
        let mut sums = vec![[0; 2]; canvas.stride + 1];
        for row in canvas.pixels.chunks_exact(canvas.stride) {
            let above = sums.len() - canvas.stride;
            let mut so_far = [0; 2];
            sums.push(so_far);
            for (column, &f) in row.iter().enumerate() {
                so_far = [so_far[0] + u64::from(f), so_far[1] + u64::from(f).pow(2)];
                let [sum, squares] = sums[above + column];
                sums.push([sum + so_far[0], squares + so_far[1]]);
            }
        }
        sums
    }

    pub fn at(&self, x: i32, y: i32) -> f64 {
        let [sum, squares] = self.patch_sums(x, y);
        let rows = self.canvas.rows_at(x, y).zip(self.template.pixels.chunks_exact(self.template.width));
        let products: u64 = rows.map(|(f, g)| u64::from(dot(f, g))).sum();
        // All at most 2^40 * 255 * 255 < 2^56: exact as i64, and for templates of up to 65536 pixels as f64, too.
        let pixels = self.template.pixels.len() as u64;
        let common = signed(pixels * products) - signed(sum) * self.template_sum;
        let spreads = (spread(pixels, sum, squares) as f64) * (self.template_spread as f64);
        if spreads == 0.0 { 0.0 } else { common as f64 / spreads.sqrt() }
    }

    fn patch_sums(&self, x: i32, y: i32) -> [u64; 2] {
        let (column, row) = self.canvas.locate(x, y);
        let (width, height) = (self.template.width, self.template.pixels.len() / self.template.width);
        let stride = self.canvas.stride + 1;
        let at = |column: usize, row: usize| self.sums[row * stride + column];
        let (a, b) = (at(column, row), at(column + width, row));
        let (c, d) = (at(column, row + height), at(column + width, row + height));
        [0, 1].map(|i| (d[i] + a[i]) - (b[i] + c[i]))
    }
}

/// The sum of the products of all pairs. If one row is longer, the rest of it is ignored.
fn dot(f: &[u8], g: &[u8]) -> u32 {
    f.iter().zip(g).map(|(&f, &g)| u32::from(f) * u32::from(g)).sum()
}

/// `pixels`^2 times the variance.
fn spread(pixels: u64, sum: u64, squares: u64) -> i64 {
    signed(pixels * squares - sum * sum)
}

fn signed(value: u64) -> i64 {
    i64::try_from(value).expect("sums over at most 2^20 pixels are far below 2^63")
}
