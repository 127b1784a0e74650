//! The page of a sweep and of a comparison in a real browser, from the disk: no
//! error in its console, every picture there, the keyboard works, and nothing is
//! wider than the window.
//!
//! The check is a script that is put into a copy of the page: it presses the keys,
//! looks at what happens, and writes what it finds into the page, which the browser
//! then prints.

mod common;
mod moving;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::Run;
use serde_json::Value;

/// A laptop and a phone.
const WIDTHS: [u32; 2] = [1280, 420];

/// Debian's name for it, and others'.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// The browser; a test without it fails, or it would keep nothing.
fn browser() -> PathBuf {
    let found = BROWSERS.iter().find_map(|name| which::which(name).ok());
    found.expect("Chromium is not installed: `apt-get install chromium`, or scripts/test")
}

/// Opens a page in a window of this width; gives what the page came to, and what
/// its console had.
fn open(page: &Path, fragment: &str, width: u32) -> (String, String) {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser())
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--enable-logging=stderr",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!("--window-size={width},900"))
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}{fragment}", page.display()))
        .output()
        .expect("the browser starts");
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{log}");
    let console = log.lines().filter(|line| line.contains("CONSOLE"));
    let console = console.collect::<Vec<_>>().join("\n");
    (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        console,
    )
}

/// A page that has another in a frame of this width, and writes down what the check
/// in it says.
fn in_a_frame(page: &Path, width: u32) -> String {
    let name = page.file_name().unwrap().to_string_lossy();
    format!(
        "<!doctype html><meta charset=\"utf-8\"><link rel=\"icon\" href=\"data:,\">\
         <script>addEventListener(\"message\", (event) => {{\
         const text = document.createElement(\"pre\"); text.id = \"found\";\
         text.textContent = event.data; document.body.append(text); }});</script>\
         <body><iframe src=\"{name}\" style=\"border:0;width:{width}px;height:900px\"></iframe></body>"
    )
}

/// The page with the check in it, opened; gives what the check found.
fn checked(page: &Path, width: u32) -> Value {
    let html = std::fs::read_to_string(page).unwrap();
    let script = format!(
        "<script>{}</script></body>",
        include_str!("moving/check.js")
    );
    let (start, end) = html.rsplit_once("</body>").expect("a page");
    let copy = page.with_extension("checked.html");
    std::fs::write(&copy, format!("{start}{script}{end}")).unwrap();
    // No window is narrower than this, but a frame in it may be.
    const NARROWEST: u32 = 500;
    let (dom, console) = if width < NARROWEST {
        let around = page.with_extension("around.html");
        std::fs::write(&around, in_a_frame(&copy, width)).unwrap();
        open(&around, "", 2 * NARROWEST)
    } else {
        open(&copy, "", width)
    };
    assert_eq!(console, "", "{}", page.display());
    let found = dom
        .split_once("<pre id=\"found\">")
        .and_then(|(_, rest)| rest.split_once("</pre>"))
        .unwrap_or_else(|| panic!("the check did not come to its end: {dom:.2000}"));
    let text = found.0.replace("&gt;", ">").replace("&lt;", "<");
    serde_json::from_str(&text.replace("&amp;", "&")).expect("JSON")
}

fn assert_good(page: &Path, settings: u64) {
    for width in WIDTHS {
        let found = checked(page, width);
        assert_eq!(found["failed"], serde_json::json!([]), "{width}: {found:#}");
        assert!(found["pictures"].as_u64().unwrap() > 1, "{found:#}");
        assert_eq!(found["settings"], settings, "{found:#}");
        assert_eq!(found["width"], width, "{found:#}");
    }
}

#[test]
fn the_page_of_a_sweep() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::contact(folder.path());
    let out = folder.path().join("sweep");
    Run::new(["sweep", "--renderer", "reference", "--no-fallback", "-o"])
        .arg(&out)
        .arg(&film)
        .args([
            "--thresholds",
            "0.3,1,4",
            "--modes",
            "full,equivalent,preview",
        ])
        .args(["--periods", "auto,5"])
        .succeeds();
    let page = out.join("report.html");
    let html = std::fs::read_to_string(&page).unwrap();
    let shown = html.matches("<tr data-frame=\"0\">").count();
    assert!(shown > 2, "{shown}");
    // Object by object.
    assert!(html.contains("Objects of "), "the timeline is missing");
    assert!(html.contains("GiB"), "the machine is missing");
    assert_good(&page, shown as u64);
}

#[test]
fn the_page_of_a_comparison() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let (plain, fast) = (folder.path().join("plain"), folder.path().join("fast"));
    for (out, extra) in [
        (&plain, &["--baseline"][..]),
        (&fast, &["--threshold", "0.5", "--no-fallback"]),
    ] {
        Run::new(["render", "--renderer", "reference", "-o"])
            .arg(out)
            .arg(&film)
            .args(extra)
            .succeeds();
    }
    let page = folder.path().join("compare.html");
    let ended = Run::new(["compare", "--html"])
        .arg(&page)
        .args([&plain, &fast])
        .ends();
    assert_eq!(ended.status, 2, "{}", ended.stderr);
    assert_good(&page, 1);
}

#[test]
fn the_address_says_where_to_begin() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let out = folder.path().join("sweep");
    Run::new(["sweep", "--renderer", "reference", "-o"])
        .arg(&out)
        .arg(&film)
        .args(["--thresholds", "0.3,1", "--modes", "equivalent"])
        .succeeds();
    let page = out.join("report.html");
    let (dom, console) = open(&page, "#setting=1&frame=2&mode=difference", 1280);
    assert_eq!(console, "");
    assert!(dom.contains("class=\"stage difference\""));
    let chosen = "<tr data-frame=\"2\" tabindex=\"0\" aria-selected=\"true\">";
    assert!(dom.contains(chosen), "{dom:.4000}");
}

#[test]
fn the_check_finds_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let film = moving::ladybirds(folder.path());
    let out = folder.path().join("sweep");
    Run::new(["sweep", "--renderer", "reference", "-o"])
        .arg(&out)
        .arg(&film)
        .args(["--thresholds", "1", "--modes", "full,equivalent"])
        .succeeds();
    let page = out.join("report.html");
    let html = std::fs::read_to_string(&page).unwrap();
    let broken = out.join("broken.html");
    for (from, to, wrong) in [
        (
            "data:image/png;base64,",
            "data:image/png;base64,AAAA",
            "picture",
        ),
        (
            "margin: 0 auto; max-width",
            "min-width: 90rem; max-width",
            "wider",
        ),
        ("key === \"ArrowRight\"", "key === \"x\"", "ArrowRight"),
    ] {
        assert!(html.contains(from), "{from}");
        std::fs::write(&broken, html.replace(from, to)).unwrap();
        let found = checked(&broken, 1280);
        let failed = found["failed"].to_string();
        assert!(failed.contains(wrong), "{from}: {failed}");
    }
    // What throws is in the console.
    let throws = html.replace("\"use strict\";", "\"use strict\"; nothing.at.all;");
    std::fs::write(&broken, throws).unwrap();
    let (_, console) = open(&broken, "", 1280);
    assert!(console.contains("ReferenceError"), "{console}");
}
