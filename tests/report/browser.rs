//! A headless Chromium: it opens a report in a frame of a given width, and prints what the script in it found.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

/// Names of the program.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// Time in the browser's clock within which the script ends, ms. The clock runs as fast as the page allows.
const BUDGET_MS: u32 = 120_000;
/// Collects errors from the first script on.
const WATCH: &str = "<head><script>window.checkErrors = [];\
    for (const type of ['error', 'securitypolicyviolation', 'unhandledrejection'])\
    addEventListener(type, (e) => checkErrors.push(type + ': ' + (e.message || e.violatedDirective || e.reason)));\
    </script>";

pub struct Browser {
    program: PathBuf,
}

/// Measurements of a report by the script.
#[derive(Debug, Deserialize)]
pub struct Found {
    /// Width of the frame, and of the page in it, px.
    pub width: u32,
    pub page_width: u32,
    pub is_dark: bool,
    /// Colour behind the page.
    pub ground: String,
    pub verdict: String,
    /// Addresses that the page has requested.
    pub requests: Vec<String>,
    pub errors: Vec<String>,
    pub figures: Vec<Figure>,
}

#[derive(Debug, Deserialize)]
pub struct Figure {
    pub name: String,
    pub panels: Vec<Panel>,
}

#[derive(Debug, Deserialize)]
pub struct Panel {
    pub label: String,
    /// Coloured pixels.
    pub painted: u64,
    /// Texts of the legend under the cursor.
    pub values: Vec<String>,
    /// The plot changed by a drag, and was the same again after a double click.
    pub zoomed: bool,
    pub returned: bool,
}

impl Browser {
    /// The first of [`NAMES`] that runs.
    pub fn find() -> Option<Self> {
        let runs = |name: &&str| {
            let version = Command::new(name).arg("--version").output();
            version.is_ok_and(|output| output.status.success())
        };
        let found = NAMES.into_iter().find(runs).map(|name| Self { program: name.into() });
        if found.is_none() {
            eprintln!("skipped: no Chromium; install it, on Debian by apt-get install chromium");
        }
        found
    }

    /// Opens the report of a folder.
    pub fn open(&self, folder: &Path, width: u32, is_dark: bool) -> Found {
        let work = tempfile::tempdir().unwrap();
        let page = fs::read_to_string(folder.join("report.html")).unwrap();
        let script = concat!("<script>", include_str!("check.js"), "</script></body>");
        let page = page.replacen("<head>", WATCH, 1).replacen("</body>", script, 1);
        fs::write(work.path().join("page.html"), page).unwrap();
        let frame = include_str!("frame.html").replace("PAGE", "page.html");
        let path = work.path().join("frame.html");
        fs::write(&path, frame.replace("WIDTH", &width.to_string())).unwrap();
        let output = Command::new(&self.program)
            .args([
                "--headless=new",
                "--no-sandbox",
                "--disable-gpu",
                "--hide-scrollbars",
                "--dump-dom",
            ])
            // No address but those of files has a host.
            .args(["--host-resolver-rules=MAP * ~NOTFOUND", "--enable-logging=stderr"])
            .arg(format!("--user-data-dir={}", work.path().join("profile").display()))
            .arg("--window-size=1400,1000")
            .arg(format!("--blink-settings=preferredColorScheme={}", if is_dark { 0 } else { 1 }))
            .arg(format!("--virtual-time-budget={BUDGET_MS}"))
            .arg(format!("file://{}", path.display()))
            .output()
            .unwrap();
        let log = String::from_utf8_lossy(&output.stderr);
        let console: Vec<&str> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
        assert!(console.is_empty(), "{console:?}");
        let document = String::from_utf8_lossy(&output.stdout);
        let found = document
            .split("<pre id=\"check\">")
            .nth(1)
            .and_then(|rest| rest.split("</pre>").next());
        let found = found.unwrap_or_else(|| panic!("no result from the page:\n{log}"));
        let found = found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
        serde_json::from_str(&found).unwrap()
    }
}
