//! The numbers of README's table are those that were measured (`peers/results/headline.py`).

use std::fs;

#[test]
fn readmes_numbers_are_those_of_the_measurement() {
    let read = |path: &str| fs::read_to_string(xtask::root().join(path)).unwrap();
    let (readme, measured) = (read("README.md"), read("docs/results/data/headline.json"));
    let measured: serde_json::Value = serde_json::from_str(&measured).unwrap();
    let rows = measured["rows"].as_array().unwrap();
    assert!(!rows.is_empty());
    for row in rows {
        let text = |key: &str| row[key].as_str().unwrap().to_string();
        let number = |key: &str| row["overall"][key].as_f64().unwrap();
        let expected = format!(
            "| {} | {} | {:.1}% | {:.1}% | {:.2} deg |",
            text("robot"),
            text("test"),
            100.0 * number("survival"),
            100.0 * number("success"),
            number("joint_error_deg")
        );
        assert!(readme.lines().any(|line| line == expected), "README.md: expected the line '{expected}'");
    }
    // The sentence above the table says the harder test.
    let survival = 100.0 * rows[1]["overall"]["survival"].as_f64().unwrap();
    let expected = format!("**{survival:.1}% survival on people and styles it never saw");
    assert!(readme.contains(&expected), "README.md: expected '{expected}'");
}
