//! Builds HTML pages that open offline: page frame, verdicts, figures and colour keys.

use super::chart;
use super::format::format_percent;
use super::picture::DIVERGING_COLOURS;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const PAGE_STYLE: &str = include_str!("style.css");

/// HTML page.
pub struct Page<'a> {
    /// Heading.
    pub title: &'a str,
    /// Navigation bar: its label and links.
    pub bar: (&'a str, Markup),
    /// Verdict below the heading.
    pub verdict: Markup,
    /// Style sheet in addition to the common one.
    pub style: &'a str,
    /// Body.
    pub body: Markup,
}

impl Page<'_> {
    /// Renders the page as one self-contained file.
    pub fn to_html(&self) -> String {
        let (listed, links) = &self.bar;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(PAGE_STYLE)) (PreEscaped(chart::CHART_STYLE)) (PreEscaped(self.style)) }
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

/// Renders links to the sections of scenes.
pub fn scene_links<'a>(names: impl Iterator<Item = &'a String>) -> Markup {
    html! {
        a href="#top" { "Overview" }
        @for (k, name) in names.enumerate() { a href={ "#scene-" (k + 1) } { (file_name(name)) } }
    }
}

/// Returns a path without its folders.
pub fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// Renders a verdict: good, bad, or neither.
pub fn render_verdict(good: Option<bool>, word: &str, text: Markup) -> Markup {
    let class = match good {
        Some(true) => "verdict agree",
        Some(false) => "verdict disagree",
        None => "verdict",
    };
    html! { p class=(class) { strong { (word) } " " (text) } }
}

/// Renders a verdict that is no failure but needs attention.
pub fn render_caution(word: &str, text: Markup) -> Markup {
    html! { p class="verdict careful" { strong { (word) } " " (text) } }
}

/// Renders ✓ or the sign `otherwise`, with the title of each.
pub fn render_mark(pass: bool, title: [&str; 2], otherwise: &str) -> Markup {
    html! {
        @if pass { span.pass title=(title[0]) { "✓" } } @else { span.fail title=(title[1]) { (otherwise) } }
    }
}

/// Renders notes, one per line.
pub fn render_notes(lines: &[String]) -> Markup {
    html! { @if !lines.is_empty() { div.notes { @for line in lines { p { (line) } } } } }
}

/// Renders a picture with its caption.
pub fn render_figure(class: &str, source: &str, alt: &str, caption: Markup) -> Markup {
    html! {
        figure class=(class) {
            @if source.is_empty() { p.none { "no picture" } } @else { img src=(source) alt=(alt); }
            figcaption { (caption) }
        }
    }
}

/// Renders a chart with its caption, or the text `otherwise`.
pub fn render_chart(svg: Option<&str>, otherwise: &str, caption: Markup) -> Markup {
    html! {
        figure.wide {
            @if let Some(svg) = svg { (PreEscaped(svg)) } @else { p.none { (otherwise) } }
            figcaption { (caption) }
        }
    }
}

/// Renders a colour key: a swatch and its meaning.
pub fn render_colour_key(colour: &str, name: Markup) -> Markup {
    html! { span.key { span style=(format!("background:{colour}")) {} (name) } }
}

/// Renders the diverging colour scale from −range to +range.
pub fn render_colour_bar(range: f64) -> Markup {
    let stops: Vec<String> = DIVERGING_COLOURS.iter().map(|c| css_colour(*c)).collect();
    html! {
        span.scale {
            span { "−" (format_percent(range)) }
            span.ramp style=(format!("background:linear-gradient(to right,{})", stops.join(","))) {}
            span { "+" (format_percent(range)) }
        }
    }
}

/// Formats a colour for CSS.
pub fn css_colour([r, g, b]: [u8; 3]) -> String {
    format!("rgb({r} {g} {b})")
}
