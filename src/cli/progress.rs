//! The progress bar.

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use std::fmt::Write;
use std::io::IsTerminal;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How often the bar is drawn, at most and at least.
const TICK: Duration = Duration::from_millis(100);

/// A bar on stderr, or nothing where nobody looks at it.
pub(super) struct Progress {
    bar: ProgressBar,
    paths: Arc<AtomicU64>,
    begin: Instant,
    /// What ends the render; none where it is the number of paths.
    time: Option<Duration>,
    /// Jobs that ended, and all of them.
    jobs: (AtomicU64, u64),
}

impl Progress {
    /// For a render of `paths` camera paths, or as many as fit in `time`.
    pub fn new(scene: &str, paths: u64, time: Option<Duration>, quiet: bool) -> Self {
        let name = Path::new(scene).file_stem().unwrap_or_default();
        Self::start(format!("Rendering {}", name.display()), paths, time, quiet)
    }

    /// For several jobs, of `paths` camera paths in all.
    pub fn of_jobs(jobs: usize, paths: u64, quiet: bool) -> Self {
        let mut progress = Self::start(String::new(), paths, None, quiet);
        progress.jobs.1 = jobs as u64;
        progress.show_jobs(0);
        progress
    }

    fn start(message: String, paths: u64, time: Option<Duration>, quiet: bool) -> Self {
        let traced = Arc::new(AtomicU64::new(0));
        let bar = if quiet || !std::io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            let bar = ProgressBar::new(time.map_or(paths, milliseconds));
            bar.set_style(style(&traced, time));
            bar.set_message(message);
            bar.enable_steady_tick(TICK);
            bar
        };
        Self {
            bar,
            paths: traced,
            begin: Instant::now(),
            time,
            jobs: (AtomicU64::new(0), 0),
        }
    }

    /// After each wave, by any worker.
    pub fn add(&self, paths: u64) {
        if self.bar.is_hidden() {
            return;
        }
        let traced = self.paths.fetch_add(paths, Ordering::Relaxed) + paths;
        match self.time {
            None => self.bar.set_position(traced),
            Some(time) => {
                let elapsed = self.begin.elapsed().min(time);
                self.bar.set_position(milliseconds(elapsed));
            }
        }
    }

    /// After each job; `untraced` of its paths will not be.
    pub fn job(&self, untraced: u64) {
        self.add(untraced);
        self.show_jobs(self.jobs.0.fetch_add(1, Ordering::Relaxed) + 1);
    }

    fn show_jobs(&self, ended: u64) {
        self.bar
            .set_message(format!("{ended} of {} jobs", self.jobs.1));
    }

    /// Says something on stderr, above the bar.
    pub fn say(&self, message: impl std::fmt::Display) {
        self.bar.suspend(|| super::say(message));
    }

    /// Takes the bar away: what is said next has the line to itself.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn milliseconds(time: Duration) -> u64 {
    u64::try_from(time.as_millis()).unwrap_or(u64::MAX).max(1)
}

fn style(traced: &Arc<AtomicU64>, time: Option<Duration>) -> ProgressStyle {
    let template = "{msg} {bar:30.cyan/blue} {percent:>3} %  {speed} paths/s  {left}";
    let traced = Arc::clone(traced);
    ProgressStyle::with_template(template)
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("━╸─")
        .with_key(
            "speed",
            move |state: &ProgressState, out: &mut dyn Write| {
                let seconds = state.elapsed().as_secs_f64();
                let paths = traced.load(Ordering::Relaxed) as f64;
                let _ = out.write_str(&metric(paths / seconds.max(1e-3)));
            },
        )
        .with_key("left", move |state: &ProgressState, out: &mut dyn Write| {
            let _ = match time {
                Some(time) => write!(
                    out,
                    "{:.0} of {:.0} s",
                    state.elapsed().as_secs_f64(),
                    time.as_secs_f64()
                ),
                None if state.pos() == 0 => Ok(()),
                None => write!(out, "{:#} left", HumanDuration(state.eta())),
            };
        })
}

/// Three significant digits and a metric prefix: `3.41 M`.
pub(super) fn metric(value: f64) -> String {
    let (scaled, prefix) = [(1e12, " T"), (1e9, " G"), (1e6, " M"), (1e3, " k")]
        .into_iter()
        .find(|(unit, _)| value >= *unit * 0.9995)
        .map_or((value, ""), |(unit, prefix)| (value / unit, prefix));
    let decimals = match scaled {
        _ if prefix.is_empty() => 0,
        x if x < 9.995 => 2,
        x if x < 99.95 => 1,
        _ => 0,
    };
    format!("{scaled:.decimals$}{prefix}")
}

#[cfg(test)]
mod tests {
    use super::metric;

    #[test]
    fn a_count_keeps_three_digits() {
        let cases = [
            (0.0, "0"),
            (999.0, "999"),
            (1000.0, "1.00 k"),
            (3_412_345.0, "3.41 M"),
            (18_740_000.0, "18.7 M"),
            (999_990.0, "1.00 M"),
            (123.4e9, "123 G"),
        ];
        for (value, text) in cases {
            assert_eq!(metric(value), text, "{value}");
        }
    }
}
