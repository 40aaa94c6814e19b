//! Runs the program on hostile input and checks its exit code, messages and files.

use std::fs;
use std::io::Read;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

/// Largest processor time of a call in seconds: a measure of its work, which a busy machine does not change.
const MAX_PROCESSOR_SECONDS: u32 = 600;
/// Time without any processor time after which a call counts as blocked.
const MAX_IDLE_TIME: Duration = Duration::from_secs(120);
/// Largest address space in KiB: a call that eats memory aborts instead of exhausting the machine.
const MAX_ADDRESS_KIB: u32 = 16 << 20;

/// A call of the program in a folder, and its expected end.
pub struct Row {
    /// The command line, separated by spaces; `out` is the folder of results.
    pub arguments: &'static str,
    /// The exit code.
    pub code: i32,
    /// Text of its `error:` line; with code 0, text on stdout or stderr.
    pub says: &'static str,
}

/// Makes a row of a table.
pub const fn row(arguments: &'static str, code: i32, says: &'static str) -> Row {
    Row { arguments, code, says }
}

/// The end of a call.
pub struct ProgramEnd {
    /// None after a signal.
    pub code: Option<i32>,
    /// All of its output.
    pub stdout: String,
    /// All of its messages.
    pub stderr: String,
    /// Wall time, for people.
    pub seconds: f64,
}

/// Makes an empty folder of this process.
pub fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("hostile-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes a file into the folder.
pub fn write_file(folder: &Path, name: &str, text: impl AsRef<[u8]>) {
    fs::write(folder.join(name), text).unwrap();
}

/// Runs each row and asserts its end: the exit code, one `error:` line (none at code 0), no panic, no control
/// characters, no partial file, and at code 2 no file at all.
pub fn assert_rows(folder: &Path, rows: &[Row]) {
    for row in rows {
        let _ = fs::remove_dir_all(folder.join("out"));
        let arguments: Vec<&str> = row.arguments.split_whitespace().collect();
        let ended = run_program(folder, &arguments);
        let what = describe_end(row.arguments, &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(row.code), "{what}");
        assert_clean_end(folder, &ended, &what);
        let errors = error_lines(&ended);
        if row.code == 0 {
            assert!(errors.is_empty(), "{what}");
            let all = format!("{}{}", ended.stdout, ended.stderr);
            assert!(all.contains(row.says), "{what} does not say {}", row.says);
        } else {
            assert!(
                matches!(errors[..], [line] if line.contains(row.says)),
                "{what} does not say {}",
                row.says
            );
        }
        assert!(
            row.code != 2 || !folder.join("out").exists(),
            "{what}: something was written"
        );
    }
}

/// Returns the lines that begin with `error:`.
pub fn error_lines(ended: &ProgramEnd) -> Vec<&str> {
    let lines = ended.stderr.lines();
    lines.filter(|line| line.starts_with("error:")).collect()
}

/// Asserts that a call did not panic, printed no control characters and left no temporary file.
pub fn assert_clean_end(folder: &Path, ended: &ProgramEnd, what: &str) {
    let all = format!("{}{}", ended.stdout, ended.stderr);
    assert!(!all.contains("panicked"), "{what}");
    let control = |c: char| c.is_control() && c != '\n';
    assert!(!all.contains(control), "{what}: {all:?}");
    let left = partial_files(folder);
    assert!(left.is_empty(), "{what} leaves {left:?}");
}

/// Formats seconds, exit code and the last line, for people.
pub fn describe_end(arguments: &str, ended: &ProgramEnd) -> String {
    let line = error_lines(ended).first().map(ToString::to_string);
    let line = line.or_else(|| ended.stderr.lines().last().map(ToOwned::to_owned));
    format!(
        "{:5.2} s, code {:?}: {arguments}: {}",
        ended.seconds,
        ended.code,
        line.unwrap_or_default()
    )
}

/// Runs the program in `folder`.
pub fn run_program(folder: &Path, arguments: &[&str]) -> ProgramEnd {
    run_in_shell(folder, "exec \"$0\" \"$@\"", arguments)
}

/// Runs `script` by the shell in `folder`; `"$0" "$@"` is the program with its arguments.
pub fn run_in_shell(folder: &Path, script: &str, arguments: &[&str]) -> ProgramEnd {
    let start = Instant::now();
    let mut child = Command::new("bash")
        .args([
            "-c",
            &format!("ulimit -v {MAX_ADDRESS_KIB} -t {MAX_PROCESSOR_SECONDS}; {script}"),
        ])
        .arg(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments)
        .current_dir(folder)
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let stdout = read_all(child.stdout.take().unwrap());
    let stderr = read_all(child.stderr.take().unwrap());
    let code = wait_for_exit(&mut child, arguments);
    ProgramEnd {
        code,
        stdout: stdout.join().unwrap(),
        stderr: stderr.join().unwrap(),
        seconds: start.elapsed().as_secs_f64(),
    }
}

/// Waits for the end of a call and returns its exit code; panics if it is blocked. `ulimit -t` ends a call that works
/// too much.
fn wait_for_exit(child: &mut Child, arguments: &[&str]) -> Option<i32> {
    let (mut used, mut last_change) = (f64::NAN, Instant::now());
    loop {
        for _ in 0..100 {
            if let Some(status) = child.try_wait().unwrap() {
                return status.code();
            }
            sleep(Duration::from_millis(10));
        }
        let now = processor_seconds(child.id());
        if now != used {
            (used, last_change) = (now, Instant::now());
        } else if last_change.elapsed() > MAX_IDLE_TIME {
            let group = format!("-{}", child.id());
            Command::new("kill").args(["-KILL", "--", &group]).status().unwrap();
            child.wait().unwrap();
            panic!("{arguments:?} is blocked after {used} s of work");
        }
    }
}

/// Returns the processor time in seconds that the processes of a group have used (Linux; 0 elsewhere).
#[allow(clippy::disallowed_methods, reason = "reads the system's own /proc")]
pub fn processor_seconds(group: u32) -> f64 {
    const TICKS_PER_SECOND: f64 = 100.0;
    let mut ticks = 0;
    for process in fs::read_dir("/proc").into_iter().flatten().flatten() {
        let text = fs::read_to_string(process.path().join("stat")).unwrap_or_default();
        // The name in parentheses may hold anything; the fields behind it are separated by spaces.
        let fields: Vec<&str> = match text.rsplit_once(')') {
            Some((_, rest)) => rest.split_whitespace().collect(),
            None => continue,
        };
        let number = |k: usize| fields.get(k).and_then(|field| field.parse::<u64>().ok());
        if number(2) == Some(group.into()) {
            ticks += number(11).unwrap_or(0) + number(12).unwrap_or(0);
        }
    }
    ticks as f64 / TICKS_PER_SECOND
}

fn read_all(mut pipe: impl Read + Send + 'static) -> JoinHandle<String> {
    spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// Returns the temporary files in a folder and the folders in it.
fn partial_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(partial_files(&path));
        } else if path.to_string_lossy().ends_with(".part") {
            found.push(path);
        }
    }
    found
}
