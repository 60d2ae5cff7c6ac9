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
    let offset = first.as_ptr() as usize - line.as_ptr() as usize;
    let extras = words()
        .filter(|w| w.as_ptr() as usize - line.as_ptr() as usize >= offset)
        .map(|w| cell(line, w));
    (cells(&line[..offset]), extras.collect())
}

/// The part of a line as a cell.
fn cell<'a>(line: &str, part: &'a str) -> Cell<'a> {
    let offset = part.as_ptr() as usize - line.as_ptr() as usize;
    Cell {
        text: part,
        column: line[..offset].chars().count() + 1,
    }
}

/// Cuts a line into cells. Blank cells count only where the line is four or five cells separated
/// by single tabs; otherwise any run of blanks is one separator.
fn cells(line: &str) -> Vec<Cell<'_>> {
    let cut = |part| cell(line, part);
    let tabbed: Vec<Cell> = line
        .trim_end()
        .split('\t')
        .map(str::trim)
        .map(cut)
        .collect();
    let blank = tabbed.iter().any(|c| c.text.is_empty());
    let single = tabbed.iter().all(|c| !c.text.contains(char::is_whitespace));
    if blank
        && single
        && matches!(tabbed.len(), 4 | 5)
        && tabbed[1..].iter().any(|c| !c.text.is_empty())
    {
        return tabbed;
    }
    line.split_whitespace().map(cut).collect()
}
