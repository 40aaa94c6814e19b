//! The WGSL files of `shaders/`, and files of others that take the place of some of them.

use common::file::read_input;
use common::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// A WGSL file of the program: a stage, or functions that stages share.
#[derive(Clone, Copy, Debug)]
pub struct ShaderStage {
    /// File name in `shaders/`, without ending.
    pub name: &'static str,
    /// The WGSL.
    pub text: &'static str,
    /// Names of the stages at which `compare` shows its faults, the likeliest first; of records any.
    pub verdict: &'static [&'static str],
}

/// Makes a table of the names and the texts of shaders, and of the names by which a verdict speaks of them.
macro_rules! shader_files {
    ($($name:ident: $($verdict:literal)*;)*) => { [$(ShaderStage {
        name: stringify!($name),
        text: include_str!(concat!("shaders/", stringify!($name), ".wgsl")),
        verdict: &[$($verdict),*],
    }),*] };
}

/// All files, in the order in which a solve runs them.
pub const SHADER_STAGES: [ShaderStage; 36] = shader_files! {
    types:;
    form_factor: "form factor" "link" "link_factors" "sample_links" "links of GPU and CPU" "links side by side" "is_remote" "is_low";
    frame: "aim" "item buffer" "lookup" "escape" "links side by side";
    hemicube: "item buffer" "lookup" "project_direction" "unproject_point" "side_extent"
        "bound_corner";
    projection: "item buffer" "item buffer, all silhouettes" "lookup" "links side by side" "project_direction"
        "unproject_point" "bound_arc";
    image_bound: "item buffer" "item buffer, all silhouettes" "item buffer, relit" "links side by side" "edge_distance"
        "bound_arc" "bound_corner";
    intersect: "item buffer" "lookup" "rays" "escape" "links of GPU and CPU" "lookup, relit" "rays, relit"
        "intersect_planes" "touches_plane";
    item_buffer: "item buffer" "item buffer, all silhouettes" "item buffer, relit" "links side by side";
    item_buffer_paper: "item buffer" "item buffer, all silhouettes" "item buffer, relit" "links side by side";
    lookup: "lookup" "lookup, all mismatches" "lookup, relit" "links side by side";
    sampling: "form factor" "link" "link_factors" "sample_links" "rays" "texel_uv" "near_point_uv" "point_on_texel"
        "spot_point" "outline_point";
    texel_point: "form factor" "link" "point_on_texel";
    bvh: "rays" "escape" "links of GPU and CPU" "rays, relit" "make_ray";
    rays: "rays" "links of GPU and CPU" "rays, relit" "links side by side";
    view: "aim" "view: drawn faces" "item buffer" "item buffer, relit" "view: drawn faces, relit" "links side by side";
    link: "link" "form factor" "lookup" "rays" "links of GPU and CPU" "link, relit" "links side by side";
    patch_transfer: "received" "patch_transfer, races";
    closure: "closure" "escape" "link_scale" "closure, races";
    deposit: "deposit" "deposit, relit";
    escape: "escape" "escape, all patches";
    unshot_power: "power" "unshot_power, races";
    select: "select" "select: workgroups" "select: unshot" "closure" "deposit" "deposit, relit" "select, races";
    exchange: "exchange";
    gather: "collect";
    hierarchy_types:;
    surface_points: "link_factors" "sample_links" "spot_point" "outline_point";
    link_bounds: "link_bounds";
    link_factors: "link_factors";
    clear_work_lists: "clear_work_lists";
    visibility_samples: "refine" "receiver_points_per_side" "visibility_deviation";
    refine: "refine";
    sample_links: "sample_links" "rays";
    prefix_sum: "prefix_sum" "prefix_sum, races";
    subdivide_nodes: "subdivide_nodes";
    add_links: "add_links";
    store_links: "store_links";
};

impl ShaderStage {
    /// Returns the stage of this name.
    ///
    /// Errors: [`Error::Usage`], which lists all names.
    pub fn find(name: &str) -> Result<Self> {
        let found = SHADER_STAGES.into_iter().find(|stage| stage.name == name);
        found.ok_or_else(|| {
            let names = SHADER_STAGES.map(|stage| stage.name).join(", ");
            Error::Usage(format!("no shader stage is called {name:?}; there are: {names}"))
        })
    }

    /// Returns the names of the files whose faults `compare` shows at the stage of this name.
    pub fn files_judged_by(stage: &str) -> Vec<&'static str> {
        let judged = SHADER_STAGES.iter().filter(|file| file.verdict.contains(&stage));
        judged.map(|file| file.name).collect()
    }

    /// Returns the names of its stages in a verdict, in words.
    pub fn verdict_names(&self) -> String {
        match self.verdict {
            [] => "any".to_owned(),
            names => names.join("; "),
        }
    }

    /// Returns what the file does: the beginning of its first comment.
    pub fn summary(&self) -> String {
        let header = self.text.lines().map_while(|line| line.strip_prefix("// "));
        let header = header.collect::<Vec<_>>().join(" ");
        let ends = [". ", ": ", " ("].iter().filter_map(|end| header.find(end));
        header[..ends.min().unwrap_or(header.len())]
            .trim_end_matches('.')
            .to_owned()
    }

    /// Iterates over the entry points, in order.
    pub fn entry_points(&self) -> impl Iterator<Item = &'static str> {
        let is_entry = |attributes: &&str| {
            ["@compute", "@vertex", "@fragment"]
                .iter()
                .any(|a| attributes.starts_with(a))
        };
        let lines = self.text.lines();
        let entries = lines.clone().zip(lines.skip(1)).filter(move |(line, _)| is_entry(line));
        entries.filter_map(|(_, line)| function_name(line))
    }

    /// Returns the file of the twin in Rust, and its functions: those of the entry points, else all.
    pub fn twin(&self) -> String {
        let mut functions: Vec<&str> = self.entry_points().collect();
        if functions.is_empty() {
            functions = self.text.lines().filter_map(function_name).collect();
        }
        let end = if functions.is_empty() { "" } else { ": " };
        format!("cpu/src/shader_twins/{}.rs{end}{}", self.name, functions.join(", "))
    }

    /// Returns the names of the buffers and textures that the file declares: those that it only reads, or those that it
    /// writes.
    pub fn bindings(&self, written: bool) -> Vec<&'static str> {
        let declared = self.text.lines().filter(|line| line.starts_with("@group"));
        let own = declared.filter(|line| line.contains("read_write") == written);
        own.filter_map(|line| line.split(':').next()?.split_whitespace().last())
            .collect()
    }
}

/// Returns the name of the function that is defined in a line.
fn function_name(line: &'static str) -> Option<&'static str> {
    line.strip_prefix("fn ")?.split('(').next()
}

/// A file that takes the place of one of the program's.
#[derive(Debug)]
pub struct ShaderFile {
    /// Name of the stage.
    pub stage: &'static str,
    /// The file.
    pub path: PathBuf,
    /// The WGSL.
    pub text: String,
    used: AtomicBool,
}

impl ShaderFile {
    /// Reads a file for `stage`.
    ///
    /// Errors: [`Error::Usage`] of an unknown stage; [`Error::Input`] of a file that cannot be read, or is empty.
    pub fn read(stage: &str, path: &Path) -> Result<Self> {
        let stage = ShaderStage::find(stage)?.name;
        let text = String::from_utf8(read_input(path, "")?)
            .map_err(|error| Error::bad_input(path, "", format!("is no text in UTF-8: {error}")))?;
        if text.trim().is_empty() {
            return Err(Error::bad_input(path, "", "is empty: WGSL is needed"));
        }
        Ok(Self::new(stage, path, text))
    }

    /// Makes a file of a text.
    pub fn new(stage: &'static str, path: &Path, text: String) -> Self {
        Self {
            stage,
            path: path.to_path_buf(),
            text,
            used: AtomicBool::new(false),
        }
    }

    /// Returns whether a pipeline was made of the file.
    pub fn is_used(&self) -> bool {
        self.used.load(Ordering::Relaxed)
    }

    /// Records that a pipeline was made of the file.
    pub(crate) fn mark_used(&self) {
        self.used.store(true, Ordering::Relaxed);
    }
}
