//! The whole report as one HTML page that needs nothing else: no script, no other file, no net.

use super::difference::Difference;
use super::film::{Film, Moment, Search, Still};
use super::{Color, SAD, SMR, TRUTH, color_of, encode, plot, tile};
use crate::evaluate::{Evaluation, Score, State, overlaps};
use anyhow::{Context, Result};

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
    let colors = [("smr", SMR), ("sad", SAD), ("truth", TRUTH), ("counts", counting_color(20))];
    let states = [("tracking", State::Tracking), ("leaving", State::Leaving), ("lost", State::Lost)];
    let colors = colors.into_iter().chain(states.map(|(name, state)| (name, color_of(state))));
    let variables: String = colors.map(|(name, [r, g, b])| format!("--{name}: rgb({r}, {g}, {b}); ")).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>SMR: {}</title>\n\
         <style>\n:root {{ {variables}}}\n{}</style>\n</head>\n<body>\n",
        escaped(&film.name),
        include_str!("page.css")
    )
}

fn summary(film: &Film) -> String {
    let count = |state: State| film.moments.iter().filter(|moment| moment.smr.state == state).count();
    let [first, second, third] = film.states;
    let kind = if film.is_robust() { " (robust)" } else { "" };
    format!(
        "<h1>{}</h1>\n<p>{} frames of {}x{} pixels, locked on the box of {}. SMR{kind} was {} in {} frames, {} in {}, {} in \
         {}.</p>\n",
        escaped(&film.name),
        film.moments.len(),
        film.size.0,
        film.size.1,
        tile::words(film.start),
        first.name(),
        count(first),
        second.name(),
        count(second),
        third.name(),
        count(third)
    )
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
        "<h2>Film strip</h2>\n<p class=\"note\"><span class=\"key smr\"></span>SMR<span class=\"key smr last\"></span>\
         SMR's last box, while lost<span class=\"key sad\"></span>SAD{truth}<span class=\"key window\"></span>search \
         window; black around the frame: padding</p>\n{left_out}<div class=\"strip\">\n{}</div>\n",
        figures?
    ))
}

fn figure(film: &Film, still: &Still) -> Result<String> {
    let evidence = film.moments[still.index].smr.evidence.map_or("locked here".to_owned(), |evidence| {
        let runner_up = evidence.runner_up_ratio.map_or(String::new(), |ratio| format!(", runner-up {ratio:.3}"));
        let alpha = evidence.alpha.map_or(String::new(), |alpha| format!(", alpha {alpha}"));
        format!("{} {:.3}{runner_up}{alpha}", film.measure(), evidence.ratio)
    });
    let (number, tile) = (still.index + 1, tile::tile(film, still)?);
    Ok(format!("<figure id=\"f{number}\">{tile}<figcaption>{evidence}</figcaption></figure>\n"))
}

fn over_time(film: &Film) -> Result<String> {
    let iou = |of| {
        let truth = film.truth.as_ref();
        truth.map(|truth| overlaps(&film.trajectory(of), truth).with_context(|| film.name.clone())).transpose()
    };
    let overlaps = iou(Moment::smr)?.zip(iou(Moment::sad)?).map(|(smr, sad)| [smr, sad]);
    let about_iou = match overlaps {
        Some(_) => " Without an answer the IoU is 0; where the target is not visible there is none.",
        None => "",
    };
    let about_alpha = if film.is_robust() { "" } else { " alpha is in gray levels;" };
    let states = film.states.map(|state| format!("<span class=\"key {0}\"></span>{0}", state.name())).concat();
    Ok(format!(
        "<h2>Over time</h2>\n<p class=\"note\">{states}<span class=\"key smr\"></span>SMR\
         <span class=\"key sad\"></span>SAD<span class=\"key runner-up\"></span>runner-up.{about_alpha} \
         The marks on top lead to the frames above.{about_iou}</p>\n<div class=\"scroll\">{}</div>\n",
        plot::over_time(film, overlaps)
    ))
}

fn differences(film: &Film) -> Result<String> {
    let searches = film.stills.iter().filter_map(|still| Some((still, still.sight.search.as_ref()?)));
    let figures: Result<String> = searches.map(|(still, search)| comparison(film, still, search)).collect();
    Ok(format!(
        "<h2>Differences</h2>\n<p class=\"note\">|F - G| of each pixel of both winners to their templates, the brighter \
         the more.<span class=\"key counts\"></span>counts: below alpha, with the share of such pixels. Under them how many pixels differ by how many \
         gray levels: <span class=\"key smr\"></span>SMR<span class=\"key sad\"></span>SAD\
         <span class=\"key threshold\"></span>alpha</p>\n<div class=\"strip large\">\n{}</div>\n",
        figures?
    ))
}

fn comparison(film: &Film, still: &Still, search: &Search) -> Result<String> {
    let report = &film.moments[still.index].smr;
    let alpha = search.alpha;
    let belief = if report.target.is_some() { "" } else { " (not believed)" };
    let counting = search.smr.counting(alpha) * 100.0;
    let (number, state) = (still.index + 1, report.state.name());
    Ok(format!(
        "<figure><figcaption><a href=\"#f{number}\">frame {number}</a>, {state}</figcaption><div class=\"pair\">\
         <div>{}<figcaption>SMR{belief}: {counting:.0}%</figcaption></div>\
         <div>{}<figcaption>SAD</figcaption></div></div>{}</figure>\n",
        map(&search.smr, alpha)?,
        map(&search.sad, 0)?,
        plot::histogram(search, alpha)
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
    use smr_core::Config;
    use std::path::Path;

    fn film(change: impl FnOnce(Sequence) -> Sequence) -> Film {
        let sequence = sequence::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        let choice = Choice::Listed([0, 104, 180].into());
        watch(change(sequence), &Config::paper().into(), choice, || ()).unwrap()
    }

    /// Every tag that is opened is closed, in the right order.
    fn nests(page: &str) {
        let mut open = Vec::new();
        for tag in page.split('<').skip(2).filter_map(|rest| rest.split('>').next()) {
            let name = tag.split([' ', '\n']).next().unwrap();
            match name.strip_prefix('/') {
                Some(closed) => assert_eq!(open.pop(), Some(closed)),
                None if tag.ends_with('/') || ["meta", "img"].contains(&name) => (),
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
