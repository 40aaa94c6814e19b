//! A stage, an entry point of a WGSL file, and its checks on inputs of many sizes.

use crate::case::Case;
use crate::compare::{UNWRITTEN_BITS, check_layout, compare_output};
use crate::device::{Gpu, RunBuffer};
use crate::entry_point::{Binding, EntryPoint};
use crate::failure::{Failure, Fault, format_number};
use crate::loops::max_loop_turns;
use crate::watch::{LogPlace, WATCH_LOG, WATCH_LOG_WORDS, WatchedText, watch_shader};
use crate::wgsl::compile;
use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;
use wgpu::naga::Module;

/// Time that a run may take, unless another is set: a check of 65 536 workgroups takes seconds on a software adapter.
const DEFAULT_TIME_LIMIT: Duration = Duration::from_secs(60);

/// Largest number of workgroups that are watched, and of the further sizes that are run after a difference.
const MAX_OTHER_GROUPS: usize = 64;

/// A stage that watches its accesses and its loops.
struct WatchedStage {
    pipeline: wgpu::ComputePipeline,
    text: WatchedText,
    binding: u32,
}

/// Returns the workgroups for so many elements.
type Dispatch = Box<dyn Fn(usize) -> [u32; 3]>;

/// An entry point of a WGSL file, compiled on a device.
pub struct Stage {
    gpu: Gpu,
    /// File and entry point.
    subject: String,
    entry: EntryPoint,
    pipeline: wgpu::ComputePipeline,
    /// None where there is nothing to watch.
    watched: Option<WatchedStage>,
    dispatch: Option<Dispatch>,
    sizes: Vec<usize>,
    time_limit: Duration,
}

/// What a check that passed has compared.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Sizes of the cases.
    pub sizes: Vec<usize>,
    /// Number of compared values.
    pub values: u64,
    /// Largest error over its bound.
    pub nearest: f64,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let nearest = format_number(100.0 * self.nearest);
        write!(
            f,
            "{} values of sizes {:?} agree; {nearest} % of a bound is reached",
            self.values, self.sizes
        )
    }
}

impl Stage {
    /// Compiles the entry point `entry` of `text`; messages call the file `path`.
    ///
    /// Errors: naga's diagnostic; an entry point that is not there, or that binds other things than buffers.
    pub fn new(gpu: &Gpu, path: &str, text: &str, entry: &str) -> Result<Self, Failure> {
        let subject = format!("{path}: {entry}");
        let fail = |fault| Failure {
            subject: subject.clone(),
            fault,
        };
        let (module, info) = compile(text, path).map_err(|found| fail(Fault::Wgsl(found.listing)))?;
        let described = EntryPoint::new(&module, &info, entry).map_err(|reason| fail(Fault::Case(reason)))?;
        let pipeline = compile_within_limit(gpu, text, entry);
        let mut stage = Self {
            gpu: gpu.clone(),
            pipeline: pipeline.map_err(fail)?,
            watched: watch_stage(gpu, (text, entry), &module, &described).map_err(fail)?,
            subject,
            entry: described,
            dispatch: None,
            sizes: Vec::new(),
            time_limit: DEFAULT_TIME_LIMIT,
        };
        let (lanes, most) = (stage.lanes(), stage.most_in_a_row());
        stage.sizes = vec![1, lanes - 1, lanes, lanes + 1, 5 * lanes + 1, most + 1];
        stage.sizes.retain(|size| *size > 0);
        stage.sizes.dedup();
        Ok(stage)
    }

    /// Sets the workgroups for so many elements. Otherwise each lane has an element: where one dimension does not hold
    /// the workgroups they are split over x and y, and workgroup `y * num_workgroups.x + x` may have no elements.
    pub fn with_dispatch(self, dispatch: impl Fn(usize) -> [u32; 3] + 'static) -> Self {
        Self {
            dispatch: Some(Box::new(dispatch)),
            ..self
        }
    }

    /// Sets the sizes of [`Self::check`]. Otherwise they are, by the number of lanes of a workgroup: 1, lanes − 1, lanes,
    /// lanes + 1, 5 lanes + 1, and one element more than a dimension of workgroups holds (65 535 workgroups).
    pub fn with_sizes(self, sizes: &[usize]) -> Self {
        Self {
            sizes: sizes.to_vec(),
            ..self
        }
    }

    /// Leaves out the size beyond 65 535 workgroups: for a slow stage, or a slow reference.
    pub fn without_many_groups(mut self) -> Self {
        let most = self.most_in_a_row();
        self.sizes.retain(|size| *size <= most);
        self
    }

    /// Adds size 0, run as one workgroup, for a stage that reads the number of elements from a buffer: WGSL knows no
    /// empty array.
    pub fn with_empty(mut self) -> Self {
        self.sizes.insert(0, 0);
        self
    }

    /// Sets the time after which a run is given up, 60 s otherwise. The thread of a run that is given up goes on until the
    /// program ends, and its device is of no further use.
    pub fn with_time_limit(self, time_limit: Duration) -> Self {
        Self { time_limit, ..self }
    }

    /// Returns the number of lanes of a workgroup.
    pub fn lanes(&self) -> usize {
        self.entry.workgroup_size.iter().map(|lanes| *lanes as usize).product()
    }

    /// Returns the number of elements that a dimension of workgroups holds.
    fn most_in_a_row(&self) -> usize {
        self.lanes() * self.gpu.limits().max_compute_workgroups_per_dimension as usize
    }

    /// Checks the case of each size.
    ///
    /// Errors: the first that differs, or cannot be run; no value is compared; the reference changes no value of a buffer
    /// that is input and output, so that a stage that does nothing would pass.
    pub fn check(&self, case: impl Fn(usize) -> Case) -> Result<Report, Failure> {
        let mut report = Report::default();
        let mut changes = BTreeMap::new();
        for (k, size) in self.sizes.iter().enumerate() {
            let made = case(*size);
            let compared = self.check_case(*size, &made);
            let (values, nearest) = compared.map_err(|failure| self.add_other_sizes(failure, k, &case))?;
            report.sizes.push(*size);
            report.values += values;
            report.nearest = report.nearest.max(nearest);
            for output in made.outputs {
                let input = made.inputs.iter().find(|(name, _)| *name == output.name);
                let changed = input.is_none_or(|(_, values)| values.bytes != output.expected.bytes);
                *changes.entry(output.name).or_insert(false) |= changed;
            }
        }
        let fail = |text: String| Failure {
            subject: self.subject.clone(),
            fault: Fault::Case(text),
        };
        if report.values == 0 {
            return Err(fail("nothing was compared".into()));
        }
        match changes.iter().find(|(_, changed)| !**changed) {
            Some((name, _)) => Err(fail(format!(
                "`{name}` is the same before and after in every case: a stage that does nothing would pass"
            ))),
            None => Ok(report),
        }
    }

    /// Adds what the other sizes show to the difference that was found at the `k`th; without the size of many workgroups.
    fn add_other_sizes(&self, mut failure: Failure, k: usize, case: impl Fn(usize) -> Case) -> Failure {
        let Fault::Difference(difference) = &mut failure.fault else {
            return failure;
        };
        let (before, after) = (&self.sizes[..k], &self.sizes[k + 1..]);
        let mut agreeing: Vec<String> = before.iter().map(usize::to_string).collect();
        let mut last = None;
        for size in after.iter().filter(|size| **size <= MAX_OTHER_GROUPS * self.lanes()) {
            match self.check_case(*size, &case(*size)) {
                Ok(_) => agreeing.push(size.to_string()),
                Err(other) => {
                    let text = other.fault.to_string();
                    last = text.lines().next().map(|line| format!("at size {size}: {line}"));
                }
            }
        }
        if !agreeing.is_empty() {
            difference.other_sizes = vec![format!("agrees at sizes {}", agreeing.join(", "))];
        }
        difference.other_sizes.extend(last);
        failure
    }

    /// Runs a case and compares its outputs; returns the number of values, and the largest error over its bound.
    fn check_case(&self, size: usize, case: &Case) -> Result<(u64, f64), Failure> {
        let fail = |fault| Failure {
            subject: format!("{}, size {size}", self.subject),
            fault,
        };
        let refuse = |text| fail(Fault::Case(text));
        let buffers = self.fill_buffers(case).map_err(refuse)?;
        let groups = self.workgroups(size).map_err(refuse)?;
        self.check_watched(case, groups).map_err(fail)?;
        let pipeline = self.pipeline.clone();
        let run = move |gpu: &Gpu| gpu.run(&pipeline, &buffers, groups);
        let found = self.gpu.work_within(self.time_limit, run).map_err(fail)?;
        let mut found = found.into_iter();
        let (mut values, mut nearest) = (0, 0.0f64);
        for binding in &self.entry.bindings {
            let Some(output) = case.outputs.iter().find(|output| output.name == binding.name) else {
                continue;
            };
            let found = found.next().unwrap_or_default();
            let bindings = &self.entry.bindings;
            let compared = compare_output(case, bindings, (binding, output), &found, self.lanes()).map_err(fail)?;
            values += compared.0;
            nearest = nearest.max(compared.1);
        }
        match values {
            0 if size > 0 => Err(refuse("nothing was compared: the reference has no values".into())),
            _ => Ok((values, nearest)),
        }
    }

    /// Runs a case of few workgroups as the text that watches it.
    ///
    /// Errors: a loop has no end; lanes race.
    fn check_watched(&self, case: &Case, groups: [u32; 3]) -> Result<(), Fault> {
        let count = groups.iter().fold(1, |all: usize, n| all.saturating_mul(*n as usize));
        let Some(watched) = self.watched.as_ref().filter(|_| count <= MAX_OTHER_GROUPS) else {
            return Ok(());
        };
        let mut buffers = self.fill_buffers(case).map_err(Fault::Case)?;
        for buffer in &mut buffers {
            buffer.is_read_back = false;
        }
        buffers.push(RunBuffer {
            group: 0,
            binding: watched.binding,
            uniform: false,
            is_read_back: true,
            bytes: vec![0; 4 * WATCH_LOG_WORDS],
        });
        let pipeline = watched.pipeline.clone();
        let run = move |gpu: &Gpu| gpu.run(&pipeline, &buffers, groups);
        let found = self.gpu.work_within(self.time_limit, run)?;
        let words = found.first().map_or(&[][..], Vec::as_slice).chunks_exact(4);
        let words: Vec<u32> = words
            .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
            .collect();
        if let Some(number) = watched.text.find_endless_loop(&words) {
            return Err(Fault::EndlessLoop(watched.text.loops[number].clone()));
        }
        let report = watched.text.read_races(&words);
        match report.races {
            0 => Ok(()),
            _ => Err(Fault::Race(report)),
        }
    }

    /// Returns the buffers of a run. Outputs that are no inputs hold a pattern.
    fn fill_buffers(&self, case: &Case) -> Result<Vec<RunBuffer>, String> {
        let bindings = &self.entry.bindings;
        let names = case.inputs.iter().map(|(name, _)| name);
        let names = names.chain(case.outputs.iter().map(|output| &output.name));
        for name in names.chain(case.reads.iter().map(|(name, _)| name)) {
            if !bindings.iter().any(|binding| binding.name == *name) {
                let known: Vec<&str> = bindings.iter().map(|binding| binding.name.as_str()).collect();
                return Err(format!("does not use a buffer `{name}`; it uses: {}", known.join(", ")));
            }
        }
        bindings.iter().map(|binding| self.fill_buffer(case, binding)).collect()
    }

    fn fill_buffer(&self, case: &Case, binding: &Binding) -> Result<RunBuffer, String> {
        let name = &binding.name;
        let inputs: Vec<_> = case.inputs.iter().filter(|(input, _)| input == name).collect();
        let outputs: Vec<_> = case.outputs.iter().filter(|output| output.name == *name).collect();
        if inputs.len() > 1 || outputs.len() > 1 {
            return Err(format!("`{name}` is given twice"));
        }
        let (input, output) = (inputs.first(), outputs.first());
        if output.is_some() && !binding.written {
            return Err(format!("`{name}` is an output of the case; the shader only reads it"));
        }
        let expected = output.map(|output| &output.expected);
        let given = [input.map(|(_, values)| values), expected];
        for values in given.into_iter().flatten() {
            check_layout(binding, values)?;
        }
        let (mut bytes, fill, length) = match given {
            [Some(values), Some(expected)] if values.bytes.len() != expected.bytes.len() => {
                let lengths = [values, expected].map(|values| values.bytes.len());
                return Err(format!(
                    "`{name}` has {} bytes, the reference {}",
                    lengths[0], lengths[1]
                ));
            }
            [Some(values), _] => (values.bytes.clone(), [0; 4], values.bytes.len()),
            [None, Some(expected)] => (Vec::new(), UNWRITTEN_BITS.to_le_bytes(), expected.bytes.len()),
            [None, None] => return Err(format!("the case neither fills `{name}` nor compares it")),
        };
        let limits = self.gpu.limits();
        let most = match binding.uniform {
            true => limits.max_uniform_buffer_binding_size,
            false => limits.max_storage_buffer_binding_size,
        };
        let length = length.max(binding.min_bytes).next_multiple_of(4);
        if length as u64 > most {
            return Err(format!("`{name}` has {length} bytes; the device binds {most}"));
        }
        bytes.extend(fill.into_iter().cycle().take(length - bytes.len()));
        Ok(RunBuffer {
            group: binding.group,
            binding: binding.binding,
            uniform: binding.uniform,
            is_read_back: output.is_some(),
            bytes,
        })
    }

    /// Returns the workgroups for so many elements.
    fn workgroups(&self, size: usize) -> Result<[u32; 3], String> {
        let most = self.gpu.limits().max_compute_workgroups_per_dimension;
        let count = size.div_ceil(self.lanes()).max(1);
        let rows = count.div_ceil(most as usize);
        let split = || [count.div_ceil(rows), rows, 1].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let groups = self.dispatch.as_ref().map_or_else(split, |dispatch| dispatch(size));
        match groups.iter().all(|n| *n <= most) {
            true => Ok(groups),
            false => Err(format!(
                "{groups:?} workgroups; the device allows {most} in a dimension"
            )),
        }
    }
}

/// Compiles an entry point on the device.
fn compile_within_limit(gpu: &Gpu, text: &str, entry: &str) -> Result<wgpu::ComputePipeline, Fault> {
    let (text, name) = (text.to_owned(), entry.to_owned());
    gpu.work_within(DEFAULT_TIME_LIMIT, move |gpu| gpu.make_pipeline(&text, &name))
}

/// Compiles the text of an entry point that watches it; none where it has neither loops nor workgroup memory that can be watched,
/// or where the device has no place for one more buffer.
fn watch_stage(
    gpu: &Gpu,
    (text, entry): (&str, &str),
    module: &Module,
    described: &EntryPoint,
) -> Result<Option<WatchedStage>, Fault> {
    let limits = gpu.limits();
    let place = LogPlace::behind_bindings(module, 0);
    let buffers = described.bindings.iter().filter(|binding| !binding.uniform).count() as u32;
    if buffers >= limits.max_storage_buffers_per_shader_stage {
        return Ok(None);
    }
    let max_bytes = limits.max_compute_workgroup_storage_size;
    let max_turns = Some(max_loop_turns(gpu.device_type()));
    let Some(watched) = watch_shader(text, module, place, max_bytes, max_turns) else {
        return Ok(None);
    };
    // A text that hides a name from its variable is not followed, nor an entry point with nothing to watch.
    let uses_log = compile(&watched.text, "").ok().and_then(|(module, info)| {
        let described = EntryPoint::new(&module, &info, entry).ok()?;
        Some(described.bindings.iter().any(|binding| binding.name == WATCH_LOG))
    });
    if uses_log != Some(true) {
        return Ok(None);
    }
    Ok(Some(WatchedStage {
        pipeline: compile_within_limit(gpu, &watched.text, entry)?,
        text: watched,
        binding: place.binding,
    }))
}
