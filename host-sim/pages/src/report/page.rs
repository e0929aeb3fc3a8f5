//! Renders the report as one self-contained HTML page, from the template `page.html`.

use super::film::{FilmedRecording, Locked};
use super::page_data::data;
use super::player_frames::Images;
use super::scores::{Measured, scores};
use super::trackers::{SENTENCE, TITLE, looks, place_files, titled};
use crate::front_end::{STYLES, WORDS, import_map};
use anyhow::{Result, ensure};
use minijinja::value::{Serde, Value};
use minijinja::{Environment, context};
use smr_core::{Rect, State};
use smr_evaluation::{Evaluation, name_of};
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");
const PAGE: &str = include_str!("page.html");

/// Title of the page, and the command line and options for its footer.
pub struct About {
    pub title: String,
    pub command_line: String,
    /// The options of the methods, as JSON.
    pub options: String,
}

/// Renders the page in at most `budget` bytes: images of frames get smaller, then fewer, until it fits.
/// Errors: No film, ground truth of another length, an image that cannot be encoded, or a page over the budget even
/// with the fewest and smallest images.
pub fn page(films: &mut [FilmedRecording], about: &About, budget: usize) -> Result<String> {
    ensure!(!films.is_empty(), "there is no recording to show");
    place_files(films);
    loop {
        let page = render(films, about)?;
        if page.len() <= budget {
            return Ok(page);
        }
        let imaged = films.iter_mut().filter_map(|film| film.images.as_mut());
        let largest = imaged.max_by_key(|images| images.bytes());
        let shrunk = largest.map(Images::shrink).transpose()?.unwrap_or(false);
        let bytes = page.len().div_ceil(1_000_000);
        ensure!(shrunk, "the page has {bytes} MB with next to no frames: expected --budget {bytes} or more");
    }
}

fn render(films: &[FilmedRecording], about: &About) -> Result<String> {
    let measured = films.iter().map(Measured::new).collect::<Result<Vec<_>>>()?;
    let measured: Vec<Measured<'_>> = measured.into_iter().flatten().collect();
    let page = context! {
        title => about.title.as_str(),
        command_line => about.command_line.as_str(),
        options => about.options.as_str(),
        version => env!("CARGO_PKG_VERSION"),
        style => STYLES.concat() + STYLE,
        words => WORDS,
        looks => Serde(looks()),
        recordings => films.iter().map(recording).collect::<Result<Vec<_>>>()?,
        scores => Serde(scores(&measured)),
        data => data(films)?,
        import_map => import_map(),
    };
    let mut templates = Environment::new();
    templates.add_template("page.html", PAGE)?;
    Ok(templates.get_template("page.html")?.render(page)?)
}

fn recording(film: &FilmedRecording) -> Result<Value> {
    Ok(context! {
        name => film.name.as_str(),
        notes => Serde(&film.notes),
        frames => film.moments.len(),
        width => film.size.0,
        height => film.size.1,
        starts => film.targets.iter().map(|target| starts(film, target)).collect::<Vec<_>>(),
        seconds => film.times.last().and_then(|last| Some(format!("{:.1}", (*last)? - film.times[0]?))),
        states => Serde(states(film)),
        lead => lead(film)?,
        every => film.images.as_ref().map_or(1, |images| images.every),
    })
}

/// Returns, for each target, the title of its first method and that method's count of frames in each state.
fn states(film: &FilmedRecording) -> Vec<(String, Vec<(&'static str, usize)>)> {
    let of = |target: usize| {
        let method = film.method_targets.iter().position(|of| *of == target)?;
        let there = || film.moments.iter().enumerate().filter(|(index, _)| film.has(method, *index));
        let count = |state: State| there().filter(|(_, moment)| moment.reports[method].state == state).count();
        let states = film.methods[method].kind.states().iter().map(|&state| (name_of(state), count(state)));
        Some((titled(film, method, TITLE), states.filter(|(_, count)| *count > 0).collect()))
    };
    (0..film.targets.len()).filter_map(of).collect()
}

/// Returns the page's first sentence: each method's count of correct frames and, except for the best method, the frame
/// in which its longest failure begins. `None` without ground truth.
fn lead(film: &FilmedRecording) -> Result<Option<String>> {
    let Some(Evaluation { visible, scores, .. }) = film.evaluation()? else { return Ok(None) };
    let correct = |method: usize| scores[method].1.correct;
    let Some(best) = (0..film.methods.len()).rev().max_by_key(|method| correct(*method)) else { return Ok(None) };
    let all = if correct(best) == visible { "all".to_owned() } else { format!("{} of", correct(best)) };
    let mut said =
        titled(film, best, SENTENCE) + &format!(" follows the target in {all} {visible} frames that show it");
    for other in (0..film.methods.len()).filter(|method| *method != best) {
        let _ = write!(said, "; {} in {}", titled(film, other, SENTENCE), correct(other));
        if let Some((index, is_lost)) = film.longest_failure(best, other)? {
            let place = film.clock(index).unwrap_or_else(|| format!("frame {}", index + film.first));
            let _ = write!(said, ": {} at {place}", if is_lost { "it loses it" } else { "it goes astray" });
        }
    }
    let mut letters = said.chars();
    Ok(letters.next().map(|first| first.to_uppercase().to_string() + letters.as_str() + "."))
}

/// Formats a target's locks as `car: 40x48 at (150, 100), gone in frame 200, 40x48 at (170, 90) in frame 300`.
fn starts(film: &FilmedRecording, target: &Locked) -> String {
    let start = |&(index, bbox): &(usize, Option<Rect>)| {
        let frame = if index == 0 { String::new() } else { format!(" in frame {}", index + film.first) };
        let frame = film.clock(index).filter(|_| index > 0).map_or(frame.clone(), |time| format!("{frame} ({time})"));
        let place = |Rect { x, y, width, height }| format!("{width}x{height} at ({x}, {y})");
        bbox.map_or("gone".to_owned(), place) + &frame
    };
    let name = target.name.as_ref().map_or(String::new(), |name| format!("{name}: "));
    name + &target.starts.iter().map(start).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::trackers::entrants;
    use crate::report::{Watch, watch};
    use smr_core::paper::Config;
    use smr_evaluation::{MethodKind, Variant};
    use smr_recordings::{OpenOptions, Sequence, synthetic};
    use std::path::Path;

    const BUDGET: usize = 25_000_000;

    fn film(change: impl FnOnce(Sequence) -> Sequence) -> FilmedRecording {
        let sequence = smr_recordings::open(Path::new(synthetic::NAME), &OpenOptions::default()).unwrap();
        let variant = |kind| Variant::new(kind, &Config::paper().into());
        let methods = [MethodKind::Paper, MethodKind::Sad].map(variant);
        watch(change(sequence), Watch { budget: Some(BUDGET), ..Watch::new(&methods) }, || ()).unwrap()
    }

    fn about() -> About {
        About { title: "<b>&".into(), command_line: "host-sim report '<i>'".into(), options: "{}".into() }
    }

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
        assert!(page.contains("<td><b>213</b></td>") && page.contains("<h1>&lt;b&gt;&amp;</h1>"));
        let lead = page.split("class=\"lead\">").nth(1).and_then(|rest| rest.split('<').next());
        assert_eq!(
            lead.unwrap(),
            "The paper tracker of 2013 follows the target in all 213 frames that show it; SAD in 169: it goes astray at \
             frame 170."
        );
        assert!(page.contains("<pre>host-sim report &#x27;&lt;i&gt;&#x27;</pre>"));
        assert!(!page.contains("url(") && !page.contains("fetch("));
        assert_eq!(page.matches("import ").count(), page.matches("import \"smr/").count(), "nothing from elsewhere");
        assert!(!page.contains("http:") && !page.contains("https:"), "nothing from elsewhere");
        let references = page.matches("href=\"").count() + page.matches(" src=\"").count();
        let own = ["href=\"data:", " src=\"data:", "href=\"#"].map(|own| page.matches(own).count());
        assert_eq!(own.iter().sum::<usize>(), references);
    }

    #[test]
    fn without_ground_truth_there_are_no_scores_and_what_was_left_out_is_said() {
        let name = "</script><script>alert(1)</script>";
        let film = film(|sequence| Sequence { truth: None, name: name.to_owned(), ..sequence });
        let film = FilmedRecording { notes: vec!["paper is left out: too large".into()], first: 601, ..film };
        let page = page(&mut [film], &about(), BUDGET).unwrap();
        nests(&page);
        assert!(!page.contains("<h2>Scores") && !page.contains("<script>alert"));
        assert!(page.contains("<p class=\"note\">paper is left out: too large.</p>"));
        assert!(page.contains("\"first\":601,"), "frames have the numbers of the recording");
    }

    #[test]
    fn several_recordings_are_set_beside_each_other() {
        let renamed = |name: &str| film(|sequence| Sequence { name: name.to_owned(), ..sequence });
        let mut films = [renamed("one"), renamed("two")];
        films[0].files.push(smr_evaluation::ResultFile { name: "other".into(), answers: vec![None; 240], note: None });
        let page = page(&mut films, &about(), BUDGET).unwrap();
        nests(&page);
        assert!(page.contains("<p>2 recordings with 480 frames in all.</p>"));
        assert!(page.contains("<td><b>426</b></td>"), "the sum is best");
        assert!(page.contains("other</span></th><td>0</td><td>-</td><td>-</td>"), "who is not everywhere has no sum");
        assert!(page.contains("Scores on two"));
    }

    #[test]
    fn a_tracker_has_one_look_in_all_recordings() {
        let mut films = [film(|sequence| sequence), film(|sequence| Sequence { name: "two".into(), ..sequence })];
        let file = |name: &str| smr_evaluation::ResultFile { name: name.into(), answers: vec![None; 240], note: None };
        films[0].files = vec![file("a"), file("b")];
        films[1].files = vec![file("b"), file("c")];
        page(&mut films, &about(), BUDGET).unwrap();
        let looks = films.each_ref().map(|film| entrants(film)[2..].iter().map(|one| one.look).collect::<Vec<_>>());
        assert_eq!(looks, [[6, 7], [7, 8]]);
    }

    #[test]
    fn a_page_keeps_its_budget_or_says_what_it_needs() {
        let mut films = [film(|sequence| sequence)];
        let whole = page(&mut films, &about(), BUDGET).unwrap().len();
        let less = page(&mut films, &about(), whole * 2 / 3).unwrap();
        assert!(less.len() <= whole * 2 / 3 && films[0].images.as_ref().unwrap().every > 1);
        let error = page(&mut films, &about(), 1000).unwrap_err().to_string();
        assert!(error.contains("expected --budget 1 or more"), "{error}");
    }
}
