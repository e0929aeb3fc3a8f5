//! The way of a frame through the robust tracker: window, features, filter, size, verification, learning.
//!
//! It is cut into stages, so that an update can be made in steps. Until the last one only scratch memory changes.

use super::Robust;
use super::agreement::Compared;
use super::config::{Config, Parts};
use super::cost::{CODED, COMPARED, LIT, REFINED, SEEN, SLOPED, VIEWED};
use super::early::Early;
use super::exact::{Exact, MARGIN, Nearest, PLACES};
use super::features::{CELL, CHANNELS};
use super::filter::{Change, Filter, Sample, layout};
use super::grid::{Grid, Lattice, SCALE};
use super::responses::{self, Peak};
use super::track::{Place, Track};
use super::trust::{Evidence, Trust};
use super::workspace::Workspace;
use crate::image::{Frame, Image, Rect};
use crate::kernels::{Layout, Products};
use crate::similarity::{Backend, Contrast, Scorer};
use crate::track::State;

/// The scales beside the last one: 1.02 times and 1 / 1.02 times.
const SIZE_STEP: u64 = 66_847;
/// What their responses count, in units of 1/256.
const SIZE_PART: i64 = 252;
/// How far they are searched, in cells.
pub(super) const SIZE_REACH: u16 = 1;
/// Steps of learning from the first frame.
pub(super) const FIRST_STEPS: u32 = 25;
/// How far each of them goes of the best length, in units of 1/256.
const FIRST_RATE: u16 = 160;
/// The least and the most that a target may have grown.
const LEAST_SCALE: u32 = SCALE / 5;
const MOST_SCALE: u32 = 5 * SCALE;

/// What comes next in an update. Each is a unit of work, between two of which a step may end.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)] // `Done` is 0, so that a workspace in a `static` begins as zeroes
enum Stage {
    Done,
    /// A row of cells of a window.
    See(Where),
    /// A part of the responses to them.
    Respond(Where, usize),
    /// A row of the view of the place that was found.
    View(Where, u16),
    /// The score at one place of the view.
    Compare(Where, u16),
    /// Agreement at the best of them.
    Agree(Where),
    /// Where exactly that is.
    Refine,
    /// A row of cells at another scale.
    SeeSize(usize),
    /// The responses to them.
    Size(usize),
    /// How far responses are from what they should be.
    Errors,
    /// A part of what errors say of the weights.
    Gather(usize),
    /// The way to change the weights.
    Slopes,
    /// A part of the responses to that.
    Bend(usize),
}

/// Which window is looked at.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Where {
    /// Where the target is locked on.
    Locked,
    /// Where the target is expected.
    Expected,
    /// Where a lost target is looked for.
    Elsewhere,
}

/// How far an update is, and what it has found so far.
pub(super) struct Progress {
    stage: Stage,
    /// What the track becomes.
    pub(super) next: Option<Track>,
    /// Steps of learning that a lock has still to make, the one under way among them; 0 in an update.
    pub(super) lessons: u32,
    /// The look that is under way, and the one that counts.
    looking: Look,
    pub(super) look: Look,
    /// What the filter's coded weights are multiplied by.
    shift: u32,
    /// The early template's brightness and contrast.
    was: Contrast,
    /// The best place of the view so far.
    pub(super) nearest: Nearest,
    /// How much the target has grown, in units of 1/65536, if that is known exactly.
    growth: Option<i32>,
    /// The highest peak of all scales so far, and that scale.
    highest: i64,
    scale: u32,
    /// Where the target was in the window, in units of 1/256 cell.
    offset: (i32, i32),
    /// By how much errors, and then the way to change the weights, were shifted to be coded.
    coded: u32,
    /// How steep the way is.
    descent: i64,
    pub(super) change: Option<Change>,
    /// Filter and early template learn from this frame.
    pub(super) learns: bool,
}

/// What a look at a window says.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub(super) place: Place,
    pub(super) peak: Peak,
    pub(super) agreement: u16,
    /// What is seen there can show the target.
    shows: bool,
}

impl Look {
    fn evidence(&self) -> Evidence {
        if self.shows { Evidence::of(self.agreement, self.peak.response) } else { Evidence::NONE }
    }
}

impl Progress {
    #[inline(always)] // made where it stays
    pub(super) const fn new() -> Self {
        let place = Place { x: 0, y: 0, scale: 0 };
        let look = Look { place, peak: Peak { x: 0, y: 0, response: 0, height: 0 }, agreement: 0, shows: false };
        Self {
            stage: Stage::Done,
            next: None,
            lessons: 0,
            looking: look,
            look,
            shift: 0,
            was: Contrast::NONE,
            nearest: Nearest::new(),
            growth: None,
            highest: 0,
            scale: 0,
            offset: (0, 0),
            coded: 0,
            descent: 0,
            change: None,
            learns: false,
        }
    }
}

/// What an update goes by; none of it changes.
pub(super) struct Target<'a> {
    pub(super) config: &'a Config,
    pub(super) filter: &'a Filter,
    pub(super) early: &'a Early,
    pub(super) track: Track,
}

impl Target<'_> {
    pub(super) fn begin(&self, workspace: &mut Workspace) {
        let shift = self.filter.code(&mut workspace.desk);
        let Grid { columns, rows, .. } = self.track.grid;
        self.early.copy_to(&mut workspace.lit);
        let was = Image::new(&workspace.lit, columns, rows).map_or(Contrast::NONE, Contrast::of);
        workspace.progress = Progress { next: Some(self.track), shift, was, ..Progress::new() };
        workspace.under_way.spend(CODED * (weights(&self.track.grid) + self.track.grid.pixels()));
        workspace.progress.stage = self.look(workspace, Where::Expected);
    }

    /// Begins a lock: first the early template is seen, then the window that is learned from.
    pub(super) fn begin_lock(&self, workspace: &mut Workspace) {
        workspace.progress = Progress { next: Some(self.track), lessons: FIRST_STEPS, ..Progress::new() };
        self.track.place.view(&self.track.grid).begin(
            self.track.bounds,
            workspace.strip.scratch(),
            &mut workspace.view,
        );
        workspace.progress.looking.place = self.track.place;
        workspace.progress.stage = Stage::View(Where::Locked, 0);
    }

    /// Learns once more from the same window.
    pub(super) fn next_lesson(&self, workspace: &mut Workspace) {
        workspace.progress.stage = self.respond_first(workspace, Where::Locked);
    }

    /// Goes on until what is granted is spent; true at the end.
    #[inline(never)] // one copy in flash
    pub(super) fn step(&self, workspace: &mut Workspace, frame: &Frame<'_>) -> bool {
        while workspace.progress.stage != Stage::Done && !workspace.under_way.is_spent() {
            let stage = match workspace.progress.stage {
                Stage::See(place) => self.see(workspace, frame, place),
                Stage::Respond(place, part) => self.respond(workspace, place, part),
                Stage::View(place, row) => self.view(workspace, frame, place, row),
                Stage::Compare(place, number) => self.compare(workspace, place, number),
                Stage::Agree(place) => self.agree(workspace, place),
                Stage::Refine => self.refine(workspace),
                Stage::SeeSize(number) => self.see_size(workspace, frame, number),
                Stage::Size(number) => self.size(workspace, number),
                Stage::Errors => self.errors(workspace),
                Stage::Gather(part) => self.gather(workspace, part),
                Stage::Slopes => self.slopes(workspace),
                Stage::Bend(part) => self.bend(workspace, part),
                Stage::Done => Stage::Done,
            };
            workspace.progress.stage = stage;
        }
        workspace.progress.stage == Stage::Done
    }

    fn centre(&self, place: Where) -> Place {
        match place {
            Where::Locked => self.track.place,
            Where::Expected => self.track.expected(self.config.parts.velocity),
            Where::Elsewhere => self.track.sweep(self.config.reach()),
        }
    }

    fn window(&self, place: Where) -> Lattice {
        self.centre(place).window(&self.track.grid, self.config.reach())
    }

    /// How the filter lies on the cells of a window.
    fn layout(&self) -> Layout {
        layout(&self.track.grid, self.config.span())
    }

    /// Begins a look at a window.
    fn look(&self, workspace: &mut Workspace, place: Where) -> Stage {
        let Workspace { strip, cells, progress, .. } = workspace;
        progress.looking.agreement = 0;
        strip.begin(self.track.bounds, &self.window(place), cells);
        Stage::See(place)
    }

    fn see(&self, workspace: &mut Workspace, frame: &Frame<'_>, place: Where) -> Stage {
        let lattice = self.window(place);
        let Workspace { strip, cells, under_way, .. } = workspace;
        let seen = strip.row(frame, &lattice, cells);
        under_way.spend(strip.scratch().work(SEEN));
        if !seen {
            return Stage::See(place);
        }
        if place == Where::Locked { self.respond_first(workspace, place) } else { Stage::Respond(place, 0) }
    }

    /// Codes the weights as they are now.
    fn respond_first(&self, workspace: &mut Workspace, place: Where) -> Stage {
        workspace.progress.shift = self.filter.code(&mut workspace.desk);
        workspace.under_way.spend(CODED * weights(&self.track.grid));
        Stage::Respond(place, 0)
    }

    fn respond(&self, workspace: &mut Workspace, place: Where, part: usize) -> Stage {
        if !workspace.respond_part(self.layout(), self.products(), part) {
            return Stage::Respond(place, part + 1);
        }
        if place == Where::Locked { Stage::Errors } else { self.found(workspace, place) }
    }

    /// Where the target is in the window.
    fn found(&self, workspace: &mut Workspace, place: Where) -> Stage {
        let Workspace { responses, strip, view, progress, .. } = workspace;
        let (grid, centre) = (&self.track.grid, self.centre(place));
        let peak = responses.peak(self.config.parts.near);
        // 1/256 cell is 1/64 pixel of the grid.
        let at = centre.moved(grid, (peak.x, peak.y)).inside(self.track.bounds);
        progress.looking = Look { place: at, peak, agreement: 0, shows: false };
        progress.nearest = Nearest::new();
        at.view(grid).begin(self.track.bounds, strip.scratch(), view);
        Stage::View(place, 0)
    }

    fn view(&self, workspace: &mut Workspace, frame: &Frame<'_>, place: Where, row: u16) -> Stage {
        let Workspace { strip, view, progress, under_way, .. } = workspace;
        let lattice = progress.looking.place.view(&self.track.grid);
        lattice.sample_row(frame, strip.scratch(), row, view);
        under_way.spend(strip.scratch().work(VIEWED));
        if row + 1 < lattice.rows {
            return Stage::View(place, row + 1);
        }
        if place == Where::Locked { self.look(workspace, place) } else { Stage::Compare(place, 0) }
    }

    /// The early template and the view that is compared with it.
    fn compared<'a>(&'a self, view: &'a [u8], was: Contrast) -> Option<Compared<'a>> {
        let Grid { columns, rows, .. } = self.track.grid;
        let view = Image::new(view, columns + 2 * MARGIN, rows + 2 * MARGIN).ok()?;
        Some(Compared { view, early: self.early, was, columns, rows })
    }

    /// The score of the early template at one place, in the light of the view's middle.
    fn compare(&self, workspace: &mut Workspace, place: Where, number: u16) -> Stage {
        let Workspace { view, lit, table, progress, under_way, .. } = workspace;
        if let Some(compared) = self.compared(view, progress.was) {
            let at = progress.nearest.place(number);
            if number == 0 {
                compared.light(at, lit, table, self.config.table);
                under_way.spend(LIT * self.track.grid.pixels());
            }
            progress.nearest.add(number, compared.score(at, lit, &Scorer::new(self.backend(), table)));
        }
        under_way.spend(COMPARED * self.track.grid.pixels());
        if number + 1 < PLACES { Stage::Compare(place, number + 1) } else { Stage::Agree(place) }
    }

    /// How well the early template agrees at the best of these places.
    fn agree(&self, workspace: &mut Workspace, place: Where) -> Stage {
        let Workspace { view, lit, table, progress, under_way, .. } = workspace;
        if let Some(compared) = self.compared(view, progress.was) {
            let at = progress.nearest.at;
            let look = &mut progress.looking;
            look.shows = compared.light(at, lit, table, self.config.table);
            if look.shows {
                look.agreement = compared.agreement(at, lit, &Scorer::new(self.backend(), table));
            }
        }
        under_way.spend((LIT + COMPARED) * self.track.grid.pixels());
        if place == Where::Elsewhere { self.swept(workspace) } else { Stage::Refine }
    }

    /// Moves the place to where the early template lies, if it agrees well.
    fn refine(&self, workspace: &mut Workspace) -> Stage {
        let Workspace { view, lit, table, progress, under_way, .. } = workspace;
        let grid = &self.track.grid;
        let (look, at) = (&mut progress.looking, progress.nearest.at);
        let exact = self.compared(view, progress.was).and_then(|compared| {
            let lit = Image::new(lit, grid.columns, grid.rows).ok()?;
            Exact::of(look.agreement, at, compared.seen(at)?, lit, table.threshold())
        });
        if let Some(Exact { x, y, growth }) = exact {
            look.place = look.place.moved(grid, (x, y)).inside(self.track.bounds);
            progress.growth = Some(growth);
        }
        under_way.spend(REFINED * grid.pixels());
        self.looked(workspace)
    }

    /// The look where the target was expected is done.
    fn looked(&self, workspace: &mut Workspace) -> Stage {
        let progress = &mut workspace.progress;
        let look = progress.looking;
        progress.look = look;
        progress.offset = offset(&self.track.grid, self.centre(Where::Expected), look.place);
        (progress.highest, progress.scale) = (i64::MIN, look.place.scale);
        if let Some(next) = &mut progress.next
            && self.config.parts.verification
        {
            next.trust = self.track.trust.after(look.evidence(), self.config.patience);
        }
        if self.config.size { self.look_at_size(workspace, 0) } else { self.sized(workspace) }
    }

    /// Begins a look at a scale: the last one, a little smaller, a little larger. All three are looked at around the same place, so that
    /// none gains by where it was sampled.
    fn look_at_size(&self, workspace: &mut Workspace, number: usize) -> Stage {
        let Workspace { strip, aside, progress, .. } = workspace;
        match progress.aside(number, &self.track.grid) {
            Some((_, lattice)) => {
                strip.begin(self.track.bounds, &lattice, aside);
                Stage::SeeSize(number)
            }
            None => self.sized(workspace),
        }
    }

    fn see_size(&self, workspace: &mut Workspace, frame: &Frame<'_>, number: usize) -> Stage {
        let Workspace { strip, aside, progress, under_way, .. } = workspace;
        let Some((_, lattice)) = progress.aside(number, &self.track.grid) else { return Stage::Size(number) };
        let seen = strip.row(frame, &lattice, aside);
        under_way.spend(strip.scratch().work(SEEN));
        if seen { Stage::Size(number) } else { Stage::SeeSize(number) }
    }

    fn size(&self, workspace: &mut Workspace, number: usize) -> Stage {
        let (grid, products) = (&self.track.grid, self.products());
        let Workspace { strip, aside, desk, progress, under_way, .. } = workspace;
        let span = 2 * usize::from(SIZE_REACH) + 1;
        let under = (&aside[..], layout(grid, span));
        let responses = desk.few(products, strip.room(), progress.shift, under);
        let height = i64::from(responses::peak(responses, span, false).height);
        let counts = if number == 0 { height } else { (height * SIZE_PART) >> 8 };
        if let Some((scale, _)) = progress.aside(number, grid).filter(|_| counts > progress.highest) {
            (progress.highest, progress.scale) = (counts, scale);
        }
        under_way.spend(u32::from(2 * SIZE_REACH + 1).pow(2) * weights(grid));
        self.look_at_size(workspace, number + 1)
    }

    /// The scale is known.
    fn sized(&self, workspace: &mut Workspace) -> Stage {
        let Progress { next, look, scale, growth, learns, .. } = &mut workspace.progress;
        let Some(next) = next else { return Stage::Done };
        look.place.scale = match growth {
            Some(growth) if self.config.size => grown(look.place.scale, *growth),
            _ => *scale,
        };
        if look.shows || !self.config.parts.verification {
            next.follow(look.place);
        } else {
            next.hold();
        }
        if next.trust.state(self.config) == State::Lost {
            return if self.config.sweep { self.look(workspace, Where::Elsewhere) } else { Stage::Done };
        }
        let Parts { caution, verification, .. } = self.config.parts;
        let teaches = look.evidence().teaches() || !caution || !verification;
        *learns = teaches;
        if teaches { Stage::Errors } else { Stage::Done }
    }

    /// The look elsewhere is done.
    fn swept(&self, workspace: &mut Workspace) -> Stage {
        let Progress { next, look, looking, .. } = &mut workspace.progress;
        let Some(next) = next else { return Stage::Done };
        next.swept();
        if looking.evidence().finds(look.evidence()) {
            next.find(looking.place);
            next.trust = Trust::found(looking.evidence());
            *look = *looking;
        }
        Stage::Done
    }

    // Cells and responses are those of the first look while the filter learns: only a lost target is looked for elsewhere.

    fn errors(&self, workspace: &mut Workspace) -> Stage {
        let Workspace { desk, responses, progress, under_way, .. } = workspace;
        let sample = Sample { responses, target: progress.offset, reach: self.config.reach() };
        progress.coded = self.filter.errors(&self.track.grid, &sample, desk);
        under_way.spend(words(self.config.span().pow(2)) + CODED * weights(&self.track.grid));
        Stage::Gather(0)
    }

    fn gather(&self, workspace: &mut Workspace, part: usize) -> Stage {
        let Workspace { strip, desk, cells, under_way, .. } = workspace;
        let under = (&cells[..], self.layout());
        under_way.spend(words(self.products().gather_work(part, under.1, self.filter.weights().len())));
        let gathered = desk.gather(self.products(), strip.room(), under, part);
        if gathered { Stage::Slopes } else { Stage::Gather(part + 1) }
    }

    fn slopes(&self, workspace: &mut Workspace) -> Stage {
        let Workspace { desk, progress, under_way, .. } = workspace;
        (progress.coded, progress.descent) = self.filter.slopes(&self.track.grid, desk, progress.coded);
        under_way.spend(SLOPED * weights(&self.track.grid));
        Stage::Bend(0)
    }

    fn bend(&self, workspace: &mut Workspace, part: usize) -> Stage {
        let Workspace { strip, desk, cells, progress, under_way, .. } = workspace;
        let under = (&cells[..], self.layout());
        under_way.spend(words(self.products().work(part, under.1, self.filter.weights().len())));
        if !desk.bends(self.products(), strip.room(), under, part) {
            return Stage::Bend(part + 1);
        }
        let rate = if progress.lessons > 0 { FIRST_RATE } else { self.config.learning_rate };
        progress.change = Some(desk.change((progress.coded, progress.descent), rate));
        under_way.spend(CODED * weights(&self.track.grid));
        Stage::Done
    }

    fn backend(&self) -> Backend {
        self.config.backend.unwrap_or_else(Backend::best)
    }

    fn products(&self) -> Products {
        Products::new(self.backend())
    }
}

impl Progress {
    /// The scale of that number, the last one first, and what is looked at there.
    fn aside(&self, number: usize, grid: &Grid) -> Option<(u32, Lattice)> {
        let Place { scale, .. } = self.look.place;
        let [smaller, larger] = other_scales(scale);
        let scale = *[scale, smaller, larger].get(number)?;
        Some((scale, Place { scale, ..self.look.place }.window(grid, SIZE_REACH)))
    }
}

impl Workspace {
    /// Makes the cells of a search window.
    pub(super) fn see(&mut self, frame: &Frame<'_>, window: &Lattice) -> bool {
        self.strip.features(frame, window, &mut self.cells)
    }

    /// Makes a part of the filter's responses to them, its weights coded as they are on the desk; true when this was the last part.
    #[inline(never)] // one copy in flash
    fn respond_part(&mut self, layout: Layout, products: Products, part: usize) -> bool {
        let Self { strip, desk, cells, responses, progress, under_way, .. } = self;
        let under = (&cells[..], layout);
        responses.span = layout.span;
        under_way.spend(words(products.work(part, layout, desk.weights())));
        desk.responses(products, strip.room(), progress.shift, under, part, &mut responses.rows)
    }

    /// Codes the filter's weights and makes all its responses.
    #[inline(never)] // one copy in flash
    pub(super) fn respond(&mut self, filter: &Filter, layout: Layout, products: Products) {
        self.progress.shift = filter.code(&mut self.desk);
        let mut parts = 0..;
        while !self.respond_part(layout, products, parts.next().unwrap_or(0)) {}
    }

    /// What is seen where the early template agrees best.
    pub(super) fn patch(&self, grid: &Grid) -> Option<Image<'_>> {
        let Grid { columns, rows, .. } = *grid;
        let [left, top] = self.progress.nearest.in_view().map(i32::from);
        let view = Image::new(&self.view, columns + 2 * MARGIN, rows + 2 * MARGIN).ok()?;
        view.crop(Rect::new(left, top, columns, rows))
    }
}

impl Robust {
    /// What an update goes by, or a lock that will have this track.
    pub(super) fn given(&self, track: Track) -> Target<'_> {
        let Self { config, filter, early, .. } = self;
        Target { config, filter, early, track }
    }
}

fn words(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// A little smaller, and a little larger.
pub(super) fn other_scales(scale: u32) -> [u32; 2] {
    let scale = u64::from(scale);
    [(scale << 16) / SIZE_STEP, (scale * SIZE_STEP) >> 16]
        .map(|scale| u32::try_from(scale).unwrap_or(SCALE).clamp(LEAST_SCALE, MOST_SCALE))
}

/// So many 65536ths larger.
fn grown(scale: u32, growth: i32) -> u32 {
    let grown = i64::from(scale) + ((i64::from(scale) * i64::from(growth)) >> 16);
    u32::try_from(grown).unwrap_or(SCALE).clamp(LEAST_SCALE, MOST_SCALE)
}

/// Where the target is in a window, from its middle, in units of 1/256 cell.
fn offset(grid: &Grid, centre: Place, target: Place) -> (i32, i32) {
    let cell = (i64::from(CELL) * grid.step_at(centre.scale)).max(1);
    let part = |to: i64, from: i64| i32::try_from((to - from) * 256 / cell).unwrap_or(0);
    (part(target.x, centre.x), part(target.y, centre.y))
}

fn weights(grid: &Grid) -> u32 {
    u32::from(grid.across) * u32::from(grid.down) * u32::try_from(CHANNELS).unwrap_or(0)
}

/// True for a scale that a target can have.
pub(super) fn scale_is_known(scale: u32) -> bool {
    (LEAST_SCALE..=MOST_SCALE).contains(&scale)
}
