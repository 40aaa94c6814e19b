//! The article "Radiosity, step by step" as a static site.
//!
//! The texts are the HTML files of `web/`, in which placeholders stand for what the program makes:
//!
//! ```text
//! {{rust FILE ITEM}}, {{wgsl FILE ITEM}}   lines of the source
//! {{figure RUN PLACE CAPTION …}}           a page that a run wrote, opened at #PLACE
//! {{picture RUN FILE CAPTION …}}           a picture that a run wrote
//! {{shot RUN N}}, {{step RUN N PART}}      a link that moves a figure
//! {{number RUN QUANTITY}}                  a number of a run's results
//! {{hand VALUE FUNCTION ARGUMENTS}}        a number worked by hand, checked by an exact function
//! {{command RUN}}                          the command line of a run
//! ```
//!
//! [`runs`] runs the commands of `web/runs.txt`, [`excerpt`] takes lines from sources, [`number`] reads results, [`hand`]
//! checks numbers, [`placeholder`] fills a text, [`site`] writes the pages, and [`live_page`] that which solves. A placeholder that cannot be filled is an error of
//! one line, which names the file.

pub mod excerpt;
pub mod hand;
pub mod live_page;
pub mod number;
pub mod placeholder;
pub mod runs;
pub mod site;
pub mod written_page;

/// Result of a step; the error is one line for the person who runs it.
pub type Result<T> = std::result::Result<T, String>;
