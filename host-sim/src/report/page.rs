//! The whole report as one HTML page that needs nothing else: style, script, pictures and figures are in it.

use super::data::{css, data};
use super::entrants::{Entrant, entrants};
use super::escaped::escaped;
use super::film::{Film, Still};
use super::plot::{self, Line};
use super::{TRUTH, color_of, pictures, tile};
use crate::evaluate::{Curves, Evaluation, Evidence, Otb, Score, name_of};
use anyhow::{Result, ensure};
use smr_core::State;

/// What the foot of the page says.
pub struct About {
    /// Of the whole page.
    pub title: String,
    /// As it was typed.
    pub command_line: String,
    /// All that the methods were built with, as JSON.
    pub options: String,
}

/// The page, of at most `budget` bytes: frames get smaller, then fewer, until it is.
///
/// # Errors
/// No film, ground truth that is not of so many frames, a picture that cannot be encoded, or figures alone that take more than
/// the budget.
pub fn page(films: &mut [Film], about: &About, budget: usize) -> Result<String> {
    loop {
        let page = whole(films, about)?;
        if page.len() <= budget {
            return Ok(page);
        }
        let pictured = films.iter_mut().filter_map(|film| film.pictures.as_mut());
        let largest = pictured.max_by_key(|pictures| pictures.bytes());
        let shrunk = largest.map(pictures::Pictures::shrink).transpose()?.unwrap_or(false);
        let bytes = page.len().div_ceil(1_000_000);
        ensure!(shrunk, "the page has {bytes} MB with next to no frames: expected --budget {bytes} or more");
    }
}

fn whole(films: &[Film], about: &About) -> Result<String> {
    ensure!(!films.is_empty(), "there is no recording to show");
    let scored = films.iter().map(Scored::of).collect::<Result<Vec<_>>>()?;
    let strips = films.iter().map(|film| strip(film, films.len() > 1)).collect::<Result<String>>()?;
    let sections = [
        head(about),
        summary(films, about),
        scores(films, &scored)?,
        player(films),
        strips,
        words(),
        foot(about),
        format!("<script type=\"application/json\" id=\"data\">{}</script>\n", data(films)?),
        format!("<script>\n{}</script>\n</body>\n</html>\n", include_str!("page.js")),
    ];
    Ok(sections.concat())
}

fn head(about: &About) -> String {
    let states = [State::Tracking, State::Leaving, State::Lost].map(|state| (name_of(state), color_of(state)));
    let others = [("truth", TRUTH), ("counts", pictures::counting_color(20))];
    let variables: String =
        states.iter().chain(&others).map(|(name, color)| format!("--{name}: {}; ", css(*color))).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>SMR: {}</title>\n\
         <style>\n:root {{ {variables}}}\n{}</style>\n</head>\n<body>\n",
        escaped(&about.title),
        include_str!("page.css")
    )
}

fn summary(films: &[Film], about: &About) -> String {
    let mut text = format!("<h1>{}</h1>\n", escaped(&about.title));
    if films.len() > 1 {
        let frames: usize = films.iter().map(|film| film.moments.len()).sum();
        return text + &format!("<p>{} recordings with {frames} frames in all.</p>\n", films.len());
    }
    let film = &films[0];
    let first = &film.methods[0];
    let count = |state: State| film.moments.iter().filter(|moment| moment.first().state == state).count();
    let states = first.kind.states().iter().map(|&state| format!("{} in {}", name_of(state), count(state)));
    text += &format!(
        "<p>{} frames of {}x{} pixels, locked on the box of {}. Frames by the state of {}: {}.</p>\n",
        film.moments.len(),
        film.size.0,
        film.size.1,
        tile::words(film.start),
        first.name.to_uppercase(),
        states.collect::<Vec<_>>().join(", ")
    );
    text
}

/// A recording's scores with everyone's curves, in the order of its entrants.
struct Scored {
    evaluation: Evaluation,
    curves: Vec<Curves>,
}

impl Scored {
    /// `None` without ground truth.
    fn of(film: &Film) -> Result<Option<Self>> {
        let (Some(evaluation), Some(truth)) = (film.evaluation()?, &film.truth) else { return Ok(None) };
        let curves = entrants(film).iter().map(|entrant| Curves::new(&entrant.answers, truth)).collect();
        Ok(Some(Self { evaluation, curves }))
    }

    /// Those of the one called `name`.
    fn curves_of(&self, name: &str) -> Option<&Curves> {
        self.place_of(name).map(|place| &self.curves[place])
    }

    fn score_of(&self, name: &str) -> Option<&Score> {
        self.place_of(name).map(|place| &self.evaluation.scores[place].1)
    }

    fn place_of(&self, name: &str) -> Option<usize> {
        self.evaluation.scores.iter().position(|(who, _)| who.name == name)
    }
}

fn scores(films: &[Film], scored: &[Option<Scored>]) -> Result<String> {
    let measured: Vec<(&Film, &Scored)> =
        films.iter().zip(scored).filter_map(|(film, scored)| Some((film, scored.as_ref()?))).collect();
    if measured.is_empty() {
        return Ok(String::new());
    }
    let everyone = everyone(&measured);
    let protocol = "A frame is correct if the intersection over union (IoU) with the ground truth is above 0.25 (TLD \
                    protocol). OTB AUC is the area under the success plot, OTB P20 the part of the visible frames with \
                    a centre error of at most 20 pixels. The best is bold.";
    let mut section = format!("<h2>Scores</h2>\n<p class=\"note\">{protocol}</p>\n");
    if measured.len() > 1 {
        section += &across(&measured, &everyone);
    } else {
        section += &table_of(measured[0].0, measured[0].1);
    }
    let lines: Vec<Line> = everyone
        .iter()
        .filter_map(|entrant| {
            let of: Vec<&Curves> = measured.iter().filter_map(|(_, scored)| scored.curves_of(&entrant.name)).collect();
            let (title, color) = (entrant.title.clone(), entrant.color);
            let mean = (of.len() == measured.len()).then(|| Curves::mean(&of)).flatten();
            mean.map(|curves| Line { title, color, curves })
        })
        .collect();
    section += &plot::plots(&lines);
    if measured.len() > 1 {
        for (film, scored) in &measured {
            let (name, table) = (escaped(&film.name), table_of(film, scored));
            section += &format!("<details><summary>Scores on {name}</summary>\n{table}</details>\n");
        }
    }
    Ok(section)
}

/// All that are in one recording or another, each once.
fn everyone(measured: &[(&Film, &Scored)]) -> Vec<Entrant> {
    let mut all: Vec<Entrant> = Vec::new();
    for entrant in measured.iter().flat_map(|(film, _)| entrants(film)) {
        if all.iter().all(|known| known.name != entrant.name) {
            all.push(entrant);
        }
    }
    all
}

/// A number in a table; larger ones are better.
struct Cell {
    value: Option<f64>,
    text: String,
}

impl Cell {
    fn count(value: usize) -> Self {
        Self { value: Some(value as f64), text: value.to_string() }
    }

    fn part(value: f64) -> Self {
        Self { value: Some((value * 1000.0).round()), text: format!("{value:.3}") }
    }

    fn plain(text: String) -> Self {
        Self { value: None, text }
    }
}

/// A table with a line for each entrant; the largest value of each column is bold.
fn table(caption: &str, header: &[String], lines: &[(&Entrant, Vec<Cell>)]) -> String {
    let best = |column: usize| {
        let values = lines.iter().filter_map(|(_, cells)| cells[column].value);
        values.fold(f64::NEG_INFINITY, f64::max)
    };
    let cell = |(column, cell): (usize, &Cell)| match cell.value {
        Some(value) if lines.len() > 1 && value == best(column) => format!("<td><b>{}</b></td>", cell.text),
        _ => format!("<td>{}</td>", cell.text),
    };
    let heads: String = header.iter().map(|head| format!("<th scope=\"col\">{}</th>", escaped(head))).collect();
    let rows: String = lines
        .iter()
        .map(|(entrant, cells)| {
            let cells: String = cells.iter().enumerate().map(cell).collect();
            format!("<tr><th scope=\"row\">{}</th>{cells}</tr>\n", key(entrant))
        })
        .collect();
    format!(
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\"><table>\n<caption>{0}</caption>\n\
         <thead><tr><td></td>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        escaped(caption)
    )
}

/// The mark of an entrant, with its name.
fn key(entrant: &Entrant) -> String {
    let class = if entrant.method.is_some() {
        entrant.name.replace(|letter: char| !letter.is_alphanumeric(), "-")
    } else {
        "file".into()
    };
    format!("<span class=\"key {class}\" style=\"--c:{}\"></span>{}", css(entrant.color), escaped(&entrant.title))
}

fn across(measured: &[(&Film, &Scored)], everyone: &[Entrant]) -> String {
    let visible = |scored: &Scored| scored.evaluation.visible;
    let mut header: Vec<String> =
        measured.iter().map(|(film, scored)| format!("{} (of {})", film.name, visible(scored))).collect();
    let all: usize = measured.iter().map(|(_, scored)| visible(scored)).sum();
    header.extend([format!("all (of {all})"), "OTB AUC".to_owned(), "OTB P20".to_owned()]);
    let line = |entrant: &Entrant| {
        let scores: Vec<Option<&Score>> = measured.iter().map(|(_, scored)| scored.score_of(&entrant.name)).collect();
        let none = || Cell::plain("-".to_owned());
        let mut cells: Vec<Cell> =
            scores.iter().map(|score| score.map_or_else(none, |score| Cell::count(score.correct))).collect();
        let of: Option<Vec<Otb>> = scores.iter().map(|score| score.and_then(|score| score.otb)).collect();
        match of {
            Some(of) => {
                let correct = scores.iter().flatten().map(|score| score.correct).sum();
                let mean = |figure: fn(&Otb) -> f64| of.iter().map(figure).sum::<f64>() / of.len() as f64;
                cells.extend([
                    Cell::count(correct),
                    Cell::part(mean(|otb| otb.otb_auc)),
                    Cell::part(mean(|otb| otb.otb_precision)),
                ]);
            }
            None => cells.extend([none(), none(), none()]),
        }
        cells
    };
    let lines: Vec<(&Entrant, Vec<Cell>)> = everyone.iter().map(|entrant| (entrant, line(entrant))).collect();
    table("Correct frames of each recording; OTB AUC and OTB P20 are means over the recordings", &header, &lines)
}

fn table_of(film: &Film, scored: &Scored) -> String {
    let header = [
        "answered",
        "correct",
        "correct at 0.5",
        "correct / answered",
        "correct / visible",
        "F",
        "mean IoU",
        "OTB AUC",
        "OTB P20",
        "first failure",
    ];
    let entrants = entrants(film);
    let mut lines = Vec::new();
    for (entrant, (_, score)) in entrants.iter().zip(&scored.evaluation.scores) {
        let otb = score.otb.unwrap_or_default();
        let first_failure = score.first_failure.map_or("-".to_owned(), |frame| frame.to_string());
        let mut cells = vec![Cell::plain(score.answered.to_string())];
        cells.extend([score.correct, score.correct_50].map(Cell::count));
        cells.extend([score.precision, score.recall, score.f, score.mean_iou].map(Cell::part));
        cells.extend([otb.otb_auc, otb.otb_precision].map(Cell::part));
        cells.push(Cell::plain(first_failure));
        lines.push((entrant, cells));
    }
    let caption = format!("{} frames, the target is visible in {}", film.moments.len(), scored.evaluation.visible);
    table(&caption, &header.map(str::to_owned), &lines)
}

/// What the script fills: the player, the curves, and what was compared.
fn player(films: &[Film]) -> String {
    let options: String = films
        .iter()
        .enumerate()
        .map(|(index, film)| format!("<option value=\"{index}\">{}</option>", escaped(&film.name)))
        .collect();
    let hidden = if films.len() > 1 { "" } else { " hidden" };
    format!(
        "<h2>Player</h2>\n<noscript><p class=\"note\">Player and curves need scripts to be allowed.</p></noscript>\n\
         <p{hidden}><label>Recording <select id=\"recording\">{options}</select></label></p>\n{}",
        include_str!("player.html")
    )
}

fn strip(film: &Film, several: bool) -> Result<String> {
    let figures: Result<String> = film.stills.iter().map(|still| figure(film, still)).collect();
    let keys: String = entrants(film).iter().filter(|entrant| entrant.method.is_some()).map(key).collect();
    let truth = if film.truth.is_some() { "<span class=\"key truth\"></span>ground truth" } else { "" };
    let left_out = match film.changes_left_out {
        0 => String::new(),
        more => format!("<p class=\"note\">{more} more changes of state are not shown here; the player has all.</p>\n"),
    };
    let name = escaped(&film.name);
    let strip = format!(
        "<p class=\"note\">{keys}{truth}<span class=\"key window\"></span>search window. Boxes \
         that coincide share one dashed line; short dashes show the last box while the target is lost; black around the frame is \
         the padding. Click a frame to see it in the player.</p>\n{left_out}\
         <div class=\"strip\" data-recording=\"{name}\">\n{}</div>\n",
        figures?
    );
    Ok(if several {
        format!("<details><summary>Film strip of {name}</summary>\n{strip}</details>\n")
    } else {
        format!("<h2>Film strip</h2>\n{strip}")
    })
}

fn figure(film: &Film, still: &Still) -> Result<String> {
    let moment = &film.moments[still.index];
    let known = film.methods.iter().zip(&moment.reports).filter_map(|(method, report)| {
        let Evidence { confidence, ratio, runner_up_ratio, alpha, .. } = report.evidence?;
        let runner_up = runner_up_ratio.map_or(String::new(), |ratio| format!(", runner-up {ratio:.3}"));
        let alpha = alpha.map_or(String::new(), |alpha| format!(", alpha {alpha}"));
        Some(format!("{}: confidence {confidence:.3}, ratio {ratio:.3}{runner_up}{alpha}", method.name.to_uppercase()))
    });
    let evidence = if still.index == 0 { "locked on here".to_owned() } else { known.collect::<Vec<_>>().join("<br>") };
    let (number, tile) = (still.index + 1, tile::tile(film, still)?);
    Ok(format!(
        "<figure><a class=\"still\" href=\"#player\" data-frame=\"{number}\">{tile}</a><figcaption>{evidence}</figcaption>\
         </figure>\n"
    ))
}

/// What the terms on the page mean.
fn words() -> String {
    let terms = [
        (
            "SMR",
            "The Similarity Matching Ratio compares the template with a place in the frame: each pixel that differs by less \
             than alpha adds exp(-difference / 255), other pixels add nothing, and the sum is divided by the number of pixels. \
             The place with the largest ratio wins; how much the other pixels differ does not matter.",
        ),
        (
            "alpha",
            "The threshold, in gray levels, below which a pixel counts. It is a fraction (a quarter, unless --k says otherwise) \
             of the largest difference between the last two templates, so it grows when the target changes quickly.",
        ),
        (
            "runner-up",
            "The best ratio at any place away from the winner. If it is close to the winner's, the answer is ambiguous.",
        ),
        (
            "confidence",
            "How sure the tracker is of its answer, from 0 to 1. Compare values of one tracker only; <code>host-sim eval \
             --calibration</code> shows how often answers with a given confidence are correct.",
        ),
        (
            "tracking",
            "The target was found, and its box is inside the frame. The template is updated where the method allows it.",
        ),
        (
            "leaving",
            "The target was found, but its box reaches over the border of the frame. The template is not updated.",
        ),
        (
            "uncertain",
            "The robust tracker follows something that may not be the target. It still reports a box; use it with care.",
        ),
        (
            "lost",
            "Nothing in the search window is clear enough to be the target, so there is no answer. The tracker keeps looking; \
             the box of short dashes is its last answer, or what it follows meanwhile.",
        ),
        ("cost", "The comparisons or products that an answer took, at most. The number is the same on every machine."),
    ];
    let terms: String = terms.iter().map(|(term, text)| format!("<dt>{term}</dt><dd>{text}</dd>\n")).collect();
    format!("<h2>What the words mean</h2>\n<dl>\n{terms}</dl>\n")
}

fn foot(about: &About) -> String {
    format!(
        "<footer><p>host-sim {}</p>\n<pre>{}</pre>\n<pre>{}</pre></footer>\n",
        env!("CARGO_PKG_VERSION"),
        escaped(&about.command_line),
        escaped(&about.options)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{MethodKind, Variant};
    use crate::report::{Choice, watch};
    use crate::sequence::{self, OpenOptions, Sequence, synthetic};
    use smr_core::paper::Config;
    use std::path::Path;

    const BUDGET: usize = 25_000_000;

    fn film(change: impl FnOnce(Sequence) -> Sequence) -> Film {
        let sequence = sequence::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        let choice = Choice::Listed([0, 104, 180].into());
        let variant = |kind| Variant::new(kind, &Config::paper().into());
        let methods = [MethodKind::Smr, MethodKind::Sad].map(variant);
        watch(change(sequence), &methods, choice, Some(BUDGET), || ()).unwrap()
    }

    fn about() -> About {
        About { title: "<b>&".into(), command_line: "host-sim report '<i>'".into(), options: "{}".into() }
    }

    /// Every tag that is opened is closed, in the right order.
    fn nests(page: &str) {
        let mut open = Vec::new();
        let page = page.split("<script").next().unwrap();
        for tag in page.split('<').skip(2).filter_map(|rest| rest.split('>').next()) {
            let name = tag.split([' ', '\n']).next().unwrap();
            match name.strip_prefix('/') {
                Some(closed) => assert_eq!(open.pop(), Some(closed)),
                None if tag.ends_with('/') || ["meta", "img", "br", "input"].contains(&name) => (),
                None => open.push(name),
            }
        }
        assert_eq!(open, ["html", "body"]);
    }

    #[test]
    fn a_page_shows_what_was_asked_for_and_needs_nothing_else() {
        let page = page(&mut [film(|sequence| sequence)], &about(), BUDGET).unwrap();
        nests(&page);
        for number in ["1", "105", "181"] {
            assert!(page.contains(&format!("data-frame=\"{number}\"")), "{number}");
        }
        assert!(page.contains("<td><b>213</b></td>") && page.contains("<h1>&lt;b&gt;&amp;</h1>"));
        assert!(page.contains("<pre>host-sim report '&lt;i&gt;'</pre>"));
        assert!(!page.contains("url(") && !page.contains("import ") && !page.contains("fetch("));
        let namespace = "http://www.w3.org/2000/svg";
        assert!(page.matches("http").count() == page.matches(namespace).count(), "nothing from elsewhere");
        let references = page.matches("href=\"").count() + page.matches(" src=\"").count();
        let own = ["href=\"data:", " src=\"data:", "href=\"#"].map(|own| page.matches(own).count());
        assert_eq!(own.iter().sum::<usize>(), references);
    }

    #[test]
    fn without_ground_truth_there_are_no_scores() {
        let name = "</script><script>alert(1)</script>";
        let film = film(|sequence| Sequence { truth: None, name: name.to_owned(), ..sequence });
        let page = page(&mut [film], &about(), BUDGET).unwrap();
        nests(&page);
        assert!(!page.contains("<h2>Scores") && !page.contains("</span>ground truth"));
        assert!(!page.contains("<script>alert"));
    }

    #[test]
    fn several_recordings_are_set_beside_each_other() {
        let renamed = |name: &str| film(|sequence| Sequence { name: name.to_owned(), ..sequence });
        let mut films = [renamed("one"), renamed("two")];
        films[0].files.push(crate::evaluate::ResultFile { name: "other".into(), answers: vec![None; 240], note: None });
        let page = page(&mut films, &about(), BUDGET).unwrap();
        nests(&page);
        assert!(page.contains("<p>2 recordings with 480 frames in all.</p>"));
        assert!(page.contains("<td><b>426</b></td>"), "the sum is best");
        assert!(page.contains("other</th><td>0</td><td>-</td><td>-</td>"), "who is not everywhere has no sum");
        assert!(page.contains("Scores on two") && page.contains("Film strip of one"));
    }

    #[test]
    fn a_page_keeps_its_budget_or_says_what_it_needs() {
        let mut films = [film(|sequence| sequence)];
        let whole = page(&mut films, &about(), BUDGET).unwrap().len();
        let less = page(&mut films, &about(), whole * 2 / 3).unwrap();
        assert!(less.len() <= whole * 2 / 3 && films[0].pictures.as_ref().unwrap().every > 1);
        let error = page(&mut films, &about(), 1000).unwrap_err().to_string();
        assert!(error.contains("expected --budget 1 or more"), "{error}");
    }
}
