//! When a picture is painted: at once after a change, then less and less often, and only if somebody waits for it.

use super::exhibit::{Exhibit, Gallery};
use super::look::Layer;
use super::picture::{Picture, paint};
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// Least time between two pictures.
const QUICKEST: Duration = Duration::from_millis(66);
/// And the most: by then pictures differ little.
const SLOWEST: Duration = Duration::from_secs(1);
/// A picture follows another when the image is older by a tenth.
const GROWTH: u32 = 10;

/// Paints until it is over.
pub fn work(gallery: &Gallery, pictures: &watch::Sender<Option<Picture>>) {
    let mut last = Last {
        serial: 0,
        of: None,
        at: Instant::now(),
        took: Duration::ZERO,
    };
    for number in 1.. {
        let exhibit = gallery.visit(|exhibit| last.due(exhibit));
        if exhibit.over {
            return;
        }
        let begin = Instant::now();
        let Exhibit {
            generation, layer, ..
        } = exhibit;
        let picture = exhibit
            .is_complete()
            .then(|| paint(number, generation, layer, &exhibit.sides));
        let painted = picture.is_some();
        pictures.send_replace(picture);
        last = Last {
            serial: exhibit.serial,
            of: painted.then_some((generation, layer)),
            at: begin,
            took: begin.elapsed(),
        };
    }
}

/// The last picture.
struct Last {
    serial: u64,
    /// Its generation and layer; none where it was empty.
    of: Option<(u64, Layer)>,
    at: Instant,
    took: Duration,
}

impl Last {
    /// How long until the next is due, if nothing changes.
    fn due(&self, exhibit: &Exhibit) -> Option<Duration> {
        if exhibit.over {
            return Some(Duration::ZERO);
        }
        if !exhibit.is_complete() {
            // What was freed is not shown any more.
            let freed = exhibit.sides.is_empty() && self.of.is_some();
            return freed.then_some(Duration::ZERO);
        }
        let changed = exhibit.serial != self.serial || exhibit.busy;
        if !exhibit.awaited || !changed {
            return None;
        }
        if self.of != Some((exhibit.generation, exhibit.layer)) {
            return Some(Duration::ZERO);
        }
        let age = exhibit.since.elapsed() / GROWTH;
        // Painting must not take what rendering needs.
        let rest = age.clamp(QUICKEST, SLOWEST).max(self.took * GROWTH);
        Some(rest.saturating_sub(self.at.elapsed()))
    }
}
