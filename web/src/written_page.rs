//! What the pages of the site share: the frame, and their writing.

use crate::Result;
use std::fs;
use std::path::Path;

/// The written site.
pub struct WrittenSite {
    /// Number of files.
    pub files: usize,
    /// Their bytes.
    pub bytes: usize,
}

impl WrittenSite {
    /// Writes files into `out`, by their names there.
    pub fn write(out: &Path, files: &[(String, Vec<u8>)]) -> Result<Self> {
        for (name, content) in files {
            let path = out.join(name);
            let folder = path.parent().unwrap_or(out);
            fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
            fs::write(&path, content).map_err(|error| format!("{name}: {error}"))?;
        }
        Ok(Self {
            files: files.len(),
            bytes: files.iter().map(|(_, content)| content.len()).sum(),
        })
    }
}

/// Renders a page of the frame `web/page.html` with these style sheets.
pub fn render_page(repository: &Path, title: &str, style_sheets: &[&str], content: &str) -> Result<String> {
    let frame = read_source(repository, "web/page.html")?;
    let mut style = String::new();
    for file in style_sheets {
        style += &read_source(repository, file)?;
    }
    Ok(frame
        .replace("{{title}}", title)
        .replace("{{style}}", &style)
        .replace("{{content}}", content))
}

/// Reads a file of the repository.
pub fn read_source(repository: &Path, file: &str) -> Result<String> {
    fs::read_to_string(repository.join(file)).map_err(|error| format!("{file}: {error}"))
}
