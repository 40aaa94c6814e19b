//! Runs the program on an input that is meant to hurt it, and judges how it ends.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

/// Everything must end within this, on a busy machine too.
const LIMIT: Duration = Duration::from_secs(60);
/// KiB of addresses: what eats the memory is to end in an abort, not to take the machine along.
const MEMORY: u32 = 16 << 20;

/// A way to call the program in a folder, and how that has to end.
pub struct Row {
    /// The command line, parted by spaces; `out` is the folder of results.
    pub arguments: &'static str,
    /// The exit code.
    pub code: i32,
    /// What its `error:` line says; with code 0, what stdout or stderr says.
    pub says: &'static str,
}

/// A row of a table.
pub const fn row(arguments: &'static str, code: i32, says: &'static str) -> Row {
    Row {
        arguments,
        code,
        says,
    }
}

/// How a call ended.
pub struct Ended {
    /// None after a signal.
    pub code: Option<i32>,
    /// Both whole.
    pub stdout: String,
    pub stderr: String,
    pub seconds: f64,
}

/// An empty folder of this process.
pub fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("hostile-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes a file into the folder.
pub fn put(folder: &Path, name: &str, text: impl AsRef<[u8]>) {
    fs::write(folder.join(name), text).unwrap();
}

/// Runs each row, prints what it said and took, and asks that it ended as it has to: in time, by
/// its own exit code, with one `error:` line (none at code 0), without a panic, with nothing in the
/// terminal's language, and with no file left behind; at code 2 with nothing written at all.
pub fn judge(folder: &Path, rows: &[Row]) {
    for row in rows {
        let _ = fs::remove_dir_all(folder.join("out"));
        let arguments: Vec<&str> = row.arguments.split_whitespace().collect();
        let ended = run(folder, &arguments);
        let what = told(row.arguments, &ended);
        println!("{what}");
        assert_eq!(ended.code, Some(row.code), "{what}");
        well_behaved(folder, &ended, &what);
        let errors = errors(&ended);
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

/// The lines that begin with `error:`.
pub fn errors(ended: &Ended) -> Vec<&str> {
    let lines = ended.stderr.lines();
    lines.filter(|line| line.starts_with("error:")).collect()
}

/// No panic, no control characters, no temporary file.
pub fn well_behaved(folder: &Path, ended: &Ended, what: &str) {
    let all = format!("{}{}", ended.stdout, ended.stderr);
    assert!(!all.contains("panicked"), "{what}");
    let control = |c: char| c.is_control() && c != '\n';
    assert!(!all.contains(control), "{what}: {all:?}");
    let left = parts(folder);
    assert!(left.is_empty(), "{what} leaves {left:?}");
}

/// Seconds, exit code and the last line, for people.
pub fn told(arguments: &str, ended: &Ended) -> String {
    let line = errors(ended).first().map(ToString::to_string);
    let line = line.or_else(|| ended.stderr.lines().last().map(ToOwned::to_owned));
    format!(
        "{:5.2} s, code {:?}: {arguments}: {}",
        ended.seconds,
        ended.code,
        line.unwrap_or_default()
    )
}

/// Calls the program in `folder`.
pub fn run(folder: &Path, arguments: &[&str]) -> Ended {
    in_shell(folder, "exec \"$0\" \"$@\"", arguments)
}

/// Has the shell run `script` in `folder`, where `"$0" "$@"` is the program with its arguments.
pub fn in_shell(folder: &Path, script: &str, arguments: &[&str]) -> Ended {
    let start = Instant::now();
    let mut child = Command::new("bash")
        .args(["-c", &format!("ulimit -v {MEMORY}; {script}")])
        .arg(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let stdout = all_of(child.stdout.take().unwrap());
    let stderr = all_of(child.stderr.take().unwrap());
    let code = wait(&mut child, arguments);
    Ended {
        code,
        stdout: stdout.join().unwrap(),
        stderr: stderr.join().unwrap(),
        seconds: start.elapsed().as_secs_f64(),
    }
}

fn wait(child: &mut Child, arguments: &[&str]) -> Option<i32> {
    let start = Instant::now();
    while start.elapsed() < LIMIT {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    panic!("{arguments:?} runs on after {LIMIT:?}");
}

fn all_of(mut pipe: impl Read + Send + 'static) -> JoinHandle<String> {
    spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// Temporary files in a folder and the folders in it.
fn parts(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(parts(&path));
        } else if path.to_string_lossy().ends_with(".part") {
            found.push(path);
        }
    }
    found
}
