//! One frame with all its boxes, for the page's template.

use super::coinciding_boxes::turns;
use super::film::{Film, Still};
use super::palette::TRUTH_LOOK;
use super::trackers::look_of;
use crate::encode;
use anyhow::Result;
use serde::Serialize;
use smr_evaluation::{Evidence, name_of};
use smr_recordings::BoundingBox;

/// In place of the state, before a target's first box.
const NOT_BEGUN: &str = "not begun";

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
        let begun = |method: &usize| still.index >= film.begins(*method);
        for method in (0..film.methods.len()).filter(begun) {
            let (look, sight) = (look_of(film, method), &still.sights[method]);
            match moment.reports[method].target {
                Some(_) => found.push(("method", look, sight.bbox)),
                None => lasts.push(Outline { class: "method last", bbox: sight.bbox, look, place: 0, sharing: 1 }),
            }
        }
        found.extend(film.truth_at(still.index).map(|truth| ("truth", TRUTH_LOOK, truth)));
        let turns = turns(&found.iter().map(|(_, _, bbox)| *bbox).collect::<Vec<_>>());
        let outline = |((class, look, bbox), (place, sharing))| Outline { class, bbox, look, place, sharing };
        let evidence = moment.reports.iter().enumerate();
        let evidence = evidence.filter_map(|(method, report)| Some((film.title(method), report.evidence?)));
        Ok(Self {
            number: still.index + film.first,
            state: if begun(&0) { name_of(moment.first().state) } else { NOT_BEGUN },
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
