//! `stress.html`.

use super::Study;
use maud::{DOCTYPE, html};

/// One file that opens offline.
pub fn page(studies: &[Study]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head { meta charset="utf-8"; title { "Failure atlas" } }
            body {
                h1 { "Failure atlas" }
                ul { @for study in studies { li { (study.about.name) ": " (study.about.breaks) } } }
            }
        }
    };
    page.into_string()
}
