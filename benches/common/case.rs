//! What every benchmark is: a name, what has to be there before, and the work.

use std::time::Duration;

/// Does something with the work of a case, which has so many elements: times it, or counts its instructions.
pub type Face<'a> = &'a mut dyn FnMut(usize, &mut dyn FnMut());

/// A benchmark. It is defined once, whatever is done with its work.
pub struct Case {
    /// What follows the name of its file in `FILE/NAME`.
    pub name: String,
    /// How long to look at it.
    pub pace: Pace,
    /// Whether its instructions are counted as well. Not where the work is too long for that, or done by threads of its
    /// own.
    pub counted: bool,
    prepare: Box<dyn Fn(Face)>,
}

impl Case {
    /// `prepare` makes ready what the work needs, and hands it to the face with the number of its elements. The same work
    /// again does the same.
    pub fn new(name: impl Into<String>, pace: Pace, prepare: impl Fn(Face) + 'static) -> Self {
        Self {
            name: name.into(),
            pace,
            counted: true,
            prepare: Box::new(prepare),
        }
    }

    /// One whose instructions are not counted.
    pub fn timed(name: impl Into<String>, pace: Pace, prepare: impl Fn(Face) + 'static) -> Self {
        Self {
            counted: false,
            ..Self::new(name, pace, prepare)
        }
    }

    /// Makes ready, and shows the work to `face`.
    ///
    /// # Panics
    /// When the work has no elements: what is measured would be nothing.
    pub fn show(&self, face: Face) {
        (self.prepare)(&mut |elements, work| {
            assert!(elements > 0, "{} has nothing to work on", self.name);
            face(elements, work);
        });
    }
}

/// How long criterion looks at a case.
#[derive(Clone, Copy)]
pub enum Pace {
    /// Some microseconds of work.
    Quick,
    /// Milliseconds, or seconds.
    Slow,
}

impl Pace {
    pub fn samples(self) -> usize {
        match self {
            Pace::Quick => 20,
            Pace::Slow => 10,
        }
    }

    pub fn warm_up(self) -> Duration {
        Duration::from_millis(300)
    }

    pub fn measurement(self) -> Duration {
        match self {
            Pace::Quick => Duration::from_secs(1),
            Pace::Slow => Duration::from_secs(3),
        }
    }
}
