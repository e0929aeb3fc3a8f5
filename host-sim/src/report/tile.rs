//! One frame with all its boxes, for the page's template.

use super::encode;
use super::film::{Film, Still};
use super::palette::{TRUTH_LOOK, look_of_method};
use super::turns::turns;
use crate::evaluate::{Evidence, name_of};
use crate::sequence::BoundingBox;
use anyhow::Result;
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct Tile {
    number: usize,
    /// By the first method.
    state: &'static str,
    method: String,
    /// A URI.
    picture: String,
    width: u16,
    height: u16,
    /// As much of the padding as boxes reach into.
    margin: u16,
    window: Option<BoundingBox>,
    /// In the order of drawing: later ones lie on top.
    boxes: Vec<Outline>,
    /// By title of the method.
    evidence: Vec<(String, Evidence)>,
}

#[derive(Serialize)]
struct Outline {
    class: &'static str,
    bbox: BoundingBox,
    look: usize,
    /// Its place among so many boxes that share one line.
    place: usize,
    sharing: usize,
}

impl Tile {
    pub fn new(film: &Film, still: &Still) -> Result<Self> {
        let moment = &film.moments[still.index];
        let (mut lasts, mut found) = (Vec::new(), Vec::new());
        for (method, (report, sight)) in film.methods.iter().zip(moment.reports.iter().zip(&still.sights)) {
            let look = look_of_method(method.kind);
            match report.target {
                Some(_) => found.push(("method", look, sight.bbox)),
                None => lasts.push(Outline { class: "method last", bbox: sight.bbox, look, place: 0, sharing: 1 }),
            }
        }
        found.extend(film.truth_at(still.index).map(|truth| ("truth", TRUTH_LOOK, truth)));
        let turns = turns(&found.iter().map(|(_, _, bbox)| *bbox).collect::<Vec<_>>());
        let outline = |((class, look, bbox), (place, sharing))| Outline { class, bbox, look, place, sharing };
        let evidence = film.methods.iter().zip(&moment.reports);
        let evidence = evidence.filter_map(|(method, report)| Some((method.name.to_uppercase(), report.evidence?)));
        Ok(Self {
            number: still.index + film.first,
            state: name_of(moment.first().state),
            method: film.methods[0].name.clone(),
            picture: encode::data_uri("image/jpeg", &encode::jpeg(&still.frame)?),
            width: still.frame.width,
            height: still.frame.height,
            margin: film.margin(),
            window: still.window().map(BoundingBox::from),
            boxes: lasts.into_iter().chain(found.into_iter().zip(turns).map(outline)).collect(),
            evidence: evidence.collect(),
        })
    }
}
