//! Data for the script of the report, as JSON: boxes and scores of every frame, and images of some or all frames.

use super::difference::{BAR, BARS};
use super::film::{FilmedRecording, Locked, Moment};
use super::player_frames::Images;
use super::trackers::{Entrant, TRUTH_LOOK, entrants};
use crate::encode::{base64, rounded};
use anyhow::{Context, Result};
use serde_json::{Value, json};
use smr_evaluation::{Evidence, MethodAnswer, centre_errors, name_of, overlaps};
use smr_recordings::BoundingBox;

/// Returns all films as JSON. `<` is escaped, as `</script>` in a name would end the page's element that holds the
/// JSON. Errors: Ground truth of another length than its film.
pub(super) fn data(films: &[FilmedRecording]) -> Result<String> {
    let recordings = films.iter().map(recording).collect::<Result<Vec<_>>>()?;
    let data = json!({ "bar": BAR, "bars": BARS, "recordings": recordings });
    Ok(data.to_string().replace('<', "\\u003c"))
}

fn recording(film: &FilmedRecording) -> Result<Value> {
    let mut entrants = entrants(film).iter().map(|entrant| figures(film, entrant)).collect::<Result<Vec<_>>>()?;
    entrants.extend(film.truth.as_deref().map(truth_of));
    let margin = film.margin().min(film.overhang());
    let failure = if film.methods.len() > 1 { film.longest_failure(0, 1)? } else { None };
    Ok(json!({
        "name": film.name,
        "width": film.size.0,
        "height": film.size.1,
        "margin": margin,
        "first": film.first,
        "frames": film.moments.len(),
        "times": film.times.iter().any(Option::is_some).then(|| all_rounded(film.times.iter().copied(), 3)),
        "parting": failure.map(|(index, _)| index + film.first),
        "targets": film.targets.iter().map(|target| target_of(film, target)).collect::<Vec<_>>(),
        "entrants": entrants,
        "images": film.images.as_ref().map(images),
    }))
}

fn truth_of(truth: &[Option<BoundingBox>]) -> Value {
    json!({
        "name": "ground truth",
        "title": "ground truth",
        "short": "truth",
        "look": TRUTH_LOOK,
        "method": null,
        "isTruth": true,
        "boxes": boxes(truth),
        "size": sizes(truth),
    })
}

fn target_of(film: &FilmedRecording, target: &Locked) -> Value {
    let locks = target.starts.iter().filter(|(_, bbox)| bbox.is_some()).map(|(index, _)| index + film.first);
    json!({ "name": target.name, "locks": locks.collect::<Vec<_>>() })
}

fn figures(film: &FilmedRecording, entrant: &Entrant) -> Result<Value> {
    let answers = &entrant.answers;
    let reports = |value: &dyn Fn(&MethodAnswer) -> Option<f64>, digits: i32| {
        let values = entrant.method.map(|method| film.moments.iter().map(move |moment| value(&moment.reports[method])));
        values.map(|values| all_rounded(values, digits)).filter(|values| values.iter().any(|value| !value.is_null()))
    };
    let evidence = |value: fn(&Evidence) -> Option<f64>| reports(&|report| report.evidence.as_ref().and_then(value), 3);
    let truth = film.truth.as_deref();
    let iou = truth.map(|truth| overlaps(answers, truth).with_context(|| film.name.clone())).transpose()?;
    let error = truth.map(|truth| centre_errors(answers, truth));
    let of_each = |value: &dyn Fn(usize, usize, &Moment) -> Value| {
        let method = entrant.method?;
        let moments = film.moments.iter().enumerate();
        Some(moments.map(|(index, moment)| value(method, index, moment)).collect::<Vec<_>>())
    };
    let lasts = of_each(&|method, index, moment| {
        let lost = moment.reports[method].target.is_none() && film.has(method, index);
        of_box(lost.then(|| &moment.lasts[method]))
    });
    // The state is null before the target's first box, and while the target is gone.
    let states =
        of_each(&|method, index, moment| film.has(method, index).then(|| name_of(moment.reports[method].state)).into());
    Ok(json!({
        "name": entrant.name,
        "title": entrant.title,
        "short": entrant.short,
        "look": entrant.look,
        "method": entrant.method,
        "target": entrant.method.map(|method| film.method_targets[method]),
        "boxes": boxes(answers),
        "lasts": lasts,
        "states": states,
        "iou": iou.map(|iou| all_rounded(iou.into_iter(), 3)),
        "error": error.map(|error| all_rounded(error.into_iter(), 1)),
        "confidence": evidence(|evidence| Some(evidence.confidence)),
        "ratio": evidence(|evidence| Some(evidence.ratio)),
        "runner_up": evidence(|evidence| evidence.runner_up_ratio),
        "alpha": evidence(|evidence| evidence.alpha.map(f64::from)),
        "identity": evidence(|evidence| evidence.identity),
        "size": sizes(answers),
        "work": reports(&|report| report.work.map(f64::from), 0),
    }))
}

fn images(Images { every, kept, .. }: &Images) -> Value {
    let frames: Vec<String> = kept.iter().map(|image| base64(&image.jpeg)).collect();
    let comparisons: Vec<_> = kept.iter().map(|image| &image.comparisons).collect();
    json!({ "every": every, "frames": frames, "comparisons": comparisons })
}

fn boxes(of: &[Option<BoundingBox>]) -> Vec<Value> {
    of.iter().map(|bbox| of_box(bbox.as_ref())).collect()
}

/// Returns the square root of each box's area, in pixels.
fn sizes(of: &[Option<BoundingBox>]) -> Vec<Value> {
    all_rounded(of.iter().map(|bbox| bbox.map(|bbox| (bbox.width * bbox.height).max(0.0).sqrt())), 1)
}

fn all_rounded(values: impl Iterator<Item = Option<f64>>, digits: i32) -> Vec<Value> {
    values.map(|value| value.map_or(Value::Null, |value| rounded(value, digits))).collect()
}

fn of_box(bbox: Option<&BoundingBox>) -> Value {
    bbox.map_or(Value::Null, |bbox| {
        [bbox.x, bbox.y, bbox.width, bbox.height].map(|side| rounded(side, 2)).to_vec().into()
    })
}
