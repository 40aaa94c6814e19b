//! Filling of a text's placeholders `{{KIND WORDS …}}`.

use crate::Result;
use crate::excerpt::read_item;
use crate::hand::check_number;
use crate::number::{count_shots, read_number};
use crate::runs::FinishedRuns;
use maud::html;
use std::collections::BTreeSet;
use std::path::Path;

/// Page with the record of a run.
pub const RECORD_PAGE: &str = "trace.html";

/// What fills the placeholders, and the files that filled texts refer to.
pub struct PlaceholderFiller<'a> {
    /// Root of the repository.
    pub repository: &'a Path,
    /// Results of the program.
    pub runs: &'a FinishedRuns,
    /// Files of runs that pages show, as run and file.
    pub shown_files: BTreeSet<(String, String)>,
}

impl PlaceholderFiller<'_> {
    /// Fills all placeholders of `text`, a file of this `name`.
    ///
    /// Errors: a placeholder that is unknown or cannot be filled; the message names the file and what is missing.
    pub fn fill_text(&mut self, name: &str, text: &str) -> Result<String> {
        let mut filled = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once("{{") {
            let (placeholder, behind) = after
                .split_once("}}")
                .ok_or_else(|| format!("{name}: {{{{ without }}}}"))?;
            filled += before;
            filled += &self
                .fill_placeholder(placeholder)
                .map_err(|error| format!("{name}: {error}"))?;
            rest = behind;
        }
        Ok(filled + rest)
    }

    fn fill_placeholder(&mut self, placeholder: &str) -> Result<String> {
        let words: Vec<&str> = placeholder.split_whitespace().collect();
        match words[..] {
            ["rust", file, item] => self.quote_item("Rust", file, item),
            ["wgsl", file, item] => self.quote_item("WGSL", file, item),
            ["figure", run, place, ref caption @ ..] => self.embed_page(run, place, &caption.join(" ")),
            ["picture", run, file, ref caption @ ..] => self.embed_picture(run, file, &caption.join(" ")),
            ["shot", run, shot] => self.link_shot(run, shot),
            ["step", run, step, part] => self.link_step(run, step, part),
            ["number", run, ref quantity @ ..] => read_number(self.runs, run, quantity),
            ["hand", printed, function, ref arguments @ ..] => {
                let parse = |word: &&str| word.parse().map_err(|_| format!("{word} is not a number"));
                let arguments = arguments.iter().map(parse).collect::<Result<Vec<f64>>>()?;
                check_number(printed, function, &arguments).map(|()| printed.to_owned())
            }
            ["command", run] => Ok(html! { code { (self.runs.command_of(run)?) } }.into_string()),
            _ => Err(format!("no placeholder is {{{{{placeholder}}}}}")),
        }
    }

    fn quote_item(&self, language: &str, file: &str, item: &str) -> Result<String> {
        let code = read_item(self.repository, file, item)?;
        let figure = html! {
            figure.code data-language=(language) {
                figcaption { b { (language) } " " code { (item) } " in " code { (file) } }
                pre tabindex="0" { code { (code) } }
            }
        };
        Ok(figure.into_string())
    }

    fn embed_page(&mut self, run: &str, place: &str, caption: &str) -> Result<String> {
        if let Some(shot) = place.strip_prefix("shot=") {
            self.check_shot(run, shot)?;
        }
        let page = self.show_file(run, RECORD_PAGE)?;
        let address = format!("{page}#{place}");
        let command = self.runs.command_of(run)?;
        let figure = html! {
            figure.live {
                iframe loading="lazy" name=(run) title=(caption) src=(address) {}
                figcaption {
                    (caption) " " a href=(address) target="_blank" { "Open this figure by itself" } ". Made by "
                    code { (command) } "."
                }
            }
        };
        Ok(figure.into_string())
    }

    fn embed_picture(&mut self, run: &str, file: &str, caption: &str) -> Result<String> {
        let picture = self.show_file(run, file)?;
        let figure = html! {
            figure.wide {
                img loading="lazy" src=(picture) alt=(caption);
                figcaption { (caption) }
            }
        };
        Ok(figure.into_string())
    }

    fn link_shot(&self, run: &str, shot: &str) -> Result<String> {
        self.check_shot(run, shot)?;
        Ok(link_into_figure(run, &format!("shot={shot}"), &format!("shot {shot}")))
    }

    fn link_step(&self, run: &str, step: &str, part: &str) -> Result<String> {
        self.runs.folder_of(run)?;
        let place = format!("step={step}&part={part}");
        let text = match part {
            "direct" => "direct light",
            "coarse" => "coarse links",
            "final" => "final gather",
            _ => return Err(format!("a step has no part {part}")),
        };
        Ok(link_into_figure(run, &place, &format!("step {step}, {text}")))
    }

    fn check_shot(&self, run: &str, shot: &str) -> Result<()> {
        let shots = count_shots(self.runs, run)?;
        match shot.parse::<u64>() {
            Ok(number) if number <= shots => Ok(()),
            _ => Err(format!("{run} has {shots} shots, and no shot {shot}")),
        }
    }

    /// Notes that the site needs a file of a run; returns its address.
    fn show_file(&mut self, run: &str, file: &str) -> Result<String> {
        self.runs.read_file(run, file)?;
        self.shown_files.insert((run.to_owned(), file.to_owned()));
        Ok(site_address(run, file))
    }
}

/// Returns the address of a run's file on the site.
pub fn site_address(run: &str, file: &str) -> String {
    let ending = file.rsplit('.').next().unwrap_or(file);
    format!("figures/{run}.{ending}")
}

fn link_into_figure(run: &str, place: &str, text: &str) -> String {
    let page = site_address(run, RECORD_PAGE);
    html! { a href={ (page) "#" (place) } target=(run) { (text) } }.into_string()
}
