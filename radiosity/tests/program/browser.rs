//! Opens pages in a browser.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Returns the browser's command; without one prints that the test is skipped.
pub fn browser_for(test: &str) -> Option<String> {
    let browser = std::env::var("RADIOSITY_BROWSER").ok();
    if browser.is_none() {
        eprintln!("SKIPPED {test}: RADIOSITY_BROWSER names no browser");
    }
    browser
}

/// A function by which a script hands its outcome over.
const HAND_OVER: &str = include_str!("outcome.js");

/// Returns `page` with a script at its end, which calls `hand_over` with its outcome.
pub fn with_script(page: &str, script: &str) -> String {
    page.replace("</body>", &format!("<script>{HAND_OVER}{script}</script></body>"))
}

/// Opens the page in `browser` and returns the JSON that its script hands over.
pub fn page_outcome(browser: &str, page: &Path) -> Value {
    let shown = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu-sandbox"])
        .args([
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
        ])
        .args(["--ignore-gpu-blocklist", "--window-size=1000,900"])
        .args([
            "--disable-background-networking",
            "--allow-file-access-from-files",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    let Some(start) = text.find("<pre id=\"outcome\">") else {
        panic!("the script did nothing: {text}");
    };
    let outcome = &text[start + 18..];
    serde_json::from_str(&outcome[..outcome.find("</pre>").unwrap()]).unwrap()
}
