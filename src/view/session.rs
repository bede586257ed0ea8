//! What the studio's thread has in hand: the view that is rendered, and its sides.

use super::look::View;
use super::side::Side;
use super::sides::{Sides, Watcher};
use super::studio::{Current, Doing, Report, Studio};
use super::wish::{Reply, Wish};
use crate::error::{Error, Result};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Least time between two reports of what the render has come to.
const REPORTS: Duration = Duration::from_millis(500);

/// The view that is rendered, and how far it is.
pub struct Session<'a> {
    studio: &'a Studio,
    sides: Sides,
    current: Current,
    /// None where there is something to be told at once.
    reported: Option<Instant>,
}

impl<'a> Session<'a> {
    /// Of the view that is first looked at.
    pub fn new(studio: &'a Studio, sides: Sides) -> Self {
        Self {
            current: studio.current.borrow().clone(),
            reported: None,
            studio,
            sides,
        }
    }

    /// Goes over to another view, or says why it cannot be. Whoever asked may be gone, here and below.
    pub fn look(&mut self, view: View, reply: Reply<Current>) {
        let keeps = self.current.view.keeps_samples(&view) && self.sides.is_open();
        let answer = match keeps {
            true => self.sides.adjust(&view),
            false => self.sides.set(&view),
        };
        self.reported = None;
        if let Err(error) = answer {
            let _ = reply.send(Err(error));
            return;
        }
        self.current = Current {
            version: self.current.version + 1,
            generation: self.current.generation + u64::from(!keeps),
            view,
        };
        // The answer comes before the news.
        let _ = reply.send(Ok(self.current.clone()));
        self.tell(!keeps);
    }

    /// Begins the images anew, if there are none.
    ///
    /// # Errors
    /// [`Error::Usage`] where there can be none.
    pub fn open(&mut self) -> Result<()> {
        if self.sides.is_open() {
            return Ok(());
        }
        let current = &mut self.current;
        if self.sides.set(&current.view).is_err() {
            // What could be looked at before may not fit in memory any more.
            current.view = self.studio.start.clone();
            self.sides.set(&current.view)?;
        }
        current.version += 1;
        current.generation += 1;
        self.tell(true);
        Ok(())
    }

    /// Frees the images.
    pub fn close(&mut self) {
        if self.sides.is_open() {
            self.sides.close();
            self.studio.gallery.show(|exhibit| exhibit.sides.clear());
        }
    }

    /// Tells all what is looked at now, and whether its images are new.
    fn tell(&self, anew: bool) {
        let Current {
            generation, view, ..
        } = &self.current;
        self.studio.gallery.show(|exhibit| match anew {
            true => *exhibit = exhibit.begin(*generation, view.layer, self.sides.shown()),
            false => exhibit.layer = view.layer,
        });
        self.studio.current.send_replace(self.current.clone());
    }

    /// Does what was asked for.
    pub fn fulfil(&mut self, wishes: Vec<Wish>) {
        if wishes.is_empty() {
            return;
        }
        for wish in wishes {
            match wish {
                Wish::Pick(x, y, reply) => {
                    let _ = reply.send(self.sides.pick(x, y));
                }
                Wish::CommandLine(side, tonemap, reply) => {
                    let whole = self.make_whole(side);
                    let line = whole.and_then(|()| self.sides.command_line(side, tonemap));
                    let _ = reply.send(line);
                }
                Wish::Save(side, format, reply) => {
                    let whole = self.make_whole(side);
                    let _ = reply.send(whole.and_then(|()| self.sides.save(side, format)));
                }
            }
        }
        // A pass may have been ended for it.
        let shown = self.sides.shown();
        self.studio.gallery.show(|exhibit| exhibit.sides = shown);
        self.reported = None;
    }

    /// Ends the pass of a side that is under way.
    fn make_whole(&mut self, side: usize) -> Result<()> {
        while self.studio.goes_on() {
            if self.sides.make_whole(side, &self.studio.stop)? {
                return Ok(());
            }
        }
        Err(Error::Usage(
            "the view changed before the image was whole; ask again".to_owned(),
        ))
    }

    /// Renders a round, and tells what the render has come to. False where there is nothing to be rendered.
    ///
    /// # Errors
    /// [`Error::Usage`] where an image cannot be rendered that was found to be right.
    pub fn round(&mut self, paused: bool) -> Result<bool> {
        let next = self.sides.next(self.current.view.balance);
        let doing = match (paused, &next) {
            (_, None) => Doing::Done,
            (true, _) => Doing::Paused,
            _ => Doing::Rendering,
        };
        let due = self.reported.is_none_or(|last| last.elapsed() >= REPORTS);
        if doing != Doing::Rendering || due {
            self.report(doing);
        }
        // A pause shows what it stopped at, if only coarsely.
        let goes_on = doing == Doing::Rendering || self.sides.is_coarse();
        let Some(next) = next.filter(|_| goes_on) else {
            return Ok(false);
        };
        let meanwhile = Meanwhile::new(self.studio, next);
        let gallery = &self.studio.gallery;
        let watcher = Watcher {
            begun: &|shown| gallery.show(|exhibit| (exhibit.busy, exhibit.sides) = (true, shown)),
            progress: &|paths| meanwhile.tell(paths),
        };
        self.sides.render(next, &self.studio.stop, &watcher)?;
        let shown = self.sides.shown();
        gallery.show(|exhibit| (exhibit.busy, exhibit.sides) = (false, shown));
        Ok(true)
    }

    fn report(&mut self, state: Doing) {
        self.reported = Some(Instant::now());
        self.studio.report.send_replace(Arc::new(Report {
            generation: self.current.generation,
            state,
            sides: self.sides.sides().iter().map(Side::report).collect(),
        }));
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
