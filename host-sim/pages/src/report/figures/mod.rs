//! The five figures of the paper, of any recording: SMR beside SAD.
//!
//! A recording is followed twice: first for what happens in it, then for the pictures of the frames that are shown.

mod boxes;
mod differences;
mod drawing;
mod drift;
mod leaving;
mod occlusion;

use super::film::{Film, Still};
use anyhow::{Context, Result, bail, ensure};
use smr_evaluation::MethodKind;
use smr_recordings::FrameRange;
use std::fmt;

pub use drawing::Sheet;

/// Methods in the figures.
pub const METHODS: [MethodKind; 2] = [MethodKind::Smr, MethodKind::Sad];
const SMR: usize = 0;
const SAD: usize = 1;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Figure {
    Boxes,
    Differences,
    Leaving,
    Drift,
    Occlusion,
}

impl Figure {
    pub const ALL: [Self; 5] = [Self::Boxes, Self::Differences, Self::Leaving, Self::Drift, Self::Occlusion];

    pub const fn number(self) -> usize {
        self as usize + 1
    }

    pub const fn name(self) -> &'static str {
        match self {
            Self::Boxes => "boxes",
            Self::Differences => "differences",
            Self::Leaving => "leaving",
            Self::Drift => "drift",
            Self::Occlusion => "occlusion",
        }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.number(), self.name())
    }
}

/// Frames that the user names. The command chooses the others by the states.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wish {
    /// Frame of the boxes and the differences; the first is 0.
    pub frame: Option<usize>,
    /// Frames in which the target is hidden.
    pub hidden: Option<FrameRange>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    pub figure: Figure,
    /// The frames whose pictures are in it, in order; the first is 0.
    pub frames: Vec<usize>,
    /// First and last frame in which the target is hidden.
    hidden: Option<(usize, usize)>,
}

impl Plan {
    /// Chosen by what happened.
    /// Errors: What the figure needs is not in the recording, or in its ground truth.
    pub fn new(figure: Figure, film: &Film, wish: &Wish) -> Result<Self> {
        let chosen = match figure {
            Figure::Boxes => boxes::frame(film, wish.frame).map(|frame| (vec![frame], None)),
            Figure::Differences => differences::frame(film, wish.frame).map(|frame| (vec![frame], None)),
            Figure::Leaving => leaving::frames(film).map(|frames| (frames, None)),
            Figure::Drift => drift::possible(film).map(|()| (Vec::new(), None)),
            Figure::Occlusion => {
                occlusion::span(film, wish.hidden).map(|span| (occlusion::frames(film, span), Some(span)))
            }
        };
        let (frames, hidden) =
            chosen.with_context(|| format!("{}: no figure {} ({})", film.name, figure.number(), figure.name()))?;
        Ok(Self { figure, frames, hidden })
    }

    /// Draws it. The film has the frames of the plan as its stills, and maybe others.
    pub fn draw(&self, film: &Film) -> Result<Sheet> {
        let stills = self.frames.iter().map(|&index| still(film, index)).collect::<Result<Vec<_>>>()?;
        match (self.figure, &stills[..]) {
            (Figure::Boxes, [still]) => boxes::draw(film, still),
            (Figure::Differences, [still]) => differences::draw(film, still),
            (Figure::Leaving, stills) => leaving::draw(film, stills),
            (Figure::Drift, _) => Ok(drift::draw(film)),
            (Figure::Occlusion, stills) => occlusion::draw(film, stills, self.hidden.context("a span")?),
            (Figure::Boxes | Figure::Differences, _) => bail!("the figure is of one frame"),
        }
    }
}

fn still(film: &Film, index: usize) -> Result<&Still> {
    film.stills.iter().find(|still| still.index == index).context("the frames of the plan are kept")
}

/// The frame that is asked for, if there is such a one with something to compare.
fn asked(film: &Film, frame: usize) -> Result<usize> {
    let length = film.moments.len();
    ensure!((1..length).contains(&frame), "frame {} compares nothing: expected 2 to {length}", frame + 1);
    Ok(frame)
}

/// Lead of SMR over SAD in a frame: the difference of their IoU with the ground truth, else 1 minus the IoU of both.
fn lead(film: &Film, index: usize) -> Option<f64> {
    let answer = |method: usize| film.moments[index].reports[method].target;
    let smr = answer(SMR)?;
    match (&film.truth, film.truth_at(index)) {
        (Some(_), None) => None,
        (_, Some(truth)) => Some(smr.iou(&truth) - answer(SAD).map_or(0.0, |sad| sad.iou(&truth))),
        (None, None) => answer(SAD).map(|sad| 1.0 - smr.iou(&sad)),
    }
}

/// The first frame in which they differ most to the advantage of SMR.
fn clearest(film: &Film) -> Option<usize> {
    let leads = (1..film.moments.len()).filter_map(|index| Some((index, lead(film, index)?)));
    leads.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map(|best| best.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::canvas::Canvas;
    use crate::report::{Refusal, watch};
    use smr_core::paper::Config;
    use smr_evaluation::{Configs, Variant};
    use smr_recordings::{OpenOptions, Sequence, synthetic};
    use std::path::Path;
    use std::sync::OnceLock;

    fn open(name: &str) -> Sequence {
        smr_recordings::open(Path::new(name), &OpenOptions::default()).unwrap()
    }

    fn watched(sequence: Sequence, frames: &[usize]) -> Film {
        let configs = Configs::from(Config::paper());
        let methods = METHODS.map(|kind| Variant::new(kind, &configs));
        watch(sequence, &methods, Refusal::Fails, &frames.iter().copied().collect(), None, || ()).unwrap()
    }

    /// The film of the built-in recording, without pictures.
    fn synthetic() -> &'static Film {
        static FILM: OnceLock<Film> = OnceLock::new();
        FILM.get_or_init(|| watched(open(synthetic::NAME), &[]))
    }

    /// Both files of a figure of `film`, which is of the recording `name`, read back.
    fn drawn(name: &str, film: &Film, figure: Figure, wish: &Wish) -> (Plan, String, Canvas) {
        let plan = Plan::new(figure, film, wish).unwrap();
        let sheet = plan.draw(&watched(open(name), &plan.frames)).unwrap();
        let svg = sheet.svg().unwrap();
        let png = Canvas::decoded(&sheet.png().unwrap());
        assert_eq!((png.width, png.height), sheet.size);
        (plan, svg, png)
    }

    #[test]
    fn all_five_from_the_built_in_recordings() {
        for figure in Figure::ALL {
            let (plan, svg, png) = drawn(synthetic::NAME, synthetic(), figure, &Wish::default());
            let colors = [crate::colors::SMR, crate::colors::SAD];
            for color in colors.iter().skip(usize::from(figure == Figure::Leaving)) {
                assert!(png.pixels.contains(color), "{figure}: {color:?}");
            }
            // Each tile is a frame, in JPEG; patches are PNG.
            assert_eq!(
                svg.matches("data:image/jpeg").count(),
                if figure == Figure::Differences { 0 } else { plan.frames.len() },
                "{figure}"
            );
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"), "{figure}");
        }
        let (plan, ..) = drawn("border", &watched(open("border"), &[]), Figure::Leaving, &Wish::default());
        assert!(plan.frames.len() > 1, "{plan:?}");
    }

    #[test]
    fn the_frame_can_be_chosen() {
        for figure in [Figure::Boxes, Figure::Differences] {
            let (plan, svg, _) =
                drawn(synthetic::NAME, synthetic(), figure, &Wish { frame: Some(59), ..Wish::default() });
            assert_eq!(plan.frames, [59]);
            assert!(svg.contains("frame 60"), "{figure}");
            for frame in [0, 240] {
                let error =
                    Plan::new(figure, synthetic(), &Wish { frame: Some(frame), ..Wish::default() }).unwrap_err();
                let expected = format!("frame {} compares nothing: expected 2 to 240", frame + 1);
                assert!(format!("{error:#}").ends_with(&expected), "{error:#}");
            }
        }
    }

    #[test]
    fn what_the_recording_does_not_have_is_said() {
        let error = |film: &Film, figure, wish: &Wish| format!("{:#}", Plan::new(figure, film, wish).unwrap_err());
        let blind = watched(Sequence { truth: None, ..open(synthetic::NAME) }, &[]);
        for figure in [Figure::Differences, Figure::Drift, Figure::Occlusion] {
            let said = error(&blind, figure, &Wish::default());
            assert!(said.starts_with("synthetic: no figure ") && said.contains("needs ground truth"), "{said}");
        }
        // Boxes need none, nor does leaving.
        for figure in [Figure::Boxes, Figure::Leaving] {
            assert!(Plan::new(figure, &blind, &Wish::default()).is_ok(), "{figure}");
        }
        let still = error(&watched(open("noise"), &[]), Figure::Leaving, &Wish::default());
        assert!(still.contains("never reaches over the border"), "{still}");
        let hidden = error(synthetic(), Figure::Differences, &Wish { frame: Some(185), hidden: None });
        assert!(hidden.contains("frame 186"), "{hidden}");
        let mut visible = open(synthetic::NAME);
        visible.truth = visible.truth.map(|truth| vec![truth[0]; 240]);
        let said = error(&watched(visible, &[]), Figure::Occlusion, &Wish::default());
        assert!(said.contains("--hidden A..B"), "{said}");
        let late = Wish { hidden: Some("200..300".parse().unwrap()), frame: None };
        assert!(error(synthetic(), Figure::Occlusion, &late).contains("expected frames of 2..240"));
    }

    #[test]
    fn the_hidden_span_is_the_one_of_the_ground_truth_or_the_one_that_is_given() {
        let plan = |wish: &Wish| Plan::new(Figure::Occlusion, synthetic(), wish).unwrap();
        assert_eq!(plan(&Wish::default()).hidden, Some((173, 199)));
        assert_eq!(plan(&Wish { hidden: Some("82..130".parse().unwrap()), frame: None }).hidden, Some((81, 129)));
    }
}
