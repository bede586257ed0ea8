//! Where the view is rendered: one thread that gives rounds of waves to the workers, and starts anew when the view changes.
//!
//! A round is some whole passes (16 samples of each pixel) over one side, about [`ROUND`] long. Between rounds an image can be
//! saved that any `ondine render` would have made, and the noise be measured. A change stops the round under way after the
//! waves in hand, some milliseconds each.

use super::exhibit::Gallery;
use super::look::View;
use super::side::{Side, SideReport};
use super::sides::{Sides, Watcher};
use super::wish::{Format, Picked, Reply, Saved, Wish};
use crate::error::{Error, Result};
use crate::film::tonemap::Tonemap;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{oneshot, watch};

/// Least time between two reports of what the render has come to.
const REPORTS: Duration = Duration::from_millis(500);

/// What the studio is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Doing {
    /// Samples are being traced, or would be if anybody looked.
    Rendering,
    /// Somebody said so.
    Paused,
    /// The limit is reached.
    Done,
}

/// The view that is rendered now.
#[derive(Clone, Debug)]
pub struct Current {
    /// Grows when the view changes.
    pub version: u64,
    /// Grows when the image begins anew.
    pub generation: u64,
    /// What is looked at.
    pub view: View,
}

/// What the sides have come to.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename = "stats")]
pub struct Report {
    /// Of [`Current::generation`].
    pub generation: u64,
    /// What is being done.
    pub state: Doing,
    /// In the order of the view.
    pub sides: Vec<SideReport>,
}

#[derive(Default)]
struct Desk {
    /// The newest; what came before it is never rendered.
    view: Option<(View, Reply<Current>)>,
    wishes: Vec<Wish>,
    readers: usize,
    paused: bool,
    quit: bool,
}

impl Desk {
    fn wish(&mut self, wish: Wish) {
        // Those who asked before may be gone: so many wait as there are askers.
        self.wishes.retain(|wish| !wish.is_in_vain());
        self.wishes.push(wish);
    }
}

/// The studio as others see it.
pub struct Studio {
    desk: Mutex<Desk>,
    news: Condvar,
    /// Stops the round under way.
    stop: AtomicBool,
    /// What there is to be seen.
    pub gallery: Gallery,
    /// What can always be looked at.
    start: View,
    current: watch::Sender<Current>,
    report: watch::Sender<Arc<Report>>,
}

impl Studio {
    /// For a view that nobody has looked at yet.
    pub fn new(view: View) -> Self {
        let (layer, start) = (view.layer, view.clone());
        let current = Current {
            version: 0,
            generation: 0,
            view,
        };
        let report = Report {
            generation: 0,
            state: Doing::Rendering,
            sides: Vec::new(),
        };
        Self {
            desk: Mutex::default(),
            news: Condvar::new(),
            stop: AtomicBool::new(false),
            gallery: Gallery::new(layer),
            start,
            current: watch::Sender::new(current),
            report: watch::Sender::new(Arc::new(report)),
        }
    }

    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes what the studio is to do.
    fn tell(&self, change: impl FnOnce(&mut Desk)) {
        change(&mut self.desk());
        self.news.notify_all();
    }

    /// The same, and the round under way ends.
    fn tell_at_once(&self, change: impl FnOnce(&mut Desk)) {
        let mut desk = self.desk();
        change(&mut desk);
        self.stop.store(true, Ordering::Relaxed);
        self.news.notify_all();
    }

    /// The view as it is, and as it will be.
    pub fn views(&self) -> watch::Receiver<Current> {
        self.current.subscribe()
    }

    /// What the render comes to.
    pub fn reports(&self) -> watch::Receiver<Arc<Report>> {
        self.report.subscribe()
    }

    /// Looks at something else. A view that is followed by another before it was begun gets no answer.
    pub fn look(&self, view: View) -> oneshot::Receiver<Result<Current>> {
        let (reply, answer) = oneshot::channel();
        self.tell_at_once(|desk| desk.view = Some((view, reply)));
        answer
    }

    /// What is at a pixel of the view.
    pub fn pick(&self, x: u32, y: u32) -> oneshot::Receiver<Result<Option<Picked>>> {
        let (reply, answer) = oneshot::channel();
        self.tell_at_once(|desk| desk.wish(Wish::Pick(x, y, reply)));
        answer
    }

    /// Writes a file of a side once its passes are whole.
    pub fn save(&self, side: usize, format: Format) -> oneshot::Receiver<Result<Saved>> {
        let (reply, answer) = oneshot::channel();
        self.tell(|desk| desk.wish(Wish::Save(side, format, reply)));
        answer
    }

    /// The command line that renders what there is of a side once its passes are whole.
    pub fn command_line(
        &self,
        side: usize,
        tonemap: Option<Tonemap>,
    ) -> oneshot::Receiver<Result<String>> {
        let (reply, answer) = oneshot::channel();
        self.tell(|desk| desk.wish(Wish::CommandLine(side, tonemap, reply)));
        answer
    }

    /// Stops tracing, or goes on.
    pub fn pause(&self, paused: bool) {
        self.tell_at_once(|desk| desk.paused = paused);
    }

    /// Somebody looks. Without anybody nothing is rendered, and the films are freed.
    pub fn enter(self: &Arc<Self>) -> Reader {
        self.tell(|desk| desk.readers += 1);
        Reader(self.clone())
    }

    /// Ends [`Studio::work`].
    pub fn quit(&self) {
        self.tell_at_once(|desk| desk.quit = true);
        self.gallery.show(|exhibit| exhibit.over = true);
    }

    /// Renders until it is told to quit.
    ///
    /// # Errors
    /// [`Error::Usage`] where an image cannot be rendered that was found to be right.
    pub fn work(&self, mut sides: Sides) -> Result<()> {
        let (mut version, mut generation) = (0, 0);
        let mut view = self.current.borrow().view.clone();
        // None where there is something to be told at once.
        let mut reported: Option<Instant> = None;
        loop {
            let mut desk = self.desk();
            self.stop.store(false, Ordering::Relaxed);
            if desk.quit {
                return Ok(());
            }
            if let Some((wanted, reply)) = desk.view.take() {
                drop(desk);
                let keeps = view.keeps_samples(&wanted) && sides.is_open();
                let answer = match keeps {
                    true => sides.adjust(&wanted),
                    false => sides.set(&wanted),
                };
                reported = None;
                if let Err(error) = answer {
                    // Who asked may be gone, here and below.
                    let _ = reply.send(Err(error));
                    continue;
                }
                version += 1;
                view = wanted;
                let answer = |generation| Current {
                    version,
                    generation,
                    view: view.clone(),
                };
                // The answer comes before the news.
                if keeps {
                    let _ = reply.send(Ok(answer(generation)));
                    self.gallery.show(|exhibit| exhibit.layer = view.layer);
                    self.current.send_replace(answer(generation));
                } else {
                    generation += 1;
                    let _ = reply.send(Ok(answer(generation)));
                    self.begin(version, generation, &view, &sides);
                }
                continue;
            }
            if desk.readers == 0 {
                // Nobody looks: no image needs to be kept.
                desk.wishes.clear();
                if sides.is_open() {
                    sides.close();
                    self.gallery.show(|exhibit| exhibit.sides.clear());
                }
                drop(self.news.wait(desk));
                continue;
            }
            if !sides.is_open() {
                drop(desk);
                if sides.set(&view).is_err() {
                    // What could be looked at before may not fit in memory any more.
                    view = self.start.clone();
                    sides.set(&view)?;
                }
                (version, generation) = (version + 1, generation + 1);
                self.begin(version, generation, &view, &sides);
                continue;
            }
            let paused = desk.paused;
            let wishes = std::mem::take(&mut desk.wishes);
            drop(desk);
            if !wishes.is_empty() {
                for wish in wishes {
                    self.fulfil(wish, &mut sides);
                }
                // A pass may have been ended for it.
                let shown = sides.shown();
                self.gallery.show(|exhibit| exhibit.sides = shown);
                reported = None;
            }
            let next = sides.next(view.balance);
            let doing = match (paused, &next) {
                (_, None) => Doing::Done,
                (true, _) => Doing::Paused,
                _ => Doing::Rendering,
            };
            let due = reported.is_none_or(|last| last.elapsed() >= REPORTS);
            if doing != Doing::Rendering || due {
                self.report(generation, doing, &sides);
                reported = Some(Instant::now());
            }
            // A pause shows what it stopped at, if only coarsely.
            match next.filter(|_| doing == Doing::Rendering || sides.is_coarse()) {
                Some(next) => {
                    let meanwhile = Meanwhile::new(self, next);
                    let watcher = Watcher {
                        begun: &|shown| {
                            self.gallery
                                .show(|exhibit| (exhibit.busy, exhibit.sides) = (true, shown));
                        },
                        progress: &|paths| meanwhile.tell(paths),
                    };
                    sides.render(next, &self.stop, &watcher)?;
                    let shown = sides.shown();
                    self.gallery
                        .show(|exhibit| (exhibit.busy, exhibit.sides) = (false, shown));
                }
                None => self.wait_for_news(paused),
            }
        }
    }

    /// Tells all that images begin.
    fn begin(&self, version: u64, generation: u64, view: &View, sides: &Sides) {
        let shown = sides.shown();
        self.gallery
            .show(|exhibit| *exhibit = exhibit.begin(generation, view.layer, shown));
        self.current.send_replace(Current {
            version,
            generation,
            view: view.clone(),
        });
    }

    /// Waits while there is nothing to be done.
    fn wait_for_news(&self, paused: bool) {
        let mut desk = self.desk();
        while desk.view.is_none()
            && desk.wishes.is_empty()
            && desk.readers > 0
            && desk.paused == paused
            && !desk.quit
        {
            desk = self.news.wait(desk).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn report(&self, generation: u64, state: Doing, sides: &Sides) {
        self.report.send_replace(Arc::new(Report {
            generation,
            state,
            sides: sides.sides().iter().map(Side::report).collect(),
        }));
    }

    /// Does what was asked for. Whoever asked may be gone.
    fn fulfil(&self, wish: Wish, sides: &mut Sides) {
        match wish {
            Wish::Pick(x, y, reply) => {
                let _ = reply.send(sides.pick(x, y));
            }
            Wish::CommandLine(side, tonemap, reply) => {
                let _ = reply.send(
                    self.whole(side, sides)
                        .and_then(|()| sides.command_line(side, tonemap)),
                );
            }
            Wish::Save(side, format, reply) => {
                let _ = reply.send(
                    self.whole(side, sides)
                        .and_then(|()| sides.save(side, format)),
                );
            }
        }
    }

    /// Ends the pass of a side that is under way.
    fn whole(&self, side: usize, sides: &mut Sides) -> Result<()> {
        loop {
            let desk = self.desk();
            if desk.view.is_some() || desk.quit || desk.readers == 0 {
                return Err(Error::Usage(
                    "the view changed before the image was whole; ask again".to_owned(),
                ));
            }
            // Whatever else stops a round can wait.
            self.stop.store(false, Ordering::Relaxed);
            drop(desk);
            if sides.make_whole(side, &self.stop)? {
                return Ok(());
            }
        }
    }
}

/// What is told of a round that takes long.
struct Meanwhile<'a> {
    studio: &'a Studio,
    /// As it was before the round.
    report: Arc<Report>,
    side: usize,
    begin: Instant,
    paths: AtomicU64,
    told: Mutex<Instant>,
}

impl<'a> Meanwhile<'a> {
    fn new(studio: &'a Studio, side: usize) -> Self {
        let begin = Instant::now();
        Self {
            report: studio.report.borrow().clone(),
            paths: AtomicU64::new(0),
            told: Mutex::new(begin),
            studio,
            side,
            begin,
        }
    }

    /// A worker has traced so many more paths.
    fn tell(&self, paths: u64) {
        let paths = self.paths.fetch_add(paths, Ordering::Relaxed) + paths;
        // Whoever is not the first goes on.
        let Ok(mut told) = self.told.try_lock() else {
            return;
        };
        if told.elapsed() < REPORTS {
            return;
        }
        *told = Instant::now();
        let mut report = Report::clone(&self.report);
        if let Some(side) = report.sides.get_mut(self.side) {
            *side = side.with(paths, self.begin.elapsed());
            self.studio.report.send_replace(Arc::new(report));
        }
    }
}

/// Somebody who looks, until dropped.
pub struct Reader(Arc<Studio>);

impl Drop for Reader {
    fn drop(&mut self) {
        // A round that was ended goes on, if somebody else looks.
        self.0.tell_at_once(|desk| desk.readers -= 1);
    }
}
