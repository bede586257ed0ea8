//! Many images side by side: while some are traced, the next is read and the last is written, so that no core is idle.

use super::crew::Crew;
use super::{Control, Frame, Rendered, workers};
use crate::error::Result;
use crate::wavefront;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Condvar, Mutex, PoisonError, mpsc};
use std::time::Duration;

/// Images that are ready and of which no wave has begun: one is traced next while another is made.
const READY: usize = 2;
/// Threads that see to finished images. They wait for the disk more than they work.
const WRITERS: usize = 4;

/// The images that [`many`] renders, and what becomes of them.
pub trait Jobs: Sync {
    /// What tells one from another.
    type Job: Send + Sync;

    /// The next, made ready: asked for by one thread, ahead of its turn, while others are traced. None where there is no
    /// more.
    fn next(&self) -> Option<(Self::Job, Frame)>;

    /// An image at a checkpoint; no wave of it is under way.
    fn keep(&self, job: &Self::Job, so_far: Rendered);

    /// An image that is finished or was stopped. Several are seen to at a time.
    fn finish(&self, job: &Self::Job, rendered: Rendered);
}

/// Renders images on so many threads. Where one has no wave left to begin, its workers go on with the next. While the films of
/// those that are not seen to yet take `memory` bytes and more, none is made.
///
/// [`Jobs::next`] and [`Jobs::finish`] run in a rayon pool beside the workers.
///
/// # Errors
/// [`Error::Usage`](crate::error::Error::Usage) where threads cannot be started.
pub fn many<J: Jobs>(jobs: &J, threads: usize, memory: u64, control: &Control) -> Result<()> {
    // Writers wait for the disk, and must not keep trees from being built.
    let (tracers, helpers) = (workers(threads)?, workers(threads + WRITERS)?);
    let stopped = || control.stop.load(Ordering::Relaxed);
    let crew = Crew::new(threads, &stopped);
    let films = Films::default();
    // A finished image waits here for a writer; a bound, so that memory has one.
    let (finished, to_write) = mpsc::sync_channel::<(Arc<J::Job>, Rendered)>(WRITERS);
    let to_write = Arc::new(Mutex::new(to_write));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let _closes = Closes(&crew);
            while crew.has_room(READY) && films.below(memory, &stopped) {
                let Some((job, frame)) = helpers.install(|| jobs.next()) else {
                    break;
                };
                films.add(frame.film.bytes());
                crew.open(frame, job);
            }
        });
        for _ in 0..WRITERS {
            let to_write = to_write.clone();
            let (films, helpers) = (&films, &helpers);
            scope.spawn(move || {
                let next = || {
                    let queue = to_write.lock().unwrap_or_else(PoisonError::into_inner);
                    queue.recv()
                };
                while let Ok((job, rendered)) = next() {
                    let bytes = rendered.film.bytes();
                    helpers.install(|| jobs.finish(&job, rendered));
                    films.remove(bytes);
                }
            });
        }
        // Without a writer left, there is nobody to wait for.
        drop(to_write);
        let keep = |job: &J::Job, so_far| jobs.keep(job, so_far);
        let end = |job, rendered| {
            // Writers end when the last sender does.
            let _ = finished.send((job, rendered));
        };
        tracers.broadcast(|_| crew.work(&wavefront::trace, &keep, &end, control.progress));
        drop(finished);
    });
    Ok(())
}

/// Lets the workers go when no more images come, for whatever reason.
struct Closes<'a, 'b, T>(&'a Crew<'b, T>);

impl<T> Drop for Closes<'_, '_, T> {
    fn drop(&mut self) {
        self.0.close();
    }
}

/// The memory of all films that there are.
#[derive(Default)]
struct Films {
    bytes: Mutex<u64>,
    /// There are fewer.
    freed: Condvar,
}

impl Films {
    fn change(&self, change: impl FnOnce(u64) -> u64) {
        let mut bytes = self.bytes.lock().unwrap_or_else(PoisonError::into_inner);
        *bytes = change(*bytes);
    }

    fn add(&self, film: u64) {
        self.change(|bytes| bytes + film);
    }

    fn remove(&self, film: u64) {
        self.change(|bytes| bytes - film);
        self.freed.notify_all();
    }

    /// Waits until they take less than that; false where nothing is to be made any more.
    fn below(&self, most: u64, stopped: &dyn Fn() -> bool) -> bool {
        let mut bytes = self.bytes.lock().unwrap_or_else(PoisonError::into_inner);
        while *bytes >= most.max(1) && !stopped() {
            // Being stopped is no news.
            let woken = self.freed.wait_timeout(bytes, Duration::from_millis(50));
            bytes = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        !stopped()
    }
}
