//! A comparison in words: a table, worst first, and the verdict in the last line.

use std::io::{self, Write};

use super::Comparison;
use super::pair::PairReport;
use super::table::{HEAD, Row, is_number, last_line, notes, of_the_film, row, worst_first};

/// Rows of the table: the worst are what is looked for, `--json` has all.
const ROWS: usize = 20;

/// Writes the table and the verdict.
///
/// # Errors
/// Where `out` cannot be written.
pub fn write(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    if let Some(reason) = &comparison.reason {
        return writeln!(out, "{}: {reason}", comparison.verdict.words());
    }
    let (numbers, rest) = worst_first(comparison);
    for pair in rest.iter().take(ROWS) {
        let (name, verdict) = (&pair.name, pair.verdict.words());
        writeln!(out, "{name}: {verdict}: {}", pair.reasons.join("; "))?;
    }
    left_out(rest.len(), "pairs that could not be compared", out)?;
    for (names, side) in [
        (&comparison.totals.missing_from_a, 'A'),
        (&comparison.totals.missing_from_b, 'B'),
    ] {
        for name in names.iter().take(ROWS) {
            writeln!(out, "{name}: missing from {side}")?;
        }
        left_out(names.len(), &format!("missing from {side}"), out)?;
    }
    table(&numbers, out)?;
    left_out(numbers.len(), "pairs that differ", out)?;
    if comparison.entries.len() > 1 && comparison.totals.identical > 0 {
        writeln!(out, "identical: {}", comparison.totals.identical)?;
    }
    for note in notes(comparison) {
        writeln!(out, "note: {note}")?;
    }
    for line in of_the_film(comparison) {
        writeln!(out, "{line}")?;
    }
    writeln!(out, "{}", last_line(comparison))
}

fn left_out(count: usize, what: &str, out: &mut dyn Write) -> io::Result<()> {
    if count > ROWS {
        writeln!(out, "… and {} more {what}", count - ROWS)?;
    }
    Ok(())
}

fn table(pairs: &[&PairReport], out: &mut dyn Write) -> io::Result<()> {
    let rows: Vec<Row> = pairs
        .iter()
        .take(ROWS)
        .filter_map(|pair| row(pair))
        .collect();
    if rows.is_empty() {
        return Ok(());
    }
    let mut widths = HEAD.map(|word| word.chars().count());
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(&row.cells) {
            *width = cell.chars().count().max(*width);
        }
    }
    let line = |cells: [&str; HEAD.len()]| {
        let mut text = String::new();
        for (k, (cell, width)) in cells.into_iter().zip(widths).enumerate() {
            text += &if is_number(k) {
                format!("{cell:>width$}  ")
            } else {
                format!("{cell:<width$}  ")
            };
        }
        text.trim_end().to_owned()
    };
    writeln!(out, "{}", line(HEAD))?;
    for row in &rows {
        writeln!(out, "{}", line(row.cells.each_ref().map(String::as_str)))?;
        for words in &row.below {
            writeln!(out, "    {words}")?;
        }
    }
    Ok(())
}

/// The same as Markdown, with every pair that differs.
///
/// # Errors
/// Where `out` cannot be written.
pub fn write_markdown(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    if let Some(reason) = &comparison.reason {
        let verdict = comparison.verdict.words();
        return writeln!(out, "**{verdict}: {}**", escaped(reason));
    }
    writeln!(out, "**{}**", escaped(&last_line(comparison)))?;
    let (numbers, rest) = worst_first(comparison);
    let rows: Vec<Row> = numbers.into_iter().filter_map(row).collect();
    if !rows.is_empty() {
        writeln!(out, "\n| {} |", HEAD.join(" | "))?;
        let rule = |k| if is_number(k) { "---:" } else { "---" };
        let rules: Vec<&str> = (0..HEAD.len()).map(rule).collect();
        writeln!(out, "| {} |", rules.join(" | "))?;
        for row in &rows {
            let cells = row.cells.each_ref().map(|cell| escaped(cell));
            writeln!(out, "| {} |", cells.join(" | "))?;
        }
    }
    let mut items: Vec<String> = Vec::new();
    for pair in rest {
        let (name, verdict) = (&pair.name, pair.verdict.words());
        items.push(format!("{name}: {verdict}: {}", pair.reasons.join("; ")));
    }
    for (names, side) in [
        (&comparison.totals.missing_from_a, 'A'),
        (&comparison.totals.missing_from_b, 'B'),
    ] {
        items.extend(
            names
                .iter()
                .map(|name| format!("{name}: missing from {side}")),
        );
    }
    for row in &rows {
        let name = &row.cells[0];
        items.extend(row.below.iter().map(|words| format!("{name}: {words}")));
    }
    items.extend(notes(comparison).iter().map(|note| format!("note: {note}")));
    items.extend(of_the_film(comparison));
    if !items.is_empty() {
        writeln!(out)?;
    }
    for item in items {
        writeln!(out, "- {}", escaped(&item))?;
    }
    Ok(())
}

/// Text in which Markdown sees nothing of its own.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        if matches!(c, '\\' | '|' | '*' | '_' | '`' | '<' | '[' | ']') {
            escaped.push('\\');
        }
        escaped.push(if c == '\n' { ' ' } else { c });
    }
    escaped
}
