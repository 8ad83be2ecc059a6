//! A table of results: one thing for the terminal, the page and the document.

use std::fmt::Write;

/// On which side a column's cells stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Align {
    /// Returns a cell of words.
    Left,
    /// Numbers.
    Right,
}

/// The head of a column.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Column {
    /// Head of the column.
    pub name: String,
    /// Unit; may be empty.
    pub unit: String,
    /// Side.
    pub align: Align,
    /// Shown on a terminal only when all columns are asked for.
    #[serde(skip)]
    pub minor: bool,
}

impl Column {
    /// Returns a column of numbers.
    pub fn number(name: &str, unit: &str) -> Self {
        Self { name: name.into(), unit: unit.into(), align: Align::Right, minor: false }
    }

    /// Returns a column of words.
    pub fn text(name: &str) -> Self {
        Self { name: name.into(), unit: String::new(), align: Align::Left, minor: false }
    }
}

/// Emphasis of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// As it should be.
    Good,
    /// Not as it should be.
    Bad,
}

/// One cell.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Cell {
    /// Text of the cell.
    pub text: String,
    /// The number behind it, for sorting.
    pub value: Option<f64>,
    /// Emphasis.
    pub tone: Option<Tone>,
}

impl Cell {
    /// Returns a cell of words.
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), value: None, tone: None }
    }

    /// Returns a number with so many digits after the point; a dash where there is none.
    pub fn number(value: f64, digits: usize) -> Self {
        if value.is_finite() {
            Self { text: format!("{value:.digits$}"), value: Some(value), tone: None }
        } else {
            Self::text("–")
        }
    }

    /// Returns the same, emphasised.
    pub fn tone(mut self, tone: Option<Tone>) -> Self {
        self.tone = tone;
        self
    }
}

/// A table with a title, rows and, at its foot, sums or means.
///
/// ```
/// use lifelike_report::{Cell, Column, Table};
///
/// let mut table = Table::new("Errors", vec![Column::text("clip"), Column::number("joints", "deg")]);
/// table.rows.push(vec![Cell::text("walk"), Cell::number(1.25, 2)]);
/// table.rows.push(vec![Cell::text("run"), Cell::number(f64::NAN, 2)]);
/// let text = table.to_text();
/// assert!(text.starts_with("clip  joints [deg]\n"));
/// assert!(text.contains("walk          1.25\n") && text.contains("run              –\n"));
/// ```
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Table {
    /// Title.
    pub title: String,
    /// Caption: the meaning of the columns, in a sentence or two.
    pub caption: String,
    /// Heads.
    pub columns: Vec<Column>,
    /// Rows of as many cells as there are columns.
    pub rows: Vec<Vec<Cell>>,
    /// Rows at the foot.
    pub foot: Vec<Vec<Cell>>,
}

impl Table {
    /// Returns an empty table.
    pub fn new(title: &str, columns: Vec<Column>) -> Self {
        Self { title: title.into(), caption: String::new(), columns, rows: Vec::new(), foot: Vec::new() }
    }

    /// Returns aligned plain text, a line each; widths counted in characters.
    pub fn to_text(&self) -> String {
        let heads: Vec<String> = self
            .columns
            .iter()
            .map(|c| if c.unit.is_empty() { c.name.clone() } else { format!("{} [{}]", c.name, c.unit) })
            .collect();
        let mut widths: Vec<usize> = heads.iter().map(|h| h.chars().count()).collect();
        for row in self.rows.iter().chain(&self.foot) {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = (*width).max(cell.text.chars().count());
            }
        }
        let mut out = String::new();
        let mut line = |cells: &[&str]| {
            let mut text = String::new();
            for ((cell, width), column) in cells.iter().zip(&widths).zip(&self.columns) {
                let gap = " ".repeat(width.saturating_sub(cell.chars().count()));
                let _ = match column.align {
                    Align::Left => write!(text, "{cell}{gap}  "),
                    Align::Right => write!(text, "{gap}{cell}  "),
                };
            }
            out.push_str(text.trim_end());
            out.push('\n');
        };
        line(&heads.iter().map(String::as_str).collect::<Vec<_>>());
        let rules: Vec<String> = widths.iter().map(|w| "─".repeat(*w)).collect();
        let rules: Vec<&str> = rules.iter().map(String::as_str).collect();
        line(&rules);
        for row in &self.rows {
            line(&row.iter().map(|c| c.text.as_str()).collect::<Vec<_>>());
        }
        if !self.foot.is_empty() {
            line(&rules);
        }
        for row in &self.foot {
            line(&row.iter().map(|c| c.text.as_str()).collect::<Vec<_>>());
        }
        out
    }

    /// Returns the table as a section of the page.
    pub(super) fn to_html(&self) -> String {
        let mut out =
            format!("<section>\n<h2>{}</h2>\n<div class=\"card scroll\">\n<table>\n<thead><tr>", escape(&self.title));
        for column in &self.columns {
            let class = if column.align == Align::Left { " class=\"text\"" } else { "" };
            let unit =
                if column.unit.is_empty() { String::new() } else { format!("<small>{}</small>", escape(&column.unit)) };
            let _ = write!(out, "<th{class} scope=\"col\">{}{unit}</th>", escape(&column.name));
        }
        out.push_str("</tr></thead>\n<tbody>\n");
        self.rows.iter().for_each(|row| out.push_str(&self.row_html(row)));
        out.push_str("</tbody>\n");
        if !self.foot.is_empty() {
            out.push_str("<tfoot>\n");
            self.foot.iter().for_each(|row| out.push_str(&self.row_html(row)));
            out.push_str("</tfoot>\n");
        }
        out.push_str("</table>\n</div>\n");
        if !self.caption.is_empty() {
            let _ = writeln!(out, "<p class=\"caption\">{}</p>", escape(&self.caption));
        }
        out.push_str("</section>\n");
        out
    }

    fn row_html(&self, row: &[Cell]) -> String {
        let mut out = String::from("<tr>");
        for (cell, column) in row.iter().zip(&self.columns) {
            let mut classes = Vec::new();
            if column.align == Align::Left {
                classes.push("text");
            }
            match cell.tone {
                Some(Tone::Good) => classes.push("good"),
                Some(Tone::Bad) => classes.push("bad"),
                None => {}
            }
            let class = if classes.is_empty() { String::new() } else { format!(" class=\"{}\"", classes.join(" ")) };
            let value = cell.value.map_or(String::new(), |v| format!(" data-value=\"{v}\""));
            let _ = write!(out, "<td{class}{value}>{}</td>", escape(&cell.text));
        }
        out.push_str("</tr>\n");
        out
    }
}

/// Text as it may stand in HTML, inside and outside of attributes.
pub(super) fn escape(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, c| {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            other => out.push(other),
        }
        out
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Table {
        let mut table = Table::new("Results", vec![Column::text("clip"), Column::number("MAE", "deg")]);
        table.rows.push(vec![Cell::text("walk"), Cell::number(2.5, 1)]);
        table.rows.push(vec![Cell::text("a<b>"), Cell::number(f64::NAN, 1)]);
        table.foot.push(vec![Cell::text("all"), Cell::number(12.25, 1).tone(Some(Tone::Bad))]);
        table
    }

    #[test]
    fn plain_text_is_aligned() {
        let expected = "\
clip  MAE [deg]
────  ─────────
walk        2.5
a<b>          –
────  ─────────
all        12.2
";
        assert_eq!(example().to_text(), expected);
    }

    #[test]
    fn html_is_escaped_and_keeps_the_numbers_for_sorting() {
        let html = example().to_html();
        assert!(html.contains("<td class=\"text\">a&lt;b&gt;</td><td>–</td>"), "{html}");
        assert!(html.contains("<td class=\"bad\" data-value=\"12.25\">12.2</td>"), "{html}");
    }
}
