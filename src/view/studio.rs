//! Where the view is rendered: one thread that gives rounds of waves to the workers, and starts anew when the view changes.
//!
//! A round is some whole passes (16 samples of each pixel) over one side, about a tenth of a second long. Between rounds an image can be
//! saved that any `ondine render` would have made, and the noise be measured. A change stops the round under way after the
//! waves in hand, some milliseconds each.

use super::exhibit::Gallery;
use super::look::View;
use super::session::Session;
use super::side::SideReport;
use super::sides::Sides;
use super::wish::{Format, Picked, Reply, Saved, Wish};
use crate::error::Result;
use crate::film::tonemap::Tonemap;
use serde::Serialize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use tokio::sync::{oneshot, watch};

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
    pub(super) stop: AtomicBool,
    /// What there is to be seen.
    pub gallery: Gallery,
    /// What can always be looked at.
    pub(super) start: View,
    pub(super) current: watch::Sender<Current>,
    pub(super) report: watch::Sender<Arc<Report>>,
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
    /// [`Error::Usage`](crate::error::Error::Usage) where an image cannot be rendered that was found to be right.
    pub fn work(&self, sides: Sides) -> Result<()> {
        let mut session = Session::new(self, sides);
        loop {
            let mut desk = self.desk();
            self.stop.store(false, Ordering::Relaxed);
            if desk.quit {
                return Ok(());
            }
            if let Some((view, reply)) = desk.view.take() {
                drop(desk);
                session.look(view, reply);
                continue;
            }
            if desk.readers == 0 {
                // Nobody looks: no image needs to be kept.
                desk.wishes.clear();
                session.close();
                drop(self.news.wait(desk));
                continue;
            }
            let (paused, wishes) = (desk.paused, std::mem::take(&mut desk.wishes));
            drop(desk);
            session.open()?;
            session.fulfil(wishes);
            if !session.round(paused)? {
                self.wait_for_news(paused);
            }
        }
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

    /// Forgets what stopped the last round, for one that may only be stopped by what is urgent. False where there is such.
    pub(super) fn goes_on(&self) -> bool {
        let desk = self.desk();
        self.stop.store(false, Ordering::Relaxed);
        desk.view.is_none() && !desk.quit && desk.readers > 0
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
