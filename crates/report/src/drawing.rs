//! Small drawings of plane curves and small pictures, side by side.

use std::fmt::Write;

use super::base64::encode;
use super::table::escape;

/// A row of panels under one heading.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawing {
    /// Heading.
    pub title: String,
    /// Caption, a sentence.
    pub caption: String,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Panels side by side; 0 for as many as fit.
    pub across: usize,
}

/// Some lines in one frame, x to the right and y up, both to the same scale.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Name.
    pub name: String,
    /// Something short beside the name.
    pub note: String,
    /// Lines that the boldly drawn ones are compared with.
    pub reference: Vec<Vec<[f32; 2]>>,
    /// The boldly drawn lines.
    pub lines: Vec<Vec<[f32; 2]>>,
    /// A picture instead of lines.
    pub picture: Option<Picture>,
}

/// A picture in pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Returns the number of rows.
    pub height: usize,
    /// Red, green and blue of each pixel, row by row from the top.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// As large as the frame, each pixel a square of one colour. Nothing where the numbers are not as many as the pixels need.
    fn to_svg(&self) -> String {
        let size = (self.width as u32, self.height as u32);
        let Some(file) = crate::png::encode(&self.rgb, size) else { return String::new() };
        format!(
            "<image width=\"200\" height=\"200\" class=\"pixels\" href=\"data:image/png;base64,{}\"/>",
            encode(&file)
        )
    }
}

impl Drawing {
    /// Returns a section of the page.
    pub(super) fn to_html(&self) -> String {
        let grid = match self.across {
            0 => String::new(),
            n => format!(" style=\"grid-template-columns: repeat({n}, minmax(0, 300px))\""),
        };
        let mut out = format!("<section>\n<h2>{}</h2>\n<div class=\"panels drawing\"{grid}>\n", escape(&self.title));
        self.panels.iter().for_each(|panel| out.push_str(&panel.to_html()));
        out.push_str("</div>\n");
        if !self.caption.is_empty() {
            let _ = writeln!(out, "<p class=\"caption\">{}</p>", escape(&self.caption));
        }
        out.push_str("</section>\n");
        out
    }
}

impl Panel {
    fn to_html(&self) -> String {
        let all = || self.reference.iter().chain(&self.lines).flatten().filter(|p| p.iter().all(|x| x.is_finite()));
        let least = |axis: usize| all().map(|p| p[axis]).fold(f32::INFINITY, f32::min);
        let most = |axis: usize| all().map(|p| p[axis]).fold(f32::NEG_INFINITY, f32::max);
        let (low, high) = ([least(0), least(1)], [most(0), most(1)]);
        let side = (high[0] - low[0]).max(high[1] - low[1]).max(1e-6) * 1.08;
        let centre = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        // 200 units a side; y grows downwards on a page.
        let place =
            |p: &[f32; 2]| [100.0 + (p[0] - centre[0]) / side * 200.0, 100.0 - (p[1] - centre[1]) / side * 200.0];
        let path = |line: &[[f32; 2]], class: &str| {
            let (mut d, mut pen) = (String::new(), 'M');
            for point in line {
                let [x, y] = place(point);
                if x.is_finite() && y.is_finite() {
                    let _ = write!(d, "{pen}{x:.1} {y:.1}");
                    pen = 'L';
                } else {
                    pen = 'M';
                }
            }
            format!("<path d=\"{d}\" class=\"{class}\"/>")
        };
        let mut paths = self.picture.as_ref().map(Picture::to_svg).unwrap_or_default();
        paths.extend(self.reference.iter().map(|line| path(line, "behind")));
        self.lines.iter().for_each(|line| paths.push_str(&path(line, "bold")));
        let (name, note) = (escape(&self.name), escape(&self.note));
        format!(
            "<figure><figcaption><b>{name}</b><span>{note}</span></figcaption>\
             <svg viewBox=\"0 0 200 200\" role=\"img\" aria-label=\"{name}\">{paths}</svg></figure>\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_drawn_upright_to_one_scale_and_names_are_escaped() {
        let panel = Panel {
            name: "<a>".into(),
            note: "1e-3".into(),
            reference: vec![vec![[-1.0, 0.0], [1.0, 0.0]]],
            lines: vec![vec![[0.0, 0.0], [f32::NAN, 0.0], [0.0, 0.5]]],
            picture: None,
        };
        let html = Drawing { title: "T".into(), panels: vec![panel], across: 3, ..Drawing::default() }.to_html();
        // 2 wide with a margin of 8%: 200 / 2.16 units for 1; the middle of y is 0.25.
        assert!(html.contains("d=\"M7.4 123.1L192.6 123.1\" class=\"behind\""), "{html}");
        assert!(html.contains("d=\"M100.0 123.1M100.0 76.9\" class=\"bold\""), "{html}");
        assert!(html.contains("<b>&lt;a&gt;</b><span>1e-3</span>") && !html.contains("caption\">"), "{html}");
        assert!(html.contains("repeat(3, "), "{html}");
    }

    #[test]
    fn a_picture_is_a_png_of_its_pixels() {
        let rgb: Vec<u8> = (0..2 * 3 * 3).map(|i| 10 * i).collect();
        let picture = Picture { width: 3, height: 2, rgb: rgb.clone() };
        let svg = Panel { picture: Some(picture.clone()), ..Panel::default() }.to_html();
        // A PNG's first eight bytes, as base64.
        assert!(svg.contains("href=\"data:image/png;base64,iVBORw0KGg"), "{svg}");
        let file = svg.split("base64,").nth(1).and_then(|t| t.split('"').next()).and_then(crate::base64::decode);
        assert_eq!(file.and_then(|file| crate::png::decode(&file)), Some(((3, 2), rgb)));
        assert_eq!(Picture { height: 3, ..picture }.to_svg(), "");
    }

    #[test]
    fn nothing_to_draw_is_no_reason_to_fail() {
        assert!(Panel::default().to_html().contains("<svg"));
    }
}
