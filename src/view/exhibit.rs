//! What there is to be seen: the studio hangs it up, the [painter](super::painter) comes to look.

use super::look::Layer;
use super::picture::Shown;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What there is to be seen.
#[derive(Clone)]
pub struct Exhibit {
    /// Grows at each change.
    pub serial: u64,
    /// Whether it changes of itself: a round is under way.
    pub busy: bool,
    /// That of the images.
    pub generation: u64,
    /// When they were begun.
    pub since: Instant,
    /// What is shown of them.
    pub layer: Layer,
    /// The images, in the order of the view.
    pub sides: Vec<Shown>,
    /// Whether anybody waits for a picture.
    pub awaited: bool,
    /// No picture will be wanted any more.
    pub over: bool,
}

impl Exhibit {
    /// Whether there is something to be seen of every side.
    pub fn is_complete(&self) -> bool {
        !self.sides.is_empty() && self.sides.iter().all(|side| !side.is_empty())
    }

    /// That of images that begin now.
    pub fn begin(&self, generation: u64, layer: Layer, sides: Vec<Shown>) -> Self {
        Self {
            generation,
            layer,
            since: Instant::now(),
            sides,
            ..self.clone()
        }
    }
}

/// The exhibit, and who waits for it.
pub struct Gallery {
    exhibit: Mutex<Exhibit>,
    /// It is another, or somebody waits for a picture.
    changed: Condvar,
}

impl Gallery {
    /// With nothing in it.
    pub fn new(layer: Layer) -> Self {
        let exhibit = Exhibit {
            serial: 0,
            busy: false,
            generation: 0,
            since: Instant::now(),
            layer,
            sides: Vec::new(),
            awaited: false,
            over: false,
        };
        Self {
            exhibit: Mutex::new(exhibit),
            changed: Condvar::new(),
        }
    }

    fn exhibit(&self) -> MutexGuard<'_, Exhibit> {
        self.exhibit.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes it.
    pub fn show(&self, change: impl FnOnce(&mut Exhibit)) {
        let mut exhibit = self.exhibit();
        change(&mut exhibit);
        exhibit.serial += 1;
        self.changed.notify_all();
    }

    /// Somebody has drawn the last picture, and waits for the next.
    pub fn await_picture(&self) {
        self.exhibit().awaited = true;
        self.changed.notify_all();
    }

    /// Waits until it is `due`, which says how long that will take otherwise, as far as is known. Gives a copy; whoever waited
    /// for a picture will get one.
    pub fn visit(&self, due: impl Fn(&Exhibit) -> Option<Duration>) -> Exhibit {
        let mut exhibit = self.exhibit();
        loop {
            let wait = match due(&exhibit) {
                Some(Duration::ZERO) => break,
                Some(wait) => wait,
                None => Duration::MAX,
            };
            // So long that it is as good as for ever, and no overflow.
            let wait = wait.min(Duration::from_secs(3600));
            let woken = self.changed.wait_timeout(exhibit, wait);
            exhibit = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        let copy = exhibit.clone();
        // Of what is empty there will be none.
        exhibit.awaited &= !copy.is_complete();
        copy
    }
}
