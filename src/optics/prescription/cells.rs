//! Lines, rows and cells of a lens table.

/// The lines of a text with their numbers, whatever ends them.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split('\n').enumerate().flat_map(|(i, line)| {
        line.split('\r')
            .filter(|part| !part.is_empty())
            .map(move |part| (i + 1, part))
    })
}

/// One cell: its text (empty for a blank one) and its column, from 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<'a> {
    pub text: &'a str,
    pub column: usize,
}

/// One row that is not blank.
#[derive(Debug)]
pub(super) struct Row<'a> {
    /// In the file, from 1.
    pub line: usize,
    /// In the table, from 1.
    pub row: usize,
    /// The columns.
    pub cells: Vec<Cell<'a>>,
    /// Words of the form `name=value` behind them.
    pub extras: Vec<Cell<'a>>,
}

/// Cuts a line into its columns and the words behind them that have a `=`.
pub(super) fn split(line: &str) -> (Vec<Cell<'_>>, Vec<Cell<'_>>) {
    let words = || line.split_whitespace();
    let Some(first) = words().find(|w| w.contains('=')) else {
        return (cells(line), Vec::new());
    };
    let offset = offset_in(line, first);
    let extras = words().filter(|w| offset_in(line, w) >= offset);
    (cells(&line[..offset]), placed(line, extras))
}

/// Where a part of a line begins, in bytes.
fn offset_in(line: &str, part: &str) -> usize {
    part.as_ptr() as usize - line.as_ptr() as usize
}

/// Parts of a line, in their order, as cells. Characters are counted on from one to the next, so
/// that a line of megabytes takes no time squared.
fn placed<'a>(line: &'a str, parts: impl Iterator<Item = &'a str>) -> Vec<Cell<'a>> {
    let (mut counted, mut column) = (0, 1);
    let place = |text: &'a str| {
        let offset = offset_in(line, text);
        column += line[counted..offset].chars().count();
        counted = offset;
        Cell { text, column }
    };
    parts.map(place).collect()
}

/// Cuts a line into cells. Blank cells count only where the line is four or five cells separated
/// by single tabs; otherwise any run of blanks is one separator. Commas or semicolons are where all of a line has them: `1,5` among blanks is no number.
fn cells(line: &str) -> Vec<Cell<'_>> {
    let tabbed = placed(line, line.trim_end().split('\t').map(str::trim));
    let blank = tabbed.iter().any(|c| c.text.is_empty());
    let single = tabbed.iter().all(|c| !c.text.contains(char::is_whitespace));
    if blank
        && single
        && matches!(tabbed.len(), 4 | 5)
        && tabbed[1..].iter().any(|c| !c.text.is_empty())
    {
        return tabbed;
    }
    let separator = if line.contains(';') { ';' } else { ',' };
    let words: Vec<&str> = line.split_whitespace().collect();
    let is_separated = match words.split_last() {
        Some((only, [])) => only.contains(separator),
        Some((last, before)) => {
            // `1,5` is no two numbers.
            let is_plain = |word: &str| !word.trim_end_matches(separator).contains([',', ';']);
            is_plain(last)
                && before
                    .iter()
                    .all(|word| is_plain(word) && word.ends_with(separator))
        }
        None => false,
    };
    match is_separated {
        true => {
            let parts = line.split(separator).map(str::trim);
            placed(line, parts.filter(|cell| !cell.is_empty()))
        }
        false => placed(line, words.into_iter()),
    }
}

/// The finite number that a text is; `what` is expected.
pub(super) fn number(text: &str, what: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => {
            let found = if text.is_empty() { "a blank" } else { text };
            Err(format!("expected {what}, found {found}"))
        }
    }
}
