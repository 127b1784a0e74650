//! Waits for a child to end, to be stopped, or to take too long. Nobody looks
//! in between: a thread sleeps in the kernel until the child has ended. (A look
//! every 4 ms at each of 16 processes took 3 % of the CPU of an animation.)

use std::io;
use std::time::{Duration, Instant};

use process_wrap::std::ChildWrapper;

/// Between two looks at whether to stop, in a call's first second: nobody notices a
/// longer wait.
const LOOK: Duration = Duration::from_millis(100);

/// The same later on. Each look wakes a thread while the cores are busy, and many calls
/// run at once: 25 frames by twelve calls took 2153 of decor's switches between threads,
/// and 1388 with this and with what is printed read in bursts.
const LATER: Duration = Duration::from_millis(250);

/// How long to wait before the next look at a call that was begun so long ago.
fn pause(begun: Duration) -> Duration {
    const SOON: Duration = Duration::from_secs(1);
    if begun < SOON { LOOK } else { LATER }
}

/// Why waiting is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The child has ended. It was not waited for yet: its number, and its group's,
    /// are still its own.
    Ended,
    /// It was asked to stop; the child may still run.
    Stopped,
    /// It took too long, and still runs.
    TooLong,
}

/// A child that is waited for.
pub struct Waiting {
    begun: Instant,
    #[cfg(target_os = "linux")]
    pid: nix::unistd::Pid,
    #[cfg(target_os = "linux")]
    ended: std::sync::mpsc::Receiver<()>,
    #[cfg(target_os = "linux")]
    waiter: std::thread::JoinHandle<()>,
}

#[cfg(target_os = "linux")]
impl Waiting {
    /// Begins to wait.
    pub fn begin(child: &dyn ChildWrapper) -> Self {
        // A process's number is an i32 in the kernel.
        let pid = nix::unistd::Pid::from_raw(child.id().cast_signed());
        let (tell, ended) = std::sync::mpsc::channel();
        let waiter = std::thread::spawn(move || {
            use nix::errno::Errno;
            use nix::sys::wait::{Id, WaitPidFlag, waitid};
            // The child stays to be waited for: its CPU time is read after this.
            let flags = WaitPidFlag::WEXITED | WaitPidFlag::WNOWAIT;
            while let Err(Errno::EINTR) = waitid(Id::Pid(pid), flags) {}
            // Who waited may have gone.
            let _ = tell.send(());
        });
        Self {
            begun: Instant::now(),
            pid,
            ended,
            waiter,
        }
    }

    /// Waits; at most `limit` from the beginning on. Of the CPU time that the child
    /// has used in all its threads `used` is told now and then, and at the end: what
    /// came since the last time.
    pub fn ending(
        &self,
        _: &mut dyn ChildWrapper,
        limit: Duration,
        stop: impl Fn() -> bool,
        used: impl Fn(Duration),
    ) -> io::Result<Ending> {
        use std::sync::mpsc::RecvTimeoutError;
        let mut told = Duration::ZERO;
        let mut tell = || {
            if let Some(time) = cpu_time(self.pid) {
                used(time.saturating_sub(told));
                told = told.max(time);
            }
        };
        loop {
            if stop() {
                return Ok(Ending::Stopped);
            }
            let begun = self.begun.elapsed();
            let left = limit.saturating_sub(begun);
            match self.ended.recv_timeout(pause(begun).min(left)) {
                Err(RecvTimeoutError::Timeout) if left.is_zero() => return Ok(Ending::TooLong),
                Err(RecvTimeoutError::Timeout) => tell(),
                Ok(()) | Err(RecvTimeoutError::Disconnected) => {
                    tell();
                    return Ok(Ending::Ended);
                }
            }
        }
    }

    /// Ends waiting. The child has ended, or was killed.
    pub fn end(self) {
        let _ = self.waiter.join();
    }
}

/// The CPU time of all threads of a child that was not waited for yet: what the sum
/// over all children cannot tell, where many run at once.
#[cfg(target_os = "linux")]
fn cpu_time(pid: nix::unistd::Pid) -> Option<Duration> {
    let clock = nix::time::ClockId::pid_cpu_clock_id(pid).ok()?;
    Some(Duration::from(clock.now().ok()?))
}

// Elsewhere a child cannot be waited for without taking its number away.
#[cfg(not(target_os = "linux"))]
impl Waiting {
    /// Begins to wait.
    pub fn begin(_: &dyn ChildWrapper) -> Self {
        Self {
            begun: Instant::now(),
        }
    }

    /// Waits; at most `limit` from the beginning on. CPU time is not told.
    pub fn ending(
        &self,
        child: &mut dyn ChildWrapper,
        limit: Duration,
        stop: impl Fn() -> bool,
        _: impl Fn(Duration),
    ) -> io::Result<Ending> {
        loop {
            if child.try_wait()?.is_some() {
                return Ok(Ending::Ended);
            }
            if stop() {
                return Ok(Ending::Stopped);
            }
            if self.begun.elapsed() >= limit {
                return Ok(Ending::TooLong);
            }
            std::thread::sleep(pause(self.begun.elapsed()) / 4);
        }
    }

    /// Ends waiting. The child has ended, or was killed.
    pub fn end(self) {}
}
