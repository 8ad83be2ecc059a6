//! Tables at the width of a terminal: the columns that matter, one line a row, and what is left out is counted.

use std::fmt::Write;

use crate::table::{Align, Cell, Table, Tone};

/// Characters between two columns.
const GAP: usize = 2;
/// Width down to which text is wrapped before a column of numbers is left out.
const ROOMY: usize = 42;
/// Width down to which text is wrapped before a column of text is left out.
const NARROW: usize = 12;

/// Space for a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Screen {
    /// Characters in a line.
    pub columns: usize,
    /// Show every column, however long the lines become.
    pub wide: bool,
    /// Colour cells by their tone.
    pub colours: bool,
}

impl Screen {
    /// Width where there is no terminal.
    pub const PIPED: usize = 100;
}

impl Table {
    /// Marks the columns with these names as the ones that a terminal shows first; others need [`Screen::wide`].
    pub fn main_columns(mut self, names: &[&str]) -> Self {
        for column in &mut self.columns {
            column.minor = !names.contains(&column.name.as_str());
        }
        self
    }

    /// Returns the table as text whose lines fit the screen. Text that is too long continues on the next line. The number of
    /// columns that are left out stands below the table.
    pub fn to_terminal(&self, screen: Screen) -> String {
        let mut shown: Vec<usize> =
            (0..self.columns.len()).filter(|i| screen.wide || !self.columns[*i].minor).collect();
        let mut widths: Vec<usize> = shown.iter().map(|i| self.natural_width(*i)).collect();
        if !screen.wide {
            self.fit(&mut shown, &mut widths, screen.columns);
        }
        let layout = Layout { table: self, shown: &shown, widths: &widths, colours: screen.colours };
        let mut out = layout.line(&|i| (self.columns[i].name.as_str(), None));
        if shown.iter().any(|i| !self.columns[*i].unit.is_empty()) {
            out += &layout.line(&|i| (self.columns[i].unit.as_str(), None));
        }
        let rule: String = widths.iter().map(|w| "─".repeat(*w)).collect::<Vec<_>>().join(&" ".repeat(GAP));
        out += &format!("{rule}\n");
        for row in &self.rows {
            out += &layout.line(&|i| cell_of(row, i));
        }
        if !self.foot.is_empty() {
            out += &format!("{rule}\n");
        }
        for row in &self.foot {
            out += &layout.line(&|i| cell_of(row, i));
        }
        match self.columns.len() - shown.len() {
            0 => {}
            1 => out += "1 more column: --wide\n",
            n => {
                let _ = writeln!(out, "{n} more columns: --wide");
            }
        }
        out
    }

    /// Width of the longest of a column's cells, and of its head.
    fn natural_width(&self, column: usize) -> usize {
        let cells = self.rows.iter().chain(&self.foot).filter_map(|row| row.get(column)).map(|c| c.text.as_str());
        let head = [self.columns[column].name.as_str(), self.columns[column].unit.as_str()];
        cells.chain(head).map(|text| text.chars().count()).max().unwrap_or(0)
    }

    /// Wraps text and leaves out columns until a line fits.
    fn fit(&self, shown: &mut Vec<usize>, widths: &mut Vec<usize>, space: usize) {
        let is_text = |i: usize| self.columns[i].align == Align::Left;
        loop {
            if self.shrink(shown, widths, space, ROOMY) {
                return;
            }
            // The last numbers go first.
            let Some(last) = (1..shown.len()).rev().find(|at| !is_text(shown[*at])) else { break };
            shown.remove(last);
            widths.remove(last);
        }
        while !self.shrink(shown, widths, space, NARROW) && shown.len() > 1 {
            shown.pop();
            widths.pop();
        }
        if let ([_], [only]) = (shown.as_slice(), widths.as_mut_slice()) {
            *only = (*only).min(space.max(1));
        }
    }

    /// Makes the widest columns of text narrower, down to a limit; returns whether a line fits then.
    fn shrink(&self, shown: &[usize], widths: &mut [usize], space: usize, least: usize) -> bool {
        let total = |widths: &[usize]| widths.iter().sum::<usize>() + GAP * widths.len().saturating_sub(1);
        while total(widths) > space {
            let texts = (0..shown.len()).filter(|at| self.columns[shown[*at]].align == Align::Left);
            match texts.max_by_key(|at| widths[*at]) {
                Some(at) if widths[at] > least => widths[at] -= 1,
                _ => return false,
            }
        }
        true
    }
}

/// Returns the text and the tone of a cell; no text where a row is too short.
fn cell_of(row: &[Cell], column: usize) -> (&str, Option<Tone>) {
    row.get(column).map_or(("", None), |cell| (cell.text.as_str(), cell.tone))
}

/// Returns text in the colour of a tone, as terminals do it (ECMA-48).
fn coloured(text: &str, tone: Tone) -> String {
    let code = match tone {
        Tone::Good => 32,
        Tone::Bad => 31,
    };
    format!("\x1b[{code}m{text}\x1b[0m")
}

struct Layout<'a> {
    table: &'a Table,
    shown: &'a [usize],
    widths: &'a [usize],
    colours: bool,
}

impl Layout<'_> {
    /// Returns one row, in as many lines as its longest cell needs.
    fn line<'t>(&self, cell: &dyn Fn(usize) -> (&'t str, Option<Tone>)) -> String {
        let cells: Vec<Vec<String>> =
            self.shown.iter().zip(self.widths).map(|(i, width)| wrapped(cell(*i).0, *width)).collect();
        let lines = cells.iter().map(Vec::len).max().unwrap_or(1);
        let mut out = String::new();
        for k in 0..lines {
            let mut text = String::new();
            for ((lines, width), i) in cells.iter().zip(self.widths).zip(self.shown) {
                let part = lines.get(k).map_or("", String::as_str);
                let space = " ".repeat(width.saturating_sub(part.chars().count()));
                let gap = " ".repeat(GAP);
                let tone = cell(*i).1.filter(|_| self.colours && !part.is_empty());
                let part = tone.map_or_else(|| part.to_string(), |tone| coloured(part, tone));
                let _ = match self.table.columns[*i].align {
                    Align::Left => write!(text, "{part}{space}{gap}"),
                    Align::Right => write!(text, "{space}{part}{gap}"),
                };
            }
            out.push_str(text.trim_end());
            out.push('\n');
        }
        out
    }
}

/// Returns text in lines of at most `width` characters: broken at spaces, and within words that are longer than a line.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let width = width.max(1);
    if text.chars().count() <= width {
        return vec![text.to_string()];
    }
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let mut rest: Vec<char> = word.chars().collect();
        while !rest.is_empty() {
            let used = lines.last().map_or(0, |line| line.chars().count());
            let gap = usize::from(used > 0);
            if used + gap + rest.len() <= width {
                append(&mut lines, gap, rest.drain(..));
            } else if used > 0 {
                lines.push(String::new());
            } else {
                append(&mut lines, 0, rest.drain(..width));
            }
        }
    }
    lines
}

fn append(lines: &mut [String], gap: usize, characters: impl Iterator<Item = char>) {
    if let Some(line) = lines.last_mut() {
        line.extend(std::iter::repeat_n(' ', gap).chain(characters));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cell, Column};

    fn example() -> Table {
        let mut columns = vec![Column::text("clip"), Column::text("verdict")];
        columns.extend(["survival", "joints", "drift", "jerk", "slip"].map(|name| Column::number(name, "deg")));
        let mut table = Table::new("", columns).main_columns(&["clip", "verdict", "survival", "joints", "drift"]);
        for (clip, verdict) in
            [("walk", "follows"), ("a_very_long_name_of_a_clip", "stands instead of walking (0 of 14 steps)")]
        {
            let numbers = [100.0, 2.5, 0.11, 5000.0, 3.0].map(|n| Cell::number(n, 2));
            table.rows.push([Cell::text(clip), Cell::text(verdict)].into_iter().chain(numbers).collect());
        }
        table
    }

    fn longest(text: &str) -> usize {
        text.lines().map(|line| line.chars().count()).max().unwrap_or(0)
    }

    #[test]
    fn no_line_is_longer_than_the_screen_and_nothing_goes_in_silence() {
        for columns in [1, 7, 20, 40, 80, 100, 160] {
            let text = example().to_terminal(Screen { columns, wide: false, colours: false });
            assert!(longest(&text) <= columns.max("9 more columns: --wide".len()), "{columns}:\n{text}");
            let heads = ["clip", "verdict", "survival", "joints", "drift", "jerk", "slip"];
            let first = text.lines().next().unwrap_or_default();
            let hidden = heads.iter().filter(|head| !first.split_whitespace().any(|word| word == **head)).count();
            if columns >= 20 {
                let note = if hidden == 1 { "1 more column:".into() } else { format!("{hidden} more columns:") };
                assert!(text.contains(&note), "{columns}, {note}:\n{text}");
            }
        }
    }

    #[test]
    fn colours_change_no_width() {
        let mut table = example();
        table.rows[0][1] = Cell::text("follows").tone(Some(Tone::Good));
        let [plain, coloured] =
            [false, true].map(|colours| table.to_terminal(Screen { columns: 80, wide: false, colours }));
        assert!(coloured.contains("\x1b[32mfollows\x1b[0m  "), "{coloured:?}");
        assert_eq!(coloured.replace("\x1b[32m", "").replace("\x1b[0m", ""), plain);
    }

    #[test]
    fn a_row_is_one_line_at_80_and_everything_is_there_when_asked_for() {
        let narrow = example().to_terminal(Screen { columns: 80, wide: false, colours: false });
        let expected = "\
clip                        verdict                                    survival
                                                                            deg
──────────────────────────  ─────────────────────────────────────────  ────────
walk                        follows                                      100.00
a_very_long_name_of_a_clip  stands instead of walking (0 of 14 steps)    100.00
4 more columns: --wide
";
        assert_eq!(narrow, expected);
        let wide = example().to_terminal(Screen { columns: 80, wide: true, colours: false });
        assert!(wide.contains("slip") && !wide.contains("more column"), "{wide}");
    }

    #[test]
    fn text_is_broken_at_spaces_and_long_words_anywhere() {
        assert_eq!(wrapped("held up by nothing", 8), ["held up", "by", "nothing"]);
        assert_eq!(wrapped("abcdefgh ij", 5), ["abcde", "fgh", "ij"]);
        assert_eq!(wrapped("é", 1), ["é"]);
    }
}
