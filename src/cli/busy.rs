//! What the program is busy with before there is a picture: a spinner on a terminal, plain lines about tables otherwise.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use indicatif::ProgressBar;

use super::progress::{FIRST_LINE_AFTER, LINE_EVERY, Verbosity};
use super::say::say;
use crate::optics::count::TableCount;

/// How often a spinner's count is brought up to date.
const COUNT_EVERY: Duration = Duration::from_millis(100);

/// Says what is being done before there is a picture to show progress of: on a terminal by a spinner, which is gone when this is
/// dropped, elsewhere in lines about tables that take long.
pub struct Busy {
    spinner: Option<ProgressBar>,
    says_lines: bool,
}

impl Busy {
    /// Begins with `what`.
    pub fn with(what: &'static str, verbosity: Verbosity) -> Self {
        let (is_heard, terminal) = (verbosity > Verbosity::Quiet, std::io::stderr().is_terminal());
        let spinner = (is_heard && terminal).then(ProgressBar::new_spinner);
        if let Some(spinner) = &spinner {
            spinner.set_message(what);
            spinner.enable_steady_tick(Duration::from_millis(100));
        }
        Self { spinner, says_lines: is_heard && !terminal }
    }

    /// Goes on with `what`.
    pub fn with_next(&self, what: &'static str) {
        if let Some(spinner) = &self.spinner {
            spinner.set_message(what);
        }
    }

    /// What `work` makes, telling meanwhile how many tables are made.
    pub fn counting<T>(&self, count: &TableCount, work: impl FnOnce() -> T) -> T {
        if self.spinner.is_none() && !self.says_lines {
            return work();
        }
        let (done, is_done) = channel();
        std::thread::scope(|scope| {
            scope.spawn(move || self.tell_until(&is_done, count));
            let made = work();
            drop::<Sender<()>>(done);
            made
        })
    }

    fn tell_until(&self, is_done: &Receiver<()>, count: &TableCount) {
        let first = if self.spinner.is_some() { COUNT_EVERY } else { FIRST_LINE_AFTER };
        let mut wait = first;
        while is_done.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
            wait = first;
            let (made, wanted) = count.made_of();
            if made == wanted {
                continue;
            }
            match &self.spinner {
                Some(spinner) => {
                    spinner.set_message(format!("making tables of how droplets scatter: {made} of {wanted}"))
                }
                None => {
                    say!("tables: {made} of {wanted}");
                    wait = LINE_EVERY;
                }
            }
        }
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
        }
    }
}
