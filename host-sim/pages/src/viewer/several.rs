//! Several recordings in one server. Each has a viewer with a page of its own at `1/`, `2/` and so on, and is opened when
//! its page first asks for it. Above the heading, each page has links to the others, and it offers the names of their
//! targets.

use super::lock;
use super::model::Target;
use super::routes::{self, Viewer};
use super::server::{Reply, Request, Server};
use super::session::{Work, beside};
use anyhow::{Context, Result};
use minijinja::HtmlEscape;
use smr_files::messages;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Style of the links: some lines of them, of which the rest can be scrolled to.
const STYLE: &str = "display:flex;flex-wrap:wrap;gap:0 1rem;max-height:6rem;overflow:auto";

type Open = dyn Fn(&Path) -> Result<Viewer> + Send + Sync;

pub struct Several {
    recordings: Vec<Recording>,
    open: Box<Open>,
}

struct Recording {
    path: PathBuf,
    name: String,
    viewer: Mutex<Option<Arc<Viewer>>>,
}

impl Several {
    /// Takes the path and the name of each recording; `open` opens one.
    pub fn new(
        recordings: impl IntoIterator<Item = (PathBuf, String)>,
        open: impl Fn(&Path) -> Result<Viewer> + Send + Sync + 'static,
    ) -> Self {
        let one = |(path, name)| Recording { path, name, viewer: Mutex::default() };
        Self { recordings: recordings.into_iter().map(one).collect(), open: Box::new(open) }
    }

    /// Serves the pages until the program ends.
    pub fn serve(self, server: Server) -> Result<()> {
        server.run(move |request| self.answer(request))
    }

    fn answer(&self, mut request: Request) -> Reply {
        if request.path.is_empty() {
            return Reply { to: Some("1/"), ..Reply::error(307, "1/ is the first recording") };
        }
        let Some((at, rest)) = self.place(&request.path) else { return Reply::error(404, "there is nothing here") };
        match (request.posts, rest.split_once('/')) {
            (false, None) if rest.is_empty() => return routes::page(&self.lead(at)),
            (false, Some(("page", name))) => return routes::module(name),
            _ => request.path = rest.to_owned(),
        }
        match self.opened(at) {
            Ok(viewer) => viewer.answer(&request),
            Err(error) => Reply::error(400, &messages::of(&error)),
        }
    }

    /// Splits a path such as `2/frames/7.jpg` into the index of the recording and the rest.
    fn place<'a>(&self, path: &'a str) -> Option<(usize, &'a str)> {
        let (number, rest) = path.split_once('/')?;
        let at = number.parse::<usize>().ok()?.checked_sub(1)?;
        (at < self.recordings.len()).then_some((at, rest))
    }

    /// Returns the viewer of a recording, and opens the recording if that has not been done. An error is tried again.
    fn opened(&self, at: usize) -> Result<Arc<Viewer>> {
        let Recording { path, name, viewer } = &self.recordings[at];
        let mut viewer = lock(viewer);
        if let Some(viewer) = &*viewer {
            return Ok(Arc::clone(viewer));
        }
        let opened = Arc::new((self.open)(path).with_context(|| name.clone())?);
        opened.start();
        *viewer = Some(Arc::clone(&opened));
        Ok(opened)
    }

    /// Returns the links to all recordings, and the names of the targets in the others, for the fields of names.
    fn lead(&self, at: usize) -> String {
        let mut links = String::new();
        let mut offered: Vec<String> = Vec::new();
        for (number, recording) in (1..).zip(&self.recordings) {
            let is_here = number == at + 1;
            let (name, targets) = (HtmlEscape(&recording.name), recording.targets());
            let list = targets.iter().map(Target::name).collect::<Vec<_>>().join(", ");
            let link = if is_here {
                format!("<b aria-current=\"page\">{name}</b>")
            } else {
                format!("<a href=\"../{number}/\">{name}</a>")
            };
            links += &format!("<span>{link} <small>{}</small></span>\n", HtmlEscape(&list));
            let has_own_name = |target: &&Target| target.name() != format!("target{}", target.id);
            offered.extend(targets.iter().filter(|_| !is_here).filter(has_own_name).map(Target::name));
        }
        offered.sort();
        offered.dedup();
        let option = |name: &String| format!("<option value=\"{}\">", HtmlEscape(name));
        let options: String = offered.iter().map(option).collect();
        format!(
            "<nav aria-label=\"Recordings\" style=\"{STYLE}\">{links}</nav><datalist id=\"names\">{options}</datalist>"
        )
    }
}

impl Recording {
    /// Returns the targets of the session, if it can be read.
    fn targets(&self) -> Vec<Target> {
        let work = beside(&self.path).and_then(|file| Work::read(&file, "").ok()?);
        work.map_or(Vec::new(), |work| work.targets)
    }
}
