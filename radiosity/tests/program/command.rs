//! A temporary folder in which the program runs.

use common::solution::pixels::ImagePlanes;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, process};

/// Limits of a run in the shell, so that it aborts instead of exhausting the machine: 16 GiB of address space, and 600
/// seconds of processor time, which a busy machine does not change.
const LIMITS: &str = "ulimit -v 16777216 -t 600";

/// A temporary folder, removed when dropped.
pub struct TestFolder(PathBuf);

/// The end of a run of the program.
pub struct ProgramEnd {
    /// The command line, for messages.
    line: String,
    /// None after a signal.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl TestFolder {
    /// Makes an empty folder.
    pub fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("radiosity-{}-{number}", process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Returns the path of a file or folder in this one; `""` is this one.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    /// Writes a file, and makes the folders above it.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn read_text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    pub fn read_json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.read(name)).unwrap()
    }

    /// Reads the channels of an OpenEXR file.
    pub fn read_planes(&self, name: &str) -> ImagePlanes {
        ImagePlanes::read(&self.path(name), 1 << 26).unwrap()
    }

    /// Changes a JSON file.
    pub fn change_json(&self, name: &str, change: impl FnOnce(&mut Value)) {
        let mut value = self.read_json(name);
        change(&mut value);
        self.write(name, value.to_string());
    }

    /// Prepares the program in this folder; a word `scenes/…` is the path of a bundled scene.
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_radiosity"));
        self.set_up(&mut command, words);
        command
    }

    fn set_up(&self, command: &mut Command, words: &[&str]) {
        let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let found = |word: &&str| match word.starts_with("scenes/") {
            true => bundled.join(word),
            false => word.into(),
        };
        command.args(words.iter().map(found)).current_dir(&self.0);
    }

    /// Runs the program with the words of a line.
    pub fn run(&self, line: &str) -> ProgramEnd {
        self.run_words(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// Runs the program; words may have spaces.
    pub fn run_words(&self, words: &[&str]) -> ProgramEnd {
        self.finish(&mut self.command(words), words.join(" "))
    }

    /// Runs a script of `bash` with limits; `RUN` in it is the program with the words of a line.
    pub fn run_in_shell(&self, script: &str, line: &str) -> ProgramEnd {
        let script = format!("{LIMITS}; {}", script.replace("RUN", "\"$0\" \"$@\""));
        let mut command = Command::new("bash");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_radiosity")]);
        self.set_up(&mut command, &line.split_whitespace().collect::<Vec<_>>());
        self.finish(&mut command, format!("{script}: {line}"))
    }

    /// Asserts that the program did not panic, printed no control characters and left no temporary file.
    fn finish(&self, command: &mut Command, line: String) -> ProgramEnd {
        let output = command.stdin(Stdio::null()).output().unwrap();
        let [stdout, stderr] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        let end = ProgramEnd {
            line,
            code: output.status.code(),
            stdout,
            stderr,
        };
        assert!(!end.stderr.contains("panicked"), "{end}");
        let control = |c: char| c.is_control() && !"\n\t".contains(c);
        assert!(!end.stdout.contains(control) && !end.stderr.contains(control), "{end}");
        let partial = |path: &PathBuf| path.to_str().is_some_and(|path| path.ends_with(".part"));
        assert!(!self.list_files().iter().any(partial), "{end} leaves a temporary file");
        end
    }

    /// Runs the program, which must end with code 0 and without errors.
    pub fn succeed(&self, line: &str) -> ProgramEnd {
        let end = self.run(line);
        assert_eq!((end.code, end.errors().len()), (Some(0), 0), "{end}");
        end
    }

    /// Runs the program with limits; it must end with this code and one `error:` line with this part.
    pub fn fail_with(&self, code: i32, line: &str, part: &str) -> ProgramEnd {
        let end = self.run_limited(line);
        assert!(end.failed_with(code, part), "{end}: not code {code} and {part}");
        end
    }

    fn run_limited(&self, line: &str) -> ProgramEnd {
        match cfg!(unix) {
            true => self.run_in_shell("exec RUN", line),
            false => self.run(line),
        }
    }

    /// Runs each row of a table, `line => part of the message`, which must end with code 2, and writes nothing.
    pub fn assert_refused(&self, rows: &str) {
        let before = self.list_files();
        let rows: Vec<_> = rows.lines().filter_map(|row| row.split_once(" => ")).collect();
        let ends = rows.into_par_iter().map(|(line, part)| (self.run_limited(line), part));
        let wrong = ends.filter(|(end, part)| !end.failed_with(2, part));
        let wrong: Vec<String> = wrong.map(|(end, part)| format!("{end} does not say {part}")).collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        assert_eq!(self.list_files(), before, "something was written");
    }

    /// Returns the paths of all files and folders.
    pub fn list_files(&self) -> BTreeSet<PathBuf> {
        let mut found = BTreeSet::new();
        let mut folders = vec![self.0.clone()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                    folders.push(entry.path());
                }
                found.insert(entry.path());
            }
        }
        found
    }
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl ProgramEnd {
    /// Returns the lines that begin with `error:`.
    pub fn errors(&self) -> Vec<&str> {
        let lines = self.stderr.lines();
        lines.filter(|line| line.starts_with("error:")).collect()
    }

    fn failed_with(&self, code: i32, part: &str) -> bool {
        self.code == Some(code) && matches!(self.errors()[..], [error] if error.contains(part))
    }

    /// Parses the only line on stdout.
    pub fn json(&self) -> Value {
        assert_eq!(self.stdout.lines().count(), 1, "{self}: {}", self.stdout);
        serde_json::from_str(&self.stdout).unwrap()
    }
}

impl std::fmt::Display for ProgramEnd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: code {:?}: {}", self.line, self.code, self.stderr)
    }
}
