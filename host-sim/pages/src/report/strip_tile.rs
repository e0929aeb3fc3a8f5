//! One frame of the film strip with all its boxes, for the page's template.

use super::coinciding_boxes::turns;
use super::film::{Film, Still};
use super::palette::TRUTH_LOOK;
use super::trackers::look_of;
use crate::encode;
use anyhow::Result;
use minijinja::context;
use minijinja::value::{Serde, Value};
use smr_evaluation::name_of;
use smr_recordings::BoundingBox;

/// In place of the state, before a target's first box.
const NOT_BEGUN: &str = "not begun";

pub(super) fn tile(film: &Film, still: &Still) -> Result<Value> {
    let moment = &film.moments[still.index];
    // Later ones lie on top. Boxes that share a line have places on it.
    let outline = |class: &str, look: usize, bbox: BoundingBox, (place, sharing): (usize, usize)| context! { class, bbox => Serde(bbox), look, place, sharing };
    let (mut boxes, mut found) = (Vec::new(), Vec::new());
    let begun = |method: &usize| still.index >= film.begins(*method);
    for method in (0..film.methods.len()).filter(begun) {
        let (look, sight) = (look_of(film, method), &still.sights[method]);
        match moment.reports[method].target {
            Some(_) => found.push(("method", look, sight.bbox)),
            None => boxes.push(outline("method last", look, sight.bbox, (0, 1))),
        }
    }
    found.extend(film.truth_at(still.index).map(|truth| ("truth", TRUTH_LOOK, truth)));
    let turns = turns(&found.iter().map(|(_, _, bbox)| *bbox).collect::<Vec<_>>());
    boxes.extend(found.into_iter().zip(turns).map(|((class, look, bbox), turn)| outline(class, look, bbox, turn)));
    let evidence = moment.reports.iter().enumerate();
    let evidence = evidence.filter_map(|(method, report)| Some((film.title(method), report.evidence?)));
    Ok(context! {
        number => still.index + film.first,
        time => film.clock(still.index),
        is_locked => film.targets.iter().any(|target| target.starts.iter().any(|(index, _)| *index == still.index)),
        state => if begun(&0) { name_of(moment.first().state) } else { NOT_BEGUN },
        method => film.methods[0].name.as_str(),
        picture => encode::data_uri("image/jpeg", &encode::color_jpeg(&still.colors, encode::GOOD)?),
        width => still.frame.width,
        height => still.frame.height,
        margin => film.margin(),
        window => still.window().map(|window| Value::from(Serde(BoundingBox::from(window)))),
        boxes,
        evidence => Serde(evidence.collect::<Vec<_>>()),
    })
}
