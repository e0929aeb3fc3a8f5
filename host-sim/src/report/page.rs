//! The whole report as one HTML page that needs nothing else: no script, no other file, no net.

use super::difference::Difference;
use super::film::{Film, Still};
use super::{Color, TRUTH, color_of, color_of_method, encode, plot, tile};
use crate::evaluate::{Evaluation, Evidence, MethodKind, Score, Variant, name_of, overlaps};
use anyhow::{Context, Result};
use smr_core::State;

/// The page.
///
/// # Errors
/// The ground truth is not that of so many frames, or a picture cannot be encoded.
pub fn page(film: &Film) -> Result<String> {
    let evaluation = film.evaluation()?;
    let sections = [
        head(film),
        summary(film),
        evaluation.as_ref().map(scores).unwrap_or_default(),
        strip(film)?,
        over_time(film)?,
        differences(film)?,
        "</body>\n</html>\n".to_owned(),
    ];
    Ok(sections.concat())
}

fn head(film: &Film) -> String {
    let methods = film.methods.iter().map(|method| (method.kind.name(), color_of_method(method.kind)));
    let colors = [("truth", TRUTH), ("counts", counting_color(20))];
    let states = [State::Tracking, State::Leaving, State::Lost].map(|state| (name_of(state), color_of(state)));
    let variables: String = methods
        .chain(colors)
        .chain(states)
        .map(|(name, [r, g, b])| format!("--{name}: rgb({r}, {g}, {b}); "))
        .collect();
    // Of equal boxes all are seen: what is drawn first is wider.
    let styles: String = (1..)
        .zip(&film.methods)
        .map(|(place, method)| {
            let (name, width) = (method.kind.name(), 3 * place);
            format!(
                ".key.{name} {{ border: 3px solid var(--{name}); box-sizing: border-box; }}\n\
                 .tile .{name} {{ stroke: var(--{name}); stroke-width: {width}; }}\n\
                 .line.{name} {{ stroke: var(--{name}); }} .bars.{name} {{ fill: var(--{name}); }}\n"
            )
        })
        .collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>SMR: {}</title>\n\
         <style>\n:root {{ {variables}}}\n{}{styles}</style>\n</head>\n<body>\n",
        escaped(&film.name),
        include_str!("page.css")
    )
}

fn summary(film: &Film) -> String {
    let first = &film.methods[0];
    let count = |state: State| film.moments.iter().filter(|moment| moment.first().state == state).count();
    let states = first.kind.states().iter().map(|&state| format!("{} in {}", name_of(state), count(state)));
    format!(
        "<h1>{}</h1>\n<p>{} frames of {}x{} pixels, locked on the box of {}. Frames by the state of {}: {}.</p>\n",
        escaped(&film.name),
        film.moments.len(),
        film.size.0,
        film.size.1,
        tile::words(film.start),
        title(first),
        states.collect::<Vec<_>>().join(", ")
    )
}

/// A method's name as it stands on the page.
fn title(method: &Variant) -> String {
    method.name.to_uppercase()
}

/// The methods in their colors.
fn keys(film: &Film) -> String {
    let key = |method: &Variant| format!("<span class=\"key {}\"></span>{}", method.kind.name(), title(method));
    film.methods.iter().map(key).collect()
}

fn scores(evaluation: &Evaluation) -> String {
    let header = [
        "",
        "frames",
        "visible",
        "answered",
        "correct",
        "correct at 0.5",
        "precision",
        "recall",
        "F",
        "mean IoU",
        "first failure",
    ];
    let header: String = header.map(|cell| format!("<th>{cell}</th>")).concat();
    let rows: String = evaluation.scores.iter().map(|(who, score)| score_row(who.name(), score)).collect();
    format!(
        "<h2>Scores</h2>\n<p class=\"note\">By the TLD protocol: a frame is correct if the intersection over union \
         (IoU) with the ground truth is above 0.25.</p>\n<div class=\"scroll\"><table>\n<thead><tr>{header}</tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

fn score_row(name: &str, score: &Score) -> String {
    let counts = [score.frames, score.visible, score.answered, score.correct, score.correct_50];
    let means = [score.precision, score.recall, score.f, score.mean_iou];
    let first_failure = score.first_failure.map_or("-".to_owned(), |frame| frame.to_string());
    let cells = counts.iter().map(ToString::to_string).chain(means.iter().map(|mean| format!("{mean:.3}")));
    let cells: String = cells.chain([first_failure]).map(|cell| format!("<td>{cell}</td>")).collect();
    format!("<tr><th><span class=\"key {name}\"></span>{}</th>{cells}</tr>\n", name.to_uppercase())
}

fn strip(film: &Film) -> Result<String> {
    let figures: Result<String> = film.stills.iter().map(|still| figure(film, still)).collect();
    let truth = if film.truth.is_some() { "<span class=\"key truth\"></span>ground truth" } else { "" };
    let left_out = match film.changes_left_out {
        0 => String::new(),
        more => format!("<p class=\"note\">{more} more changes of state are not shown here; all are below.</p>\n"),
    };
    Ok(format!(
        "<h2>Film strip</h2>\n<p class=\"note\">{}{truth}<span class=\"key window\"></span>search window; dashed: the last \
         box, while lost; black around the frame: padding</p>\n{left_out}<div class=\"strip\">\n{}</div>\n",
        keys(film),
        figures?
    ))
}

fn figure(film: &Film, still: &Still) -> Result<String> {
    let moment = &film.moments[still.index];
    let known = film.methods.iter().zip(&moment.reports).filter_map(|(method, report)| {
        let Evidence { confidence, ratio, runner_up_ratio, alpha, .. } = report.evidence?;
        let runner_up = runner_up_ratio.map_or(String::new(), |ratio| format!(", runner-up {ratio:.3}"));
        let alpha = alpha.map_or(String::new(), |alpha| format!(", alpha {alpha}"));
        Some(format!("{}: confidence {confidence:.3}, ratio {ratio:.3}{runner_up}{alpha}", title(method)))
    });
    let evidence = if still.index == 0 { "locked here".to_owned() } else { known.collect::<Vec<_>>().join("<br>") };
    let (number, tile) = (still.index + 1, tile::tile(film, still)?);
    Ok(format!("<figure id=\"f{number}\">{tile}<figcaption>{evidence}</figcaption></figure>\n"))
}

fn over_time(film: &Film) -> Result<String> {
    let iou = |truth| {
        let of = |method| overlaps(&film.trajectory(method), truth).with_context(|| film.name.clone());
        (0..film.methods.len()).map(of).collect::<Result<Vec<_>>>()
    };
    let overlaps = film.truth.as_ref().map(|truth| iou(truth)).transpose()?;
    let about_iou = match overlaps {
        Some(_) => " Without an answer the IoU is 0; where the target is not visible there is none.",
        None => "",
    };
    let smr = film.all_of(MethodKind::Smr).next().is_some();
    let (runner_up, about_alpha) =
        if smr { ("<span class=\"key runner-up\"></span>runner-up", " alpha is in gray levels;") } else { ("", "") };
    let states = film.methods[0].kind.states();
    let states: String =
        states.iter().map(|&state| format!("<span class=\"key {0}\"></span>{0}", name_of(state))).collect();
    Ok(format!(
        "<h2>Over time</h2>\n<p class=\"note\">{states}<span></span> ({}){}{runner_up}.{about_alpha} \
         The marks on top lead to the frames above.{about_iou}</p>\n<div class=\"scroll\">{}</div>\n",
        title(&film.methods[0]),
        keys(film),
        plot::over_time(film, overlaps)
    ))
}

fn differences(film: &Film) -> Result<String> {
    let figures: Result<String> = film.stills.iter().map(|still| comparison(film, still)).collect();
    Ok(format!(
        "<h2>Differences</h2>\n<p class=\"note\">|F - G| of each pixel of the winners to their templates, the brighter \
         the more.<span class=\"key counts\"></span>counts: below alpha, with the share of such pixels. Under them how many \
         pixels differ by how many gray levels: {}<span class=\"key threshold\"></span>alpha of {}</p>\n\
         <div class=\"strip large\">\n{}</div>\n",
        keys(film),
        title(&film.methods[0]),
        figures?
    ))
}

/// Nothing for the frame that was locked on.
fn comparison(film: &Film, still: &Still) -> Result<String> {
    let reports = &film.moments[still.index].reports;
    let mut maps = String::new();
    for ((method, report), sight) in film.methods.iter().zip(reports).zip(&still.sights) {
        let Some(search) = &sight.search else { return Ok(String::new()) };
        let belief = if report.target.is_some() { "" } else { " (not believed)" };
        let counting = |alpha| format!(": {:.0}%", search.difference.counting(alpha) * 100.0);
        maps += &format!(
            "<div>{}<figcaption>{}{belief}{}</figcaption></div>",
            map(&search.difference, search.alpha.unwrap_or(0))?,
            title(method),
            search.alpha.map_or(String::new(), counting)
        );
    }
    let (number, state) = (still.index + 1, name_of(reports[0].state));
    Ok(format!(
        "<figure><figcaption><a href=\"#f{number}\">frame {number}</a>, {state}</figcaption><div class=\"pair\">{maps}</div>{}\
         </figure>\n",
        plot::histogram(film, still)
    ))
}

/// Larger differences are as bright: a first half of a palette for pixels that do not count, the other for those that do.
const BRIGHTEST: u8 = 127;

/// Each pixel's difference; those below `alpha` are marked.
fn map(difference: &Difference, alpha: u16) -> Result<String> {
    let index = |&pixel: &u8| pixel.min(BRIGHTEST) + if u16::from(pixel) < alpha { BRIGHTEST + 1 } else { 0 };
    let indices: Vec<u8> = difference.pixels.iter().map(index).collect();
    let palette: Vec<Color> =
        (0..=BRIGHTEST).map(|level| [gray(level); 3]).chain((0..=BRIGHTEST).map(counting_color)).collect();
    let size = (difference.size.0.into(), difference.size.1.into());
    let picture = encode::data_uri("image/png", &encode::png(size, &indices, &palette)?);
    Ok(format!("<img src=\"{picture}\" alt=\"differences of the box of {}\">", tile::words(difference.at)))
}

/// Steep where differences are small, as most are.
fn gray(level: u8) -> u8 {
    let shade = (255 * 255 * u32::from(level) / u32::from(BRIGHTEST)).isqrt();
    u8::try_from(shade).unwrap_or(u8::MAX)
}

fn counting_color(level: u8) -> Color {
    let shade = gray(level) / 3;
    [shade, 105 + shade, 65 + shade]
}

/// A name as the text of a page.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Choice, watch};
    use crate::sequence::{self, OpenOptions, Sequence, synthetic};
    use smr_core::paper::Config;
    use std::path::Path;

    fn film(change: impl FnOnce(Sequence) -> Sequence) -> Film {
        let sequence = sequence::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        let choice = Choice::Listed([0, 104, 180].into());
        let variant = |kind| Variant::new(kind, &Config::paper().into());
        watch(change(sequence), &[MethodKind::Smr, MethodKind::Sad].map(variant), choice, || ()).unwrap()
    }

    /// Every tag that is opened is closed, in the right order.
    fn nests(page: &str) {
        let mut open = Vec::new();
        for tag in page.split('<').skip(2).filter_map(|rest| rest.split('>').next()) {
            let name = tag.split([' ', '\n']).next().unwrap();
            match name.strip_prefix('/') {
                Some(closed) => assert_eq!(open.pop(), Some(closed)),
                None if tag.ends_with('/') || ["meta", "img", "br"].contains(&name) => (),
                None => open.push(name),
            }
        }
        assert_eq!(open, Vec::<&str>::new());
    }

    #[test]
    fn a_page_shows_what_was_asked_for_and_needs_nothing_else() {
        let page = page(&film(|sequence| sequence)).unwrap();
        nests(&page);
        for id in ["f1", "f105", "f181"] {
            assert!(page.contains(&format!("<figure id=\"{id}\">")), "{id}");
        }
        assert_eq!(page.matches("<figure id=").count(), 3);
        assert_eq!(page.matches("class=\"histogram\"").count(), 2, "nothing is compared in the frame locked on");
        assert!(page.contains("<td>213</td>") && page.contains("(not believed)"));
        assert!(!page.contains("http") && !page.contains("<script") && !page.contains("url("));
        let references = page.matches("href=\"").count() + page.matches("src=\"").count();
        let own = ["href=\"data:", "src=\"data:", "href=\"#"].map(|own| page.matches(own).count());
        assert_eq!(own.iter().sum::<usize>(), references);
    }

    #[test]
    fn without_ground_truth_there_are_no_scores() {
        let page = page(&film(|sequence| Sequence { truth: None, name: "<b>&".to_owned(), ..sequence })).unwrap();
        nests(&page);
        assert!(!page.contains("<h2>Scores") && !page.contains(">IoU<") && !page.contains("ground truth"));
        assert!(page.contains("<h1>&lt;b&gt;&amp;</h1>"));
    }

    #[test]
    fn brightness_grows_with_the_difference() {
        assert!((1..=BRIGHTEST).all(|level| gray(level) >= gray(level - 1)));
        assert_eq!((gray(0), gray(BRIGHTEST)), (0, 255));
    }
}
