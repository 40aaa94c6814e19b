//! A process that compares with mutants, seen from outside: it is killed when it takes too long, and started again.

use super::worker::{TrialReply, TrialRequest};
use common::{Error, Result};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Answers after which a process is replaced: each compiled pipeline stays in its memory.
const MAX_ANSWERS: u32 = 100;
/// Time between two looks at Ctrl-C.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// End of a comparison in the other process.
pub enum TrialEnd {
    /// It answered.
    Reply(TrialReply),
    /// It was killed after its time.
    Late,
    /// It ended without an answer: a panic, or a crash of the driver.
    Crashed,
    /// The run was interrupted.
    Interrupted,
}

/// The process, started on demand.
pub struct Judge<'c> {
    command: &'c (dyn Fn() -> Command + Sync),
    process: Option<Process>,
}

impl<'c> Judge<'c> {
    /// Makes a judge that starts this command.
    pub fn new(command: &'c (dyn Fn() -> Command + Sync)) -> Self {
        Self { command, process: None }
    }

    /// Runs a comparison for at most `limit`.
    ///
    /// Errors: the process cannot be started.
    pub fn run_trial(
        &mut self,
        request: &TrialRequest,
        limit: Duration,
        is_interrupted: &dyn Fn() -> bool,
    ) -> Result<TrialEnd> {
        let mut process = match self.process.take() {
            Some(process) => process,
            None => Process::start((self.command)())?,
        };
        let mut line = serde_json::to_string(request).map_err(|error| Error::Fault(error.to_string()))?;
        line.push('\n');
        // A process that has ended is noticed below.
        let _ = process.input.write_all(line.as_bytes());
        let start = Instant::now();
        loop {
            match process.replies.recv_timeout(POLL_INTERVAL) {
                _ if is_interrupted() => return Ok(TrialEnd::Interrupted),
                Err(RecvTimeoutError::Timeout) if start.elapsed() > limit => return Ok(TrialEnd::Late),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(TrialEnd::Crashed),
                Ok(text) => {
                    let reply: TrialReply =
                        serde_json::from_str(&text).map_err(|error| Error::Fault(error.to_string()))?;
                    process.answers += 1;
                    if process.answers < MAX_ANSWERS && reply.error.is_none() {
                        self.process = Some(process);
                    }
                    return Ok(TrialEnd::Reply(reply));
                }
            }
        }
    }
}

struct Process {
    child: Child,
    input: ChildStdin,
    replies: Receiver<String>,
    answers: u32,
}

impl Process {
    fn start(mut command: Command) -> Result<Self> {
        let fault = |text: &str| Error::Fault(format!("the process that judges mutants cannot be started: {text}"));
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        let mut child = command.spawn().map_err(|error| fault(&error.to_string()))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(fault("it has no pipes"));
        };
        let (send, replies) = channel();
        thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(std::io::Result::ok) {
                if send.send(line).is_err() {
                    break;
                }
            }
        });
        Ok(Self {
            child,
            input,
            replies,
            answers: 0,
        })
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
