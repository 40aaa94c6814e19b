//! Files that appear in their folder together or not at all, so that a result is always of one run.
//!
//! They are written into the folder's `.radiosity.part`. When all are complete, it is renamed to `.radiosity.new`: from
//! then on they are the result. They are moved to their own names next. After an interruption [`locate_file`] finds those
//! that were not moved yet, and the next write into the folder moves them.

use crate::error::{Error, Result};
use crate::file::{self, MAX_FILE_BYTES, file_checksum, resolve_path};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Folder of files that are being written.
const PARTIAL_FOLDER: &str = ".radiosity.part";
/// Folder of complete files that are being moved to the folder above.
const COMPLETE_FOLDER: &str = ".radiosity.new";

/// Name of a file, relative to its folder, and its content.
pub type NamedBytes = (String, Vec<u8>);

/// Files of one folder or several that are written together.
#[derive(Default)]
pub struct PendingFiles {
    /// Folder as given, and its files, by resolved path.
    folders: BTreeMap<PathBuf, (PathBuf, Vec<NamedBytes>)>,
}

impl PendingFiles {
    /// Adds a file; nothing is written yet. `name` may lie in a folder within `dir`.
    pub fn add(&mut self, dir: &Path, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        let folder = self.folders.entry(resolve_path(dir));
        let (_, files) = folder.or_insert_with(|| (dir.to_path_buf(), Vec::new()));
        files.push((name.into(), bytes.into()));
    }

    /// Writes all files, and removes those of the result in the same folder that the new one does not have.
    ///
    /// Errors: [`Error::Write`] with the file; unless a file could not be renamed, all are as before.
    pub fn write(self) -> Result<()> {
        let folders = self.folders.values();
        let partial = folders.map(|(dir, files)| PartialFolder::open(dir)?.add_files(files));
        let partial: Vec<PartialFolder> = partial.collect::<Result<_>>()?;
        partial.into_iter().try_for_each(PartialFolder::publish_files)
    }
}

/// Writes files into `dir`, together.
///
/// Errors: those of [`PendingFiles::write`].
pub fn write_files<N: Into<String>, B: Into<Vec<u8>>>(
    dir: &Path,
    files: impl IntoIterator<Item = (N, B)>,
) -> Result<()> {
    let mut pending = PendingFiles::default();
    files
        .into_iter()
        .for_each(|(name, bytes)| pending.add(dir, name, bytes));
    pending.write()
}

/// Creates the folders of a command's outputs (folder and name) where needed, and checks that files can be written into
/// them, before any long work.
///
/// Errors: [`Error::Usage`] if an output would replace a file that was read, or two outputs are one file;
/// [`Error::Write`] with the folder.
pub fn prepare_outputs<'a>(outputs: impl IntoIterator<Item = (&'a Path, String)>) -> Result<()> {
    let mut known: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    let mut folders = BTreeSet::new();
    for (dir, name) in outputs {
        let path = dir.join(name);
        let resolved = resolve_path(&path);
        let refuse = |reason| {
            Err(Error::Usage(format!(
                "{}: {reason}: write to another place",
                path.display()
            )))
        };
        if let Some(input) = file::find_input(&resolved) {
            return refuse(format!("would replace the input {}", input.display()));
        }
        if let Some(other) = known.insert(resolved, path.clone()) {
            return refuse(format!("is also where {} would be written", other.display()));
        }
        folders.insert(dir);
    }
    folders
        .into_iter()
        .try_for_each(|dir| PartialFolder::open(dir).map(drop))
}

/// Prepares outputs in one folder: see [`prepare_outputs`].
pub fn prepare_folder(dir: &Path, names: &[&str]) -> Result<()> {
    prepare_outputs(names.iter().map(|name| (dir, (*name).to_owned())))
}

/// Returns the path of a file of the result in `dir`, which an interrupted write may have left among its complete files.
pub fn locate_file(dir: &Path, name: &str) -> PathBuf {
    let own = dir.join(COMPLETE_FOLDER).join(name);
    // The maps of a room are a folder within a result.
    let within = dir
        .file_name()
        .map(|folder| dir.with_file_name(COMPLETE_FOLDER).join(folder).join(name));
    let complete = [Some(own), within].into_iter().flatten();
    complete
        .into_iter()
        .find(|path| path.is_file())
        .unwrap_or_else(|| dir.join(name))
}

/// The partial files of a folder; removed when dropped, unless they were completed. While it exists, other processes
/// that write into the folder wait.
struct PartialFolder<'a> {
    dir: &'a Path,
    /// The folder, locked; none where the system does not lock folders.
    lock: Option<fs::File>,
}

impl<'a> PartialFolder<'a> {
    /// Creates `dir` and its empty partial folder, after the end of another process's write and the rest of an
    /// interrupted one.
    ///
    /// Errors: [`Error::Write`] with the folder or a file.
    fn open(dir: &'a Path) -> Result<Self> {
        fs::create_dir_all(dir).map_err(|source| write_error(dir, source))?;
        let lock = lock_folder(dir);
        move_complete_files(dir)?;
        let partial = dir.join(PARTIAL_FOLDER);
        if partial.exists() {
            fs::remove_dir_all(&partial).map_err(|source| write_error(&partial, source))?;
        }
        fs::create_dir(&partial).map_err(|source| write_error(dir, source))?;
        Ok(Self { dir, lock })
    }

    fn add_files(self, files: &[NamedBytes]) -> Result<Self> {
        for (name, bytes) in files {
            let path = self.dir.join(name);
            let partial = self.dir.join(PARTIAL_FOLDER).join(name);
            let written = match path.is_dir() {
                true => Err(std::io::ErrorKind::IsADirectory.into()),
                false => fs::create_dir_all(partial.parent().unwrap_or(self.dir)),
            };
            let written = written.and_then(|()| fs::write(&partial, bytes));
            written.map_err(|source| write_error(&path, source))?;
        }
        Ok(self)
    }

    fn publish_files(self) -> Result<()> {
        let [from, to] = [PARTIAL_FOLDER, COMPLETE_FOLDER].map(|name| self.dir.join(name));
        fs::rename(from, to).map_err(|source| write_error(self.dir, source))?;
        move_complete_files(self.dir)
    }
}

impl Drop for PartialFolder<'_> {
    fn drop(&mut self) {
        // A half-written file must not remain; the first error is reported.
        let _ = fs::remove_dir_all(self.dir.join(PARTIAL_FOLDER));
        drop(self.lock.take());
    }
}

/// Opens and locks a folder; the lock ends with the process. None where folders cannot be locked, as on Windows.
fn lock_folder(dir: &Path) -> Option<fs::File> {
    #[allow(clippy::disallowed_methods, reason = "it is a folder, which is not read")]
    let folder = fs::File::open(dir).ok()?;
    folder.lock().ok()?;
    Some(folder)
}

/// Moves the complete files of `dir`, if there are any, to their own names.
fn move_complete_files(dir: &Path) -> Result<()> {
    let complete = dir.join(COMPLETE_FOLDER);
    if !complete.is_dir() {
        return Ok(());
    }
    remove_outdated_files(dir, &complete);
    for name in files_to_move(&complete).map_err(|source| write_error(&complete, source))? {
        let path = dir.join(&name);
        let moved =
            fs::create_dir_all(path.parent().unwrap_or(dir)).and_then(|()| fs::rename(complete.join(&name), &path));
        moved.map_err(|source| write_error(&path, source))?;
    }
    fs::remove_dir_all(&complete).map_err(|source| write_error(&complete, source))
}

/// Lists the complete files in the order in which they are moved: a result's description comes last, since the outdated
/// files of the result before are known by its description.
fn files_to_move(complete: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut names = list_files(complete)?;
    names.sort_by_key(|name| name.as_os_str() == "result.json");
    Ok(names)
}

/// Lists the files of a folder and of the folders within, relative to it.
fn list_files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = PathBuf::from(entry.file_name());
        match entry.file_type()?.is_dir() {
            true => names.extend(list_files(&entry.path())?.iter().map(|inner| name.join(inner))),
            false => names.push(name),
        }
    }
    Ok(names)
}

/// Removes the files of the result in `dir` that the one in `complete` does not have. What somebody changed since, and
/// what was read for the new result, stays, together with all files of the folder within `dir` in which it lies.
fn remove_outdated_files(dir: &Path, complete: &Path) {
    let [old, new] = [dir, complete].map(result_checksums);
    if new.is_empty() {
        return;
    }
    let mut groups: BTreeMap<PathBuf, Vec<(PathBuf, String)>> = BTreeMap::new();
    // Whatever the description says, nothing outside of the folder is touched.
    let is_within = |name: &String| {
        let mut parts = Path::new(name).components();
        parts.all(|part| matches!(part, Component::Normal(_)))
    };
    let outdated = old
        .into_iter()
        .filter(|(name, _)| is_within(name) && !new.contains_key(name));
    for (name, checksum) in outdated {
        let path = dir.join(&name);
        let group = path
            .parent()
            .filter(|folder| *folder != dir)
            .unwrap_or(&path)
            .to_path_buf();
        groups.entry(group).or_default().push((path, checksum));
    }
    for (group, files) in groups {
        let is_unused = |(path, checksum): &(PathBuf, String)| match file::read_unrecorded(path, MAX_FILE_BYTES) {
            Ok(bytes) => file_checksum(&bytes) == *checksum && file::find_input(&resolve_path(path)).is_none(),
            Err(_) => !path.exists(),
        };
        if files.iter().all(is_unused) {
            // A file that cannot be removed, and a folder that has other files, stay.
            files.iter().for_each(|(path, _)| drop(fs::remove_file(path)));
            let _ = fs::remove_dir(group);
        }
    }
}

/// Returns the checksums of a result's files by name, as its `result.json` lists them; empty if it lists none.
fn result_checksums(dir: &Path) -> BTreeMap<String, String> {
    /// The other entries of a result of many faces are long, and are not kept.
    #[derive(Default, Deserialize)]
    struct ResultFiles {
        files: BTreeMap<String, String>,
    }
    let text = file::read_unrecorded(&dir.join("result.json"), MAX_FILE_BYTES).unwrap_or_default();
    let listed: ResultFiles = serde_json::from_slice(&text).unwrap_or_default();
    listed.files
}

fn write_error(path: &Path, source: std::io::Error) -> Error {
    Error::Write {
        path: path.to_path_buf(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Content of a folder by name.
    type Content = BTreeMap<String, Vec<u8>>;

    fn content_of(files: &[(&str, &str)]) -> Content {
        let files = files.iter();
        files
            .map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec()))
            .collect()
    }

    /// Returns a result with a description that lists these files.
    fn result_of(files: &[(&str, &str)]) -> Content {
        let mut all = content_of(files);
        let checksums: BTreeMap<_, _> = all.iter().map(|(name, bytes)| (name, file_checksum(bytes))).collect();
        let description = serde_json::json!({ "files": checksums }).to_string();
        all.insert("result.json".into(), description.into_bytes());
        all
    }

    fn write_content(dir: &Path, files: &Content) {
        for (name, bytes) in files {
            let path = dir.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
    }

    fn read_content(dir: &Path) -> Content {
        let names = list_files(dir).unwrap();
        let file = |name: PathBuf| {
            (
                name.display().to_string(),
                file::read_unrecorded(&dir.join(name), 1 << 20).unwrap(),
            )
        };
        names.into_iter().map(file).collect()
    }

    fn read_located(dir: &Path, names: &Content) -> Content {
        let file = |name: &String| {
            (
                name.clone(),
                file::read_unrecorded(&locate_file(dir, name), 1 << 20).unwrap(),
            )
        };
        names.keys().map(file).collect()
    }

    const OLD_FILES: &[(&str, &str)] = &[
        ("lightmap.exr", "1"),
        ("error.exr", "1"),
        ("maps/0.exr", "1"),
        ("maps/1.exr", "1"),
    ];
    const NEW_FILES: &[(&str, &str)] = &[("lightmap.exr", "2"), ("view.html", "2"), ("walls/0.exr", "2")];
    const OWN_FILES: &[(&str, &str)] = &[("note.txt", "mine"), ("drafts/note.txt", "mine")];

    /// The write ends after each of its steps, and another write follows.
    #[test]
    fn interrupted_write_leaves_the_old_result_or_the_new_one() {
        let dir = std::env::temp_dir().join(format!("radiosity-pending-{}", std::process::id()));
        let (old, new, own) = (result_of(OLD_FILES), result_of(NEW_FILES), content_of(OWN_FILES));
        let with_own = |files: &Content| -> Content { files.clone().into_iter().chain(own.clone()).collect() };
        let [partial, complete] = [PARTIAL_FOLDER, COMPLETE_FOLDER].map(|name| dir.join(name));
        for step in 0..=2 * new.len() {
            let _ = fs::remove_dir_all(&dir);
            write_content(&dir, &with_own(&old));
            let expected = if step < new.len() {
                write_content(&partial, &new.clone().into_iter().take(step).collect());
                &old
            } else {
                write_content(&complete, &new);
                remove_outdated_files(&dir, &complete);
                for name in files_to_move(&complete).unwrap().iter().take(step - new.len()) {
                    fs::create_dir_all(dir.join(name).parent().unwrap()).unwrap();
                    fs::rename(complete.join(name), dir.join(name)).unwrap();
                }
                &new
            };
            assert_eq!(read_located(&dir, expected), *expected, "{step}");
            drop(PartialFolder::open(&dir).unwrap());
            assert_eq!(read_content(&dir), with_own(expected), "{step}");
        }
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn outdated_files_that_were_changed_stay() {
        let dir = std::env::temp_dir().join(format!("radiosity-outdated-{}", std::process::id()));
        write_content(&dir, &result_of(OLD_FILES));
        write_content(&dir, &content_of(&[("maps/1.exr", "painted")]));
        write_files(&dir, result_of(NEW_FILES)).unwrap();
        // One map alone would be no room.
        let kept = content_of(&[("maps/0.exr", "1"), ("maps/1.exr", "painted")]);
        assert_eq!(
            read_content(&dir),
            result_of(NEW_FILES).into_iter().chain(kept).collect()
        );
        fs::remove_dir_all(dir).unwrap();
    }
}
