//! Charts of several series in one frame: mean lines in bands from the least to the largest value.

use std::fmt::Write;

use super::table::escape;

/// Size of the frame in units of the drawing, and the room left of and below it for numbers.
const SIZE: [f64; 2] = [640.0, 240.0];
const ROOM: [f64; 2] = [56.0, 22.0];
/// Colours that the style sheet has.
const COLOURS: usize = 10;

/// One line and its band.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Values on the axis below, ascending.
    pub x: Vec<f64>,
    /// The line; what is not finite leaves a gap.
    pub mean: Vec<f64>,
    /// Lower edge of the band.
    pub low: Vec<f64>,
    /// Upper edge of the band.
    pub high: Vec<f64>,
}

/// Series in one frame.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Chart {
    /// Heading, with the unit.
    pub title: String,
    /// Words below the axis.
    pub x: String,
    /// The series.
    pub series: Vec<Series>,
}

impl Series {
    /// Returns the points that have a line, as (x, low, mean, high).
    fn points(&self) -> impl Iterator<Item = [f64; 4]> + Clone {
        let all = self.x.iter().zip(&self.mean).zip(self.low.iter().zip(&self.high));
        all.map(|((x, mean), (low, high))| [*x, *low, *mean, *high]).filter(|p| p.iter().all(|v| v.is_finite()))
    }
}

impl Chart {
    /// Returns a section of the page.
    pub(super) fn to_html(&self) -> String {
        let points = || self.series.iter().flat_map(Series::points);
        let range = |low: f64, high: f64| if high > low { (low, high) } else { (low - 0.5, low + 0.5) };
        let (left, right) = range(least(points().map(|p| p[0])), -least(points().map(|p| -p[0])));
        let (bottom, top) = range(least(points().map(|p| p[1])), -least(points().map(|p| -p[3])));
        let at = |x: f64, y: f64| {
            [(x - left) / (right - left) * SIZE[0] + ROOM[0], (top - y) / (top - bottom) * SIZE[1] + 6.0]
        };
        let mut svg = String::new();
        for k in 0..=4 {
            let share = f64::from(k) / 4.0;
            let (x, y) = (left + (right - left) * share, bottom + (top - bottom) * share);
            let ([across, _], [_, down]) = (at(x, bottom), at(left, y));
            let _ = write!(
                svg,
                "<line class=\"rule\" x1=\"{}\" x2=\"{}\" y1=\"{down:.1}\" y2=\"{down:.1}\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
                 <text x=\"{across:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                ROOM[0],
                ROOM[0] + SIZE[0],
                ROOM[0] - 6.0,
                down + 4.0,
                short(y),
                SIZE[1] + ROOM[1],
                short(x)
            );
        }
        let mut legend = String::new();
        for (i, series) in self.series.iter().enumerate() {
            let colour = i % COLOURS;
            let edge = |column: usize| series.points().map(move |p| at(p[0], p[column]));
            let band: Vec<[f64; 2]> = edge(3).chain(edge(1).collect::<Vec<_>>().into_iter().rev()).collect();
            let line = edge(2).collect::<Vec<_>>();
            let _ = write!(svg, "<polygon class=\"band c{colour}\" points=\"{}\"/>", path(&band));
            let _ = write!(svg, "<polyline class=\"line c{colour}\" points=\"{}\"/>", path(&line));
            let _ = write!(legend, "<span class=\"c{colour}\">{}</span>", escape(&series.name));
        }
        format!(
            "<section>\n<h2>{}</h2>\n<figure class=\"chart\"><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">{svg}</svg>\
             <p class=\"quiet\">{}</p><p class=\"series\">{legend}</p></figure>\n</section>\n",
            escape(&self.title),
            ROOM[0] + SIZE[0] + 20.0,
            SIZE[1] + ROOM[1] + 8.0,
            escape(&self.title),
            escape(&self.x)
        )
    }
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    let least = values.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

fn path(points: &[[f64; 2]]) -> String {
    points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

/// A number on an axis: three digits, with M and k for millions and thousands.
fn short(value: f64) -> String {
    let (value, unit) = match value.abs() {
        size if size >= 1e6 => (value * 1e-6, "M"),
        size if size >= 1e4 => (value * 1e-3, "k"),
        _ => (value, ""),
    };
    let digits = if value.abs() >= 100.0 { 0 } else { 2 - (value.abs() >= 10.0) as usize };
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_lies_in_its_band_and_gaps_are_left_out() {
        let series = Series {
            name: "<M>".into(),
            x: vec![0.0, 1e6, 2e6],
            mean: vec![1.0, f64::NAN, 3.0],
            low: vec![0.0, 0.0, 2.0],
            high: vec![2.0, 9.0, 4.0],
        };
        let html = Chart { title: "survival [%]".into(), x: "samples".into(), series: vec![series] }.to_html();
        // 0 to 4 over 240 units from 6 on: the line from (0, 1) to (2 M, 3); the band's upper edge, then back below.
        assert!(html.contains("class=\"line c0\" points=\"56.0,186.0 696.0,66.0\""), "{html}");
        assert!(html.contains("class=\"band c0\" points=\"56.0,126.0 696.0,6.0 696.0,126.0 56.0,246.0\""), "{html}");
        assert!(html.contains("&lt;M&gt;") && html.contains(">1.5M<") && html.contains(">2M<"), "{html}");
    }

    #[test]
    fn numbers_are_short_and_nothing_is_an_empty_frame() {
        let told: Vec<String> = [0.0, 0.25, 12.5, 120.0, 2.5e5, 3.2e7, -0.5].map(short).to_vec();
        assert_eq!(told, ["0", "0.25", "12.5", "120", "250k", "32M", "-0.5"]);
        assert!(Chart::default().to_html().contains("<svg"));
    }
}
