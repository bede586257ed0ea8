//! The workers of one or many images: each takes a wave of the oldest image that has one, and the last to finish with an
//! image sees to it.

use super::{Frame, Rendered};
use crate::stats::Stats;
use crate::wavefront::{Context, Tally, Wave, Workspace};
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How many times as long as a checkpoint took there is none.
const REST: u32 = 4;

/// What the workers share: images under way, each with a `T` that tells its owner which it is.
pub(super) struct Crew<'a, T> {
    desk: Mutex<Desk<T>>,
    /// There is something to do, or to leave for.
    news: Condvar,
    /// The last wave of an image was begun.
    room: Condvar,
    threads: usize,
    stopped: &'a (dyn Fn() -> bool + Sync),
}

struct Desk<T> {
    /// Oldest first.
    open: VecDeque<Course<T>>,
    /// Whether further images may come.
    more: bool,
    /// A worker panicked: what it had in hand will never end.
    broken: bool,
}

/// How far an image is.
struct Course<T> {
    frame: Arc<Frame>,
    owner: Arc<T>,
    /// Number of the next wave.
    next: u64,
    /// Waves that workers have in hand.
    running: usize,
    /// A checkpoint is being written.
    held: bool,
    /// When the next checkpoint is due; with the first wave the time begins.
    due: Option<Instant>,
    tally: Tally,
    /// Seconds of all workers together.
    busy: Duration,
}

/// What a worker does next.
enum Step<T> {
    /// The last field is whether it is the image's last wave.
    Trace(Arc<Frame>, Wave, bool),
    Keep(Arc<Frame>, Arc<T>, Rendered),
    End(Arc<T>, Rendered),
    Wait,
    Leave,
}

impl<'a, T> Crew<'a, T> {
    /// Without images. Once `stopped`, no further wave begins.
    pub fn new(threads: usize, stopped: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self {
            desk: Mutex::new(Desk {
                open: VecDeque::new(),
                more: true,
                broken: false,
            }),
            news: Condvar::new(),
            room: Condvar::new(),
            threads,
            stopped,
        }
    }

    /// Puts an image last.
    pub fn open(&self, frame: Frame, owner: T) {
        self.desk().open.push_back(Course {
            frame: Arc::new(frame),
            owner: Arc::new(owner),
            next: 0,
            running: 0,
            held: false,
            due: None,
            tally: Tally::default(),
            busy: Duration::ZERO,
        });
        self.news.notify_all();
    }

    /// No further image will come.
    pub fn close(&self) {
        self.desk().more = false;
        self.news.notify_all();
    }

    /// Waits until fewer than so many images have waves that nobody has begun. False where there is no use in opening more.
    pub fn has_room(&self, waiting: usize) -> bool {
        let mut desk = self.desk();
        loop {
            if desk.broken || (self.stopped)() {
                return false;
            }
            let fresh = desk
                .open
                .iter()
                .filter(|course| course.next < course.frame.plan.waves());
            if fresh.count() < waiting {
                return true;
            }
            // Being stopped is no news.
            let patience = Duration::from_millis(50);
            let woken = self.room.wait_timeout(desk, patience);
            desk = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn desk(&self) -> MutexGuard<'_, Desk<T>> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What a worker does until all images are at their end: `keep` sees an image at its checkpoints, `end` when it is done
    /// or stopped, `progress` the paths of each wave.
    pub fn work(
        &self,
        trace: &impl Fn(&Context, &Wave, &mut Workspace),
        keep: &impl Fn(&T, Rendered),
        end: &impl Fn(Arc<T>, Rendered),
        progress: &(dyn Fn(u64) + Sync),
    ) {
        let _guard = Guard(self);
        let mut own: Option<(Arc<Frame>, Workspace)> = None;
        let mut desk = self.desk();
        loop {
            match desk.step((self.stopped)(), self.threads) {
                Step::Trace(frame, wave, is_last) => {
                    drop(desk);
                    if is_last {
                        self.room.notify_one();
                    }
                    let begin = Instant::now();
                    let ws = match &mut own {
                        Some((of, ws)) if Arc::ptr_eq(of, &frame) => ws,
                        other => &mut other.insert((frame.clone(), frame.workspace())).1,
                    };
                    frame.trace(&wave, ws, trace);
                    progress(wave.paths() as u64);
                    let tally = std::mem::take(&mut ws.tally);
                    desk = self.desk();
                    desk.give_back(&frame, &tally, begin.elapsed());
                }
                Step::Keep(frame, owner, so_far) => {
                    drop(desk);
                    let begin = Instant::now();
                    keep(&owner, so_far);
                    desk = self.desk();
                    desk.go_on(&frame, begin.elapsed());
                    self.news.notify_all();
                }
                Step::End(owner, rendered) => {
                    own = None;
                    drop(desk);
                    end(owner, rendered);
                    desk = self.desk();
                    self.news.notify_all();
                }
                Step::Wait => {
                    // A film may be large.
                    own = None;
                    desk = self.news.wait(desk).unwrap_or_else(PoisonError::into_inner);
                }
                Step::Leave => break,
            }
        }
    }
}

impl<T> Desk<T> {
    fn step(&mut self, stopped: bool, threads: usize) -> Step<T> {
        if self.broken {
            return Step::Leave;
        }
        for (place, course) in self.open.iter_mut().enumerate() {
            if course.held {
                continue;
            }
            let wave = course.frame.plan.wave(course.next);
            let Some(wave) = wave.filter(|_| !stopped) else {
                if course.running == 0 {
                    return self.end(place, threads);
                }
                continue;
            };
            if course.due.is_some_and(|due| Instant::now() >= due) {
                if course.running == 0 {
                    course.held = true;
                    let (frame, owner) = (course.frame.clone(), course.owner.clone());
                    return Step::Keep(frame, owner, course.rendered(threads));
                }
                continue;
            }
            if course.next == 0 {
                course.wait_for_checkpoint(Duration::ZERO);
            }
            course.next += 1;
            course.running += 1;
            let is_last = course.next == course.frame.plan.waves();
            return Step::Trace(course.frame.clone(), wave, is_last);
        }
        match self.open.is_empty() && !self.more {
            true => Step::Leave,
            false => Step::Wait,
        }
    }

    fn end(&mut self, place: usize, threads: usize) -> Step<T> {
        match self.open.remove(place) {
            Some(course) => Step::End(course.owner.clone(), course.rendered(threads)),
            None => Step::Wait,
        }
    }

    fn course(&mut self, frame: &Arc<Frame>) -> Option<&mut Course<T>> {
        self.open
            .iter_mut()
            .find(|course| Arc::ptr_eq(&course.frame, frame))
    }

    /// A wave is done.
    fn give_back(&mut self, frame: &Arc<Frame>, tally: &Tally, busy: Duration) {
        if let Some(course) = self.course(frame) {
            course.running -= 1;
            course.tally.merge(tally);
            course.busy += busy;
        }
    }

    /// A checkpoint is written, and that took so long.
    fn go_on(&mut self, frame: &Arc<Frame>, took: Duration) {
        if let Some(course) = self.course(frame) {
            course.held = false;
            course.wait_for_checkpoint(took * REST);
        }
    }
}

impl<T> Course<T> {
    /// From now on as long as was asked for, and at least so long.
    fn wait_for_checkpoint(&mut self, least: Duration) {
        let every = self.frame.interval().map(|every| every.max(least));
        self.due = every.and_then(|every| Instant::now().checked_add(every));
    }

    /// The image as it is, while no wave is under way.
    fn rendered(&self, threads: usize) -> Rendered {
        Rendered {
            film: self.frame.film.clone(),
            coverage: self.frame.coverage(self.next),
            stats: Stats {
                threads,
                build: Duration::ZERO,
                render: self.busy / u32::try_from(threads).unwrap_or(1).max(1),
                tally: self.tally.clone(),
            },
            interrupted: self.next < self.frame.plan.waves(),
        }
    }
}

/// Lets the others go where a worker panics, so that the panic is seen.
struct Guard<'a, 'b, T>(&'a Crew<'b, T>);

impl<T> Drop for Guard<'_, '_, T> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.desk().broken = true;
            self.0.news.notify_all();
        }
    }
}
