//! A bar for work over a second, on a terminal only; Ctrl-C asks the work to stop.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Follows a piece of work.
pub struct Progress {
    bar: Option<ProgressBar>,
    started: Instant,
    stopped: Arc<AtomicUsize>,
}

impl Progress {
    /// Starts; `what` stands before the bar.
    pub fn new(what: &'static str, quiet: bool) -> Self {
        let stopped = Arc::new(AtomicUsize::new(0));
        let flag = Arc::clone(&stopped);
        // A second handler is refused; the first one serves then, and this work runs to its end.
        let _ = ctrlc::set_handler(move || {
            flag.fetch_add(1, Ordering::Relaxed);
        });
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::hidden().with_message(what);
            bar.set_length(1000);
            if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} %  {eta} left") {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, started: Instant::now(), stopped }
    }

    /// Tells the share done, 0..=1; false if the person wants to stop.
    pub fn update(&self, share: f64) -> bool {
        if let Some(bar) = &self.bar {
            if bar.is_hidden() && self.started.elapsed() > Duration::from_secs(1) {
                bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
            }
            bar.set_position((share * 1000.0) as u64);
        }
        self.presses() == 0
    }

    /// How often Ctrl-C was pressed.
    pub fn presses(&self) -> usize {
        self.stopped.load(Ordering::Relaxed)
    }

    /// Says something else before the bar.
    pub fn say(&self, what: String) {
        if let Some(bar) = &self.bar {
            bar.set_message(what);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
