//! A process that stands ready to build and ask its rows, a lap at a time, while others of its kind
//! wait.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde::{Deserialize, Serialize};

use crate::gate::against::Program;
use measurement::record::RunRecord;
use measurement::system::child_process::{ChildError, arguments, ended_early, without_samples};

/// A build of a row and a pass over its rays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lap {
    pub build_s: f64,
    /// Seconds of each kind of rays.
    pub trace_s: BTreeMap<String, f64>,
}

#[derive(Debug)]
pub struct Runner {
    program: PathBuf,
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
}

impl Runner {
    /// Starts a program with the rows of a record; it gets ready while others start.
    pub fn start(
        program: &Program,
        like: &RunRecord,
        allow_outside: bool,
    ) -> Result<Self, ChildError> {
        let mut command = Command::new(&program.path);
        command.args(arguments(allow_outside)).args(&program.plugins).arg("laps");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let path = program.path.clone();
        let failed = |source| ChildError::Start { program: path.clone(), source };
        let mut child = command.spawn().map_err(failed)?;
        let pipes = (child.stdin.take(), child.stdout.take());
        let (Some(input), Some(output)) = pipes else {
            return Err(failed(std::io::ErrorKind::BrokenPipe.into()));
        };
        let (input, output) = (Some(input), BufReader::new(output));
        let mut runner = Self { program: path.clone(), child, input, output };
        let text = serde_json::to_string(&without_samples(like));
        let text = text.map_err(|e| runner.unreadable(&e))?;
        runner.say(&text)?;
        Ok(runner)
    }

    /// One lap of a row; none where the row is not timed.
    pub fn lap(&mut self, row: &str) -> Result<Option<Lap>, ChildError> {
        self.say(row)?;
        let mut line = String::new();
        match self.output.read_line(&mut line) {
            Ok(n) if n > 0 => serde_json::from_str(&line).map_err(|e| self.unreadable(&e)),
            _ => Err(self.failure()),
        }
    }

    /// Lets it end.
    pub fn end(mut self) -> Result<(), ChildError> {
        self.input = None;
        match self.child.wait() {
            Ok(status) if status.success() => Ok(()),
            _ => Err(self.failure()),
        }
    }

    fn say(&mut self, line: &str) -> Result<(), ChildError> {
        let said =
            self.input.as_mut().map(|input| writeln!(input, "{line}").and_then(|()| input.flush()));
        match said {
            Some(Ok(())) => Ok(()),
            // its last words say more than the closed pipe
            _ => Err(self.failure()),
        }
    }

    fn unreadable(&self, error: &serde_json::Error) -> ChildError {
        ChildError::Answer { program: self.program.clone(), message: error.to_string() }
    }

    fn failure(&mut self) -> ChildError {
        self.input = None;
        let mut said = String::new();
        if let Some(mut stderr) = self.child.stderr.take() {
            let _ = stderr.read_to_string(&mut said);
        }
        match self.child.wait() {
            Ok(status) => ended_early(&self.program, status, &said),
            Err(source) => ChildError::Start { program: self.program.clone(), source },
        }
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        // one that was not asked to end is not waited for
        if self.input.take().is_some() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}
