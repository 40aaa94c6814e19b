//! What all pages are made of: one file that opens offline, in one look.

use super::cards::labelled;
use super::chart;
use super::number::percent;
use super::picture::DIVERGING;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");

/// A page.
pub struct Page<'a> {
    /// Its heading.
    pub title: &'a str,
    /// What the bar on top lists, and its links.
    pub bar: (&'a str, Markup),
    /// Below the heading.
    pub verdict: Markup,
    /// What it looks like beside what all do.
    pub style: &'a str,
    /// All else.
    pub body: Markup,
}

impl Page<'_> {
    /// The file.
    pub fn html(&self) -> String {
        let (listed, links) = &self.bar;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) (PreEscaped(chart::STYLE)) (PreEscaped(self.style)) }
                }
                body {
                    nav aria-label=(listed) { (links) }
                    main {
                        header #top { h1 { (self.title) } (self.verdict) }
                        (self.body)
                    }
                }
            }
        };
        page.into_string()
    }
}

/// The links to the sections of scenes.
pub fn scenes<'a>(names: impl Iterator<Item = &'a String>) -> Markup {
    html! {
        a href="#top" { "Overview" }
        @for (k, name) in names.enumerate() { a href={ "#scene-" (k + 1) } { (short(name)) } }
    }
}

/// The class of such tables.
const CARDS: &str = "cards";
/// More columns than these are cards on a phone.
const NARROW: usize = 4;

/// A table that scrolls by itself, or on a phone becomes a card a row, if it is wide or of the class that asks
/// for it. A heading that begins with # stands over
/// numbers; a line of it ends at |.
pub fn table(class: &str, heads: &[&str], rows: Markup) -> Markup {
    let cards = class == CARDS || heads.len() > NARROW;
    let rows = if cards { labelled(heads, &rows) } else { rows };
    let classes = [class, if cards && class != CARDS { CARDS } else { "" }].join(" ");
    let classes = classes.trim();
    html! {
        div.scroll { table class=[(!classes.is_empty()).then_some(classes)] {
            @if !heads.is_empty() { thead { tr { @for text in heads { (head(text)) } } } }
            tbody { (rows) }
        } }
    }
}

fn head(text: &str) -> Markup {
    let name = text.trim_start_matches('#');
    html! {
        th.n[name.len() < text.len()] {
            @for (k, line) in name.split('|').enumerate() { @if k > 0 { br; } (line) }
        }
    }
}

/// A scene's file without its folders.
pub fn short(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// A name and its value a row.
pub fn list<K: maud::Render, V: maud::Render>(rows: impl IntoIterator<Item = (K, V)>) -> Markup {
    table(
        "",
        &[],
        html! { @for (name, value) in rows { tr { td { (name) } td.n { (value) } } } },
    )
}

/// Large and at once: good, bad, or neither.
pub fn verdict(good: Option<bool>, word: &str, text: Markup) -> Markup {
    let class = match good {
        Some(true) => "verdict agree",
        Some(false) => "verdict disagree",
        None => "verdict",
    };
    html! { p class=(class) { strong { (word) } " " (text) } }
}

/// The same for what is no failure and yet to be looked at.
pub fn caution(word: &str, text: Markup) -> Markup {
    html! { p class="verdict careful" { strong { (word) } " " (text) } }
}

/// ✓ or another sign, told apart without colour too.
pub fn mark(pass: bool, title: [&str; 2], otherwise: &str) -> Markup {
    html! {
        @if pass { span.pass title=(title[0]) { "✓" } } @else { span.fail title=(title[1]) { (otherwise) } }
    }
}

/// What is worth saying, a line each.
pub fn notes(lines: &[String]) -> Markup {
    html! { @if !lines.is_empty() { div.notes { @for line in lines { p { (line) } } } } }
}

/// A picture with its caption.
pub fn figure(class: &str, source: &str, alt: &str, caption: Markup) -> Markup {
    html! {
        figure class=(class) {
            @if source.is_empty() { p.none { "no picture" } } @else { img src=(source) alt=(alt); }
            figcaption { (caption) }
        }
    }
}

/// A chart with its caption, or what to say where there is none.
pub fn chart(svg: Option<&str>, otherwise: &str, caption: Markup) -> Markup {
    html! {
        figure.wide {
            @if let Some(svg) = svg { (PreEscaped(svg)) } @else { p.none { (otherwise) } }
            figcaption { (caption) }
        }
    }
}

/// A colour and what it stands for.
pub fn key(colour: &str, name: Markup) -> Markup {
    html! { span.key { span style=(format!("background:{colour}")) {} (name) } }
}

/// From −range to +range.
pub fn colour_bar(range: f64) -> Markup {
    let stops: Vec<String> = DIVERGING.iter().map(|c| css(*c)).collect();
    html! {
        span.scale {
            span { "−" (percent(range)) }
            span.ramp style=(format!("background:linear-gradient(to right,{})", stops.join(","))) {}
            span { "+" (percent(range)) }
        }
    }
}

/// A colour as CSS writes it.
pub fn css([r, g, b]: [u8; 3]) -> String {
    format!("rgb({r} {g} {b})")
}
