//! Intersection over union (IoU): how well two boxes agree.
//!
//! IoU = area of what both cover / area of what at least one covers

use super::BoundingBox;

impl BoundingBox {
    /// Intersection over union, 0 to 1; 0 if neither has an area.
    pub fn iou(&self, other: &Self) -> f64 {
        let shared =
            overlap(self.x, self.width, other.x, other.width) * overlap(self.y, self.height, other.y, other.height);
        let union = self.area() + other.area() - shared;
        // Far from the origin what is shared can be rounded to more than there is.
        if union > 0.0 { (shared / union).min(1.0) } else { 0.0 }
    }

    fn area(&self) -> f64 {
        self.width.max(0.0) * self.height.max(0.0)
    }
}

fn overlap(a: f64, a_size: f64, b: f64, b_size: f64) -> f64 {
    ((a + a_size).min(b + b_size) - a.max(b)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxed([x, y, width, height]: [f64; 4]) -> BoundingBox {
        BoundingBox { x, y, width, height }
    }

    #[test]
    fn intersection_over_union() {
        let [one, none] = [[0.0, 0.0, 10.0, 10.0], [2.0, 2.0, 0.0, 0.0]].map(boxed);
        assert_eq!(one.iou(&boxed([5.0, 0.0, 10.0, 10.0])), 1.0 / 3.0);
        assert_eq!(one.iou(&boxed([10.0, 0.0, 10.0, 10.0])), 0.0);
        assert_eq!([one.iou(&one), one.iou(&none), none.iou(&none)], [1.0, 0.0, 0.0]);
        let far = boxed([-1.0, 8223.0, 1.0, 0.2]);
        assert!(far.iou(&far) <= 1.0, "{}", far.iou(&far));
    }

    proptest! {
        #[test]
        fn iou_is_symmetric_and_bounded(numbers in proptest::array::uniform8(0.0..6e4)) {
            let [x1, y1, w1, h1, x2, y2, w2, h2] = numbers;
            let [a, b] = [[x1 - 3e4, y1 - 3e4, w1, h1], [x2 - 3e4, y2 - 3e4, w2, h2]].map(boxed);
            prop_assert_eq!(a.iou(&b), b.iou(&a));
            prop_assert!((0.0..=1.0).contains(&a.iou(&b)));
        }
    }
}
