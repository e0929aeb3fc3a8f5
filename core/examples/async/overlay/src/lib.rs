//! Draws a tracker's answer on a display of embedded-graphics: the box and the state's name, in the state's color.
//!
//! ```
//! use embedded_graphics::mock_display::MockDisplay;
//! use embedded_graphics::pixelcolor::Rgb888;
//! use embedded_graphics::prelude::*;
//! use overlay::{Colors, draw};
//! use smr_core::{Rect, State};
//!
//! const COLORS: Colors<Rgb888> =
//!     Colors { tracking: Rgb888::GREEN, uncertain: Rgb888::YELLOW, lost: Rgb888::RED };
//! let mut display = MockDisplay::new(); // yours: any `DrawTarget`
//! display.set_allow_overdraw(true);
//!
//! // In a program, after the camera's picture: `draw(&mut display, answer.bbox, answer.state, your_own_colors)?`.
//! draw(&mut display, Rect::new(2, 14, 20, 16), State::Tracking, COLORS)?; // the box and the state's name
//! assert_eq!(display.get_pixel(Point::new(2, 14)), Some(Rgb888::GREEN));
//! # Ok::<(), core::convert::Infallible>(())
//! ```

#![no_std]
#![deny(missing_docs)]

use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::FONT_6X10;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{PrimitiveStyle, Rectangle};
use embedded_graphics::text::{Baseline, Text};
use smr_core::{Rect, State};

/// Space between the box and the name, in pixels.
const GAP: i32 = 2;

/// A color for each state. A target that is leaving the frame has the color of `tracking`.
#[derive(Clone, Copy, Debug)]
pub struct Colors<C> {
    /// Color while the target is in the box.
    pub tracking: C,
    /// Color while the box may contain something else.
    pub uncertain: C,
    /// Color while the target is not visible.
    pub lost: C,
}

impl<C: Copy> Colors<C> {
    fn of(self, state: State) -> C {
        match state {
            State::Tracking | State::Leaving => self.tracking,
            State::Lost => self.lost,
            _ => self.uncertain,
        }
    }
}

/// Draws the box, and the state's name above it, or below it for lack of room. Both are clipped at the display's edges.
///
/// # Errors
/// Errors of the display.
pub fn draw<D: DrawTarget>(
    display: &mut D,
    bbox: Rect,
    state: State,
    colors: Colors<D::Color>,
) -> Result<(), D::Error> {
    let area = display.bounding_box();
    let Some(corner) = area.bottom_right() else { return Ok(()) };
    let left_or_above = bbox.right() <= area.top_left.x || bbox.bottom() <= area.top_left.y;
    // Skips a box outside the display: coordinates far outside would overflow in embedded-graphics.
    if left_or_above || bbox.x > corner.x || bbox.y > corner.y {
        return Ok(());
    }
    let color = colors.of(state);
    let frame = Rectangle::new(Point::new(bbox.x, bbox.y), Size::new(bbox.width.into(), bbox.height.into()));
    frame.into_styled(PrimitiveStyle::with_stroke(color, 1)).draw(display)?;

    let text = Text::with_baseline(name(state), Point::zero(), MonoTextStyle::new(&FONT_6X10, color), Baseline::Top);
    let height = i32::try_from(FONT_6X10.character_size.height).unwrap_or(0);
    let above = bbox.y.saturating_sub(height + GAP);
    let y = if above < area.top_left.y { bbox.bottom().saturating_add(GAP) } else { above };
    text.translate(Point::new(bbox.x, y)).draw(display)?;
    Ok(())
}

const fn name(state: State) -> &'static str {
    state.name()
}

#[cfg(test)]
mod tests {
    use super::{Colors, draw};
    use embedded_graphics::mock_display::MockDisplay;
    use embedded_graphics::pixelcolor::Rgb888;
    use embedded_graphics::prelude::*;
    use smr_core::{Rect, State};

    const COLORS: Colors<Rgb888> = Colors { tracking: Rgb888::GREEN, uncertain: Rgb888::YELLOW, lost: Rgb888::RED };

    fn drawn(bbox: Rect, state: State) -> MockDisplay<Rgb888> {
        let mut display = MockDisplay::new();
        display.set_allow_out_of_bounds_drawing(true);
        let Ok(()) = draw(&mut display, bbox, state, COLORS);
        display
    }

    #[test]
    fn box_and_name_are_drawn_in_the_color_of_the_state() {
        let display = drawn(Rect::new(0, 12, 26, 4), State::Lost);
        display.assert_pattern(&[
            "                          ",
            " RR                R      ",
            "  R                R      ",
            "  R    RRR   RRR  RRRR    ",
            "  R   R   R R      R      ",
            "  R   R   R  RRR   R      ",
            "  R   R   R     R  R  R   ",
            " RRR   RRR  RRRR    RR    ",
            "                          ",
            "                          ",
            "                          ",
            "                          ",
            "RRRRRRRRRRRRRRRRRRRRRRRRRR",
            "R                        R",
            "R                        R",
            "RRRRRRRRRRRRRRRRRRRRRRRRRR",
        ]);
        for (state, color) in
            [(State::Tracking, Rgb888::GREEN), (State::Leaving, Rgb888::GREEN), (State::Uncertain, Rgb888::YELLOW)]
        {
            assert_eq!(drawn(Rect::new(5, 20, 9, 9), state).get_pixel(Point::new(13, 28)), Some(color));
        }
    }

    #[test]
    fn without_room_above_the_name_is_below() {
        let display = drawn(Rect::new(3, 1, 20, 10), State::Tracking);
        let rows = display.affected_area();
        assert_eq!((rows.top_left.y, rows.bottom_right().map(|corner| corner.y > 13)), (1, Some(true)));
    }

    #[test]
    fn boxes_partly_or_wholly_outside_the_display_are_clipped() {
        let display = drawn(Rect::new(-5, 40, 20, 60), State::Tracking);
        assert_eq!(display.get_pixel(Point::new(14, 63)), Some(Rgb888::GREEN));
        for far in [Rect::new(i32::MIN, i32::MIN, 9, 9), Rect::new(i32::MAX, i32::MAX, u16::MAX, u16::MAX)] {
            assert!(drawn(far, State::Lost).affected_area().is_zero_sized());
        }
    }
}
