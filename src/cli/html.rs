//! What the pages of several commands are made of.

/// A page that needs nothing else. `title` is text, the rest HTML; `note` ends the footer.
pub(super) fn page(title: &str, style: &str, body: &str, note: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
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
