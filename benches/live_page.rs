//! Times solves of the live page in a browser beside the same function natively, on one thread each: solve, record and its
//! rendering. Prints also the time from the address to the first record, and the size of the program.

use live::request::LiveRequest;
use live::solve::LiveScene;
use miniz_oxide::deflate::compress_to_vec;
use oracle::solve::progress::without_progress;
use pollster::block_on;
use radiosity_benches::median_and_range;
use radiosity_tests::served_pages::work_pages;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::{env, fs};
use web::live_page::write_live_page;

const SCENES: [&str; 3] = ["cornell_box", "paper_room", "paper_room_objects"];
const TIMED_ROUNDS: usize = 5;
/// Time after which the browser is given up.
const BROWSER_LIMIT: Duration = Duration::from_secs(600);
const SCRIPT: &str = include_str!("live_page.js");

fn main() {
    let [module, browser] = ["RADIOSITY_WASM", "RADIOSITY_BROWSER"].map(|name| env::var(name).ok());
    let (Some(module), Some(browser)) = (module, browser) else {
        println!("the live page: skipped, RADIOSITY_WASM or RADIOSITY_BROWSER names no program or no browser");
        return;
    };
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = make_folder();
    write_live_page(&repository, Path::new(&module), &folder.join("page")).expect("the page is written");
    let program = fs::read(folder.join("page/program_bg.wasm")).expect("the page has a program");
    println!(
        "program: {} bytes, {} by deflate",
        program.len(),
        compress_to_vec(&program, 9).len()
    );
    let script = format!("const SCENES = {}, ROUNDS = {TIMED_ROUNDS};\n{SCRIPT}", json!(SCENES));
    let outcome = work_pages(&browser, &folder, &script, BROWSER_LIMIT);
    assert_eq!(outcome["failed"], Value::Null);
    let pool = ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread starts");
    for timed in outcome["scenes"].as_array().expect("scenes are timed") {
        compare_with_native(&repository, timed, &pool);
    }
}

/// Makes an empty folder for the page and the browser's profile.
fn make_folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("live_page");
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("an old page can be removed");
    }
    folder
}

/// Solves a scene as the page did, and prints both times.
fn compare_with_native(repository: &Path, timed: &Value, pool: &ThreadPool) {
    let name = timed["scene"].as_str().expect("a scene has a name");
    let file = repository.join(format!("scenes/{name}.obj"));
    let mut scene = LiveScene::open(&file.to_string_lossy(), None).expect("the scene is sound");
    let request = LiveRequest::parse(&timed["request"].to_string()).expect("the page asks for what it may");
    let mut solve = || {
        let start = Instant::now();
        let solved = pool.install(|| {
            block_on(scene.solve(&request, &without_progress(), async |_| ControlFlow::Continue(())))
                .expect("the scene is solved")
        });
        (start.elapsed().as_secs_f64(), solved.checksum)
    };
    let rounds: Vec<(f64, String)> = (0..TIMED_ROUNDS).map(|_| solve()).collect();
    assert!(
        rounds
            .iter()
            .all(|(_, checksum)| timed["checksum"] == checksum.as_str())
    );
    let seconds = timed["seconds"].as_array().expect("solves are timed");
    let [page, page_least, page_most] = median_and_range(seconds.iter().filter_map(Value::as_f64));
    let [native, native_least, native_most] = median_and_range(rounds.iter().map(|(seconds, _)| *seconds));
    let shots = timed["shots"].as_f64().expect("shots are counted");
    println!(
        "{name}: {shots} shots; page {page:.3} s ({page_least:.3}, {page_most:.3}), {:.0} shots/s; native {native:.3} s \
         ({native_least:.3}, {native_most:.3}), {:.0} shots/s; ratio {:.2}; first record after {:.1} s",
        shots / page,
        shots / native,
        page / native,
        timed["first_record"].as_f64().expect("the first record is timed"),
    );
}
