//! Pages that a browser gets from a server of the test's.

use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read, Result, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::Duration;

/// What the browser asks for.
struct PageRequest {
    /// The file.
    name: String,
    /// What it posts.
    body: Vec<u8>,
}

/// Opens a page with `script` in `browser`, beside the files of `folder`/page, and returns the JSON that the script posts to
/// `outcome`. The browser draws and computes in software; what it keeps is in `folder`/profile.
///
/// # Panics
/// If the browser does not start, or nothing is posted within `limit`.
pub fn work_pages(browser: &str, folder: &Path, script: &str, limit: Duration) -> Value {
    let (sender, receiver) = channel();
    let page = format!("<!DOCTYPE html><body><script>{script}</script></body>");
    let port = serve_folder(folder.join("page"), page, sender).expect("a port is free");
    let mut shown = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--window-size=1300,1000"])
        .args([
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--ignore-gpu-blocklist",
        ])
        .args([
            "--enable-unsafe-webgpu",
            "--enable-features=Vulkan",
            "--use-webgpu-adapter=swiftshader",
        ])
        .args(["--disable-background-networking", "--remote-debugging-port=0"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("http://127.0.0.1:{port}/test.html"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the browser starts");
    let outcome = receiver.recv_timeout(limit);
    shown.kill().expect("the browser can be ended");
    shown.wait().expect("the browser ends");
    serde_json::from_str(&outcome.expect("the page hands nothing over")).expect("the page posts JSON")
}

/// Serves the files of `folder` and `page` as test.html, and sends on what is posted. Returns the port.
fn serve_folder(folder: PathBuf, page: String, outcome: Sender<String>) -> Result<u16> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let port = listener.local_addr()?.port();
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (folder, page, outcome) = (folder.clone(), page.clone(), outcome.clone());
            // A browser may close a connection early.
            thread::spawn(move || answer_request(stream, &folder, &page, &outcome).unwrap_or_default());
        }
    });
    Ok(port)
}

fn answer_request(mut stream: TcpStream, folder: &Path, page: &str, outcome: &Sender<String>) -> Result<()> {
    let PageRequest { name, body } = read_request(&stream)?;
    let kind = match name.rsplit('.').next() {
        Some("html") => "text/html",
        Some("js") => "text/javascript",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    };
    let content = match &*name {
        "test.html" => Ok(page.as_bytes().to_vec()),
        "outcome" => {
            let _ = outcome.send(String::from_utf8_lossy(&body).into_owned());
            Ok(Vec::new())
        }
        _ => fs::read(folder.join(&name)),
    };
    let (status, content) = match content {
        Ok(content) => ("200 OK", content),
        Err(_) => ("404 Not Found", Vec::new()),
    };
    let length = content.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n"
    )?;
    stream.write_all(&content)
}

fn read_request(stream: &TcpStream) -> Result<PageRequest> {
    let mut reader = BufReader::new(stream);
    let mut line = String::new();
    reader.read_line(&mut line)?;
    let path = line.split_whitespace().nth(1).unwrap_or("/").to_owned();
    let mut length = 0;
    loop {
        let mut header = String::new();
        reader.read_line(&mut header)?;
        let Some((name, value)) = header.split_once(':') else {
            break;
        };
        if name.eq_ignore_ascii_case("content-length") {
            length = value.trim().parse().unwrap_or(0);
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body)?;
    let name = path.trim_start_matches('/').split('?').next().unwrap_or_default();
    Ok(PageRequest {
        name: name.to_owned(),
        body,
    })
}
