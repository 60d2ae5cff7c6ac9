//! The page of `fstop lens` in a real browser, where one is installed: it fits wide screens and narrow ones, by day and by night.
//!
//! Chromium is spoken to by the DevTools protocol through a pipe (fds 3 and 4, messages end with a zero byte), which every build of it
//! has: <https://chromedevtools.github.io/devtools-protocol/>.
#![cfg(unix)]

use crate::common::program::fstop;
use serde_json::{Value, json};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// What `FSTOP_BROWSER` names, else a Chromium in the path.
fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("FSTOP_BROWSER") {
        return Some(named.into());
    }
    let path = std::env::var_os("PATH")?;
    let names = [
        "chromium",
        "chromium-browser",
        "google-chrome",
        "chrome-headless-shell",
    ];
    let mut places =
        std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name)));
    places.find(|place| place.is_file())
}

/// A browser with one empty page.
struct Session {
    child: Arc<Mutex<Child>>,
    commands: File,
    answers: BufReader<File>,
    asked: u64,
    id: Option<String>,
}

impl Session {
    fn start(program: &Path, folder: &Path) -> Session {
        let pipes = ["in", "out"].map(|name| folder.join(name));
        let made = Command::new("mkfifo")
            .args(&pipes)
            .status()
            .expect("mkfifo");
        assert!(made.success());
        const RUN: &str = "exec \"$0\" --headless --no-sandbox --no-zygote --disable-gpu --disable-dev-shm-usage --in-process-gpu \
             --no-first-run --remote-debugging-pipe --user-data-dir=\"$3\" 3<\"$1\" 4>\"$2\"";
        let mut command = Command::new("sh");
        command
            .args(["-c", RUN])
            .arg(program)
            .args(&pipes)
            .arg(folder.join("profile"));
        let quiet = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        let child = Arc::new(Mutex::new(quiet.spawn().expect("the browser starts")));
        // In the shell's order.
        let commands = OpenOptions::new()
            .write(true)
            .open(&pipes[0])
            .expect("its input");
        let answers = BufReader::new(File::open(&pipes[1]).expect("its output"));
        let watched = Arc::clone(&child);
        std::thread::spawn(move || {
            // A browser that says nothing must not hold the tests up: then its pipe ends, and the test fails.
            std::thread::sleep(Duration::from_secs(120));
            watched.lock().map(|mut child| child.kill()).ok();
        });
        let mut session = Session {
            child,
            commands,
            answers,
            asked: 0,
            id: None,
        };
        let page = session.ask("Target.createTarget", json!({"url": "about:blank"}));
        let attached = session.ask(
            "Target.attachToTarget",
            json!({"targetId": page["targetId"], "flatten": true}),
        );
        session.id = attached["sessionId"].as_str().map(str::to_string);
        session.ask("Page.enable", json!({}));
        session
    }

    /// The answer to a command.
    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.asked += 1;
        let mut message = json!({"id": self.asked, "method": method, "params": parameters});
        if let Some(id) = &self.id {
            message["sessionId"] = json!(id);
        }
        self.commands
            .write_all(format!("{message}\0").as_bytes())
            .expect("a command");
        loop {
            let answer = self.hear();
            if answer["id"] == json!(self.asked) {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
        }
    }

    fn hear(&mut self) -> Value {
        let mut bytes = Vec::new();
        self.answers.read_until(0, &mut bytes).expect("an answer");
        assert_eq!(bytes.pop(), Some(0), "the browser went away");
        serde_json::from_slice(&bytes).expect("JSON")
    }

    fn evaluate(&mut self, script: &str) -> Value {
        let answer = self.ask(
            "Runtime.evaluate",
            json!({"expression": script, "returnByValue": true}),
        );
        answer["result"]["value"].clone()
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        if let Ok(mut child) = self.child.lock() {
            child.kill().ok();
            child.wait().ok();
        }
    }
}

/// What is wrong with the page as it is laid out: parts that reach beyond the window but in boxes of their own that scroll, letters that nobody can
/// read, and pictures that nothing is seen of.
const LOOK: &str = "(() => { const wrong = []; const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > width) wrong.push('the page scrolls sideways: ' + document.documentElement.scrollWidth);
  const boxed = e => { for (; e; e = e.parentElement) if (getComputedStyle(e).overflowX === 'auto') return true; return false; };
  for (const e of document.querySelectorAll('svg, table, h2, p, figcaption')) { const r = e.getBoundingClientRect();
    if (r.right > width + 1 && !boxed(e)) wrong.push(e.tagName + ' ends at ' + r.right);
    if (e.tagName === 'svg' && !(r.width > 100 && r.height > 60)) wrong.push('an image of ' + r.width + ' by ' + r.height); }
  for (const t of document.querySelectorAll('svg text')) { const height = t.getBoundingClientRect().height;
    if (t.textContent.trim() && height < 8) wrong.push('letters of ' + height + ' px: ' + t.textContent); }
  return { wrong, images: document.querySelectorAll('svg').length, background: getComputedStyle(document.body).backgroundColor,
    color: getComputedStyle(document.body).color }; })()";

#[test]
fn the_page_fits_wide_and_narrow_screens_by_day_and_by_night() {
    let Some(program) = browser() else {
        println!("skipped: no Chromium in the path, nor named by FSTOP_BROWSER");
        return;
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page = folder.path().join("page.html");
    let name = page.to_string_lossy().into_owned();
    let run = fstop(["lens", "tests/golden/dgauss_50.dat", "--report", &name]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let mut session = Session::start(&program, folder.path());
    for (width, scheme) in [
        (1280, "light"),
        (400, "light"),
        (1280, "dark"),
        (400, "dark"),
    ] {
        let size =
            json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600});
        session.ask("Emulation.setDeviceMetricsOverride", size);
        let features = json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]});
        session.ask("Emulation.setEmulatedMedia", features);
        session.ask("Page.navigate", json!({"url": format!("file://{name}")}));
        // The answer says that the new page has begun.
        while session.evaluate("document.readyState") != "complete" {}
        let found = session.evaluate(LOOK);
        assert_eq!(found["wrong"], json!([]), "{width} {scheme}");
        assert!(found["images"].as_u64() > Some(20), "{found}");
        let dark = found["background"] == "rgb(21, 23, 26)";
        assert_eq!(dark, scheme == "dark", "{found}");
    }
}
