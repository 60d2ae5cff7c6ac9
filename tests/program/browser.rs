//! The pages in a real browser, where one is installed: they fit wide screens and narrow ones, by day and by night, and what is clicked
//! on does what it says.
//!
//! Chromium is spoken to by the DevTools protocol through a pipe (fds 3 and 4, messages end with a zero byte), which every build of it
//! has: <https://chromedevtools.github.io/devtools-protocol/>.
#![cfg(unix)]

use crate::common::program::{fstop, fstop_in};
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
/// read, and pictures that nothing is seen of. `dark` is the ground, and the text is its opposite.
const LOOK: &str = "(() => { const wrong = []; const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > width) wrong.push('the page scrolls sideways: ' + document.documentElement.scrollWidth);
  const boxed = e => { for (; e; e = e.parentElement) if (getComputedStyle(e).overflowX === 'auto') return true; return false; };
  for (const e of document.querySelectorAll('svg, table, canvas, img, h1, h2, p, li, label, figcaption')) { const r = e.getBoundingClientRect();
    if (r.right > width + 1 && !boxed(e)) wrong.push(e.tagName + ' ends at ' + r.right);
    if (e.tagName === 'IMG' && !(e.naturalWidth > 1 && r.width > 60)) wrong.push('an image ' + r.width + ' wide');
    if (e.tagName === 'svg' && !(r.width > 100 && r.height > 60)) wrong.push('an image of ' + r.width + ' by ' + r.height); }
  for (const t of document.querySelectorAll('svg text')) { const height = t.getBoundingClientRect().height;
    if (t.textContent.trim() && height < 8) wrong.push('letters of ' + height + ' px: ' + t.textContent); }
  const light = name => getComputedStyle(document.body)[name].match(/[0-9]+/g).slice(0, 3).reduce((sum, c) => sum + Number(c), 0) / 765;
  const [ground, text] = [light('backgroundColor'), light('color')];
  if (Math.abs(ground - text) < 0.6) wrong.push('text of ' + text + ' on ' + ground);
  return { wrong, images: document.querySelectorAll('svg, img, canvas').length, dark: ground < 0.5 }; })()";

/// A session, where there is a browser; else says so.
#[allow(clippy::print_stdout, reason = "a test that is skipped says so")]
fn session(folder: &Path) -> Option<Session> {
    let program = browser();
    if program.is_none() {
        println!("skipped: no Chromium in the path, nor named by FSTOP_BROWSER");
    }
    Some(Session::start(&program?, folder))
}

impl Session {
    fn open(&mut self, page: &Path, width: u32, scheme: &str) {
        let size =
            json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600});
        self.ask("Emulation.setDeviceMetricsOverride", size);
        let features = json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]});
        self.ask("Emulation.setEmulatedMedia", features);
        let address = format!("file://{}", page.display());
        self.ask("Page.navigate", json!({"url": address}));
        // The answer says that the new page has begun.
        while self.evaluate("document.readyState") != "complete" {}
    }

    /// Looks at a page of at least so many images on all screens.
    fn look(&mut self, page: &Path, images: u64) {
        for (width, scheme) in [
            (1280, "light"),
            (400, "light"),
            (1280, "dark"),
            (400, "dark"),
        ] {
            self.open(page, width, scheme);
            let found = self.evaluate(LOOK);
            let name = page.display();
            assert_eq!(found["wrong"], json!([]), "{name} {width} {scheme}");
            assert!(found["images"].as_u64() >= Some(images), "{name} {found}");
            assert_eq!(found["dark"], scheme == "dark", "{name} {found}");
        }
    }

    /// A click of the mouse on the middle of a pixel of the page's canvas.
    fn click(&mut self, [x, y]: [u32; 2]) {
        let place = self.evaluate(&format!(
            "(() => {{ const c = document.getElementById('canvas'); c.scrollIntoView({{ block: 'center' }}); const r = c.getBoundingClientRect();
               return [r.left + ({x} + 0.5) * r.width / c.width, r.top + ({y} + 0.5) * r.height / c.height]; }})()"
        ));
        for kind in ["mousePressed", "mouseReleased"] {
            let event = json!({"type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": 1});
            self.ask("Input.dispatchMouseEvent", event);
        }
    }
}

#[test]
fn the_page_of_a_lens_fits_every_screen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some(mut session) = session(folder.path()) else {
        return;
    };
    let page = folder.path().join("page.html");
    let name = page.to_string_lossy().into_owned();
    let run = fstop(["lens", "tests/golden/dgauss_50.dat", "--report", &name]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    session.look(&page, 21);
}

#[test]
fn the_page_of_a_study_fits_every_screen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some(mut session) = session(folder.path()) else {
        return;
    };
    let page = folder.path().join("page.html");
    let name = page.to_string_lossy().into_owned();
    let scene = "tests/scenes/reference/int_cornell_path.pbrt";
    let run = fstop(["tradeoff", scene, "--time", "1", "--quiet", "--html", &name]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    session.look(&page, 1);
}

/// 64 × 64 pixels of a sky over a ball, which has become brighter.
const SCENE: &str = r#"Film "image" "integer xresolution" [64] "integer yresolution" [64]
    LookAt 0 0 5  0 0 0  0 1 0  Camera "perspective" "float fov" [40]  WorldBegin
    LightSource "infinite" "rgb L" [1 1 1]  Material "matte" "rgb Kd" [KD KD KD]  Shape "sphere" "float radius" [1]  WorldEnd"#;

#[test]
fn pages_of_differences_fit_every_screen_and_enlarge_what_is_clicked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some(mut session) = session(folder.path()) else {
        return;
    };
    let write =
        |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    let name = "a-name-so-long-that-a-telephone-has-to-break-it-somewhere-or-scroll";
    write(
        "suite.toml",
        &format!(
            "[suite]\nspp = 16\n[renderer.fstop]\n\
             command = \"{{fstop}} render {{scene}} -o {{output}} --seed {{seed}} --spp {{spp}} --variance\"\n\
             [[scene]]\nname = \"{name}\"\nfile = \"ball.pbrt\"\n"
        ),
    );
    let run = |more: &str| {
        fstop_in(
            folder.path(),
            ["suite", "run", "suite.toml", "--quiet", more],
        )
        .code
    };
    write("ball.pbrt", &SCENE.replace("KD", "0.5"));
    assert_eq!(run("--update"), 0);
    write("ball.pbrt", &SCENE.replace("KD", "0.56"));
    assert_eq!(run("--pages"), 1);
    let results = folder.path().join("suite-results");
    session.look(&results.join("index.html"), 3);
    let page = results.join(format!("pages/{name}.html"));
    session.look(&page, 2);

    // The map of blocks of eight shows the ball in color, and a click on it enlarges it there.
    session.open(&page, 1280, "light");
    session.evaluate("document.querySelector('[value=t8]').click()");
    const SEEN: &str = "(() => { const c = document.getElementById('canvas'), s = document.getElementById('stage'), box = s.getBoundingClientRect();
        const color = c.getContext('2d').getImageData(40, 32, 1, 1).data, r = c.getBoundingClientRect();
        return { color: [...color], size: r.width / c.width, zoom: document.getElementById('zoom').value,
          middle: [(box.left + s.clientWidth / 2 - r.left) * c.width / r.width, (box.top + s.clientHeight / 2 - r.top) * c.height / r.height],
          readout: document.getElementById('readout').textContent }; })()";
    while session.evaluate(SEEN)["color"][0].as_u64() < Some(150) {}
    session.click([40, 32]);
    let seen = session.evaluate(SEEN);
    assert_eq!(seen["zoom"], "4", "{seen}");
    assert_eq!(seen["size"], 8, "{seen}");
    let readout = seen["readout"].as_str().expect("words");
    assert!(
        readout.starts_with("pixel 40, 32 ") && readout.contains(" — t of 8 × 8: ≥ 8"),
        "{readout}"
    );
    // On a narrow screen it scrolls, to where the click was, and back by another.
    session.open(&page, 400, "light");
    session.evaluate("document.querySelector('[value=t8]').click()");
    let fitted = session.evaluate(SEEN)["size"].clone();
    session.click([30, 32]);
    let seen = session.evaluate(SEEN);
    let middle = seen["middle"][0].as_f64().expect("a number");
    // Scrolling is by whole pixels of the screen, eight to one of these.
    assert!((middle - 30.5).abs() < 0.25, "{seen}");
    session.click([30, 32]);
    let seen = session.evaluate(SEEN);
    assert_eq!((&seen["zoom"], &seen["size"]), (&json!("0"), &fitted));
}
