//! What the pages of several commands are made of.

/// What pages of text, charts and tables have in common: dark where the reader's system is, charts on white, as their ink is black;
/// tables that scroll where the page is narrow.
pub(super) const PLAIN: &str = ":root{color-scheme:light dark;--text:#222;--soft:#555;--line:#e3e3e3;--ground:#fff}\
@media(prefers-color-scheme:dark){:root{--text:#e6e9ec;--soft:#a0a9b3;--line:#343b42;--ground:#14171a}}\
body{font:15px/1.45 system-ui,sans-serif;color:var(--text);background:var(--ground);max-width:1000px;margin:2em auto;padding:0 1em}\
h1{font-size:1.6em;margin-bottom:0;overflow-wrap:anywhere}.lead{color:var(--soft);margin-top:.2em}\
figure>svg{max-width:100%;height:auto;background:#fff}figcaption,.legend{color:var(--soft);max-width:46em}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums;display:block;overflow-x:auto;max-width:100%}\
th,td{padding:.15em .8em;text-align:right;border-bottom:1px solid var(--line)}footer{color:var(--soft)}\
@media(max-width:30em){body{margin:1em auto;padding:0 .75em}th,td{padding:.15em .4em}figure{margin:1em 0}}";

/// A page that needs nothing else. `title` is text, the rest HTML; `note` ends the footer.
pub(super) fn page(title: &str, style: &str, body: &str, note: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>{}</title>\n<style>{style}</style></head>\n<body>\n{body}\
         <footer>Made by fstop {}.{note}</footer>\n</body></html>\n",
        escaped(title),
        env!("CARGO_PKG_VERSION")
    )
}

/// A table of cells, which are HTML; without a head if that is empty.
pub(super) fn table<Cells: AsRef<[String]>>(
    head: &[&str],
    rows: impl IntoIterator<Item = Cells>,
) -> String {
    let row = |tag: &str, cells: &mut dyn Iterator<Item = &str>| {
        let cells: String = cells.map(|c| format!("<{tag}>{c}</{tag}>")).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let mut text = "<table>\n".to_string();
    if !head.is_empty() {
        text += &row("th", &mut head.iter().copied());
    }
    for cells in rows {
        text += &row("td", &mut cells.as_ref().iter().map(String::as_str));
    }
    text + "</table>\n"
}

/// Text as HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
