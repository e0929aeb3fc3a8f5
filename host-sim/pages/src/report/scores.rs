//! Score tables and plots of the report, as JSON for its template.

use super::film::FilmedRecording;
use super::trackers::{Entrant, entrants};
use anyhow::Result;
use serde_json::{Value, json};
use smr_evaluation::{Curves, FARTHEST, NEAR, Otb, Score};

pub(super) struct Measured<'a> {
    film: &'a FilmedRecording,
    visible: usize,
    scored: Vec<Scored>,
}

struct Scored {
    entrant: Entrant,
    score: Score,
    curves: Curves,
}

type EntrantRow<'a> = (&'a Entrant, Vec<Option<&'a Scored>>);

/// Returns the values that `of` takes from an entrant's scores, one for each recording in which the target is ever
/// visible. `None` if the entrant lacks a score in any recording.
fn known<'a, T>(scored: &[Option<&'a Scored>], of: impl Fn(&'a Scored) -> T) -> Option<Vec<T>> {
    let known = scored.iter().filter(|one| one.is_none_or(|one| one.score.visible > 0));
    known.map(|one| Some(of((*one)?))).collect()
}

impl<'a> Measured<'a> {
    /// Computes the scores of all entrants of a film; `None` without ground truth.
    pub fn new(film: &'a FilmedRecording) -> Result<Option<Self>> {
        let (Some(evaluation), Some(truth)) = (film.evaluation()?, &film.truth) else { return Ok(None) };
        let scored = entrants(film).into_iter().zip(evaluation.scores).map(|(entrant, (_, score))| {
            let curves = Curves::new(&entrant.answers, truth);
            Scored { entrant, score, curves }
        });
        Ok(Some(Self { film, visible: evaluation.visible, scored: scored.collect() }))
    }

    fn of(&self, entrant: &Entrant) -> Option<&Scored> {
        self.scored.iter().find(|scored| scored.entrant.name == entrant.name)
    }

    fn table(&'a self) -> Value {
        let figures = || Score::FIGURES.iter().filter(|figure| !figure.page.is_empty());
        let line = |one: &'a Scored| (&one.entrant, figures().map(|figure| (figure.of)(&one.score)).collect());
        let caption = format!("{} frames, the target is visible in {}", self.film.moments.len(), self.visible);
        let columns = figures().map(|figure| (figure.page.to_owned(), figure.digits, figure.is_ranked));
        table(&caption, columns, &self.scored.iter().map(line).collect::<Vec<_>>())
    }
}

/// Returns the table and plots over all recordings and, if there are several, a table for each; `None` without scores.
pub(super) fn scores<'a>(measured: &'a [Measured<'a>]) -> Option<Value> {
    let rows = rows(measured);
    let (table, each) = match measured {
        [] => return None,
        [one] => (one.table(), Vec::new()),
        all => (across(all, &rows), all.iter().map(|one| (one.film.name.as_str(), one.table())).collect()),
    };
    Some(json!({ "table": table, "plots": plots(&rows), "each": each }))
}

fn rows<'a>(measured: &'a [Measured<'a>]) -> Vec<EntrantRow<'a>> {
    let mut rows: Vec<EntrantRow<'_>> = Vec::new();
    for Scored { entrant, .. } in measured.iter().flat_map(|one| &one.scored) {
        if rows.iter().all(|(known, _)| known.name != entrant.name) {
            rows.push((entrant, measured.iter().map(|one| one.of(entrant)).collect()));
        }
    }
    rows
}

fn across<'a>(measured: &[Measured<'a>], rows: &[EntrantRow<'a>]) -> Value {
    let correct = measured.iter().map(|one| (format!("{} (of {})", one.film.name, one.visible), 0, true));
    let visible: usize = measured.iter().map(|one| one.visible).sum();
    let all = [(format!("all (of {visible})"), 0), ("OTB AUC".to_owned(), 3), ("OTB P20".to_owned(), 3)];
    let columns = correct.chain(all.map(|(title, digits)| (title, digits, true)));
    let line = |(entrant, scored): &EntrantRow<'a>| {
        let mut values: Vec<_> = scored.iter().map(|one| Some(one.as_ref()?.score.correct as f64)).collect();
        let all: Option<f64> = values.iter().copied().sum();
        let otb: Option<Vec<Otb>> = known(scored, |one| one.score.otb).into_iter().flatten().collect();
        let otb = otb.filter(|otb| !otb.is_empty());
        let mean =
            |figure: fn(&Otb) -> f64| otb.as_ref().map(|otb| otb.iter().map(figure).sum::<f64>() / otb.len() as f64);
        values.extend([all, mean(|otb| otb.otb_auc), mean(|otb| otb.otb_precision)]);
        (*entrant, values)
    };
    let caption = "Correct frames of each recording; OTB AUC and OTB P20 are means over the recordings";
    table(caption, columns, &rows.iter().map(line).collect::<Vec<_>>())
}

/// Returns a table as JSON. A column is (title, decimals, true to mark its largest value as the best).
fn table(
    caption: &str,
    columns: impl Iterator<Item = (String, usize, bool)>,
    lines: &[(&Entrant, Vec<Option<f64>>)],
) -> Value {
    let best = |column: usize| lines.iter().filter_map(|(_, values)| values[column]).max_by(f64::total_cmp);
    let column = |(at, (title, digits, ranked))| json!({ "title": title, "digits": digits, "best": best(at).filter(|_| ranked && lines.len() > 1) });
    let line = |(entrant, values): &(&Entrant, Vec<_>)| json!({ "entrant": entrant, "values": values });
    json!({
        "caption": caption,
        "columns": columns.enumerate().map(column).collect::<Value>(),
        "lines": lines.iter().map(line).collect::<Value>(),
    })
}

/// Returns the success and the precision plot: mean curves over the recordings, of entrants that are in all of them.
fn plots<'a>(rows: &[EntrantRow<'a>]) -> [Value; 2] {
    let mean = |(entrant, scored): &EntrantRow<'a>| Some((*entrant, Curves::mean(&known(scored, |one| &one.curves)?)?));
    let means: Vec<(&Entrant, Curves)> = rows.iter().filter_map(mean).collect();
    let lines = |area: fn(&Curves) -> f64, values: fn(&Curves) -> &Vec<f64>| {
        let mut lines: Vec<_> = means.iter().map(|(entrant, curves)| (area(curves), entrant, values(curves))).collect();
        lines.sort_by(|a, b| b.0.total_cmp(&a.0));
        let line = |(area, entrant, values)| json!({ "entrant": entrant, "area": area, "values": values });
        lines.into_iter().map(line).collect::<Value>()
    };
    [
        json!({
            "title": "Success: visible frames with an IoU above",
            "axis": "IoU",
            "most": 1.0,
            "digits": 1,
            "mark": null,
            "lines": lines(Curves::auc, |curves| &curves.success),
        }),
        json!({
            "title": "Precision: visible frames within a distance",
            "axis": "centre error in pixels",
            "most": FARTHEST as f64,
            "digits": 0,
            "mark": NEAR as f64,
            "lines": lines(Curves::precision_area, |curves| &curves.precision),
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use smr_evaluation::STEPS;

    #[test]
    fn the_largest_area_is_named_first_and_who_is_not_everywhere_is_not_named() {
        let scored = |name: &str, part: f64| Scored {
            entrant: Entrant {
                name: name.into(),
                title: name.into(),
                short: name.into(),
                look: 0,
                answers: vec![],
                method: None,
            },
            score: Score { visible: 1, ..Score::default() },
            curves: Curves { success: vec![part; STEPS + 1], precision: vec![part; FARTHEST + 1] },
        };
        let all = [scored("low", 0.25), scored("high", 0.75), scored("partly", 1.0)];
        let row =
            |scored: usize| (&all[scored].entrant, vec![Some(&all[scored]), (scored < 2).then_some(&all[scored])]);
        for plot in plots(&[0, 1, 2].map(row)) {
            let lines = plot["lines"].as_array().unwrap().iter();
            let lines: Vec<_> = lines.map(|line| (&line["entrant"]["name"], &line["area"])).collect();
            assert_eq!(lines, [(&json!("high"), &json!(0.75)), (&json!("low"), &json!(0.25))]);
        }
    }
}
